"""Pressure between the points of the pad, linear on each triangle, and its mean over 1 mm².

From forces at the mesh points alone, a mean over 1 mm² would depend on where the points are.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.finger_mesh import triangle_areas
from fefinger.results.records import Pad
from fefinger.support.arrays import Array, Flags, Integers


if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

MOST = 8
"""Largest number of parts of an edge: their number limits memory, which grows with its square."""

SPREAD = 1 / np.sqrt(2 * np.pi)
"""Standard deviation in mm of a Gaussian whose integral is 1 mm² times its peak."""


def net(pad: Pad, parts: int) -> "tuple[csr_matrix, csr_matrix]":
    """Divide each triangle of the pad into parts² with a force at the center of each part.

    Returns two matrices (n_centers, n_pad): from values at the pad's points to values at the
    centers, and, in mm², from pressures in kPa at the pad's points to forces in mN at the centers.
    The force of a point of the pad, its pressure times its area, is kept.
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
    """Return the largest mean pressure in kPa over 1 mm² at any time, and its place (3,) mm."""
    points, means = _means(pad, pressure)
    number = int(means.max(axis=1).argmax())
    return float(means[number].max()), points[number]


def peaks(pad: Pad, pressure: Array) -> Array:
    """Return the largest mean pressure (n_t,) in kPa over 1 mm², from pressures (n_t, n_pad).

    A mean is weighted by a Gaussian about a point of the pad. It does not depend on the mesh; the
    pressure of a single point at the rim of a plate varies by a quarter on the standard mesh.
    """
    return np.asarray(_means(pad, pressure)[1].max(axis=0))


def _means(pad: Pad, pressure: Array) -> tuple[Array, Array]:
    """Return the points (n, 3) mm that ever bear pressure, and the means (n, n_t) kPa about them.

    Without pressure, the first point of the pad with zeros.
    """
    from scipy.spatial import KDTree

    used = np.any(pressure > 0, axis=0)
    if not used.any():
        return pad.points[:1], np.zeros((1, len(pressure)))
    pad = pressed(pad, used)
    between, loads = net(pad, cuts(pad, SPREAD))
    far = 4.0  # cutoff of a Gaussian in standard deviations; it neglects 3e-4 of the weight
    near = KDTree(pad.points[used]).sparse_distance_matrix(
        KDTree(between @ pad.points), far * SPREAD, output_type="coo_matrix"
    )
    near.data = np.exp(-(near.data**2) / (2 * SPREAD**2)) / (2 * np.pi * SPREAD**2)
    return pad.points[used], np.asarray((near @ loads)[:, used] @ pressure[:, used].T)


def pressed(pad: Pad, used: Flags) -> Pad:
    """Return the pad with only the triangles that have a corner among points `used` (n_pad,)."""
    return replace(pad, triangles=pad.triangles[used[pad.triangles].any(axis=1)])


def cuts(pad: Pad, length: float) -> int:
    """Return into how many parts, at most MOST, edges are cut to be no longer than `length` mm."""
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


def isobar(points: Array, triangles: Integers, pressure: Array, level: float) -> Array:
    """Line of constant pressure as segments (k, 2, 2) mm, from linear triangles.

    points (n, 2) mm, triangles (m, 3), pressure (n,) kPa. A vertex at exactly `level` is outside.
    """
    above = pressure[triangles] > level
    crossed = triangles[above.any(axis=1) & ~above.all(axis=1)]
    inside = pressure[crossed] > level
    # The corner that is alone on its side of the level: both cut edges meet there.
    lone = np.argmax(inside == (inside.sum(axis=1) == 1)[:, None], axis=1)
    rows = np.arange(len(crossed))
    one = crossed[rows, lone]
    ends = []
    for other in (crossed[rows, (lone + 1) % 3], crossed[rows, (lone + 2) % 3]):
        part = (level - pressure[one]) / (pressure[other] - pressure[one])
        ends.append(points[one] + part[:, None] * (points[other] - points[one]))
    return np.stack(ends, axis=1)
