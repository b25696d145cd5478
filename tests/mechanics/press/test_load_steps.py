"""Steps chosen along a motion, and answers interpolated between them."""

import numpy as np
import pytest
from fefinger.validation.problems import published

from fefinger.mechanics.press.load_steps import (
    BY_DISTANCE,
    LoadSteps,
    load_steps,
    peak_steps,
    tissue_relaxations,
)
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.scene.finger import Finger
from fefinger.scene.motion import Motion
from fefinger.scene.motions import Ramp, RampHold, RampSinusoid, Trapezoid, Vibration
from fefinger.scene.samples import Sampled
from fefinger.theory.relaxation import creep_integral, hereditary_integral


PRONY = tissue_relaxations(Finger.subject("a.h.", tissue="maeno1998"))
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
    steps = load_steps(motion, time, PRONY)
    assert steps.times[0] == 0
    assert steps.times[-1] == time[-1]  # exact: chosen among them
    assert np.abs(np.diff(steps.value)).max() < 1.5 * motion.peak / BY_DISTANCE
    assert steps.value.max() == pytest.approx(steps.path.max(), rel=1e-12)
    assert len(steps.times) < len(time) / 2
    assert len(load_steps(motion, time, PRONY, refine=2).times) > 1.5 * len(steps.times)


@EACH
def test_what_follows_the_motion_is_interpolated_exactly_enough(motion: Motion):
    steps = load_steps(motion, time_grid(motion, fast=True), PRONY)
    follows = steps.path**2
    for way, limit in ((steps.smooth, 4e-3), (steps.bounded, 6e-3)):
        found = way(follows[steps.chosen])
        assert found[steps.chosen] == pytest.approx(follows[steps.chosen], abs=1e-12)
        assert np.abs(found - follows).max() < limit * follows.max()


@pytest.mark.parametrize("depth", [1.9, 2.0, 2.3, 2.6])
def test_a_plain_ramp_is_solved_at_every_twelfth_of_its_depth(depth: float):
    motion = Ramp(60, depth, corner=0.0)
    steps = load_steps(motion, time_grid(motion, fast=False), PRONY)
    twelfths = depth * np.arange(1, 13) / 12
    assert np.abs(steps.value[:, None] - twelfths).min(axis=0).max() < 1e-9


def test_a_tiny_motion_after_a_long_rest_is_interpolated_as_a_large_one() -> None:
    """Beside the time of the rest, its distances in mm would be lost to rounding."""
    tiny, large = (Sampled([0, 1, 1e3, 1e3 + 1], [0, a, a, 2 * a]) for a in (1e-30, 1.0))
    answers = []
    for motion in (tiny, large):
        steps = load_steps(motion, time_grid(motion, fast=False), PRONY)
        answers.append(steps.bounded(steps.value / motion.peak))
    np.testing.assert_allclose(*answers, rtol=1e-9, atol=1e-12)


def test_nothing_below_zero_comes_of_forces_that_push():
    motion = Trapezoid(20, 1.0, hold=0.2)
    steps = load_steps(motion, time_grid(motion, fast=True), PRONY)
    force = np.maximum(steps.value - 0.5, 0.0) ** 1.5
    assert steps.bounded(force).min() == 0


def test_tensors_keep_their_shape():
    motion = RampHold(60, 1.5, hold=0.1)
    steps = load_steps(motion, time_grid(motion, fast=False), PRONY)
    values = np.random.default_rng(0).normal(size=(len(steps.times), 2, 3, 3))
    assert steps.smooth(values).shape == (len(steps.time), 2, 3, 3)


def stiffening(depth: np.ndarray) -> np.ndarray:
    return depth**1.5 + 0.35 * depth**3


@pytest.mark.parametrize("refine", [1, 2])
def test_the_steps_carry_the_relaxation_through_a_rounded_ramp(refine: int) -> None:
    peak = 5e-3 / refine**2  # second order
    scene = published.load("flat-press")
    time = time_grid(scene.motion, fast=True)
    steps = load_steps(scene.motion, time, tissue_relaxations(scene.finger), refine)
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
    steps = load_steps(motion, time_grid(motion, fast=False), PRONY)
    values = np.sqrt(np.random.default_rng(8).uniform(0, 1, len(steps.chosen)))
    values[-1] = 0.0
    for interpolate in (steps.bounded, steps.smooth):
        np.testing.assert_allclose(interpolate(values)[steps.chosen], values, rtol=1e-12)


DRIFTS = [
    Sampled((0.0, 0.05, 5.0), (0.0, 0.5, 0.52), corner=0.0),
    Sampled((0.0, 1 / 60, 5.0), (0.0, 1.0, 1.01), corner=0.0),
    Sampled((0.0, 0.5, 0.52, 2.0, 2.02, 4.0), (0.0, 0.02, 0.25, 0.27, 0.5, 0.52), corner=0.0),
    Sampled((0.0, 2.0, 2.01, 2.5), (0.0, 0.5, 0.1, 0.0), corner=0.0),
]


@pytest.mark.parametrize("motion", DRIFTS)
def test_a_motion_that_changes_its_speed_is_followed_through_the_change(motion: Motion) -> None:
    """A press that goes on to drift lost 15 % of its peak, and was 36 % too high after it."""
    (prony,) = PRONY
    time = time_grid(motion, fast=False)
    steps = load_steps(motion, time, PRONY)
    assert len(steps.times) < 60
    fine = np.unique(np.concatenate([time, np.linspace(0.0, motion.duration, 100_001)]))
    exact = hereditary_integral(prony, fine, stiffening(motion.value(fine)))
    few = hereditary_integral(prony, steps.times, stiffening(steps.value))
    expected = np.interp(time, fine, exact)
    assert steps.bounded(few) == pytest.approx(expected, abs=8e-3 * exact.max())
    assert steps.smooth(steps.value) == pytest.approx(steps.path, abs=6e-3 * motion.peak)


def test_a_force_that_goes_on_to_drift_creeps_as_far_as_it_should() -> None:
    (prony,) = PRONY
    motion = Sampled((0.0, 0.05, 3.0), force=(0.0, 0.3, 0.31), corner=0.0)
    steps = load_steps(motion, time_grid(motion, fast=False), PRONY)
    exact = creep_integral(prony, steps.time, steps.path)
    few = creep_integral(prony, steps.times, steps.value)
    assert steps.bounded(few) == pytest.approx(exact, abs=5e-3 * exact.max())


def test_depth_and_area_are_known_from_a_light_touch_on_under_force_control() -> None:
    """They begin as roots of the force, which a spring that is linear in it does not see."""
    motion = RampHold(loading_rate=5, force=1, hold=0.05)
    steps = load_steps(motion, time_grid(motion, fast=True), PRONY)
    for power in (1, 2 / 3, 1 / 3):
        exact = np.maximum(steps.path, 0.0) ** power
        assert steps.bounded(exact[steps.chosen]) == pytest.approx(exact, abs=0.02)


def test_a_small_sinusoid_on_a_press_keeps_its_size() -> None:
    (prony,) = PRONY
    motion = RampSinusoid(20, 0.5, amplitude=0.02, frequency=50, cycles=6, settle=0.1, corner=0.0)
    steps = load_steps(motion, time_grid(motion, fast=True), PRONY)
    force = hereditary_integral(prony, steps.time, stiffening(steps.path))
    found = steps.bounded(hereditary_integral(prony, steps.times, stiffening(steps.value)))
    last = steps.time > motion.duration - 1 / 50
    wave = np.exp(2j * np.pi * 50 * steps.time[last])
    sizes = [abs(np.trapezoid((f - f.mean()) * wave)) for f in (force[last], found[last])]
    assert sizes[1] == pytest.approx(sizes[0], rel=0.01)  # three steps a half cycle: .03


def test_cycles_are_not_divided_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each moved the error to the next: of 2 s at 200 Hz `explain` took 17 s, in 134 rounds."""
    rounds = []
    smooth = LoadSteps.smooth
    monkeypatch.setattr(LoadSteps, "smooth", lambda *given: rounds.append(0) or smooth(*given))
    motion = Vibration(
        preload=1.0, amplitude=0.05, frequency=200.0, seconds=0.3, held=0.0, corner=0.0
    )
    prony = tissue_relaxations(Finger.subject("a.h."))
    steps = load_steps(motion, time_grid(motion, fast=True), prony)
    assert len(rounds) < 20
    assert len(steps.chosen) < 8 * 2 * motion.frequency * motion.duration


def test_the_step_of_the_largest_force_comes_before_that_of_the_largest_depth() -> None:
    scene = published.load("flat-press")
    steps = load_steps(scene.motion, time_grid(scene.motion, fast=True), PRONY)
    (found,) = peak_steps(scene.motion, steps, PRONY)
    (prony,) = PRONY
    exact = hereditary_integral(prony, steps.time, stiffening(steps.path))
    assert steps.times[found] == pytest.approx(steps.time[exact.argmax()], abs=1e-3)
    assert steps.times[found] < steps.times[steps.value.argmax()]


@EACH
@pytest.mark.parametrize("count", [4, 9])
def test_the_first_steps_alone_are_those_steps(motion: Motion, count: int) -> None:
    steps = load_steps(motion, time_grid(motion, fast=True), PRONY)
    first = steps.until(count)
    np.testing.assert_allclose(first.times, steps.times[:count], rtol=1e-12)
    assert first.time[-1] == pytest.approx(first.times[-1], rel=1e-12)
    assert len(first.path) == len(first.coordinate) == len(first.time)
    np.testing.assert_allclose(first.bounded(first.value)[first.chosen], first.value, rtol=1e-12)
    kept = first.bounded(first.time[first.chosen])
    assert (np.diff(kept) > 0).all()
    np.testing.assert_allclose(kept[[0, -1]], first.times[[0, -1]], rtol=1e-12)
