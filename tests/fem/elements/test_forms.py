"""Taylor-Hood elements: patch test, manufactured solution, rigid motion, strain at points."""

import numpy as np
import pytest
from fefinger.validation.fem import elements
from fefinger.validation.problems.grids import box

from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.probe import inside, locate, strain_at, strain_at_vertices
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg.system import factor
from fefinger.support.checks import InputError
from fefinger.support.tensors import tensor_from_voigt
from fefinger.support.tolerances import INSIDE


RATIOS = [0.0, 0.3, 0.49, 0.5]


def cube(cells: int, *, tissues: int = 1, seed: int = 3) -> Space:
    """Return a unit cube of shaken tetrahedra, in layers along z if `tissues` is above 1."""
    even = box(*3 * (np.linspace(0, 1, cells + 1),))
    points, vertices = even.points.copy(), even.cells
    tissue = 1 + np.floor(points[vertices][:, :, 2].mean(axis=1) * tissues).astype(np.int8)
    if tissues == 1:
        inside = ((points > 0) & (points < 1)).all(axis=1)
        shake = np.random.default_rng(seed).uniform(-0.15, 0.15, points.shape) / cells
        points[inside] += shake[inside]
    return Space(points, vertices, tissue)


def boundary(space: Space) -> np.ndarray:
    places = space.node_points
    outer = (np.isclose(places, 0) | np.isclose(places, 1)).any(axis=1)
    return np.flatnonzero(np.repeat(outer, 3))


@pytest.mark.parametrize("poisson", RATIOS)
def test_linear_displacements_are_exact(poisson: float) -> None:
    space = cube(3)
    gradient = np.array([[0.1, 0.2, -0.3], [0.4, -0.3, 0.1], [0.05, 0.6, 0.2]])
    assert np.trace(gradient) == pytest.approx(0)  # so that nu = 0.5 is possible too
    exact = space.node_points @ gradient.T
    fixed = boundary(space)
    system = factor(space, stiffness(space, {1: Elastic(7.0, poisson)}), fixed)
    answer = system.solve(np.zeros(space.n_unknowns), exact.ravel()[fixed])
    assert answer[: space.n_displacements] == pytest.approx(exact.ravel(), abs=1e-9)
    strain = (strain_at(space, np.array([[0.31, 0.42, 0.53], [0.9, 0.1, 0.2]])) @ answer).reshape(
        -1, 6
    )
    assert tensor_from_voigt(strain) == pytest.approx(
        np.tile((gradient + gradient.T) / 2, (2, 1, 1))
    )


def test_constant_mean_stress_is_exact_in_a_compressible_body() -> None:
    space, elastic = cube(2), Elastic(3.0, 0.3)
    exact = 0.01 * space.node_points
    fixed = boundary(space)
    system = factor(space, stiffness(space, {1: elastic}), fixed)
    answer = system.solve(np.zeros(space.n_unknowns), exact.ravel()[fixed])
    mean_stress = answer[space.n_displacements :] * elastic.shear
    assert mean_stress == pytest.approx(0.03 / elastic.compressibility)


@pytest.mark.parametrize("poisson", RATIOS)
def test_a_free_bar_has_the_modulus_and_the_poisson_ratio_that_it_was_given(poisson: float) -> None:
    space, modulus, squeeze = cube(2), 7.0, 0.01
    held = np.isclose(space.node_points, 0)
    top = np.isclose(space.node_points[:, 2], 1)
    held[top, 2] = True
    fixed = np.flatnonzero(held.ravel())
    prescribed = np.zeros((space.n_nodes, 3))
    prescribed[top, 2] = -squeeze
    system = factor(space, stiffness(space, {1: Elastic(modulus, poisson)}), fixed)
    loads = np.zeros(space.n_unknowns)
    answer = system.solve(loads, prescribed.ravel()[fixed])
    reactions = np.zeros(space.n_unknowns)
    reactions[fixed] = system.reactions(answer, loads)
    at_nodes = answer[: space.n_displacements].reshape(-1, 3)
    force = reactions[: space.n_displacements].reshape(-1, 3)[top, 2].sum()
    assert force == pytest.approx(-modulus * squeeze, rel=1e-8)
    side = np.isclose(space.node_points[:, 0], 1)
    assert at_nodes[side, 0] == pytest.approx(np.full(side.sum(), poisson * squeeze), abs=1e-10)


@pytest.mark.parametrize("poisson", RATIOS)
def test_rigid_motion_gives_no_strain_and_no_force(poisson: float) -> None:
    space = cube(2)
    matrix = stiffness(space, {1: Elastic(2.0, poisson)})
    rigid = np.zeros(space.n_unknowns)
    shift = np.array([1.0, 2.0, 3.0])
    rotation = np.cross([0.3, -0.7, 0.2], space.node_points) + shift
    rigid[: space.n_displacements] = rotation.ravel()
    assert np.abs(matrix @ rigid).max() < 1e-13
    assert np.abs(strain_at_vertices(space) @ rigid).max() < 1e-13


def test_the_manufactured_load_is_minus_the_divergence_of_its_stress() -> None:
    exact = elements.Manufactured(Elastic(2.0, 0.4))
    points = np.random.default_rng(7).uniform(0, 1, (5, 3))
    step = 1e-5
    divergence = np.zeros((5, 3))
    for j in range(3):
        shift = step * np.eye(3)[j]
        ahead, behind = exact.stress(points + shift), exact.stress(points - shift)
        divergence += (ahead - behind)[:, :, j] / (2 * step)
        ahead, behind = exact.displacement(points + shift), exact.displacement(points - shift)
        slope = (ahead - behind) / (2 * step)
        assert exact.gradient(points)[:, :, j] == pytest.approx(slope, abs=1e-8)
    assert exact.load(points) == pytest.approx(-divergence, abs=1e-6)
    volume = np.einsum("nii->n", exact.gradient(points))
    mean = exact.mean_stress(points) * exact.elastic.compressibility
    assert volume == pytest.approx(mean, abs=1e-12)


def test_mean_stress_may_jump_between_tissues() -> None:
    soft, stiff = Elastic(1.0, 0.4), Elastic(20.0, 0.4)
    space = cube(4, tissues=2)
    assert space.n_unknowns - space.n_displacements == 125 + 25  # the interface counts twice
    ends = np.isclose(space.node_points[:, 2], 0) | np.isclose(space.node_points[:, 2], 1)
    sides = (np.isclose(space.node_points, 0) | np.isclose(space.node_points, 1)).any(axis=1)
    held = np.zeros((space.n_nodes, 3), dtype=bool)
    held[sides, :2] = True
    held[ends, 2] = True
    fixed = np.flatnonzero(held.ravel())
    prescribed = np.zeros((space.n_nodes, 3))
    prescribed[np.isclose(space.node_points[:, 2], 1), 2] = -0.01
    system = factor(space, stiffness(space, {1: soft, 2: stiff}), fixed)
    answer = system.solve(np.zeros(space.n_unknowns), prescribed.ravel()[fixed])
    oedometer = [t.shear * 4 / 3 + 1 / t.compressibility for t in (soft, stiff)]
    stress = -0.01 / sum(0.5 / m for m in oedometer)
    strain = strain_at(space, np.array([[0.4, 0.5, 0.2], [0.4, 0.5, 0.8]])) @ answer
    expected = [stress / oedometer[0], stress / oedometer[1]]
    assert strain.reshape(-1, 6)[:, 2] == pytest.approx(np.array(expected), rel=1e-8)


def test_quadratic_displacement_has_its_exact_strain_everywhere() -> None:
    space = cube(2)
    x, y, z = space.node_points.T
    unknowns = np.zeros(space.n_unknowns)
    unknowns[: space.n_displacements] = np.stack([x * y, y * z + x**2, z * x], axis=1).ravel()
    at = np.random.default_rng(1).uniform(0.05, 0.95, (7, 3))
    strain = tensor_from_voigt((strain_at(space, at) @ unknowns).reshape(-1, 6))
    for (px, py, pz), e in zip(at, strain, strict=True):
        gradient = np.array([[py, px, 0], [2 * px, pz, py], [pz, 0, px]])
        assert e == pytest.approx((gradient + gradient.T) / 2)


def test_a_site_that_cells_share_gets_their_mean() -> None:
    space = cube(2, seed=0)
    unknowns = np.random.default_rng(4).normal(size=space.n_unknowns)
    corner = space.points[np.argmin(np.abs(space.points - 0.5).sum(axis=1))]
    _, cells, _ = locate(space, corner[None])
    assert len(cells) == (space.vertices == np.argmin(np.abs(space.points - corner).sum(1))).sum()
    inside = corner + 1e-6 * (space.points[space.vertices[cells]].mean(axis=1) - corner)
    around = (strain_at(space, inside) @ unknowns).reshape(-1, 6)
    shared = strain_at(space, corner[None]) @ unknowns
    assert shared == pytest.approx(around.mean(axis=0), abs=1e-3)


def test_a_site_outside_the_body_is_refused() -> None:
    with pytest.raises(InputError, match="expected a point in the soft tissue"):
        strain_at(cube(2), np.array([[0.5, 0.5, 1.2]]))


def test_the_body_holds_its_points_and_as_much_beyond_as_flat_facets_cut_off() -> None:
    """At a corner the middle of its cell is as far as it gets, and all others are beyond."""
    space = cube(2)
    within = np.random.default_rng(5).uniform(0.0, 1.0, (50, 3))
    (alone,) = space.cells[(space.cells == 0).any(axis=1)][:1]
    corner = space.points[0]
    outward = 4 * INSIDE * (corner - space.points[alone].mean(axis=0))
    near, far = (corner + part * outward for part in (0.9, 1.1))
    assert inside(space, np.concatenate([within, near[None]])).all()
    assert not inside(space, np.concatenate([within + 2.0, far[None]])).any()
    assert inside(space, np.empty((0, 3))).shape == (0,)
