"""The linear factors give the answer of SciPy's, and refuse what they cannot solve."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from fefinger.validation.bench import superlu
from fefinger.validation.problems.grids import box
from refusals import refused
from scipy import sparse
from scipy.sparse.linalg import spsolve

from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg import dissection
from fefinger.fem.linalg import system as solve
from fefinger.fem.linalg.multifrontal_indefinite import ApproximateFactor
from fefinger.fem.linalg.system import compressible
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.tolerances import LINEAR_RESIDUAL


def clamped(space: Space) -> np.ndarray:
    return np.flatnonzero(np.repeat(np.isclose(space.node_points[:, 2], 0), 3))


def double(factor: ApproximateFactor) -> bool:
    """Whether a factor is in double precision."""
    return bool(factor.branches[0].values.dtype == np.float64)


def carried() -> tuple[Space, np.ndarray, np.ndarray]:
    """Return a cube whose tissue 2, held on top, carries tissue 1, and a pull at its base."""
    even = box(*3 * (np.linspace(0, 1, 4),))
    tissue = np.where(even.points[even.cells][:, :, 2].mean(axis=1) < 0.5, 1, 2).astype(np.int8)
    space = Space(even.points, even.cells, tissue)
    loads = np.zeros(space.n_unknowns)
    loads[3 * np.flatnonzero(space.node_points[:, 2] == 0) + 2] = 0.01
    return space, np.flatnonzero(np.repeat(space.node_points[:, 2] == 1, 3)), loads


def layers(count: int = 4) -> Space:
    """Return a unit cube of two tissues."""
    even = box(*3 * (np.linspace(0, 1, count + 1),))
    upper = even.points[even.cells][:, :, 2].mean(axis=1) > 0.5
    return Space(even.points, even.cells, np.where(upper, 2, 1).astype(np.int8))


def held(space: Space) -> Integers:
    """Return the unknowns of the base, and those across a plane in which the body slides."""
    places = space.node_points
    return np.flatnonzero(np.stack([places[:, 2] == 0] * 3, axis=1) | (places == 0))


def cube() -> Space:
    return box(*3 * (np.linspace(0, 1, 4),))


@pytest.fixture
def space() -> Space:
    return cube()


@pytest.mark.parametrize("poisson", [0.3, 0.49, 0.499999, 0.5])
@pytest.mark.parametrize("leaf", [4, 48, 10_000])
def test_the_multifrontal_factor_agrees_with_scipy(
    space: Space, poisson: float, leaf: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dissection, "LEAF", leaf)
    matrix = stiffness(space, {1: Elastic(5.0, poisson)})
    system = solve.factor(space, matrix, clamped(space))
    loads = np.zeros((space.n_unknowns, 3))
    loads[: space.n_displacements] = np.random.default_rng(0).normal(
        size=(space.n_displacements, 3)
    )
    answer = system.solve(loads)
    reference = spsolve(system.reduced.tocsc(), loads[system.free])
    assert answer[system.free] == pytest.approx(reference, rel=1e-7, abs=1e-8)
    assert answer[:, 0] == pytest.approx(system.solve(loads[:, 0]), rel=1e-9, abs=1e-12)


def prepared(poisson: float, ratio: float = 4.0) -> solve.System:
    space = layers()
    tissues = {1: Elastic(5.0, poisson), 2: Elastic(5.0 * ratio, min(poisson, 0.49))}
    return solve.factor(space, stiffness(space, tissues), held(space))


def loads_on(system: solve.System, count: int) -> Array:
    found = np.zeros((system.space.n_unknowns, count))
    n = system.space.n_displacements
    found[:n] = np.random.default_rng(0).normal(size=(n, count))
    return found


@pytest.mark.parametrize("poisson", [0.0, 0.49, 0.4999, 0.5])
def test_a_layered_cube_has_the_answer_of_superlu(poisson: float) -> None:
    system = prepared(poisson)
    reference = superlu.factor(system.space, system.matrix, system.fixed)
    right, fixed = loads_on(system, 3), np.linspace(0, 1, len(system.fixed))
    answer, expected = system.solve(right), reference.solve(right)
    assert np.abs(answer - expected).max() < 1e-9 * np.abs(expected).max()
    moved, expected = system.solve(right[:, 0], fixed), reference.solve(right[:, 0], fixed)
    assert np.array_equal(moved[system.fixed], fixed)  # exact: handed through
    assert np.abs(moved - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 1e3])
def test_the_true_residual_is_met(ratio: float) -> None:
    system = prepared(0.5, ratio)
    right = loads_on(system, 2)
    right[:, 1] = 0.0
    answer = system.solve(right)
    left = system.matrix[system.free] @ answer - right[system.free]
    assert np.linalg.norm(left[:, 0]) <= 1.01 * LINEAR_RESIDUAL * np.linalg.norm(right)
    assert not answer[:, 1].any()


def test_the_inverse_is_symmetric() -> None:
    system = prepared(0.4999)
    a, b = loads_on(system, 2).T
    assert a @ system.solve(b) == pytest.approx(b @ system.solve(a), rel=1e-8)


def test_what_does_not_converge_says_so() -> None:
    wrong = prepared(0.1)
    wrong.reduced = prepared(0.49).reduced  # the factor is that of the other matrix
    with pytest.raises(ConvergenceError, match=r"linear solution.*1e-10, reached"):
        wrong.solve(loads_on(wrong, 1)[:, 0])


def test_a_body_that_can_turn_is_refused() -> None:
    space = layers()
    point = 3 * int(np.argmin(space.node_points.sum(axis=1))) + np.arange(3)
    matrix = stiffness(space, dict.fromkeys((1, 2), Elastic(1.0, 0.3)))
    with pytest.raises(InputError, match="held facets"):
        solve.factor(space, matrix, point)


def buckled(space: Space, matrix: sparse.csr_matrix) -> sparse.csr_matrix:
    """Return a stiffness that is negative for some displacements."""
    down = np.where(np.arange(space.n_unknowns) < space.n_displacements, 0.15, 0.0)
    return (matrix - sparse.diags(down)).tocsr()


@cache
def spectrum(poisson: float) -> tuple[float, int]:
    """Return the lowest eigenvalue of a buckled cube, and how many the factored one has below 0."""
    space = cube()
    bent = buckled(space, stiffness(space, {1: Elastic(5.0, poisson)}))
    free = np.setdiff1d(np.arange(space.n_unknowns), clamped(space))
    moving = free[free < space.n_displacements]
    lowest = np.linalg.eigvalsh(bent[moving][:, moving].toarray())[0]
    neighbor = compressible(space, bent)[free][:, free].toarray()
    return float(lowest), int((np.linalg.eigvalsh(neighbor) < 0).sum())


@pytest.mark.parametrize("poisson", [0.3, 0.5])
@pytest.mark.parametrize("leaf", [4, 48, 10_000])
def test_the_rough_factor_takes_indefinite_matrices_and_one_or_many_loads(
    space: Space, poisson: float, leaf: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dissection, "LEAF", leaf)
    matrix = stiffness(space, {1: Elastic(5.0, poisson)})
    system = solve.factor(space, matrix, clamped(space))
    n, bent = space.n_displacements, buckled(space, matrix)
    lowest, negative = spectrum(poisson)
    assert lowest < -0.01
    rough = solve.approximate_factor(bent, system)
    assert rough.negative == negative
    assert rough.negative > (system.free >= n).sum()
    reduced = bent[system.free][:, system.free]
    exact = np.random.default_rng(0).normal(size=(len(system.free), 3))
    loads = reduced @ exact
    for wanted, load in ((exact, loads), (exact[:, 0], loads[:, 0])):
        found = np.zeros_like(wanted)
        for _ in range(8):
            found += rough.solve(load - reduced @ found)
        assert np.linalg.norm(found - wanted) < 1e-8 * np.linalg.norm(wanted)


def test_a_singular_matrix_has_no_rough_factor(space: Space) -> None:
    matrix = stiffness(space, {1: Elastic(5.0, 0.3)})
    system = solve.factor(space, matrix, clamped(space))
    with pytest.raises(InputError, match="singular"):
        solve.approximate_factor(0 * matrix, system)


def test_a_matrix_beyond_single_precision_is_factored_in_double(space: Space) -> None:
    matrix = stiffness(space, {1: Elastic(5.0, 0.3)})
    system = solve.factor(space, matrix, clamped(space))
    found = solve.approximate_factor(1e200 * matrix, system)
    assert double(found)
    assert system.failed == [
        "solve: expected numbers within the range of single precision, received larger ones"
    ]
    right = np.random.default_rng(0).normal(size=len(system.free))
    left = system.reduced @ found.solve(1e200 * right) - right
    assert np.linalg.norm(left) < 1e-9 * np.linalg.norm(right)
    with np.errstate(all="ignore"), refused("solve"):
        solve.approximate_factor(1e200 * (1e200 * matrix), system)
    assert len(system.failed) == 1


def test_a_rough_factor_that_fails_gives_way_and_then_the_body_is_at_fault(
    space: Space, unsound: Callable[..., None]
) -> None:
    matrix = stiffness(space, {1: Elastic(5.0, 0.3)})
    system = solve.prepare(space, matrix, clamped(space))
    usual = system.approximate_factor
    assert not double(usual)
    unsound(np.float32)
    found = solve.approximate_factor(matrix, system)
    assert double(found)
    assert len(system.failed) == 1
    assert found.negative == usual.negative
    right = np.random.default_rng(0).normal(size=len(system.free))
    assert found.solve(right) == pytest.approx(system.solver.solve(right), rel=1e-9, abs=1e-12)
    again = solve.prepare(space, matrix, clamped(space))
    assert double(again.approximate_factor)
    assert len(again.failed) == 1
    unsound(np.float32, np.float64)
    with pytest.raises(InputError, match="hold more facets or repair the mesh"):
        solve.approximate_factor(matrix, system)
    assert len(system.failed) == 1


@pytest.mark.parametrize("count", [0, 1, 2])
@pytest.mark.parametrize("seed", range(2))
def test_a_body_at_rest_that_can_still_turn_has_no_rough_factor(
    space: Space, count: int, seed: int
) -> None:
    points = np.random.default_rng(seed).permutation(len(space.points))[:count]
    fixed = (3 * points[:, None] + np.arange(3)).ravel() if count else np.array([0])
    matrix = stiffness(space, {1: Elastic(5.0, 0.49)})
    with pytest.raises(InputError, match="hold more facets"):
        _ = solve.prepare(space, matrix, fixed).approximate_factor


def test_reactions_balance_the_load(space: Space) -> None:
    system = solve.factor(space, stiffness(space, {1: Elastic(5.0, 0.49)}), clamped(space))
    loads = np.zeros(space.n_unknowns)
    loads[3 * np.argmax(space.node_points.sum(axis=1)) + np.arange(3)] = [1.0, 2.0, 3.0]
    reactions = system.reactions(system.solve(loads), loads).reshape(-1, 3).sum(axis=0)
    assert reactions == pytest.approx([-1.0, -2.0, -3.0], rel=1e-8)


def test_a_body_that_nothing_holds_is_refused(space: Space) -> None:
    with pytest.raises(InputError, match="at least one held face"):
        solve.factor(space, stiffness(space, {1: Elastic(1.0, 0.3)}), np.empty(0, dtype=int))


def test_moduli_a_billion_apart_cost_no_balance() -> None:
    space, held, loads = carried()
    tissues = {1: Elastic(1.0, 0.49), 2: Elastic(1e9, 0.3)}
    system = solve.factor(space, stiffness(space, tissues), held)
    reactions = system.reactions(system.solve(loads), loads)
    assert reactions.reshape(-1, 3).sum(axis=0) == pytest.approx(
        [0, 0, -loads.sum()], abs=1e-9 * loads.sum()
    )


@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_a_stiff_tissue_that_floats_on_a_soft_one_balances_to_rounding_or_says_so(
    poisson: float,
) -> None:
    space, held, loads = carried()
    for ratio in (1e3, 1e6):
        tissues = {1: Elastic(ratio, poisson), 2: Elastic(1.0, 0.49)}
        system = solve.factor(space, stiffness(space, tissues), held)
        along = system.reactions(system.solve(loads), loads).reshape(-1, 3)[:, 2].sum()
        assert along == pytest.approx(-loads.sum(), rel=1e-8)
    tissues = {1: Elastic(1e9, poisson), 2: Elastic(1.0, 0.49)}
    system = solve.factor(space, stiffness(space, tissues), held)
    with pytest.raises(ConvergenceError, match="moduli closer"):
        system.solve(loads)
