"""The skin that a population lies under: of a meshed finger, and of a spherical pad."""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.finger_mesh import triangle_areas
from fefinger.geometry.mirror import Halves
from fefinger.geometry.profiles import directions
from fefinger.support.arrays import Array, Integers


if TYPE_CHECKING:
    from fefinger.neural.populations import Surface


LATTICE = 0.4  # mm between the points of a spherical pad
STEEPEST = 0.9  # sine of the slope at which a spherical pad ends


def meshed(points: Array, triangles: Integers, normals: Array, *, half: bool) -> "Surface":
    """Return the skin of a mesh: triangles (n, 3) of its pad, smooth outward normals (n_points, 3).

    That of a half model is mirrored.
    """
    from fefinger.neural.populations import Surface

    weights = np.repeat(triangle_areas(points[triangles]) / 3.0, 3)
    shares = np.bincount(triangles.ravel(), weights, len(points)).astype(np.float64)
    used = np.unique(triangles)
    used = used[np.linalg.norm(normals[used], axis=1) > 0.5]
    points, normals, shares = points[used], normals[used], shares[used]
    if half:
        halves = Halves.of(points)
        points, normals = halves.vectors(points), halves.vectors(normals)
        shares = halves.shares(shares)
    return Surface(points, normals / np.linalg.norm(normals, axis=1, keepdims=True), shares)


def spherical(radius: float, axis: Array) -> "Surface":
    """Return a pad of `radius` mm that touches the origin, where `axis` (3,) points inward."""
    from fefinger.neural.populations import Surface

    reach = STEEPEST * radius
    x = LATTICE * np.arange(-np.floor(reach / LATTICE), np.floor(reach / LATTICE) + 1)
    flat = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    flat = flat[np.linalg.norm(flat, axis=1) <= reach]
    depth = np.sqrt(radius**2 - np.sum(flat**2, axis=1))
    outward = flat @ directions(axis) - np.outer(depth, axis)
    return Surface(radius * axis + outward, outward / radius, LATTICE**2 * radius / depth)
