"""Boundaries of meshes: edges that one triangle has alone, and faces that one tetrahedron has."""

import numpy as np

from fefinger.geometry.finger_mesh import faces, volumes
from fefinger.support.arrays import Array, Integers


def boundary_edges(triangles: Integers) -> Integers:
    """Return the edges (k, 2) that only one of the triangles (n, 3) has, ascending."""
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2), axis=1)
    return np.asarray(pairs[_single(pairs)])


def boundary_faces(points: Array, cells: Integers) -> Integers:
    """Return the outward triangles (k, 3) that only one of the tetrahedra (n, 4) has.

    A cell may be numbered either way round.
    """
    inverted = volumes(points, cells) < 0
    cells = np.where(inverted[:, None], cells[:, [0, 2, 1, 3]], cells)
    every = faces(cells).reshape(-1, 3)
    return np.asarray(every[_single(every)])


def _single(rows: Integers) -> Integers:
    """Return the indices of the rows of vertices that no other row has, in whatever order."""
    _, first, count = np.unique(
        np.sort(rows, axis=1), axis=0, return_index=True, return_counts=True
    )
    return np.asarray(first[count == 1])
