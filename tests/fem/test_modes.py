"""Modes of a body against closed forms and a dense solver."""

import numpy as np
import pytest
from refusals import refused
from scipy import linalg, sparse

from fefinger.fem.modes import lowest
from fefinger.support.checks import ConvergenceError


def chain(size: int, seed: int = 0) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """Return a stiffness and a mass that are positive definite."""
    rng = np.random.default_rng(seed)
    diagonals = [rng.uniform(2, 3, size), -np.ones(size - 1), -np.ones(size - 1)]
    k = sparse.diags(diagonals, (0, 1, -1), format="csr")
    return k, sparse.diags(rng.uniform(0.5, 2.0, size), format="csr")


@pytest.mark.parametrize("count", [1, 7, 40])
def test_modes_are_those_of_a_dense_solver(count: int) -> None:
    k, m = chain(300)
    inverse = np.linalg.inv(k.toarray())
    found = lowest(lambda loads: inverse @ loads, m, count)
    expected, _ = linalg.eigh(k.toarray(), m.toarray())
    np.testing.assert_allclose(found.omega_squared, expected[:count], rtol=1e-10)
    np.testing.assert_allclose(found.shapes.T @ m @ found.shapes, np.eye(count), atol=1e-10)


def test_modes_solve_the_eigenproblem_itself() -> None:
    k, m = chain(400, seed=1)
    inverse = np.linalg.inv(k.toarray())
    found = lowest(lambda loads: inverse @ loads, m, 30)
    left = k @ found.shapes - m @ found.shapes * found.omega_squared
    assert np.abs(left).max() < 1e-8 * found.omega_squared[-1]


def test_more_modes_than_unknowns_are_refused() -> None:
    k, m = chain(10)
    inverse = np.linalg.inv(k.toarray())
    with refused("modes"):
        lowest(lambda loads: inverse @ loads, m, 11)


def test_a_solution_that_is_none_does_not_converge() -> None:
    _, m = chain(2000)
    rng = np.random.default_rng(3)
    with pytest.raises(ConvergenceError, match="residuals"):
        lowest(lambda loads: rng.standard_normal(loads.shape), m, 20)
