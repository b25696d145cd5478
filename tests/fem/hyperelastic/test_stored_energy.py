"""Strain energy of the elements: the potential whose derivatives they solve, at any K."""

import numpy as np
import pytest
from fefinger.validation.problems.grids import box
from oracles.potential import energy

from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.continuum import continuum
from fefinger.fem.hyperelastic.material import Material, material_of
from fefinger.fem.hyperelastic.stored_energy import StoredEnergy
from fefinger.support.arrays import Array


def tissues(poisson: float) -> dict[int, Material]:
    return {
        1: material_of(Elastic(40.0, poisson), "veronda-westmann", exponent=2.0),
        2: material_of(Elastic(10.0, poisson), "mooney-rivlin", share=0.3),
    }


def body(poisson: float) -> tuple[Space, Array]:
    """Return a cube of two tissues and hard cells, and a random displacement of it."""
    space = box(*3 * (np.linspace(0.0, 1.0, 4),))
    height = space.points[space.cells].mean(axis=1)[:, 2]
    space = Space(space.points, space.cells, np.digitize(height, [0.4]).astype(np.int8) + 1)
    moved = 0.01 * np.random.default_rng(5).normal(size=(space.n_nodes, 3))
    return space, moved


def integral(space: Space, stored: StoredEnergy, moved: Array) -> tuple[float, float]:
    """Integrate the density at the vertices over the mesh, as pictures show it."""
    volume = space.scalar.dx.sum(axis=1)
    return tuple(
        float(volume @ stored.at_vertices(part)[space.vertices].mean(axis=1))
        for part in stored.cells(moved)
    )


@pytest.mark.parametrize("poisson", [0.3, 0.49, 0.49999])
def test_it_is_the_potential_at_the_pressures_that_make_it_stationary(poisson: float):
    space, moved = body(poisson)
    laws = tissues(poisson)
    elements = continuum(space, laws)
    values = np.concatenate([moved.ravel(), np.zeros(space.n_unknowns - moved.size)])
    n = moved.size
    rest = elements.at_rest
    # The derivative by the pressures is linear in them: one Newton step ends it.
    square = elements.tangent(values, rest)[n:, n:].toarray()
    values[n:] = np.linalg.solve(square, -elements.residual(values, rest)[0][n:])
    found = sum(integral(space, StoredEnergy(space, laws, finite=True), moved))
    assert found == pytest.approx(energy(elements, values, rest), rel=1e-6)


@pytest.mark.parametrize("poisson", [0.3, 0.499999])
def test_at_small_strain_it_is_half_the_displacement_times_the_force(poisson: float):
    space, moved = body(poisson)
    soft = {k: Elastic(modulus, poisson) for k, modulus in ((1, 40.0), (2, 10.0))}
    matrix, n = stiffness(space, soft), moved.size
    pressures = np.linalg.solve(matrix[n:, n:].toarray(), -(matrix[n:, :n] @ moved.ravel()))
    force = matrix[:n] @ np.append(moved.ravel(), pressures)
    laws = {k: material_of(elastic) for k, elastic in soft.items()}
    found = sum(integral(space, StoredEnergy(space, laws, finite=False), moved))
    assert found == pytest.approx(moved.ravel() @ force / 2, rel=1e-6)


def test_stiffening_is_the_mean_exponent_of_the_energy():
    """A cube that is sheared alike everywhere has I1 - 3 = shear²."""
    space, shear = body(0.49)[0], 0.3
    moved = np.zeros((space.n_nodes, 3))
    moved[:, 0] = shear * space.node_points[:, 2]
    stored = StoredEnergy(
        space, {1: material_of(Elastic(40.0, 0.49), "demiray", exponent=2.0)}, finite=True
    )
    assert stored.stiffening(moved) == pytest.approx(2.0 * shear**2, rel=1e-9)
    assert stored.stiffening(0 * moved) == 0.0
    both = StoredEnergy(space, tissues(0.49), finite=True)
    # Of the second tissue, a quarter as stiff, the exponent is 0; it has .6 of the height.
    volumes = np.bincount(space.tissue, space.scalar.dx.sum(axis=1))[1:]
    first = 40.0 * volumes[0]
    expected = 2.0 * shear**2 * first / (first + 10.0 * volumes[1])
    assert both.stiffening(moved) == pytest.approx(expected, rel=1e-9)
    plain = StoredEnergy(space, {2: tissues(0.49)[2]}, finite=True)
    assert plain.stiffening(moved) == 0.0


def test_tissue_of_constant_volume_and_cells_of_no_tissue_have_no_energy():
    space, moved = body(0.5)
    _, swelling = StoredEnergy(space, tissues(0.5), finite=True).cells(moved)
    assert not swelling.any()
    one = StoredEnergy(space, {1: tissues(0.5)[1]}, finite=True)
    shown = one.at_vertices(one.cells(moved)[0])
    inside = np.zeros(len(space.points), bool)
    inside[space.vertices[space.tissue == 1]] = True
    assert (shown[inside] > 0).all()
    assert not shown[~inside].any()
