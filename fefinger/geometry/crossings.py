"""Places where a triangulated surface crosses itself."""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.support.arrays import Array, Flags, Integers


if TYPE_CHECKING:
    from trimesh import Trimesh


FOLD = 3
"""Edges between triangles that cross each other up to which that is a fold of the surface."""


def crossings(mesh: "Trimesh") -> Array | None:
    """Find a self-intersection: a point (3,) where an edge passes through a triangle, or None.

    Triangles that share a vertex, and nearly coplanar ones, do not count; nor do folds between
    triangles up to FOLD edges apart, which are noise of a scan.
    """
    # Of a finger one unit wide: the tolerances of the intersection are absolute.
    wide = float(np.sort(mesh.extents)[1])
    faces = mesh.faces
    corners = ((mesh.vertices - mesh.bounds[0]) / wide)[faces]
    pairs = _neighbors(corners)
    low, high = corners.min(axis=1), corners.max(axis=1)
    overlap = (low[pairs[:, 0]] <= high[pairs[:, 1]]) & (low[pairs[:, 1]] <= high[pairs[:, 0]])
    pairs = pairs[overlap.all(axis=1)]
    shared = (faces[pairs[:, 0]][:, :, None] == faces[pairs[:, 1]][:, None, :]).any(axis=(1, 2))
    pairs = pairs[~shared]
    for one, other in ((0, 1), (1, 0)):
        edge, plane = corners[pairs[:, one]], corners[pairs[:, other]]
        for k in range(3):
            hit = _pierced(edge[:, k], edge[:, (k + 1) % 3], plane)
            for which in np.flatnonzero(hit):
                if not _is_fold(mesh, faces[pairs[which, 0]], faces[pairs[which, 1]]):
                    return np.asarray(mesh.bounds[0] + wide * plane[which].mean(axis=0))
    return None


def _is_fold(mesh: "Trimesh", one: Integers, other: Integers) -> bool:
    """Whether two triangles (3,) are up to FOLD edges apart along the surface."""
    edges, reached = mesh.edges, np.zeros(len(mesh.vertices), dtype=bool)
    reached[one] = True
    for _ in range(FOLD):
        reached[edges[reached[edges[:, 0]], 1]] = True
    return bool(reached[other].any())


def _neighbors(corners: Array) -> Integers:
    """Pairs (k, 2) of triangles (n, 3, 3) that are near enough to meet.

    Sorted by size, so that the few long triangles of a cut end do not make all of them near.
    """
    from scipy.spatial import cKDTree

    centers = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centers[:, None], axis=2).max(axis=1)
    octave = np.floor(np.log2(radii.max() / radii)).astype(int)
    sizes = [np.flatnonzero(octave == one) for one in np.unique(octave)]
    trees = [cKDTree(centers[members]) for members in sizes]
    pairs = []
    for i, members in enumerate(sizes):
        largest = radii[members].max()
        same = trees[i].query_pairs(2.0 * largest, output_type="ndarray")
        pairs.append(members[same])
        for tree, smaller in zip(trees[i + 1 :], sizes[i + 1 :], strict=True):
            reach = largest + radii[smaller].max()
            near = trees[i].sparse_distance_matrix(tree, reach, output_type="ndarray")
            pairs.append(np.column_stack([members[near["i"]], smaller[near["j"]]]))
    return np.concatenate(pairs)


def _pierced(start: Array, end: Array, triangle: Array) -> Flags:
    """Whether segments pass through the inside of their triangles: a + first u + second v."""
    a, b, c = triangle.transpose(1, 0, 2)
    along, u, v = end - start, b - a, c - a
    size = np.linalg.norm(along, axis=1) * np.linalg.norm(np.cross(u, v), axis=1)
    system = np.stack([u, v, -along], axis=2)
    steep = np.abs(np.linalg.det(system)) > 1e-6 * size
    system[~steep] = np.eye(3)
    first, second, place = np.linalg.solve(system, (start - a)[..., None])[..., 0].T
    small = 1e-9
    # An edge counts as a part of the triangle: symmetric surfaces cross edge on edge.
    inside = (first > -small) & (second > -small) & (first + second < 1 + small)
    return np.asarray(steep & inside & (place > small) & (place < 1 - small))
