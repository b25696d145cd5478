"""Contact: complementarity, Hertz, relaxation through time, force control."""

import itertools

import numpy as np
import pytest
from fefinger.validation.fem import hertz

from fefinger.contact.complementarity import Complementarity
from fefinger.contact.frictionless import FrictionlessContact
from fefinger.contact.stepper import Prescribed
from fefinger.contact.stepper import march as march_contact
from fefinger.theory.relaxation import Prony


PRONY = Prony((0.3, 0.4, 0.2, 0.1), (200.0, 10.0, 0.6))


def flexible(n: int, seed: int) -> np.ndarray:
    factor = np.random.default_rng(seed).normal(size=(n, n))
    return factor @ factor.T + 0.1 * np.eye(n)


@pytest.mark.parametrize("seed", range(8))
def test_complementarity_finds_the_one_solution_of_all_active_sets(seed: int) -> None:
    n = 6
    matrix, offset = flexible(n, seed), np.random.default_rng(100 + seed).normal(size=n)
    found = Complementarity(matrix).solve(offset)
    solutions = []
    for chosen in itertools.product([False, True], repeat=n):
        active = np.flatnonzero(chosen)
        answer = np.zeros(n)
        answer[active] = np.linalg.solve(matrix[np.ix_(active, active)], -offset[active])
        if (answer >= -1e-12).all() and (matrix @ answer + offset >= -1e-9).all():
            solutions.append(answer)
    assert len(solutions) == 1
    assert found == pytest.approx(solutions[0])


def test_complementarity_is_exact_on_a_large_problem_from_any_start() -> None:
    matrix, rng = flexible(200, 5), np.random.default_rng(6)
    solver = Complementarity(matrix)
    for _ in range(5):
        offset = rng.normal(size=200)
        answer = solver.solve(offset)
        gaps = matrix @ answer + offset
        assert answer.min() >= 0
        assert gaps.min() > -1e-9
        assert np.abs(answer * gaps).max() < 1e-8


@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_hertz_at_every_poisson_ratio(poisson: float) -> None:
    coarse, fine = (hertz.errors(poisson, level) for level in (0, 1))
    assert coarse["nodes"] < 1000
    assert abs(coarse["force"]) < 1.0
    assert abs(fine["force"]) < 0.3  # and on the way to zero
    assert abs(fine["peak pressure"]) < 0.5
    assert fine["pressure within 0.9 a"] < 2.0
    assert fine["strain"] < 1.3 < coarse["strain"]


@pytest.fixture
def pad() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a flexibility like a layer's, gaps of a paraboloid, and weights."""
    x = np.linspace(-1, 1, 21)
    matrix = 0.02 * np.exp(-np.abs(x[:, None] - x) / 0.4) + 0.005 * np.eye(21)
    weights = np.full(21, 0.1)
    return matrix, weights * x**2 / 2, weights


def march(matrix, gap, projected, prony: Prony, asked: Prescribed):
    return march_contact(FrictionlessContact(matrix, gap, projected, prony.branches), asked)


def test_unloading_detaches_without_pull_and_recovers(pad: tuple) -> None:
    time = np.linspace(0, 1, 401)
    asked = Prescribed("depth", time, 0.3 * np.sin(np.pi * time))
    done = march(*pad, PRONY, asked)
    assert done.pressure.min() >= 0
    left = 200 + int(np.argmax(done.pressure[200:].max(axis=1) == 0))
    assert done.depth[left] > 0.01  # the pad leaves the indenter before the indenter is back
    assert done.pressure[left:].max() == 0
    assert done.elastic_pressure[left].max() > 0  # with a dent that still creeps back


@pytest.mark.parametrize("repeat", [1, 2])
def test_force_control_inverts_depth_control(pad: tuple, repeat: int) -> None:
    time = np.linspace(0, 1, 101)
    depth = 0.3 * np.sin(np.pi * time / 2) ** 2
    pressed = march(*pad, PRONY, Prescribed("depth", time, depth))
    force = pressed.pressure @ pad[2]
    back = march(*pad, PRONY, Prescribed("force", time, force))
    assert back.depth[1:] == pytest.approx(depth[1:], rel=1e-6, abs=1e-9)


def test_a_path_of_forces_is_that_of_its_depths(pad: tuple) -> None:
    """Weighted gaps close a little beyond first touch: depth 0 is first touch all the same."""
    matrix, gap, weights = pad
    body, time = (matrix, gap + 0.004 * weights, weights), np.linspace(0, 1, 101)
    force = 0.5 * np.maximum(np.sin(3 * np.pi * time), 0.0)
    asked = Prescribed("force", time, force)
    pushed = march(*body, PRONY, asked)
    assert pushed.depth[0] == 0
    lifted = np.flatnonzero(force == 0)[1:]
    assert 0.004 < pushed.depth[lifted].min() < 0.05  # it goes back with the skin, not ahead of it
    again = Prescribed("depth", time, pushed.depth)
    moved = march(*body, PRONY, again).pressure @ weights
    assert moved == pytest.approx(force, rel=1e-6, abs=1e-9)
