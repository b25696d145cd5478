"""Smooth symmetric surface of a scan, free of its noise and of its facets."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from fefinger.geometry import finger_mesh
from fefinger.support.arrays import Array, Flags, Integers


SPACING = 0.35
"""Largest edge in mm of the refined scan whose vertices define the surface."""


DENSEST, THINNED, FITTED = 0.15, 0.25, 60
"""Side in mm of the cubes that have one point of the surface each, side of those that have one
sample of the scan each, and the number of samples in a fit: those within some 1.1 mm, however dense
the scan is."""


@dataclass(frozen=True)
class Cloud:
    """A smooth surface between points and their mirror images, moved inward by `inset` mm.

    The signed distance is a weighted mean of the distances from the tangent planes of the nearest
    points (implicit moving least squares, Kolluri 2008), and the mean of that at a point and at its
    mirror image.
    """

    points: Array
    point_normals: Array
    tree: Any
    inset: float = 0.0
    symmetric: bool = False

    @classmethod
    def of(cls, points: Array, normals: Array, inset: float = 0.0) -> "Cloud":
        """Return the surface through points (n, 3) with outward normals (n, 3).

        It is symmetric already where the second half of both is the mirror image of the first.
        """
        half, rest = divmod(len(points), 2)
        symmetric = not rest and all(
            np.array_equal(each[half:], finger_mesh.image(each[:half]))
            for each in (points, normals)
        )
        return cls(points, normals, cKDTree(points), inset, symmetric)

    def level(self, points: Array) -> Array:
        """Return a signed distance, negative inside, (n,) mm."""
        return self._evaluate(points)[0]

    def normals(self, points: Array) -> Array:
        """Return the unit outward normals (n, 3) at points of the surface."""
        return self._evaluate(points)[1]

    def project(self, points: Array, *, free: Flags | None = None) -> Array:
        """Return points (n, 3) moved onto the surface, changing only free coordinates."""
        moved = np.array(points, dtype=float)
        mask = np.ones_like(moved) if free is None else np.broadcast_to(free, moved.shape)
        away = np.arange(len(moved))
        for _ in range(60):
            level, normals = self._evaluate(moved[away])
            normals *= mask[away]
            size = np.maximum(np.einsum("ij,ij->i", normals, normals), 0.05)
            moved[away] -= np.clip(level / size, -0.5, 0.5)[:, None] * normals
            away = away[np.abs(level) >= 1e-8]
            if not len(away):
                break
        return moved

    def asymmetry(self) -> float:
        """Mean distance in mm of the points from the mirror image of their surface."""
        return float(np.mean(np.abs(self._through(finger_mesh.image(self.points))[0])))

    def _evaluate(self, points: Array) -> tuple[Array, Array]:
        """Compute signed distances (n,) mm and unit normals (n, 3)."""
        here, normals = self._through(points)
        if self.symmetric:
            # Of points in the middle, the nearest ones may be of one side.
            there, mirrored = (
                here,
                np.where(points[:, 1:2] == 0.0, normals, finger_mesh.image(normals)),
            )
        else:
            there, mirrored = self._through(finger_mesh.image(points))
        normals = normals + finger_mesh.image(mirrored)
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        return (here + there) / 2.0 + self.inset, normals

    def _through(self, points: Array) -> tuple[Array, Array]:
        """Compute signed distances (n,) mm and normals (n, 3) of the surface through the points."""
        # Averaged over 16 vertices, two rings, to smooth the facets of a scan.
        distance, index = self.tree.query(points, k=16)
        reach = distance[:, :1] ** 2 + SPACING**2
        weight = np.exp(-(distance**2 - distance[:, :1] ** 2) / reach)
        weight /= weight.sum(axis=1)[:, None]
        normals = self.point_normals[index]
        offsets = np.einsum("nki,nki->nk", points[:, None] - self.points[index], normals)
        mean = np.einsum("nk,nki->ni", weight, normals)
        mean /= np.linalg.norm(mean, axis=1)[:, None]
        return np.einsum("nk,nk->n", weight, offsets), mean


def smoothed(points: Array, normals: Array) -> Cloud:
    """Return the surface through points (n, 3) with outward normals (n, 3), without their noise.

    Each is moved to the cubic fitted around it: a cubic over the tangent plane (weighted least
    squares) follows the curvature of a finger, and leaves out the noise and the facets of a scan.
    """
    samples = points[_thinned(points, THINNED)]
    kept = _thinned(points, DENSEST)
    points, normals = points[kept], normals[kept]
    distance, near = cKDTree(samples).query(points, k=FITTED)
    # Points that are fitted at a time; all 18,697 of a finger took twice as long, in main memory.
    at_once = 1000
    fitted = [
        _fitted(points[part], normals[part], samples[near[part]], distance[part])
        for part in (slice(start, start + at_once) for start in range(0, len(points), at_once))
    ]
    moved, turned = (np.concatenate(each) for each in zip(*fitted, strict=True))
    return Cloud.of(moved, turned)


def _fitted(points: Array, normals: Array, near: Array, distance: Array) -> tuple[Array, Array]:
    """Move points (n, 3) to the cubics through samples (n, k, 3) near them; return their normals.

    distance (n, k) mm of the samples, rising.
    """
    across = np.cross(normals, np.eye(3)[np.argmin(np.abs(normals), axis=1)])
    across /= np.linalg.norm(across, axis=1)[:, None]
    frame = np.stack([across, np.cross(normals, across), normals], axis=1)
    u, v, height = np.einsum("nij,nkj->ink", frame, near - points[:, None])
    terms = np.stack([u**i * v**j for i in range(4) for j in range(4 - i)], axis=1)
    weighted = terms * np.exp(-2.0 * (distance / distance[:, -1:]) ** 2)[:, None]
    matrix = weighted @ terms.transpose(0, 2, 1)
    fit = np.linalg.solve(matrix, (weighted @ height[:, :, None]))[:, :, 0]
    constant, by_v, by_u = fit[:, 0], fit[:, 1], fit[:, 4]
    turned = np.einsum("in,nij->nj", np.stack([-by_u, -by_v, np.ones(len(fit))]), frame)
    turned /= np.linalg.norm(turned, axis=1)[:, None]
    return points + constant[:, None] * normals, turned


def _thinned(points: Array, side: float) -> Integers:
    """Return the indices of one of the points (n, 3) in each cube of a side in mm."""
    return np.unique(np.floor(points / side), axis=0, return_index=True)[1]
