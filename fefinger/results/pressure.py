"""Pressure between the points of the pad: it is linear on each triangle, and its force spread so.

A force that stands at the points of the pad alone makes what is felt on a square millimeter depend
on where the points happen to lie.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fefinger.results.records import Array, Pad


if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

MOST = 8
"""Parts that an edge is cut into at most."""

FAR = 4.0
"""Standard deviations at which a Gaussian ends, with 3e-4 of its weight left out."""

SPREAD = 1 / np.sqrt(2 * np.pi)
"""Standard deviation in mm of a Gaussian that weighs 1 mm² as much as its middle."""


@dataclass(frozen=True)
class Net:
    """Points between those of the pad.

    between (m, n_pad): values at the pad's points to values at these; loads (m, n_pad) mm²:
    pressures in kPa at the pad's points to forces in mN at these.
    """

    between: "csr_matrix"
    loads: "csr_matrix"


def net(pad: Pad, parts: int) -> Net:
    """Return points so dense that forces on them are the linear pressure of the pad.

    Every edge is cut into parts, every triangle into parts² with their forces at their middles; a
    point of the pad keeps its force, pressure times area, and shares it out.
    """
    from scipy import sparse

    corners = _corners(parts)
    one, two = (pad.points[pad.triangles[:, i]] - pad.points[pad.triangles[:, 0]] for i in (1, 2))
    size = np.linalg.norm(np.cross(one, two), axis=1) / 2 / len(corners)
    columns = np.repeat(pad.triangles, len(corners), axis=0)
    values = np.tile(corners, (len(pad.triangles), 1))
    rows = np.repeat(np.arange(len(values)), 3)
    shape = (len(values), len(pad.points))
    between = sparse.csr_matrix((values.ravel(), (rows, columns.ravel())), shape=shape)
    loads = sparse.diags(np.repeat(size, len(corners))) @ between
    total = np.asarray(loads.sum(axis=0)).ravel()
    share = np.divide(pad.areas, total, out=np.zeros_like(total), where=total > 0)
    return Net(between, (loads @ sparse.diags(share)).tocsr())


def highest(pad: Pad, pressure: Array) -> float:
    """Return the largest mean pressure in kPa over 1 mm² at any time, see `peaks`."""
    return float(peaks(pad, pressure).max())


def peaks(pad: Pad, pressure: Array) -> Array:
    """Return the largest mean pressure (n_t,) in kPa over 1 mm², of pressures (n_t, n_pad).

    The mean is weighted by a Gaussian about each point of the pad. What one point bears depends on
    the mesh (a quarter at the rim of a plate, on the standard mesh); this does not.
    """
    from scipy.spatial import KDTree

    used = np.any(pressure > 0, axis=0)
    if not used.any():
        return np.zeros(len(pressure))
    pad = pressed(pad, used)
    fine = net(pad, cuts(pad, SPREAD))
    tree = KDTree(fine.between @ pad.points)
    near = KDTree(pad.points[used]).sparse_distance_matrix(
        tree, FAR * SPREAD, output_type="coo_matrix"
    )
    near.data = np.exp(-(near.data**2) / (2 * SPREAD**2)) / (2 * np.pi * SPREAD**2)
    felt = (near @ fine.loads)[:, used] @ pressure[:, used].T
    return np.asarray(felt.max(axis=0))


def pressed(pad: Pad, used: NDArray[np.bool_]) -> Pad:
    """Return the pad with those triangles alone that have one of some points (n_pad,)."""
    return replace(pad, triangles=pad.triangles[used[pad.triangles].any(axis=1)])


def cuts(pad: Pad, length: float) -> int:
    """Return into how many parts the longest edge has to be cut for parts of a length in mm."""
    ends = pad.points[pad.triangles]
    longest = np.linalg.norm(ends - np.roll(ends, 1, axis=1), axis=2).max()
    return min(int(np.ceil(longest / length)), MOST)


def _corners(parts: int) -> Array:
    """Return barycentric coordinates (parts², 3) of the middles of equal parts of a triangle."""
    first, second = np.meshgrid(np.arange(parts), np.arange(parts), indexing="ij")
    upright = np.column_stack([first.ravel(), second.ravel()])
    upright, turned = (upright[upright.sum(axis=1) < most] for most in (parts, parts - 1))
    u, v = (np.concatenate([3 * upright + 1, 3 * turned + 2]) / (3 * parts)).T
    return np.column_stack([1 - u - v, u, v])
