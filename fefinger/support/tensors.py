"""Principal values of many symmetric tensors, as a population has at all times."""

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
    tensors = np.asarray(tensors)
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
