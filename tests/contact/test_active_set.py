"""Compiled contact and its steps, against a solver with factors and a plain loop over it."""

import numpy as np
import pytest
from fefinger.validation.oracles.march import march as plain

from fefinger.contact import active_set
from fefinger.contact.complementarity import Complementarity
from fefinger.contact.force_control import CORRECTIONS, depth_of_force
from fefinger.contact.frictionless import FrictionlessContact
from fefinger.contact.prony_history import Relaxation
from fefinger.contact.stepper import Prescribed, Stepper, Target, march
from fefinger.support.checks import ConvergenceError
from fefinger.support.tolerances import COMPLEMENTARITY, FORCE_MATCH, LEAST_FORCE, SMALL_FORCE


WEIGHTS, RATES = np.array([0.3, 0.4, 0.2, 0.1]), np.array([200.0, 10.0, 0.6])
BRANCHES = WEIGHTS[1:] / WEIGHTS[0], RATES
N = 41


@pytest.fixture
def pad() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a flexibility like a layer's, gaps of a paraboloid, and weights."""
    x = np.linspace(-1, 1, N)
    matrix = 0.02 * np.exp(-np.abs(x[:, None] - x) / 0.4) + 0.005 * np.eye(N)
    weights = np.full(N, 0.05)
    return matrix, weights * x**2 / 2, weights


def flexible(n: int, seed: int) -> np.ndarray:
    factor = np.random.default_rng(seed).normal(size=(n, n))
    return factor @ factor.T + 0.1 * np.eye(n)


@pytest.mark.parametrize("n", [1, 2, 7, 120])
def test_it_solves_what_the_oracle_solves_from_any_start(n: int) -> None:
    matrix, rng = flexible(n, n), np.random.default_rng(100 + n)
    oracle, state = Complementarity(matrix), active_set.lcp_state(matrix)
    for _ in range(12):
        offset = rng.normal(size=n)
        expected = oracle.solve(offset)
        assert active_set.solve(state, offset, COMPLEMENTARITY) == active_set.DONE
        assert state.x == pytest.approx(expected, rel=1e-8, abs=1e-8 * np.abs(expected).max())
        assert state.moved == pytest.approx(matrix @ state.x, rel=1e-9, abs=1e-9)
        assert np.array_equal(
            np.sort(state.where[: state.counts[active_set.K]]), np.nonzero(state.place >= 0)[0]
        )


def test_the_inverse_stays_that_of_the_active_block() -> None:
    matrix, rng = flexible(60, 3), np.random.default_rng(4)
    state = active_set.lcp_state(matrix)
    for _ in range(400):
        active_set.solve(state, rng.normal(size=60), COMPLEMENTARITY)
    k = state.counts[active_set.K]
    where = state.where[:k]
    product = state.inverse[:k, :k] @ matrix[np.ix_(where, where)]
    assert product == pytest.approx(np.eye(k), abs=1e-6)


def test_an_inverse_that_went_wrong_is_made_anew() -> None:
    matrix = flexible(30, 5)
    offset = np.random.default_rng(6).normal(size=30)
    state = active_set.lcp_state(matrix)
    active_set.solve(state, offset, COMPLEMENTARITY)
    state.inverse[:] *= 1.7
    assert active_set.solve(state, 1.1 * offset, COMPLEMENTARITY) == active_set.DONE
    assert state.counts[active_set.REBUILT] >= 1
    expected = Complementarity(matrix).solve(1.1 * offset)
    assert state.x == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_flexibility_that_is_not_positive_is_reported() -> None:
    state = active_set.lcp_state(-np.eye(3))
    assert (
        active_set.solve(state, np.array([-1.0, 0.0, 1.0]), COMPLEMENTARITY) == active_set.SINGULAR
    )
    assert "expected a positive definite flexibility" in Stepper.failures[active_set.SINGULAR]


def through_plain(matrix, gap, projected, asked):
    return plain(matrix, gap, projected, Relaxation(WEIGHTS, RATES, N), asked)


def through_steps(matrix, gap, projected, asked):
    return march(FrictionlessContact(matrix, gap, projected, BRANCHES), asked)


def wavy(force: bool) -> Prescribed:
    """Press, hold, let go of it, and press again, in steps of very different lengths."""
    time = np.concatenate([np.linspace(0, 0.4, 120), 0.4 + np.geomspace(1e-4, 5, 40)])
    value = 0.3 * np.sin(9 * time) + 0.05 * np.sin(70 * time)
    return Prescribed(*(("force", time, np.maximum(value, 0)) if force else ("depth", time, value)))


@pytest.mark.parametrize("force", [False, True])
def test_steps_repeat_the_march(pad: tuple, force: bool) -> None:
    expected = through_plain(*pad, wavy(force))
    found = through_steps(*pad, wavy(force))
    for name in ("depth", "pressure", "elastic_pressure"):
        exact = getattr(expected, name)
        assert getattr(found, name) == pytest.approx(exact, rel=1e-10, abs=1e-10 * exact.max())
    # A place at the rim may touch in one of them and not in the other, by rounding alone.
    assert ((found.pressure > 0) != (expected.pressure > 0)).mean() < 1e-3
    assert (expected.pressure > 0).any(axis=1).mean() < 0.9  # it does come off


@pytest.mark.parametrize("shift", [0.0, 0.013])
@pytest.mark.parametrize("through", [through_plain, through_steps])
def test_forces_far_below_the_largest_one_of_a_path_are_met_as_closely_as_can_be(
    pad: tuple, through: object, shift: float
) -> None:
    matrix, _, projected = pad
    gap = projected * (np.linspace(-1, 1, N) + shift) ** 2 / 2
    rising = 0.3 * np.geomspace(1e-17, 1, 60)
    value = np.concatenate([[0.0], rising, rising[::-1], [0.0], rising[::3]])
    asked = Prescribed("force", np.linspace(0, 1, len(value)), value)
    found = through(matrix, gap, projected, asked)
    close = FORCE_MATCH * LEAST_FORCE
    assert found.pressure @ projected == pytest.approx(value, rel=1e-9, abs=close)


@pytest.mark.parametrize("through", [through_plain, through_steps])
def test_a_path_of_tiny_forces_is_not_converged_to_rounding(pad: tuple, through: object) -> None:
    """At a depth of 7 mm the pressures of 1e-9 mN are the rounding of the gaps."""
    matrix, gap, projected = pad
    value = np.array([0.0, 1e-13, 1e-9, 1e-7])
    asked = Prescribed("force", np.linspace(0, 1, len(value)), value)
    found = through(matrix, gap + 7 * projected, projected, asked)
    assert found.pressure @ projected == pytest.approx(value, abs=FORCE_MATCH * LEAST_FORCE)


def test_an_unreachable_force_is_reported(pad: tuple) -> None:
    contact = FrictionlessContact(*pad, BRANCHES)
    assert contact.advance(0.0, Target(np.nan, by_force=True)) == active_set.MISSED
    asked = Prescribed("force", np.zeros(1), np.array([np.nan]))
    with pytest.raises(ConvergenceError, match="did not, at 0 s; press less deep"):
        through_steps(*pad, asked)


def test_a_reset_forgets_and_a_restored_state_goes_on_as_before(pad: tuple) -> None:
    contact = FrictionlessContact(*pad, BRANCHES)
    answers = []
    for _ in range(2):
        contact.reset()
        for depth in (0.1, 0.3, 0.2):
            contact.advance(0.01, Target(depth))
        answers.append(contact.pressure.copy())
    assert answers[0] == pytest.approx(answers[1], rel=1e-10)
    state = contact.state()
    contact.advance(0.5, Target(0.25))
    on = contact.pressure.copy()
    contact.advance(0.5, Target(-1.0))
    contact.restore(state)
    assert contact.depth == pytest.approx(0.2)
    assert contact.pressure == pytest.approx(answers[1], rel=1e-12)
    contact.advance(0.5, Target(0.25))
    assert contact.pressure == pytest.approx(on, rel=1e-10)


def test_a_step_that_fails_changes_nothing(pad: tuple) -> None:
    one, other = (FrictionlessContact(*pad, BRANCHES) for _ in range(2))
    for each in (one, other):
        each.advance(0.01, Target(0.2))
    depth, pressure = one.depth, one.pressure.copy()
    assert one.advance(0.01, Target(np.nan, by_force=True)) == active_set.MISSED
    assert one.depth == depth
    assert one.pressure == pytest.approx(pressure, rel=1e-12)
    for each in (one, other):
        each.advance(0.3, Target(0.25))
    assert one.pressure == pytest.approx(other.pressure, rel=1e-10)
    assert one.elastic == pytest.approx(other.elastic, rel=1e-10, abs=1e-12)


def test_a_search_stays_in_its_bracket_and_finds_a_root_of_a_stiffening_force() -> None:
    """Newton's method, or secants, on d^3 - 2 from first touch at 0."""
    for slope_known in (True, False):
        tried: list[float] = []

        def borne(depth: float, tried: list[float] = tried, known: bool = slope_known):
            tried.append(depth)
            return depth**3, 3 * depth**2 if known else 0.0

        depth, count = depth_of_force(borne, 0.0, 2.0, guess=0.1, peak=2.0, match=1e-9)
        assert depth == pytest.approx(2.0 ** (1 / 3), rel=1e-8)
        assert count == len(tried) <= CORRECTIONS
        assert min(tried) > 0
        for k, at in enumerate(tried):
            above = [each for each in tried[:k] if each**3 > 2]
            assert all(at < each for each in above)


@pytest.mark.parametrize(("force", "wrong"), [(2.0, 2e-3), (2e-3, 2e-3), (0.0005, 1.0)])
def test_a_force_is_met_to_a_part_of_itself_and_a_tiny_one_to_a_part_of_the_largest(force, wrong):
    """On d^3, after a peak of 1 N, from a depth whose force is off by a tenth of that; in mN."""
    peak, match = 1e3, 1e-3
    off = 1.1 * match * max(force, SMALL_FORCE * peak, LEAST_FORCE)
    guess = (force + off) ** (1 / 3)
    depth, count = depth_of_force(
        lambda d: (d**3, 3 * d**2), 0.0, force, guess=guess, peak=peak, match=match
    )
    assert count > 1
    assert abs(depth**3 - force) <= wrong * force
