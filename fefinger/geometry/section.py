"""Section of a finger mesh by its medial plane."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import boundary_edges
from fefinger.support.arrays import Array, Integers


SNAP = 1e-3  # distance over edge length below which a section vertex is moved to a mesh point


def is_half(points: Array) -> bool:
    """Whether only y >= 0 is meshed."""
    return bool(points[:, 1].min() >= -1e-9 * np.ptp(points))


@dataclass(frozen=True)
class EdgePoints:
    """Points on edges of a mesh, which follow the mesh through all of its frames.

    edges (n, 2) mesh points, weight (n,): 0 at the first point of an edge, 1 at the second.
    """

    edges: Integers
    weight: Array

    def at(self, nodal: Array) -> Array:
        """Interpolate values at the mesh points, (n_points, ...), to these points."""
        first, second = nodal[self.edges[:, 0]], nodal[self.edges[:, 1]]
        weight = self.weight.reshape(-1, *[1] * (nodal.ndim - 1))
        return np.asarray((1 - weight) * first + weight * second)


@dataclass(frozen=True)
class Cut(EdgePoints):
    """The medial section of a mesh: triangles (k, 3) of its points, and region (k,) of each."""

    triangles: Integers
    region: NDArray[np.int8]

    def outlines(self) -> Integers:
        """Edges (m, 2), in section vertices, that bound a region."""
        regions = np.unique(self.region)
        return np.concatenate([boundary_edges(self.triangles[self.region == k]) for k in regions])


def cut(points: Array, cells: Integers, region: NDArray[np.int8]) -> Cut:
    """Cut tetrahedra with the medial plane.

    The plane is at 1e-6 of the size above y = 0, so that it intersects the cells of half meshes.
    """
    level = 1e-6 * np.ptp(points)
    above = points[:, 1] > level
    count = above[cells].sum(axis=1)
    pairs, kinds = [], []
    for number in (1, 2, 3):
        hit = cells[count == number]
        order = np.argsort(~above[hit] if number < 3 else above[hit], axis=1, kind="stable")
        a, b, c, d = np.take_along_axis(hit, order, axis=1).T
        if number == 2:
            corners = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
        else:
            corners = [[(a, b), (a, c), (a, d)]]
        for triangle in corners:
            pairs.append(np.array(triangle).transpose(2, 0, 1).reshape(-1, 3, 2))
            kinds.append(region[count == number])
    every = np.sort(np.concatenate(pairs).reshape(-1, 2), axis=1)
    y = points[every][:, :, 1]
    weight = (level - y[:, 0]) / (y[:, 1] - y[:, 0])
    # A vertex next to a mesh point becomes that point: slivers would show as scratches.
    every[weight < SNAP, 1] = every[weight < SNAP, 0]
    every[weight > 1 - SNAP, 0] = every[weight > 1 - SNAP, 1]
    edges, first, vertex = np.unique(every, axis=0, return_index=True, return_inverse=True)
    triangles = vertex.reshape(-1, 3)
    proper = (np.diff(np.sort(triangles, axis=1), axis=1) > 0).all(axis=1)
    regions = np.concatenate(kinds)[proper]
    return Cut(edges, np.clip(weight[first], 0.0, 1.0), triangles[proper], regions)
