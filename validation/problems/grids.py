"""Structured tetrahedral meshes for tests and validation: boxes, and quarters of round bodies.

A quarter is a flat body of revolution, graded in its section where the solution is steep and even
around its axis, where the solution is smooth.
"""

from collections.abc import Callable, Sequence

import numpy as np
from skfem import MeshTet, MeshTri

from fefinger.fem.elements.spaces import Space
from fefinger.support.arrays import Array, Integers


Size = Callable[[Array, Array], Array]


def box(x: Array, y: Array, z: Array) -> Space:
    """Return the space on a box with the grid lines x, y, z in mm, six cells to each of its boxes.

    The box is one tissue with the label 1.
    """
    mesh = MeshTet.init_tensor(x, y, z)
    cells = np.ascontiguousarray(mesh.t.T, dtype=np.int64)
    return Space(np.ascontiguousarray(mesh.p.T), cells, np.ones(len(cells), dtype=np.int8))


def octant(refinements: int) -> Space:
    """Return the eighth x, y, z >= 0 of a ball of radius 1 mm: a cell, halved so many times.

    Each point keeps its direction; its distance is the sum of its coordinates in the cell.
    """
    corner = MeshTet(np.vstack([np.zeros(3), np.eye(3)]).T, np.array([[0], [1], [2], [3]]))
    mesh = corner.refined(refinements) if refinements else corner
    points = np.ascontiguousarray(mesh.p.T)
    lengths = np.linalg.norm(points, axis=1, keepdims=True)
    sums = points.sum(axis=1, keepdims=True)
    scale = np.divide(sums, lengths, out=np.ones_like(sums), where=lengths > 0)
    cells = np.ascontiguousarray(mesh.t.T, dtype=np.int64)
    return Space(points * scale, cells, np.ones(len(cells), dtype=np.int8))


def quarter(
    r: Array, z: Array, size: Size, sectors: int, *, interfaces: Sequence[float] = ()
) -> Space:
    """Return the quarter x, y >= 0 of a body of revolution about the z axis.

    Parameters
    ----------
    r, z
        Grid lines in mm of the section before it is refined, both from zero.
    size
        Longest edge in mm wanted of a triangle of the section, at its center (r, z).
    sectors
        Prisms around the quarter; its circles are polygons with 4 `sectors` sides.
    interfaces
        Depths in mm, each in `z`, below which the tissue has the next label; the first is 1.
    """
    points, triangles = _section(r, z, size)
    points, triangles = _axis_first(points, triangles)
    places, cells = _revolved(points, triangles, sectors)
    depth = places[cells][:, :, 2].mean(axis=1)
    tissue = 1 + np.searchsorted(np.asarray(interfaces, float), depth)
    return Space(places, cells, tissue.astype(np.int8))


def _section(r: Array, z: Array, size: Size) -> tuple[Array, Integers]:
    """Bisect the triangles of a grid until none is longer than `size`."""
    mesh = MeshTri.init_tensor(r, z)
    while True:
        corners = mesh.p[:, mesh.t]
        edges = corners - np.roll(corners, 1, axis=1)
        longest = np.sqrt(np.sum(edges**2, axis=0)).max(axis=0)
        wrong = np.flatnonzero(longest > size(*corners.mean(axis=1)))
        if len(wrong) == 0:
            return mesh.p.T.copy(), mesh.t.T.astype(np.int64)
        mesh = mesh.refined(wrong)


def _axis_first(points: Array, triangles: Integers) -> tuple[Array, Integers]:
    """Renumber, points on the axis first, and the corners of each triangle upward."""
    order = np.argsort(points[:, 0] > 0, kind="stable")
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return points[order], np.sort(rank[triangles], axis=1)


def _revolved(points: Array, triangles: Integers, sectors: int) -> tuple[Array, Integers]:
    """Return points (n, 3) and cells (n_cells, 4) of the prisms on the triangles.

    Prisms are cut along the diagonals that leave their lower numbers, which fits from prism to
    prism; at the axis a prism has lost corners, and its cells without volume are left out.
    """
    fixed = int(np.sum(points[:, 0] == 0))
    moved = len(points) - fixed
    number = np.arange(len(points)) + moved * np.arange(sectors + 1)[:, None]
    number[:, :fixed] = np.arange(fixed)
    angle = np.pi / 2 * np.arange(sectors + 1) / sectors
    cosine, sine = np.cos(angle), np.sin(angle)
    cosine[-1] = 0.0  # the last plane of symmetry holds its points exactly
    places = np.empty((fixed + moved * (sectors + 1), 3))
    for row, c, s in zip(number, cosine, sine, strict=True):
        places[row] = np.column_stack([points[:, 0] * c, points[:, 0] * s, points[:, 1]])
    near, far = number[:-1][:, triangles], number[1:][:, triangles]
    prisms = np.stack([near, far]).reshape(2, -1, 3)
    a, b = np.moveaxis(prisms, 2, 1)
    cells = np.concatenate(
        [
            np.stack([a[0], a[1], a[2], b[2]], axis=1),
            np.stack([a[0], a[1], b[1], b[2]], axis=1),
            np.stack([a[0], b[0], b[1], b[2]], axis=1),
        ]
    )
    distinct = (np.diff(np.sort(cells, axis=1), axis=1) > 0).all(axis=1)
    return places, cells[distinct]
