"""Boxes of tetrahedra for tests and validation, where geometry must not be in the way."""

import numpy as np
from skfem import MeshTet

from fefinger.fem.spaces import Array, Space


def box(x: Array, y: Array, z: Array) -> Space:
    """Return the space on a box with the grid lines x, y, z in mm, six cells to each of its boxes.

    The box is one tissue with the label 1.
    """
    mesh = MeshTet.init_tensor(x, y, z)
    cells = np.ascontiguousarray(mesh.t.T, dtype=np.int64)
    return Space(np.ascontiguousarray(mesh.p.T), cells, np.ones(len(cells), dtype=np.int8))
