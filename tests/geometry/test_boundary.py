"""Boundaries of triangles and of tetrahedra, against solids whose surface is known."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull, Delaunay

from fefinger.geometry.boundary import boundary_edges, boundary_faces


RNG = np.random.default_rng(1)


def test_the_boundary_of_a_square_is_its_four_sides():
    triangles = np.array([[0, 1, 2], [2, 3, 0]])
    assert boundary_edges(triangles).tolist() == [[0, 1], [0, 3], [1, 2], [2, 3]]


def test_a_closed_surface_has_no_boundary():
    tetrahedron = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    assert boundary_edges(tetrahedron).shape == (0, 2)
    assert boundary_edges(tetrahedron[1:]).tolist() == [[0, 1], [0, 2], [1, 2]]


@pytest.mark.parametrize("turned", [False, True])
def test_the_boundary_of_a_convex_solid_is_its_hull_and_looks_outward(turned):
    points = RNG.normal(size=(60, 3))
    cells, hull = Delaunay(points).simplices.astype(np.int64), ConvexHull(points)
    if turned:
        cells[::2] = cells[::2][:, [1, 0, 2, 3]]
    faces = boundary_faces(points, cells)
    assert set(map(tuple, np.sort(faces, axis=1))) == set(map(tuple, np.sort(hull.simplices)))
    a, b, c = np.moveaxis(points[faces], 1, 0)
    assert np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6 == pytest.approx(hull.volume)
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a - points.mean(axis=0)) > 0).all()
    assert len(boundary_edges(faces)) == 0
