"""The stiffness that a study tells: a local fit against closed forms, and where it tells none."""

import numpy as np
import pytest

from fefinger.studies.force_depth import POINTS, WINDOW, stiffness


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
