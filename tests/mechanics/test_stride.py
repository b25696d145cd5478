"""Steps chosen along a motion, and answers interpolated between them."""

import numpy as np
import pytest

from fefinger.mechanics._stride import STRIDES, stride
from fefinger.mechanics._timeline import time_grid
from fefinger.motion import Motion, Ramp, RampHold, RampSinusoid, Trapezoid


MOTIONS: list[Motion] = [
    Ramp(20, 1.0),
    RampHold(60, 1.5, hold=5),
    Trapezoid(20, 1.0, hold=0.2),
    RampSinusoid(20, 0.5, amplitude=0.2, frequency=10, cycles=2),
]
EACH = pytest.mark.parametrize("motion", MOTIONS, ids=[motion.kind for motion in MOTIONS])


@EACH
def test_steps_are_few_and_include_every_turn(motion: Motion):
    time = time_grid(motion, fast=True)
    steps = stride(motion, time)
    assert steps.times[0] == 0
    assert steps.times[-1] == time[-1]
    assert np.abs(np.diff(steps.value)).max() < 1.5 * motion.peak / STRIDES
    assert steps.value.max() == steps.path.max()
    assert len(steps.times) < len(time) / 2
    assert len(stride(motion, time, refine=2).times) > 1.5 * len(steps.times)


@EACH
def test_what_follows_the_motion_is_interpolated_exactly_enough(motion: Motion):
    steps = stride(motion, time_grid(motion, fast=True))
    follows = steps.path**2
    for way, limit in ((steps.smooth, 1e-6), (steps.bounded, 1e-3)):
        found = way(follows[steps.chosen])
        assert found[steps.chosen] == pytest.approx(follows[steps.chosen], abs=1e-12)
        assert np.abs(found - follows).max() < limit * follows.max()


def test_nothing_below_zero_comes_of_forces_that_push():
    motion = Trapezoid(20, 1.0, hold=0.2)
    steps = stride(motion, time_grid(motion, fast=True))
    force = np.maximum(steps.value - 0.5, 0.0) ** 1.5
    assert steps.bounded(force).min() == 0


def test_tensors_keep_their_shape():
    motion = RampHold(60, 1.5, hold=0.1)
    steps = stride(motion, time_grid(motion, fast=False))
    values = np.random.default_rng(0).normal(size=(len(steps.times), 2, 3, 3))
    assert steps.smooth(values).shape == (len(steps.time), 2, 3, 3)
