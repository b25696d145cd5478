"""Flexibility of the surface of an elastic object, under pressures on the hats of a skin.

The object is met as a flat body in the sense of Hertz: what a pressure at y moves it at x depends
on their distance along the undeformed skin, K(|x - y|). With the moment M(r), the integral of K(s)
s ds from 0 to r, integrals over a facet become integrals along its edges, for any K: with d the
distance of an edge from x in the plane of the facet, z the height of x over it, and R² = d² + z² +
s² at the place s along the edge,

    integral of K dA = sum over edges of the integral of d (M(R) - M(|z|)) / (d² + s²) ds,
    integral of K grad psi . (y - x) dA = sum of grad psi . n times the integral of M(R) ds.
"""

from typing import NamedTuple

import numpy as np

from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


NEAR = 4.0
"""Distance from the middle of a facet, over its radius, within which its integrals are taken along
its edges; from there on a rule of three points errs by 2e-4 of them."""

NODES, WEIGHTS = (each / 2 for each in np.polynomial.legendre.leggauss(6))
NODES = NODES + 0.5
"""Gauss's rule on 0 to 1."""

SLIVER = 1e-9
"""Distance from an edge over its length below which x is on it: its first integral is 0 there."""


class Kernel(NamedTuple):
    """The moment M of K at equal steps from 0, constant beyond: as `theory.contact.stack`.

    step mm; value (n,) mm²/mN; slope (n,) mm/mN, the derivative K(r) r.
    """

    step: float
    value: Array
    slope: Array


class Facets(NamedTuple):
    """Facets of a skin that carry hats.

    corners (k, 3, 3) mm; owner (k, 3): the hat of a corner, or -1; places (k, q, 3) mm of
    quadrature points, hats (k, 3, q) mm²: weights times the linear functions of the corners.
    """

    corners: Array
    owner: Integers
    places: Array
    hats: Array


@njit(cache=True, inline="always")
def _moment(kernel: Kernel, r: float) -> float:
    """Interpolate M, by its values and derivatives."""
    at = r / kernel.step
    k = int(at)
    if k >= len(kernel.value) - 1:
        return kernel.value[-1]
    t = at - k
    low, high = kernel.value[k], kernel.value[k + 1]
    a, b = kernel.step * kernel.slope[k], kernel.step * kernel.slope[k + 1]
    return low + t * (a + t * (3.0 * (high - low) - 2.0 * a - b + t * (2.0 * (low - high) + a + b)))


@njit(cache=True, inline="always")
def _displacement(kernel: Kernel, r: float) -> float:
    """Interpolate K(r), r > 0."""
    at = r / kernel.step
    k = int(at)
    if k >= len(kernel.value) - 1:
        return 0.0
    t = at - k
    rise = (kernel.value[k + 1] - kernel.value[k]) / kernel.step
    a, b = kernel.slope[k], kernel.slope[k + 1]
    return (a + t * (6.0 * rise - 4.0 * a - 2.0 * b + t * (3.0 * (a + b) - 6.0 * rise))) / r


@njit(cache=True)
def _along(kernel: Kernel, d: float, z: float, start: float, stop: float) -> tuple[float, float]:
    """Integrate d (M(R) - M(|z|)) / (d² + s²), and M(R), along an edge to one side of x.

    The first in t with s = |d| sinh t, in which a half-space in the plane of x is constant.
    """
    low = abs(d)
    first = second = begin = end = 0.0
    foot = _moment(kernel, abs(z))
    flat = low <= SLIVER * (abs(start) + abs(stop))
    if not flat:
        begin, end = np.arcsinh(start / low), np.arcsinh(stop / low)
    for i in range(len(NODES)):
        s = start + (stop - start) * NODES[i]
        second += WEIGHTS[i] * _moment(kernel, np.sqrt(low * low + z * z + s * s))
        if not flat:
            wide = np.cosh(begin + (end - begin) * NODES[i])
            over = _moment(kernel, np.sqrt((low * wide) ** 2 + z * z)) - foot
            first += WEIGHTS[i] * over / wide
    first *= end - begin
    return (first if d > 0.0 else -first), second * (stop - start)


@njit(cache=True)
def _near(kernel: Kernel, corners: Array, x: Array, out: Array) -> None:
    """Integrate K times the linear functions of the corners (3, 3) of a facet, seen from x."""
    normal, edge, outward = np.empty(3), np.empty(3), np.empty((3, 3))
    for c in range(3):
        i, j = (c + 1) % 3, (c + 2) % 3
        normal[c] = (corners[1, i] - corners[0, i]) * (corners[2, j] - corners[0, j]) - (
            corners[1, j] - corners[0, j]
        ) * (corners[2, i] - corners[0, i])
    double = np.sqrt((normal * normal).sum())
    normal /= double
    z = 0.0
    for c in range(3):
        z += (x[c] - corners[0, c]) * normal[c]
    away, height, second, whole = np.empty(3), np.empty(3), np.empty(3), 0.0
    for e in range(3):  # the edge across from corner e
        a, b = (e + 1) % 3, (e + 2) % 3
        length = 0.0
        for c in range(3):
            edge[c] = corners[b, c] - corners[a, c]
            length += edge[c] * edge[c]
        length = np.sqrt(length)
        d = start = 0.0
        for c in range(3):
            i, j = (c + 1) % 3, (c + 2) % 3
            outward[e, c] = (edge[i] * normal[j] - edge[j] * normal[i]) / length
            d += (corners[a, c] - x[c]) * outward[e, c]
            start += (corners[a, c] - x[c]) * edge[c] / length
        stop = start + length
        away[e], second[e], height[e] = d, 0.0, double / length
        foot = min(max(0.0, start), stop)
        for low, high in ((start, foot), (foot, stop)):
            if low < high:
                turned, passed = _along(kernel, d, z, low, high)
                whole += turned
                second[e] += passed
    for k in range(3):  # grad psi_k = -outward_k / height_k
        total = away[k] * whole
        for e in range(3):
            cosine = 0.0
            for c in range(3):
                cosine += outward[k, c] * outward[e, c]
            total -= cosine * second[e]
        out[k] = total / height[k]


@njit(cache=True)
def _far(kernel: Kernel, corners: Array, area: float, x: Array, out: Array) -> None:
    """Integrate the same by three points, each two thirds of the way to a corner."""
    out[:] = 0.0
    for k in range(3):
        square = 0.0
        for c in range(3):
            middle = corners[0, c] + corners[1, c] + corners[2, c]
            square += (x[c] - middle / 6.0 - corners[k, c] / 2.0) ** 2
        value = area / 3.0 * _displacement(kernel, np.sqrt(square))
        for j in range(3):
            out[j] += value * (2.0 / 3.0 if j == k else 1.0 / 6.0)


@njit(cache=True, nogil=True)
def displacements(
    kernel: Kernel, corners: Array, owner: Integers, points: Array, out: Array
) -> None:
    """Add the displacements (m, n) mm of points (m, 3) per unit pressure of every hat to `out`.

    corners (k, 3, 3) mm and owner (k, 3) as of `Facets`.
    """
    parts = np.empty(3)
    for t in range(len(corners)):
        middle, square, radius = np.zeros(3), 0.0, 0.0
        for c in range(3):
            middle[c] = (corners[t, 0, c] + corners[t, 1, c] + corners[t, 2, c]) / 3.0
            i, j = (c + 1) % 3, (c + 2) % 3
            square += (
                (corners[t, 1, i] - corners[t, 0, i]) * (corners[t, 2, j] - corners[t, 0, j])
                - (corners[t, 1, j] - corners[t, 0, j]) * (corners[t, 2, i] - corners[t, 0, i])
            ) ** 2
        for k in range(3):
            radius = max(radius, ((corners[t, k] - middle) ** 2).sum())
        for p in range(len(points)):
            apart = 0.0
            for c in range(3):
                apart += (points[p, c] - middle[c]) ** 2
            if apart < NEAR * NEAR * radius:
                _near(kernel, corners[t], points[p], parts)
            else:
                _far(kernel, corners[t], np.sqrt(square) / 2.0, points[p], parts)
            for k in range(3):
                if owner[t, k] >= 0:
                    out[p, owner[t, k]] += parts[k]


WHOLE = np.ones((1, 3))
"""Signs of the images of a body that is meshed as a whole."""


def flexibility(kernel: Kernel, facets: Facets, count: int, images: Array = WHOLE) -> Array:
    """Return C (n, n) mm³/kPa: what the pressure of each hat moves the surface under the others.

    images (m, 3): signs by which the meshed part of a symmetric body gives each of its parts.
    C is symmetric as the mean of both orders of integration, exact over one facet and by the
    quadrature of the skin over the other.
    """
    return symmetric(one_sided(kernel, facets, count, images))


def symmetric(matrix: Array) -> Array:
    """Return the mean (n, n) of a matrix and its transpose."""
    return np.asarray((matrix + matrix.T) / 2)


def one_sided(kernel: Kernel, facets: Facets, count: int, images: Array = WHOLE) -> Array:
    """Return C (n, n) mm³/kPa as of `flexibility`, its columns exact and its rows by quadrature."""
    points = np.ascontiguousarray(facets.places.reshape(-1, 3))
    moved = moved_points(kernel, facets, points, count, images)
    return weighted(facets, moved.reshape(*facets.places.shape[:2], count))


def weighted(facets: Facets, moved: Array) -> Array:
    """Return the integrals (n, n) of each hat times displacements (k, q, n) at the places."""
    rows = np.zeros((moved.shape[-1], moved.shape[-1]))
    for corner in range(3):
        owned = facets.owner[:, corner] >= 0
        sums = np.einsum("tq,tqn->tn", facets.hats[owned, corner], moved[owned])
        np.add.at(rows, facets.owner[owned, corner], sums)
    return rows


def moved_points(
    kernel: Kernel, facets: Facets, points: Array, count: int, images: Array = WHOLE
) -> Array:
    """Return the displacement (m, n) mm of points (m, 3) per unit pressure of each of n hats."""
    moved = np.zeros((len(points), count))
    for signs in images:
        corners = np.ascontiguousarray(facets.corners * signs)
        displacements(kernel, corners, facets.owner, points, moved)
    return moved
