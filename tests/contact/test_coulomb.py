"""The solver of contact with friction keeps its books, and its Newton steps are those of Newton."""

import numpy as np
import pytest

from fefinger.contact import coulomb_kernels
from fefinger.contact.active_set import DONE
from fefinger.contact.coulomb import CoulombSolver
from fefinger.contact.coulomb_kernels import SOLVED, UNKNOWNS, K


@pytest.fixture(scope="module")
def flexibility() -> np.ndarray:
    basis = np.random.default_rng(4).normal(size=(60, 60))
    return basis @ basis.T / 60 + 0.05 * np.eye(60)


def test_the_block_follows_the_vertices_that_join_and_leave(flexibility: np.ndarray) -> None:
    rng, solver = np.random.default_rng(1), CoulombSolver(flexibility, 0.3)
    for _ in range(12):
        assert solver.solve(rng.normal(size=60), 1e-10) == DONE
        k = int(solver.counts[K])
        assert np.array_equal(solver.place[solver.where[:k]], np.arange(k))
        assert np.count_nonzero(solver.place >= 0) == k
        pressed = np.flatnonzero(solver.x[:20])
        assert np.array_equal(np.sort(solver.where[:k]), pressed)
        assert not solver.x[20:].reshape(2, 20)[:, solver.x[:20] == 0].any()
        assert solver.moved == pytest.approx(flexibility @ solver.x, rel=1e-12, abs=1e-12)


def test_a_load_that_changes_slowly_has_the_solution_of_a_fresh_one(
    flexibility: np.ndarray,
) -> None:
    start, change = np.random.default_rng(2).normal(size=(2, 60))
    for mu in (0.3, 2.0):
        solver, before = CoulombSolver(flexibility, mu), 0
        for part in np.linspace(0.0, 0.2, 41):
            offset, fresh = start + part * change, CoulombSolver(flexibility, mu)
            assert solver.solve(offset, 1e-10) == fresh.solve(offset, 1e-10) == DONE
            assert solver.x == pytest.approx(fresh.x, abs=1e-7)
            before += int(fresh.counts[SOLVED])
        assert solver.counts[SOLVED] < before  # it starts from the last one


def test_newton_solves_with_the_matrix_and_not_with_its_transpose(flexibility: np.ndarray) -> None:
    solver = CoulombSolver(flexibility, 1.0)
    assert solver.solve(np.random.default_rng(1).normal(size=60), 1e-10) == DONE
    k, block, unknowns = int(solver.counts[K]), solver._block, solver._unknowns
    solver.counts[UNKNOWNS] = q = coulomb_kernels._unknowns(block, solver.where, k, unknowns)
    matrix, right = coulomb_kernels.assemble(block, k, unknowns, q)
    assert np.abs(matrix - matrix.T).max() > 0.1
    assert matrix @ solver._newton(k, invert=False) == pytest.approx(right, abs=1e-10)
    solver._newton(k, invert=True)
    assert solver._inverse @ matrix == pytest.approx(np.eye(q), abs=1e-10)
