"""Center, asymmetry and ellipticity of a piecewise linear pressure, by exact integrals.

Lengths in mm, pressures in kPa. Triangles are cut along lines exactly, so that results are
continuous when a line passes a vertex.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


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
