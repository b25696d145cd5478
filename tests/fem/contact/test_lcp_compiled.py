"""Compiled contact and its steps, against a solver with factors and a plain loop over it."""

import numpy as np
import pytest
from fefinger.validation.oracles.march import march as plain

from fefinger.fem.contact import lcp_compiled, step_compiled
from fefinger.fem.contact.complementarity import Complementarity
from fefinger.fem.contact.march import march
from fefinger.fem.contact.viscoelastic import Prescribed, Relaxation, corrected
from fefinger.support.checks import PRESS_LESS, ConvergenceError
from fefinger.support.tolerances import COMPLEMENTARITY, FORCE_MATCH, LEAST_FORCE


WEIGHTS, RATES = np.array([0.3, 0.4, 0.2, 0.1]), np.array([200.0, 10.0, 0.6])
N = 41


@pytest.fixture
def pad() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a flexibility like that of a layer, gaps of a paraboloid, and weights."""
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
    oracle, state = Complementarity(matrix), lcp_compiled.lcp_state(matrix)
    for _ in range(12):
        offset = rng.normal(size=n)
        expected = oracle.solve(offset)
        assert lcp_compiled.solve(state, offset, COMPLEMENTARITY) == lcp_compiled.DONE
        assert state.x == pytest.approx(expected, rel=1e-8, abs=1e-8 * np.abs(expected).max())
        assert state.moved == pytest.approx(matrix @ state.x, rel=1e-9, abs=1e-9)
        assert np.array_equal(
            np.sort(state.where[: state.counts[lcp_compiled.K]]), np.nonzero(state.place >= 0)[0]
        )


def test_the_inverse_stays_that_of_the_active_block() -> None:
    matrix, rng = flexible(60, 3), np.random.default_rng(4)
    state = lcp_compiled.lcp_state(matrix)
    for _ in range(400):
        lcp_compiled.solve(state, rng.normal(size=60), COMPLEMENTARITY)
    k = state.counts[lcp_compiled.K]
    where = state.where[:k]
    product = state.inverse[:k, :k] @ matrix[np.ix_(where, where)]
    assert product == pytest.approx(np.eye(k), abs=1e-6)


def test_an_inverse_that_went_wrong_is_made_anew() -> None:
    matrix = flexible(30, 5)
    offset = np.random.default_rng(6).normal(size=30)
    state = lcp_compiled.lcp_state(matrix)
    lcp_compiled.solve(state, offset, COMPLEMENTARITY)
    state.inverse[:] *= 1.7
    assert lcp_compiled.solve(state, 1.1 * offset, COMPLEMENTARITY) == lcp_compiled.DONE
    assert state.counts[lcp_compiled.REBUILT] >= 1
    expected = Complementarity(matrix).solve(1.1 * offset)
    assert state.x == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_flexibility_that_is_not_positive_is_reported() -> None:
    state = lcp_compiled.lcp_state(-np.eye(3))
    assert (
        lcp_compiled.solve(state, np.array([-1.0, 0.0, 1.0]), COMPLEMENTARITY)
        == lcp_compiled.SINGULAR
    )
    with pytest.raises(ConvergenceError, match="expected a positive definite flexibility"):
        step_compiled.check(lcp_compiled.SINGULAR)
    with pytest.raises(ConvergenceError, match="found none in 500 exchanges"):
        step_compiled.check(lcp_compiled.ENDLESS)


def wavy(force: bool) -> Prescribed:
    """Press, hold, let go of it, and press again, in steps of very different lengths."""
    time = np.concatenate([np.linspace(0, 0.4, 120), 0.4 + np.geomspace(1e-4, 5, 40)])
    value = 0.3 * np.sin(9 * time) + 0.05 * np.sin(70 * time)
    return Prescribed(*(("force", time, np.maximum(value, 0)) if force else ("depth", time, value)))


@pytest.mark.parametrize("force", [False, True])
def test_steps_repeat_the_march(pad: tuple, force: bool) -> None:
    expected = plain(*pad, Relaxation(WEIGHTS, RATES, N), wavy(force))
    found = march(*pad, Relaxation(WEIGHTS, RATES, N), wavy(force))
    for name in ("depth", "pressure", "elastic_pressure"):
        exact = getattr(expected, name)
        assert getattr(found, name) == pytest.approx(exact, rel=1e-10, abs=1e-10 * exact.max())
    # A place at the rim may touch in one of them and not in the other, by rounding alone.
    assert ((found.pressure > 0) != (expected.pressure > 0)).mean() < 1e-3
    assert (expected.pressure > 0).any(axis=1).mean() < 0.9  # it does come off


@pytest.mark.parametrize("shift", [0.0, 0.013])
@pytest.mark.parametrize("through", [plain, march], ids=["plain", "compiled"])
def test_forces_far_below_the_largest_one_of_a_path_are_met_as_closely_as_can_be(
    pad: tuple, through: object, shift: float
) -> None:
    matrix, _, projected = pad
    gap = projected * (np.linspace(-1, 1, N) + shift) ** 2 / 2
    rising = 0.3 * np.geomspace(1e-17, 1, 60)
    value = np.concatenate([[0.0], rising, rising[::-1], [0.0], rising[::3]])
    asked = Prescribed("force", np.linspace(0, 1, len(value)), value)
    found = through(matrix, gap, projected, Relaxation(WEIGHTS, RATES, N), asked)
    close = FORCE_MATCH * LEAST_FORCE
    assert found.pressure @ projected == pytest.approx(value, rel=1e-9, abs=close)


@pytest.mark.parametrize("through", [plain, march], ids=["plain", "compiled"])
def test_a_path_of_tiny_forces_is_not_converged_to_rounding(pad: tuple, through: object) -> None:
    """At a depth of 7 mm the pressures of 1e-9 mN are the rounding of the gaps."""
    matrix, gap, projected = pad
    value = np.array([0.0, 1e-13, 1e-9, 1e-7])
    asked = Prescribed("force", np.linspace(0, 1, len(value)), value)
    found = through(matrix, gap + 7 * projected, projected, Relaxation(WEIGHTS, RATES, N), asked)
    assert found.pressure @ projected == pytest.approx(value, abs=FORCE_MATCH * LEAST_FORCE)


def test_an_unreachable_force_is_reported(pad: tuple) -> None:
    matrix, gap, projected = pad
    state = lcp_compiled.lcp_state(matrix)
    memory = step_compiled.pad_state(gap, projected, WEIGHTS[1:] / WEIGHTS[0], RATES)
    assert step_compiled.step(state, memory, 0.0, np.nan, True) == lcp_compiled.MISSED
    with pytest.raises(ConvergenceError, match="did not; take shorter steps"):
        step_compiled.check(lcp_compiled.MISSED)
    with pytest.raises(ConvergenceError, match="did not; press less deep"):
        step_compiled.check(lcp_compiled.MISSED, advice=PRESS_LESS)


def test_a_reset_forgets(pad: tuple) -> None:
    matrix, gap, projected = pad
    state = lcp_compiled.lcp_state(matrix)
    memory = step_compiled.pad_state(gap, projected, WEIGHTS[1:] / WEIGHTS[0], RATES)
    first = []
    for _ in range(2):
        step_compiled.reset(state, memory)
        answers = []
        for depth in (0.1, 0.3, 0.2):
            step_compiled.step(state, memory, 0.01, depth, False)
            answers.append(state.x.copy())
        first.append(np.array(answers))
    assert np.array_equal(*first)


def test_a_corrected_depth_stays_in_its_bracket_and_finds_a_root_of_a_stiffening_force() -> None:
    """Newton's method on d^3 - 2 from first touch at 0, with and without a slope."""
    for slope_known in (True, False):
        depth, low, high = 0.1, 0.0, np.inf
        for _ in range(200):
            excess = depth**3 - 2.0
            rise = 3 * depth**2 if slope_known else 0.0
            depth, low, high = corrected(depth, excess, rise, low, high, 0.0)
            assert low <= depth <= high
            assert low**3 <= 2.0 <= high**3
        assert depth == pytest.approx(2.0 ** (1 / 3), rel=1e-9)
