"""Boundaries of surfaces: edges that one triangle has alone."""

import numpy as np

from fefinger.support.arrays import Integers


def boundary_edges(triangles: Integers) -> Integers:
    """Return the edges (k, 2) that only one of the triangles (n, 3) has, ascending."""
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2), axis=1)
    edges, count = np.unique(pairs, axis=0, return_counts=True)
    return np.asarray(edges[count == 1])
