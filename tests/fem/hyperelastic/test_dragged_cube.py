"""Friction of a plate that slides over a hyperelastic cube: balances and convergence."""

import numpy as np
import pytest
from fefinger.validation.problems.cube import cube
from scipy.sparse.linalg import splu

from fefinger.contact.complementarity import Complementarity
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.hyperelastic.material import material_of
from fefinger.fem.hyperelastic.state import State, Target
from fefinger.support.checks import ConvergenceError


AXIS = np.array([0.0, 0.0, -1.0])


def dragged(
    mu: float, depth: float, *, heading: float = 0.0, poisson: float = 0.49, steps: int = 4
):
    """Return a cube, its target and its state under a plate that slides along a heading in rad."""
    block = cube(material_of(Elastic(40.0, poisson)))
    state = State(
        np.zeros(block.body.space.n_unknowns), np.zeros(len(block.equilibrium.contact)), 0
    )
    drag = mu * np.array([np.cos(heading), np.sin(heading), 0.0])
    for part in np.linspace(0, 1, steps + 1)[1:]:
        target = Target("depth", depth * part, block.body.at_rest, drag=drag)
        state = block.equilibrium.find(state, target)
    return block, target, state


@pytest.mark.parametrize("mu", [0.1, 0.5])
@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_what_holds_the_cube_bears_pressure_and_friction(mu: float, poisson: float):
    block, target, state = dragged(mu, 0.2, poisson=poisson)
    solver, count = block.equilibrium, block.body.space.n_displacements
    inner, _ = block.body.residual(state.values, target.history)
    held = np.setdiff1d(np.arange(count), solver.system.free)
    reaction = np.zeros(count)
    pulled = solver.contact.at(state).pulled(target.drag) @ state.pressure
    reaction[held] = (inner - pulled[: len(inner)])[held]
    borne = float(solver.contact.projected @ state.pressure)
    assert pulled[:count].reshape(-1, 3).sum(axis=0) == pytest.approx(
        borne * (AXIS + target.drag), rel=1e-12, abs=1e-12 * borne
    )
    total = reaction.reshape(-1, 3).sum(axis=0)
    assert total == pytest.approx(-borne * (AXIS + target.drag), abs=1e-7 * borne)
    arms = block.body.space.node_points + state.values[:count].reshape(-1, 3)
    turning = np.cross(arms, (reaction + pulled[:count]).reshape(-1, 3)).sum(axis=0)
    assert turning == pytest.approx(np.zeros(3), abs=1e-7 * borne)


def test_friction_along_the_other_axis_is_the_mirror_image():
    (_, _, one), (_, _, other) = (dragged(0.4, 0.2, heading=h) for h in (0.0, np.pi / 2))
    force = [
        float(np.sort(state.pressure) @ np.ones(len(state.pressure))) for state in (one, other)
    ]
    assert force[0] == pytest.approx(force[1], rel=1e-6)
    assert np.sort(one.pressure) == pytest.approx(
        np.sort(other.pressure), abs=1e-5 * one.pressure.max()
    )


def test_the_same_pressures_follow_from_any_factor_and_any_steps():
    _, _, far = dragged(0.4, 0.2, steps=2)
    block, target, near = dragged(0.4, 0.2, steps=8)
    assert near.pressure == pytest.approx(far.pressure, abs=1e-6 * far.pressure.max())
    solver = block.equilibrium
    solver._renew(solver._evaluate(near, target), target)
    start = State(np.zeros_like(near.values), np.zeros_like(near.pressure), 0.0)
    for part in (0.5, 1.0):
        step = Target("depth", 0.2 * part, target.history, drag=target.drag)
        start = solver.find(start, step)
    assert start.pressure == pytest.approx(near.pressure, abs=1e-6 * near.pressure.max())


def test_the_matrix_of_the_contact_is_the_derivative_of_the_gaps():
    """Taylor, about rest: what B' K^-1 P misses of friction falls with the square of pressures."""
    block = cube(material_of(Elastic(40.0, 0.3)))
    solver, count = block.equilibrium, len(block.equilibrium.contact)
    rest, free = np.zeros(block.body.space.n_unknowns), block.equilibrium.system.free
    inverse = splu(block.body.tangent(rest, block.body.at_rest).tocsc()[np.ix_(free, free)])

    def moved(drag: np.ndarray, pressure: np.ndarray) -> np.ndarray:
        values = rest.copy()
        for _ in range(30):
            gap = solver.contact.at(State(values, pressure, 0.0))
            inner, _ = block.body.residual(values, block.body.at_rest)
            values[free] += inverse.solve((gap.pulled(drag) @ pressure - inner)[free])
        return gap.gaps

    drag, gap = np.array([0.3, 0.2, 0.0]), solver.contact.at(State(rest, np.zeros(count), 0.0))
    friction = (gap.pulled(drag) - gap.loads)[free].toarray()
    coupling = gap.loads[free].T @ inverse.solve(friction)
    skew = np.abs(coupling - coupling.T).max() / np.abs(coupling).max()
    assert skew > 0.1  # friction has no potential
    errors = []
    for h in (0.1, 0.05):
        pressure = h * np.linspace(0.5, 1.5, count)
        change = moved(drag, pressure) - moved(np.zeros(3), pressure)
        errors.append(np.abs(change - coupling @ pressure).max())
    assert errors[1] < 0.05 * np.abs(coupling @ pressure).max()
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)


def test_complementarity_without_symmetry_is_that_of_the_definition():
    rng = np.random.default_rng(3)
    for _ in range(20):
        matrix = 0.3 * rng.normal(size=(12, 12))
        matrix += np.diag(np.abs(matrix).sum(axis=1) + 0.1)  # a P-matrix
        offset = rng.normal(size=12)
        x = Complementarity(matrix, symmetric=False).solve(offset)
        gaps = matrix @ x + offset
        assert x.min() >= 0
        assert gaps.min() > -1e-9
        assert np.abs(x * gaps).max() < 1e-9


def test_a_coefficient_without_a_solution_ends_in_an_error():
    with pytest.raises(ConvergenceError, match="press less deep"):
        dragged(50.0, 0.2)
