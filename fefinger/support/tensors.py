"""Symmetric tensors: six components, logarithmic strain, and principal values of many."""

import math

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.compiled import njit


CLOSE = 1e-3
"""Distance from 1 of the cosine of the angle within which digits are lost: their number grows as
the root of its inverse."""

SWEEPS = 12
"""Largest number of sweeps of Jacobi's rotations; they converge quadratically, within some 5."""


def extremes(tensors: Array) -> tuple[Array, Array]:
    """Return the smallest and the largest principal value (...) of symmetric tensors (..., 3, 3).

    By the cosines of a third of the angle, or where two of the values are close, and these lose
    digits, by Jacobi's rotations; to rounding, of the lower triangle, as `numpy.linalg.eigvalsh`,
    in a tenth of its time.
    """
    tensors = np.ascontiguousarray(tensors)  # one layout, which is compiled once
    shape = tensors.shape[:-2]
    low, high = np.empty((2, int(np.prod(shape, dtype=np.int64))))
    _extremes(tensors.reshape(-1, 3, 3), low, high)
    return low.reshape(shape), high.reshape(shape)


@njit(cache=True, nogil=True, error_model="numpy")
def _rotated(
    first: float, second: float, between: float, one: float, other: float
) -> tuple[float, float, float, float]:
    """Return two diagonal components of which `between` vanishes, and what couples to a third."""
    if between == 0.0:
        return first, second, one, other
    ratio = (second - first) / (2.0 * between)
    tangent = 1.0 / (abs(ratio) + math.sqrt(ratio * ratio + 1.0))
    tangent = tangent if ratio >= 0.0 else -tangent
    cosine = 1.0 / math.sqrt(tangent * tangent + 1.0)
    sine = tangent * cosine
    change = tangent * between
    coupled = cosine * one - sine * other, sine * one + cosine * other
    return first - change, second + change, coupled[0], coupled[1]


@njit(cache=True, nogil=True, error_model="numpy")
def _extremes(tensors: Array, low: Array, high: Array) -> None:
    for i in range(len(tensors)):
        x, y, z = float(tensors[i, 0, 0]), float(tensors[i, 1, 1]), float(tensors[i, 2, 2])
        xy, yz, xz = float(tensors[i, 1, 0]), float(tensors[i, 2, 1]), float(tensors[i, 2, 0])
        mean = (x + y + z) / 3.0
        x, y, z = x - mean, y - mean, z - mean
        size = math.sqrt((x * x + y * y + z * z + 2.0 * (xy * xy + yz * yz + xz * xz)) / 6.0)
        if size == 0.0:
            low[i] = high[i] = mean
            continue
        a, b, c, d, e, f = x / size, y / size, z / size, xy / size, yz / size, xz / size
        cosine = 0.5 * (a * (b * c - e * e) - d * (d * c - e * f) + f * (d * e - b * f))
        if abs(cosine) < 1.0 - CLOSE:
            third = math.acos(cosine) / 3.0
            high[i] = mean + 2.0 * size * math.cos(third)
            low[i] = mean + 2.0 * size * math.cos(third + 2.0 * math.pi / 3.0)
            continue
        for _ in range(SWEEPS):
            if xy * xy + yz * yz + xz * xz <= 1e-34 * (x * x + y * y + z * z):
                break
            x, y, xz, yz = _rotated(x, y, xy, xz, yz)
            xy = 0.0
            x, z, xy, yz = _rotated(x, z, xz, xy, yz)
            xz = 0.0
            y, z, xy, xz = _rotated(y, z, yz, xy, xz)
            yz = 0.0
        low[i], high[i] = mean + min(x, y, z), mean + max(x, y, z)


VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Order of the six components: xx yy zz xy yz xz, tensor (not engineering) shear."""

PLACES = [0, 3, 5, 3, 1, 4, 5, 4, 2]
"""Number of the component at every place of the tensor, row by row."""


def tensor_from_voigt(components: Array) -> Array:
    """Return symmetric tensors (..., 3, 3) from components (..., 6) in the order of VOIGT."""
    return components[..., PLACES].reshape(*components.shape[:-1], 3, 3)


def logarithmic(gradient: Array) -> Array:
    """Return ln(F'F) / 2 (..., 3, 3) of a displacement gradient H (..., 3, 3), F = I + H.

    It is in the directions of the undeformed body (Hencky 1928), and taken from the Green-Lagrange
    strain by its principal values, log1p(2 e) / 2, so that small strains keep their digits.
    """
    h = np.asarray(gradient)
    across = np.swapaxes(h, -1, -2)
    green = (h + across + across @ h) / 2
    values, vectors = np.linalg.eigh(green)
    return np.asarray(
        (vectors * (np.log1p(2 * values) / 2)[..., None, :]) @ np.swapaxes(vectors, -1, -2)
    )
