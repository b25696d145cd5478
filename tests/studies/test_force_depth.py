"""Stiffness and dynamic stiffness of a study: against closed forms, and where there is none."""

import cmath

import numpy as np
import pytest

import fefinger as ff
from fefinger.studies.tables import POINTS, WINDOW, dynamic_stiffness, stiffness


LAWS = {
    "power 1": (lambda d: 0.7 * d, lambda d: 0.7 + 0 * d),
    "power 1.5": (lambda d: 0.7 * d**1.5, lambda d: 1.05 * d**0.5),
    "power 2.4": (lambda d: 0.7 * d**2.4, lambda d: 1.68 * d**1.4),
    "exponential 1": (lambda d: np.expm1(d), lambda d: np.exp(d)),
    "exponential 3": (lambda d: np.expm1(3 * d), lambda d: 3 * np.exp(3 * d)),
}


def steps(kind):
    """Return rising times of a ramp at 10 mm/s to 1.5 mm: even, growing, or at random."""
    parts = {
        "even": np.ones(90),
        "growing": np.linspace(1, 4, 90),
        "random": np.random.default_rng(1).uniform(0.2, 1.8, 90),
    }[kind]
    return np.append(0.0, np.cumsum(parts)) / parts.sum() * 0.15


@pytest.mark.parametrize("kind", ["even", "growing", "random"])
@pytest.mark.parametrize("law", LAWS)
def test_the_slope_is_that_of_the_law_however_the_steps_are(law, kind):
    force, slope = LAWS[law]
    time = steps(kind)
    depth = 10 * time
    end = len(time) - 1.0
    for where in (*(np.searchsorted(depth, (0.4, 0.8, 1.1)) + 0.0), end):
        tolerance = 1e-9 if law.startswith("power") else 0.03 if where == end else 0.01
        found = stiffness(time, depth, force(depth), where, control="depth")
        assert found.points >= POINTS
        assert found.note == ""
        assert found.value == pytest.approx(slope(depth[int(where)]), rel=tolerance)


def test_between_two_steps_it_is_the_slope_at_that_depth():
    time = steps("random")
    depth = 10 * time
    found = stiffness(time, depth, depth**1.5, 60.4, control="depth")
    here = 0.6 * depth[60] + 0.4 * depth[61]
    assert found.value == pytest.approx(1.5 * np.sqrt(here), rel=1e-9)


def test_jagged_forces_change_it_less_than_the_slope_of_one_step():
    time = steps("even")
    depth = 10 * time
    jagged = depth**1.5 * (1 + 0.003 * np.random.default_rng(2).uniform(-1, 1, len(depth)))
    true = 1.5 * np.sqrt(depth)
    places = range(40, 85)
    fitted = [stiffness(time, depth, jagged, p, control="depth").value / true[p] for p in places]
    single = [(np.diff(jagged) / np.diff(depth))[p - 1] / true[p] for p in places]
    assert np.ptp(fitted) < 0.1 < 0.2 < np.ptp(single)


def test_with_too_few_steps_it_tells_none_and_how_many_there_were():
    time = steps("even")
    depth = 10 * time
    few = stiffness(time, depth, depth**1.5, 4.0, control="depth")
    inside = np.abs(np.log(depth[1:] / depth[4])) <= np.log(WINDOW)
    assert inside.sum() < POINTS
    assert np.isnan(few.value)
    assert few.points == inside.sum()
    assert few.note.endswith(
        f"{few.points} steps of the loading within a factor of 1.3 of the depth, expected 5"
    )


def test_a_rest_and_a_retreat_have_none():
    time = np.linspace(0, 0.4, 401)
    depth = np.interp(time, [0, 0.1, 0.2, 0.3, 0.4], [0, 1, 1, 0, 0])
    for where in (0.0, 150.0, 250.0, 400.0):
        found = stiffness(time, depth, depth**1.5, where, control="depth")
        assert np.isnan(found.value)
        assert "not on the loading" in found.note
    up = stiffness(time, depth, depth**1.5, 80.0, control="depth")
    assert up.value == pytest.approx(1.5 * np.sqrt(0.8), rel=1e-9)


def test_under_force_control_it_goes_by_the_rate_of_the_force():
    time = np.linspace(0, 1, 201)
    force = time
    depth = force ** (2 / 3)  # ever slower, while the force rises evenly
    found = stiffness(time, depth, force, 190.0, control="force")
    assert found.value == pytest.approx(1.5 * np.sqrt(depth[190]), rel=1e-9)
    assert np.isnan(stiffness(time, depth, force, 190.0, control="depth").value)


MOTION = ff.RampSinusoid(20.0, 1.0, amplitude=0.05, frequency=80.0, cycles=6, settle=0.1)


def test_a_dynamic_stiffness_is_the_complex_ratio_whatever_drifts():
    time = np.unique(np.concatenate([np.linspace(0, MOTION.duration, 1200), MOTION.breakpoints]))
    depth = MOTION.value(time)
    ratio = cmath.rect(1.7, np.radians(25.0))
    turned = np.imag(ratio * np.exp(2j * np.pi * 80.0 * (time - MOTION.trajectory.wave.start)))
    force = 0.5 + 0.3 * (MOTION.duration - time) + 0.05 * turned
    found = dynamic_stiffness(MOTION, time, depth, force)
    assert found == pytest.approx(ratio, rel=1e-6)


def test_there_is_no_dynamic_stiffness_without_a_vibration_and_where_contact_is_lost():
    time = np.linspace(0, MOTION.duration, 1200)
    depth = MOTION.value(time)
    assert dynamic_stiffness(ff.Ramp(20.0, 1.0), time, depth, depth) is None
    assert dynamic_stiffness(MOTION, time, depth, np.maximum(depth - 1.0, 0.0)) is None


@pytest.mark.parametrize(("start", "stop"), [(20.0, 80.0), (80.0, 20.0)])
def test_the_dynamic_stiffness_of_a_sweep_is_that_at_its_end(start, stop):
    sweep = ff.FrequencySweep(1.0, amplitude=0.05, start=start, stop=stop, seconds=4.0)
    time = np.unique(np.concatenate([np.linspace(0, sweep.duration, 8000), sweep.breakpoints]))
    depth = sweep.value(time)
    force = 1.0 + 1.7 * (depth - 1.0) + 0.001 * sweep.rate(time)
    found = dynamic_stiffness(sweep, time, depth, force)
    assert found == pytest.approx(1.7 + 0.002j * np.pi * stop, rel=0.05)
