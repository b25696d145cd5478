"""Pressure between the points of the pad, linear on each triangle, and its mean over 1 mm².

With forces at the mesh points only, a mean over 1 mm² would depend on the positions of the points.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.finger_mesh import triangle_areas
from fefinger.results.records import Pad
from fefinger.support.arrays import Array, Flags


if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

MOST = 8
"""Largest number of parts of an edge."""

FAR = 4.0
"""Cutoff of a Gaussian in standard deviations; it neglects 3e-4 of the weight."""

SPREAD = 1 / np.sqrt(2 * np.pi)
"""Standard deviation in mm of a Gaussian whose integral is 1 mm² times its peak."""


def net(pad: Pad, parts: int) -> "tuple[csr_matrix, csr_matrix]":
    """Refine the pad's triangles to m points whose forces represent the linear pressure.

    Every edge is divided into `parts`, every triangle into parts² with their forces at their
    centers. The force of a point of the pad, pressure times area, is preserved and distributed.
    Returns matrices (m, n_pad) from values at the pad's points to values at the refined ones, and
    in mm² from pressures in kPa at the pad's points to forces in mN at the refined ones.
    """
    from scipy import sparse

    corners = _corners(parts)
    size = triangle_areas(pad.points[pad.triangles]) / len(corners)
    columns = np.repeat(pad.triangles, len(corners), axis=0)
    values = np.tile(corners, (len(pad.triangles), 1))
    rows = np.repeat(np.arange(len(values)), 3)
    shape = (len(values), len(pad.points))
    between = sparse.csr_matrix((values.ravel(), (rows, columns.ravel())), shape=shape)
    loads = sparse.diags(np.repeat(size, len(corners))) @ between
    total = np.asarray(loads.sum(axis=0)).ravel()
    share = np.divide(pad.areas, total, out=np.zeros_like(total), where=total > 0)
    return between, (loads @ sparse.diags(share)).tocsr()


def highest(pad: Pad, pressure: Array) -> tuple[float, Array]:
    """Largest mean pressure in kPa over 1 mm² at any time, see `peaks`, and its place (3,) mm."""
    points, means = _means(pad, pressure)
    number = int(means.max(axis=1).argmax())
    return float(means[number].max()), points[number]


def peaks(pad: Pad, pressure: Array) -> Array:
    """Largest mean pressure (n_t,) in kPa over 1 mm², of pressures (n_t, n_pad).

    The mean is weighted by a Gaussian about each point of the pad. Unlike the pressure of a single
    point, which varies by a quarter at the rim of a plate on the standard mesh, it does not depend
    on the mesh.
    """
    return np.asarray(_means(pad, pressure)[1].max(axis=0))


def _means(pad: Pad, pressure: Array) -> tuple[Array, Array]:
    """Compute the points (n, 3) mm that ever bear pressure, and the means (n, n_t) kPa about them.

    The first point of the pad, with zeros, where none does.
    """
    from scipy.spatial import KDTree

    used = np.any(pressure > 0, axis=0)
    if not used.any():
        return pad.points[:1], np.zeros((1, len(pressure)))
    pad = pressed(pad, used)
    between, loads = net(pad, cuts(pad, SPREAD))
    near = KDTree(pad.points[used]).sparse_distance_matrix(
        KDTree(between @ pad.points), FAR * SPREAD, output_type="coo_matrix"
    )
    near.data = np.exp(-(near.data**2) / (2 * SPREAD**2)) / (2 * np.pi * SPREAD**2)
    return pad.points[used], np.asarray((near @ loads)[:, used] @ pressure[:, used].T)


def pressed(pad: Pad, used: Flags) -> Pad:
    """Restrict the pad's triangles to those with at least one of the points `used` (n_pad,)."""
    return replace(pad, triangles=pad.triangles[used[pad.triangles].any(axis=1)])


def cuts(pad: Pad, length: float) -> int:
    """Count the parts of the longest edge that are at most `length` mm long."""
    ends = pad.points[pad.triangles]
    longest = np.linalg.norm(ends - np.roll(ends, 1, axis=1), axis=2).max()
    return min(int(np.ceil(longest / length)), MOST)


def _corners(parts: int) -> Array:
    """Barycentric coordinates (parts², 3) of the centers of equal parts of a triangle."""
    first, second = np.meshgrid(np.arange(parts), np.arange(parts), indexing="ij")
    upright = np.column_stack([first.ravel(), second.ravel()])
    upright, turned = (upright[upright.sum(axis=1) < most] for most in (parts, parts - 1))
    u, v = (np.concatenate([3 * upright + 1, 3 * turned + 2]) / (3 * parts)).T
    return np.column_stack([1 - u - v, u, v])
