"""The mass matrix against integrals of polynomials."""

import numpy as np
import pytest
from fefinger.validation.problems.grids import box

from fefinger.fem.elements.assembly import mass
from fefinger.fem.elements.spaces import Space


LINES = np.linspace(0.0, 2.0, 3)


@pytest.fixture
def space() -> Space:
    return box(LINES, np.linspace(0.0, 1.0, 3), np.linspace(-1.0, 1.0, 2))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_translation_carries_the_whole_mass_and_no_other_axis_any(space: Space, axis: int):
    matrix = mass(space, {1: 3.0})
    motion = np.zeros((space.n_nodes, 3))
    motion[:, axis] = 1.0
    momentum = (matrix @ motion.ravel()).reshape(-1, 3)
    assert momentum.sum(axis=0) == pytest.approx(3.0 * 4.0 * np.eye(3)[axis], abs=1e-12)


def test_products_of_quadratics_are_integrated_exactly(space: Space):
    matrix = mass(space, {1: 1.0})
    x, y, _ = space.node_points.T
    first, second = np.zeros((space.n_nodes, 3)), np.zeros((space.n_nodes, 3))
    first[:, 2], second[:, 2] = x**2, x * y
    # Over 0 to 2, 0 to 1 and a height of 2: x^3 y.
    assert first.ravel() @ matrix @ second.ravel() == pytest.approx(4.0 * 0.5 * 2.0, rel=1e-12)


def test_each_tissue_has_its_density(space: Space):
    two = Space(space.points, space.cells, (1 + (np.arange(len(space.cells)) % 2)).astype(np.int8))
    light, heavy = mass(two, {1: 1.0, 2: 1.0}), mass(two, {1: 1.0, 2: 5.0})
    assert heavy.sum() == pytest.approx(3 * light.sum(), rel=1e-12)
    assert abs(heavy - heavy.T).max() < 1e-15
