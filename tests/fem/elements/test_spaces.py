"""Spaces and traces: faces, areas, and the smooth surface between flat facets."""

import numpy as np
import pytest
from fefinger.validation.problems.grids import box
from skfem import MeshTet

from fefinger.fem.contact.patch import foremost, smooth_places
from fefinger.fem.elements.spaces import Space, trace


def cap(cells: int, radius: float = 10.0) -> tuple[Space, np.ndarray, np.ndarray]:
    """Return a slab whose face z = 0 is bent onto a sphere, its triangles and its normals."""
    line = np.linspace(-1, 1, cells + 1)
    flat = box(line, line, np.array([0.0, 0.5]))
    facets = np.asarray(flat.scalar.mesh.facets.T, dtype=np.int64)
    triangles = facets[(flat.points[facets][:, :, 2] == 0).all(axis=1)]
    points = flat.points.copy()
    face = np.unique(triangles)
    points[face, 2] = radius - np.sqrt(radius**2 - np.sum(points[face, :2] ** 2, axis=1))
    normals = np.zeros_like(points)
    normals[face] = (points[face] - [0, 0, radius]) / radius
    return Space(points, flat.cells, flat.tissue), triangles, normals


def test_smooth_places_approach_the_sphere_with_fourth_order() -> None:
    errors, sag = [], []
    for cells in (2, 4, 8):
        space, triangles, normals = cap(cells)
        surface = trace(space, triangles)
        smooth = smooth_places(space.points, normals, surface)
        errors.append(np.abs(np.linalg.norm(smooth - [0, 0, 10.0], axis=2) - 10.0).max())
        flat = np.linalg.norm(surface.places - [0, 0, 10.0], axis=2)
        sag.append(np.abs(flat - 10.0).max())
    assert np.polyfit(np.log([2, 4, 8]), np.log(errors), 1)[0] < -3.5
    assert errors[-1] < 1e-3 * sag[-1]


@pytest.mark.parametrize("tilt", [(0.03, -0.02), (-0.04, 0.01), (0.02, 0.03)])
def test_a_plate_meets_a_sphere_where_its_normal_is(tilt: tuple[float, float]) -> None:
    """The foremost vertex is 0.1 to 0.3 mm beside it, between vertices 0.5 mm apart."""
    space, triangles, normals = cap(4)
    axis = np.array([*tilt, 1.0]) / np.linalg.norm([*tilt, 1.0])
    exact = np.array([0, 0, 10.0]) - 10.0 * axis
    found = foremost(space.points, normals, triangles, axis)
    assert np.linalg.norm(found - exact) < 0.03
    vertex = space.points[triangles.ravel()[np.argmin(space.points[triangles.ravel()] @ axis)]]
    assert np.linalg.norm(vertex - exact) > 0.1


def test_a_trace_integrates_the_area_and_the_shapes_sum_to_one() -> None:
    space, triangles, _ = cap(6)
    surface = trace(space, triangles)
    line, weight = np.polynomial.legendre.leggauss(20)
    x, y = np.meshgrid(line, line)
    exact = float(np.sum(np.outer(weight, weight) * 10 / np.sqrt(100 - x**2 - y**2)))
    assert surface.weights.sum() == pytest.approx(exact, rel=1e-4)
    assert surface.linear.sum(axis=0) == pytest.approx(np.ones(surface.linear.shape[1]))
    assert surface.quadratic.sum(axis=0) == pytest.approx(np.ones(surface.quadratic.shape[1]))


def test_triangles_that_are_no_faces_are_told_apart() -> None:
    space, triangles, _ = cap(2)
    away = int(np.argmax(np.linalg.norm(space.points - space.points[triangles[0, 0]], axis=1)))
    other = np.array([[triangles[0, 0], triangles[0, 1], away]])
    assert space.has_faces(np.vstack([triangles, other])).tolist() == [True] * len(triangles) + [
        False
    ]
    with pytest.raises(KeyError, match="expected faces of the mesh"):
        space.edge_nodes(other)


def test_edges_and_faces_have_the_numbers_of_scikit_fem() -> None:
    mesh = box(*3 * (np.linspace(0, 1, 4),)).scalar.mesh
    order = np.random.default_rng(0).permutation(mesh.p.shape[1])  # vertices in any order
    own, plain = type(mesh)(mesh.p, order[mesh.t]), MeshTet(mesh.p, order[mesh.t])
    for name in ("edges", "t2e", "facets", "t2f"):
        np.testing.assert_array_equal(getattr(own, name), getattr(plain, name))


def test_the_faces_of_a_mesh_are_those_of_its_cells() -> None:
    space = box(*3 * (np.linspace(0, 1, 4),))
    faces = space.scalar.mesh.facets.T
    assert space.has_faces(np.roll(faces, 1, axis=1)).all()
    corners = np.random.default_rng(0).permuted(np.tile(np.arange(64), (500, 1)), axis=1)[:, :3]
    expected = [set(three) in [set(face) for face in faces.tolist()] for three in corners.tolist()]
    assert 0 < sum(expected) < len(expected)
    assert space.has_faces(corners).tolist() == expected
