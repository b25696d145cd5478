"""Steps chosen along a motion, and answers interpolated between them."""

import numpy as np
import pytest

from fefinger import scenes
from fefinger.mechanics._stride import STRIDES, stride
from fefinger.mechanics._timeline import time_grid
from fefinger.motion import Motion, Ramp, RampHold, RampSinusoid, Trapezoid
from fefinger.theory.relaxation import hereditary_integral


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
    for way, limit in ((steps.smooth, 4e-3), (steps.bounded, 6e-3)):
        found = way(follows[steps.chosen])
        assert found[steps.chosen] == pytest.approx(follows[steps.chosen], abs=1e-12)
        assert np.abs(found - follows).max() < limit * follows.max()


@pytest.mark.parametrize("depth", [1.9, 2.0, 2.3, 2.6])
def test_a_plain_ramp_is_solved_at_every_twelfth_of_its_depth(depth: float):
    motion = Ramp(60, depth, corner=0.0)
    steps = stride(motion, time_grid(motion, fast=False))
    twelfths = depth * np.arange(1, 13) / 12
    assert np.abs(steps.value[:, None] - twelfths).min(axis=0).max() < 1e-9


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


def stiffening(depth: np.ndarray) -> np.ndarray:
    return depth**1.5 + 0.35 * depth**3


@pytest.mark.parametrize("refine", [1, 2])
def test_the_steps_carry_the_relaxation_through_a_rounded_ramp(refine: int) -> None:
    peak = 5e-3 / refine**2  # second order
    scene = scenes.load("flat-press")
    steps = stride(scene.motion, time_grid(scene.motion, fast=True), refine)
    fine = np.linspace(0.0, scene.motion.duration, 100_001)
    prony = scene.finger.prony
    exact = hereditary_integral(prony, fine, stiffening(scene.motion.value(fine)))
    few = hereditary_integral(prony, steps.times, stiffening(steps.value))
    assert few.max() == pytest.approx(exact.max(), rel=peak)
    assert few == pytest.approx(np.interp(steps.times, fine, exact), abs=peak * exact.max())
    between = steps.bounded(few)  # a corner that is slow: in the way alone it was off by .9 %
    assert between == pytest.approx(np.interp(steps.time, fine, exact), abs=4e-3 * exact.max())


def test_at_its_steps_the_answer_is_what_was_solved_to_the_last_bit():
    motion = Trapezoid(0.0046825, 0.55848, hold=0.0, corner=0.0)
    steps = stride(motion, time_grid(motion, fast=False))
    values = np.sqrt(np.random.default_rng(8).uniform(0, 1, len(steps.chosen)))
    values[-1] = 0.0
    for interpolate in (steps.bounded, steps.smooth):
        np.testing.assert_array_equal(interpolate(values)[steps.chosen], values)
