"""Pressure between the points of the pad, linear on each triangle: means over 1 mm², and moments.

From forces at the mesh points alone, a mean over 1 mm² would depend on where the points are.

Lengths in mm, pressures in kPa. Triangles are cut along lines exactly, so that results are
continuous when a line passes a vertex.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.geometry.finger_mesh import triangle_areas
from fefinger.results.records import Pad
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.theory.contact import elastic


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
    points, weights = _weights(pad, np.any(pressure > 0, axis=0))
    # No mean about a point exceeds that of each point's largest pressure at any time. Of a press
    # that leaves few points to look at through time.
    bound = weights @ pressure.max(axis=0, initial=0.0)
    likely = int(bound.argmax())
    reached = float((weights[likely] @ pressure.T).max(initial=0.0))
    left = np.flatnonzero(bound >= reached * (1 - 1e-12))
    means = weights[left] @ pressure.T
    number = int(means.max(axis=1).argmax())
    return float(means[number].max()), points[left[number]]


def peaks(pad: Pad, pressure: Array) -> Array:
    """Return the largest mean pressure (n_t,) in kPa over 1 mm², from pressures (n_t, n_pad).

    A mean is weighted by a Gaussian about a point of the pad. It does not depend on the mesh; the
    pressure of a single point at the rim of a plate varies by a quarter on the standard mesh.
    """
    return np.asarray((_weights(pad, np.any(pressure > 0, axis=0))[1] @ pressure.T).max(axis=0))


def _weights(pad: Pad, used: Flags) -> "tuple[Array, csr_matrix]":
    """Return the points (n, 3) mm among `used` (n_pad,), and the weights (n, n_pad) of their means.

    Without any, the first point of the pad with zeros.
    """
    from scipy import sparse
    from scipy.spatial import KDTree

    if not used.any():
        return pad.points[:1], sparse.csr_matrix((1, len(used)))
    pad = pressed(pad, used)
    between, loads = net(pad, cuts(pad, SPREAD))
    far = 4.0  # cutoff of a Gaussian in standard deviations; it neglects 3e-4 of the weight
    near = KDTree(pad.points[used]).sparse_distance_matrix(
        KDTree(between @ pad.points), far * SPREAD, output_type="coo_matrix"
    )
    near.data = np.exp(-(near.data**2) / (2 * SPREAD**2)) / (2 * np.pi * SPREAD**2)
    return pad.points[used], (near @ loads).tocsr()


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


@dataclass(frozen=True)
class Moments:
    """Force, center, asymmetry and ellipticity of a pressure.

    force mN; center (2,) mm; asymmetry, (force at x > 0 - force at x < 0) / force;
    ellipticity 1 - b/a, from the ratio of the principal second moments about the center, so that an
    ellipse under Hertz's pressure has the ratio b/a of its axes; long_axis, degrees from x in -90
    to 90.
    """

    force: float
    center: Array
    asymmetry: float
    ellipticity: float
    long_axis: float


def moments(
    places: ArrayLike, triangles: ArrayLike, areas: ArrayLike, pressure: ArrayLike
) -> Moments:
    """Compute the moments of a pressure (n,) kPa at places (n, 2) mm.

    triangles (m, 3); areas (m,) mm², which may be larger than their projection on the plane.

    Raises ValueError for a pressure with a force of 0 or less.
    """
    corners, areas = np.asarray(triangles), elastic.numbers("moments", "areas", areas)
    at = elastic.numbers("moments", "places", places)[corners]
    p = elastic.numbers("moments", "pressures", pressure)[corners]
    force = float(areas @ p.mean(axis=1))
    if not force > 0:
        msg = f"moments: expected a pressure that adds up to a force above 0, received {force:g} mN"
        raise ValueError(msg)
    one = np.ones(p.shape)
    center = np.array([_product(areas, p, at[..., i], one) for i in (0, 1)]) / force
    x, y = np.moveaxis(at - center, 2, 0)
    square = [[_product(areas, p, f, g) / force for f in (x, y)] for g in (x, y)]
    (short, long), axes = np.linalg.eigh(square)
    turned = float(np.degrees(np.arctan2(axes[1, 1], axes[0, 1])))
    return Moments(
        force,
        center,
        2 * _beyond(at[..., 0], areas, p) / force - 1,
        1 - float(np.sqrt(max(short, 0.0) / long)),
        (turned + 90) % 180 - 90,
    )


def _product(areas: Array, f: Array, g: Array, h: Array) -> float:
    """Integral of f g h, each (m, 3) at the vertices and linear on the triangles.

    From the integral of barycentric coordinates, 2 A a! b! c! / (a + b + c + 2)!.
    """
    sum_f, sum_g, sum_h = (each.sum(axis=1) for each in (f, g, h))
    mixed = sum_f * (g * h).sum(axis=1) + sum_g * (f * h).sum(axis=1) + sum_h * (f * g).sum(axis=1)
    return float(areas @ (sum_f * sum_g * sum_h + mixed + 2 * (f * g * h).sum(axis=1)) / 60)


def _beyond(x: Array, areas: Array, p: Array) -> float:
    """Integral of p over x > 0; x and p (m, 3) at the vertices."""
    order = np.argsort(x, axis=1)
    x, p = np.take_along_axis(x, order, 1), np.take_along_axis(p, order, 1)
    whole = areas * p.mean(axis=1)
    count = (x > 0).sum(axis=1)
    kinds: list[tuple[int, NDArray[np.float64]]] = [
        (3, whole),
        (2, whole - _corner(x, p, areas)),
        (1, _corner(x[:, ::-1], p[:, ::-1], areas)),
    ]
    return float(sum(part[count == kind].sum() for kind, part in kinds))


def _corner(x: Array, p: Array, areas: Array) -> Array:
    """Integrals (m,) of p over the corners at the first vertex that the line x = 0 cuts off."""
    first, others = x[:, :1], x[:, 1:]
    share = np.divide(first, first - others, out=np.zeros_like(others), where=first != others)
    ends = p[:, :1] + share * (p[:, 1:] - p[:, :1])
    return np.asarray(areas * share.prod(axis=1) * (p[:, 0] + ends.sum(axis=1)) / 3)
