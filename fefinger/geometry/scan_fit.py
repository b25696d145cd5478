"""Smooth surface of a scanned fingertip: symmetric, and as smooth as the noise of the scan asks.

The logarithm of the distance from a center inside, over that of an ellipsoid of the finger's size,
is a sum of spherical harmonics that are even in y. Roughness costs, as much as generalized
cross-validation of the scan's vertices says (Wahba 1990, Spline models for observational data):
dense, coarse and noisy scans of one finger give the same surface, and the covariance of the fit
says how nearly.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from fefinger.geometry import finger_mesh
from fefinger.support.arrays import Array, Integers


if TYPE_CHECKING:
    from trimesh import Trimesh


DEGREE = 24
"""Highest degree of the harmonics: waves of 2 to 3 mm on a finger 14 mm wide."""

CELL = 0.5
"""Side in mm of the cubes in which the points of a dense scan are averaged: a surface with a radius
of 7 mm rises by 2 um in it."""

EDGE = 0.7
"""Longest edge in mm of the triangles whose middles stand for the facets of a scan."""

COSTS = np.logspace(-12.0, 0.0, 97)
"""Costs of roughness that are compared, over the number of points: from some at which all harmonics
are as the points have them to one that leaves an ellipsoid."""


@dataclass(frozen=True)
class SmoothSkin:
    """A smooth surface that is its own mirror image in y = 0.

    Attributes
    ----------
    center, size : (3,) mm middle and semi-axes of the ellipsoid.
    seen : (m, 3) mm places with points of the scan.
    coefficients : (k,) of the harmonics.
    covariance : (k, k) of these by the noise.
    noise : standard deviation in mm of the scan's vertices.
    asymmetry : mean distance in mm of the scan, less its noise, from its mirror image.

    """

    center: Array
    size: Array
    seen: Array
    coefficients: Array
    covariance: Array
    noise: float
    asymmetry: float

    def toward(self, points: Array) -> tuple[Array, Array]:
        """Return the places (n, 3) of the surface seen from the center toward points, and normals.

        points (n, 3) mm; the normals (n, 3) are outward.
        """
        ways = _ways(points, self.center, self.size)
        height, slope = np.zeros(len(points)), np.zeros_like(points)
        for factor, (even, _, slopes) in zip(self.coefficients, _harmonics(ways), strict=True):
            height += factor * even
            slope += factor * slopes
        slope -= np.sum(slope * ways, axis=1)[:, None] * ways
        normals = (ways - slope) / self.size
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        return self.center + self.size * np.exp(height)[:, None] * ways, normals

    def sampled(self, spacing: float) -> tuple[Array, Array]:
        """Return points (n, 3) of the surface, some `spacing` mm apart on its sides, and normals.

        Mirror images of each other, on a spiral (Fibonacci lattice) as seen from the center, where
        the scan has points.
        """
        count = round(4.0 * np.pi * self.size[0] * self.size[1] / spacing**2)
        x = 1.0 - (2.0 * np.arange(count) + 1.0) / count
        angle = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(count)
        across = np.sqrt(1.0 - x**2)
        ways = np.column_stack([x, across * np.sin(angle), across * np.cos(angle)])
        behind = _ways(self.seen, self.center, self.size)[:, 0].min()
        ways = ways[(ways[:, 1] >= 0.0) & (ways[:, 0] > behind)]
        points, normals = self.toward(self.center + self.size * ways)
        near = 1.0  # distance in mm from points of a scan up to which its surface is known
        known = cKDTree(finger_mesh.to_half(self.seen)).query(points)[0] < near
        points, normals = points[known], normals[known]
        both = [np.concatenate([each, finger_mesh.image(each)]) for each in (points, normals)]
        return both[0], both[1]

    def spread(self, points: Array, weights: Array) -> float:
        """Return the standard deviation in mm of a weighted sum (n,) of heights at points."""
        even, _, _ = _rows(points, np.ones(len(points)), self.center, self.size)
        sums = weights @ even
        return float(np.sqrt(sums @ self.covariance @ sums))


def smooth_skin(mesh: "Trimesh", start: float, center: Array, size: Array) -> SmoothSkin:
    """Fit a smooth surface to the skin of a scan distal of x = start mm.

    center, size : (3,) mm of an ellipsoid near it. The vertices, whose noise is independent, say
    how smooth it is. It is fitted to vertices and facets alike: those of a decimated scan lie as
    far outside of the surface as these lie inside.
    """
    faces = mesh.faces[mesh.triangles_center[:, 0] > start]
    vertices = np.asarray(mesh.vertices, dtype=float)
    used = vertices[np.unique(faces)]
    points, counts = _averaged(used, np.ones(len(used)), center, size)
    costs, noise = _costs(*_rows(points, counts, center, size))
    middles, areas = _middles(vertices, faces)
    halves = [np.full(len(used), 0.5), areas * len(used) / (2.0 * areas.sum())]
    both = np.concatenate([used, middles]), np.concatenate(halves)
    points, weights = _averaged(*both, center, size)
    even, odd, data = _rows(points, weights, center, size)
    inverse, fit = _solved(even, data, costs[0])
    _, aside = _solved(odd, data - even @ fit, costs[1])
    fit = inverse @ (even.T @ (data - odd @ aside))
    away = np.abs(odd @ aside) / np.sqrt(weights)
    asymmetry = 2.0 * float(np.average(away, weights=weights))
    return SmoothSkin(center, size, points, fit, noise**2 * inverse, noise, asymmetry)


def _costs(even: Array, odd: Array, data: Array) -> tuple[tuple[Array, Array], float]:
    """Return the costs of the even and odd harmonics by cross-validation, and the noise in mm."""
    free = len(data)
    cost, _, _ = _cross_validated(even, data, _roughness())
    left = data - even @ _solved(even, data, cost * _roughness())[1]
    other, used, _ = _cross_validated(odd, left, _roughness(least=1))
    left = data - odd @ _solved(odd, left, other * _roughness(least=1))[1]
    cost, more, squares = _cross_validated(even, left, _roughness())
    # A scan of a few points leaves no freedom, and its noise is not known.
    noise = float(np.sqrt(max(squares, 0.0) / max(free - used - more, 1.0)))
    return (cost * _roughness(), other * _roughness(least=1)), noise


def _rows(points: Array, weights: Array, center: Array, size: Array) -> tuple[Array, Array, Array]:
    """Return the rows (n, k) of least squares for the even and the odd harmonics, and data (n,).

    All are distances in mm across the ellipsoid, times the root of the weights (n,).
    """
    scaled = (points - center) / size
    radius = np.linalg.norm(scaled, axis=1)
    # A step of the radius's logarithm is so far in mm across the ellipsoid through the point.
    ratio = np.sqrt(weights) * radius**2 / np.linalg.norm(scaled / size, axis=1)
    parts = list(_harmonics(scaled / radius[:, None]))
    even = np.stack([ratio * value for value, _, _ in parts], axis=1)
    odd = np.stack([ratio * value for _, value, _ in parts[DEGREE + 1 :]], axis=1)
    return even, odd, ratio * np.log(radius)


def _solved(rows: Array, data: Array, costs: Array) -> tuple[Array, Array]:
    """Return the inverse (k, k) of the normal matrix, and the coefficients (k,) of a fit."""
    inverse = np.asarray(np.linalg.inv(rows.T @ rows + np.diag(costs)))
    return inverse, inverse @ (rows.T @ data)


def _cross_validated(rows: Array, data: Array, roughness: Array) -> tuple[float, float, float]:
    """Return the cost of roughness that predicts points best that are left out.

    Also return the degrees of freedom that its fit takes, and the squares that it leaves.
    """
    scale = 1.0 / np.sqrt(roughness)
    powers, modes = np.linalg.eigh(scale[:, None] * (rows.T @ rows) * scale)
    powers = np.maximum(powers, 0.0)  # but for rounding
    loads = modes.T @ (scale * (rows.T @ data))
    count = len(data)
    costs = count * COSTS[:, None]
    used = (powers / (powers + costs)).sum(axis=1)
    parts = loads / (powers + costs)
    squares = data @ data - parts @ loads - (costs * parts**2).sum(axis=1)
    # Factor of the degrees of freedom in the cross-validation, against too rough fits of few points
    # (Kim and Gu 2004, J. R. Stat. Soc. B 66:337).
    caution = 1.4
    free = count - caution * used
    scores = np.where(free > 0.0, squares / np.maximum(free, 1.0) ** 2, np.inf)
    best = int(np.argmin(scores))
    return float(costs[best, 0]), float(used[best]), float(squares[best])


def _harmonics(ways: Array) -> Iterator[tuple[Array, Array, Array]]:
    """Yield spherical harmonics, of mean square 1, at directions (n, 3): by order, then by degree.

    Those even in y, those odd in y (0 where the order is 0), and the derivatives (n, 3) of the even
    ones as polynomials of the direction. The pole is the x axis.
    """
    x, y, z = ways.T
    power, before = np.ones(len(x), dtype=complex), np.zeros(len(x), dtype=complex)
    first = 1.0
    for order in range(DEGREE + 1):
        if order:
            first *= np.sqrt((2 * order + 1) / (2 * order) * (2 if order == 1 else 1))
            power, before = power * (z + 1j * y), order * power
        last, last_slope = np.zeros_like(x), np.zeros_like(x)
        here, slope = np.full_like(x, first), np.zeros_like(x)
        down = 0.0
        for degree in range(order, DEGREE + 1):
            across = np.stack([slope * power.real, -here * before.imag, here * before.real], axis=1)
            yield here * power.real, here * power.imag, across
            up = np.sqrt((4 * (degree + 1) ** 2 - 1) / ((degree + 1) ** 2 - order**2))
            here, slope, last, last_slope = (
                up * (x * here - down * last),
                up * (here + x * slope - down * last_slope),
                here,
                slope,
            )
            down = 1.0 / up


def _roughness(least: int = 0) -> Array:
    """Cost of each harmonic, from order `least` on; the mean size costs as much as its place."""
    degrees = [degree for order in range(least, DEGREE + 1) for degree in range(order, DEGREE + 1)]
    degree = np.maximum(degrees, 1)
    # Power of l (l + 1) in the cost of degree l, which is so of fourth derivatives. Powers of 2 and
    # 3 left 1.5 and 1.2 times as much noise on the pads of made scans, 5 as much.
    smooth = 4
    return np.asarray((degree * (degree + 1.0)) ** smooth)


def _middles(vertices: Array, faces: Integers) -> tuple[Array, Array]:
    """Return middles (n, 3) and areas (n,) of facets, in triangles with edges up to EDGE mm."""
    from trimesh import remesh, triangles

    points, faces = remesh.subdivide_to_size(vertices, faces, EDGE)
    corners = points[faces]
    return corners.mean(axis=1), np.asarray(triangles.area(corners))


def _averaged(points: Array, weights: Array, center: Array, size: Array) -> tuple[Array, Array]:
    """Return means (m, 3) of points (n, 3) by weights (n,), and the sums (m,) of these.

    Points that the center sees through one cube of CELL on the ellipsoid are one: noise, which is
    along the way, does not tell them apart.
    """
    cubes = np.floor(size * _ways(points, center, size) / CELL)
    which = np.unique(cubes, axis=0, return_inverse=True)[1].ravel()
    sums = np.bincount(which, weights)
    means = [np.bincount(which, weights * part) / sums for part in points.T]
    return np.stack(means, axis=1), np.asarray(sums, dtype=float)


def _ways(points: Array, center: Array, size: Array) -> Array:
    """Return the directions (n, 3) of points from a center where the ellipsoid is a sphere."""
    scaled = (points - center) / size
    return np.asarray(scaled / np.linalg.norm(scaled, axis=1)[:, None])
