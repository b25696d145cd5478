"""Few steps are enough: relaxation between them, and the way back to every time of the answer."""

import numpy as np
import pytest

from fefinger import scenes
from fefinger.mechanics._stride import stride
from fefinger.mechanics._timeline import time_grid
from fefinger.theory.relaxation import hereditary_integral


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


def test_what_follows_the_path_is_found_again_at_all_times() -> None:
    motion = scenes.load("flat-sinusoid").motion
    time = time_grid(motion, fast=True)
    steps = stride(motion, time)
    assert len(steps.times) < len(time) / 10
    expected = stiffening(motion.value(time))
    for found in (steps.smooth, steps.bounded):
        again = found(stiffening(steps.value))
        assert again == pytest.approx(expected, abs=2e-2 * expected.max())
        assert again[steps.chosen] == pytest.approx(stiffening(steps.value), rel=1e-12)


def test_a_force_between_its_steps_does_not_pull() -> None:
    motion = scenes.load("flat-press").motion
    steps = stride(motion, time_grid(motion, fast=True))
    touching = np.maximum(steps.value - 0.7, 0.0)
    assert steps.bounded(touching).min() == 0.0
