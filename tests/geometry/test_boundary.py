"""Boundaries of triangles, against solids whose surface is known."""

import numpy as np
from scipy.spatial import ConvexHull

from fefinger.geometry.finger_mesh import boundary_edges


def test_the_boundary_of_a_square_is_its_four_sides():
    triangles = np.array([[0, 1, 2], [2, 3, 0]])
    assert boundary_edges(triangles).tolist() == [[0, 1], [0, 3], [1, 2], [2, 3]]


def test_a_closed_surface_has_no_boundary():
    tetrahedron = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    assert boundary_edges(tetrahedron).shape == (0, 2)
    assert boundary_edges(tetrahedron[1:]).tolist() == [[0, 1], [0, 2], [1, 2]]


def test_the_hull_of_points_has_no_boundary_until_a_triangle_is_taken_away():
    triangles = ConvexHull(np.random.default_rng(1).normal(size=(60, 3))).simplices
    assert len(boundary_edges(triangles)) == 0
    assert boundary_edges(triangles[1:]).tolist() == boundary_edges(triangles[:1]).tolist()
