"""Every linear solver gives the same answer, and says when it does not."""

import numpy as np
import pytest
from fefinger.validation.bench import superlu
from fefinger.validation.problems.grids import box

from fefinger.fem.elements.forms import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg import minres
from fefinger.fem.linalg import system as solve
from fefinger.fem.linalg.system import SOLVERS
from fefinger.scene.ask import Ask
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.tolerances import LINEAR_RESIDUAL


@pytest.fixture(params=SOLVERS)
def solver(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def layers(count: int = 4) -> Space:
    """Return a unit cube of two tissues."""
    even = box(*3 * (np.linspace(0, 1, count + 1),))
    upper = even.points[even.cells][:, :, 2].mean(axis=1) > 0.5
    return Space(even.points, even.cells, np.where(upper, 2, 1).astype(np.int8))


def held(space: Space) -> Integers:
    """Return the unknowns of the base, and those across a plane in which the body slides."""
    places = space.node_points
    return np.flatnonzero(np.stack([places[:, 2] == 0] * 3, axis=1) | (places == 0))


def prepared(name: str, poisson: float, ratio: float = 4.0) -> solve.System:
    space = layers()
    tissues = {1: Elastic(5.0, poisson), 2: Elastic(5.0 * ratio, min(poisson, 0.49))}
    return solve.factor(space, stiffness(space, tissues), held(space), name)


def loads(system: solve.System, count: int) -> Array:
    found = np.zeros((len(system.matrix.indptr) - 1, count))
    n = layers().n_displacements
    found[:n] = np.random.default_rng(0).normal(size=(n, count))
    return found


def independent(system: solve.System) -> solve.System:
    """Return the system with SciPy's factor as its solver."""
    return superlu.factor(system.space, system.matrix, system.fixed)


@pytest.mark.parametrize("poisson", [0.0, 0.49, 0.4999, 0.5])
def test_all_give_the_answer_of_superlu(solver: str, poisson: float) -> None:
    system = prepared(solver, poisson)
    reference = independent(system)
    right = loads(system, 3)
    answer, expected = system.solve(right), reference.solve(right)
    assert system.name == solver
    assert np.abs(answer - expected).max() < 1e-9 * np.abs(expected).max()
    alone = system.solve(right[:, 1])
    assert np.abs(alone - answer[:, 1]).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 1e3])
def test_the_true_residual_is_met(solver: str, ratio: float) -> None:
    system = prepared(solver, 0.5, ratio)
    right = loads(system, 2)
    right[:, 1] = 0.0
    answer = system.solve(right)
    left = system.matrix[system.free] @ answer - right[system.free]
    assert np.linalg.norm(left[:, 0]) <= 1.01 * LINEAR_RESIDUAL * np.linalg.norm(right)
    assert not answer[:, 1].any()


def test_the_inverse_is_symmetric(solver: str) -> None:
    system = prepared(solver, 0.4999)
    a, b = loads(system, 2).T
    assert a @ system.solve(b) == pytest.approx(b @ system.solve(a), rel=1e-8)


def test_prescribed_unknowns_are_met(solver: str) -> None:
    system = prepared(solver, 0.49)
    reference = independent(system)
    right, fixed = loads(system, 1)[:, 0], np.linspace(0, 1, len(system.fixed))
    answer, expected = system.solve(right, fixed), reference.solve(right, fixed)
    assert np.array_equal(answer[system.fixed], fixed)  # exact: handed through
    assert np.abs(answer - expected).max() < 1e-9 * np.abs(expected).max()


def test_what_does_not_converge_says_so(solver: str) -> None:
    wrong = prepared(solver, 0.1)
    wrong.reduced = prepared(solver, 0.49).reduced  # the solver is that of the other matrix
    last = "multifrontal" if solver == "single" else solver  # to which it gives way
    with pytest.raises(ConvergenceError, match=rf"linear solution \({last}\).*1e-10, reached"):
        wrong.solve(loads(wrong, 1)[:, 0])


def test_a_body_that_can_turn_is_refused_by_every_factor(solver: str) -> None:
    space = layers()
    point = 3 * int(np.argmin(space.node_points.sum(axis=1))) + np.arange(3)
    matrix = stiffness(space, dict.fromkeys((1, 2), Elastic(1.0, 0.3)))
    with pytest.raises(InputError, match="held facets"):  # single precision may see it at a load
        solve.factor(space, matrix, point, solver).solve(np.ones(space.n_unknowns))


def test_minres_takes_few_more_iterations_on_a_finer_mesh() -> None:
    counts = []
    for boxes in (3, 6):
        space = layers(boxes)
        matrix = stiffness(space, {1: Elastic(5.0, 0.5), 2: Elastic(5e3, 0.3)})
        system = solve.factor(space, matrix, held(space), "iterative")
        assert isinstance(system.solver, minres.Iterative)
        right = np.random.default_rng(1).normal(size=(len(system.free), 1))
        counts.append(system.solver.minres(right)[1])
    assert 20 < counts[0]
    assert counts[1] < 1.25 * counts[0]


def test_minres_stops_where_it_is_told_to(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(minres, "ITERATIONS", 2)
    system = prepared("iterative", 0.49)
    with pytest.raises(ConvergenceError, match="linear solution"):
        system.solve(loads(system, 1))


def test_the_preconditioner_is_symmetric_and_positive() -> None:
    system = prepared("iterative", 0.5, 1e3)
    assert isinstance(system.solver, minres.Iterative)
    rows = np.random.default_rng(2).normal(size=(len(system.free), 12))
    gram = rows.T @ system.solver.precondition(rows)
    assert np.abs(gram - gram.T).max() < 1e-10 * np.abs(gram).max()
    assert np.linalg.eigvalsh(gram)[0] > 0


def test_the_full_strain_of_a_node_block_has_no_trace_taken_off() -> None:
    """Swelling costs nothing in dev eps : dev eps, and 6 mu V in 2 mu eps : eps."""
    space = box(*3 * (np.linspace(0, 1, 3),))
    elastic = Elastic(3.0, 0.25)
    n = space.n_displacements
    given = stiffness(space, {1: elastic})[:n][:, :n]
    swelling = space.node_points.ravel()
    assert abs(swelling @ given @ swelling) < 1e-12
    full = minres._strain(given)
    assert swelling @ full @ swelling == pytest.approx(2 * elastic.shear * 3, rel=1e-12)
    shear = np.zeros_like(space.node_points)
    shear[:, 0] = space.node_points[:, 2]
    assert shear.ravel() @ (full - given) @ shear.ravel() == pytest.approx(0, abs=1e-12)


def test_the_choice_follows_the_free_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    space = layers()
    soft = {1: Elastic(5.0, 0.49), 2: Elastic(20.0, 0.49)}
    matrix = stiffness(space, soft)
    size = solve.factor(space, matrix, held(space)).dissection.entries
    for part, name in ((9.0, "multifrontal"), (6.0, "single"), (1.0, "iterative")):
        room = part * size * solve.WORKING / solve.ROOM
        monkeypatch.setattr(solve, "free_memory", lambda room=room: room)
        assert solve.factor(space, matrix, held(space)).name == name
    far = stiffness(space, soft | {2: Elastic(5e8, 0.3)})
    room = 6.0 * size * solve.WORKING / solve.ROOM
    monkeypatch.setattr(solve, "free_memory", lambda: room)
    assert solve.factor(space, far, held(space)).name == "iterative"


def test_free_memory_is_a_number_of_bytes() -> None:
    assert 1e8 < solve.free_memory() < 1e15


@pytest.mark.parametrize("name", ["pardiso", "superlu", "cholmod"])
def test_an_unknown_solver_is_named_with_those_there_are(name: str) -> None:
    names = "'multifrontal', 'single', 'iterative'"
    with pytest.raises(InputError, match=rf"ask.solver: expected one of {names}.*'{name}'"):
        prepared(name, 0.3)
    with pytest.raises(InputError, match=rf"ask.solver: expected one of {names}.*'{name}'"):
        Ask(solver=name)
