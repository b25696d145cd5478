"""Heights on a uniform grid as a cubic spline, evaluated by compiled code.

As SciPy's `RectBivariateSpline` (cubic, not-a-knot) through the same samples, but in uniform
B-splines: a place costs sixteen products, where FITPACK searches its knots.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.compiled import njit


@dataclass(frozen=True, eq=False)
class Raster:
    """Coefficients (n_u + 2, n_v + 2) mm of a bicubic spline.

    start (2,) mm the first grid lines, pitch (2,) mm between them.
    """

    coefficients: Array
    start: Array
    pitch: Array

    @classmethod
    def through(cls, u: Array, v: Array, heights: Array) -> Self | None:
        """Return the raster through heights (n_u, n_v) at grid lines; None if they are uneven."""
        steps = [np.diff(lines) for lines in (u, v)]
        pitch = np.array([step.mean() for step in steps])
        # With four samples of a side, not-a-knot is one cubic.
        short = min(len(u), len(v)) < 5
        # Steps that differ by less are rounding of one step.
        if short or any(np.ptp(s) > 1e-9 * p for s, p in zip(steps, pitch, strict=True)):
            return None
        coefficients = _fitted(_fitted(heights).T).T
        return cls(np.ascontiguousarray(coefficients), np.array([u[0], v[0]]), pitch)

    def heights(self, places: Array) -> Array:
        """Return the spline (...,) mm at places (..., 2) mm; infinite beyond the samples."""
        flat = np.ascontiguousarray(places, dtype=np.float64).reshape(-1, 2)
        out = np.empty(len(flat))
        _heights(self.coefficients, self.start, 1.0 / self.pitch, flat, out)
        return out.reshape(places.shape[:-1])

    def slopes(self, places: Array) -> Array:
        """Return the gradient (..., 2) of the spline at places (..., 2) mm; 0 beyond."""
        flat = np.ascontiguousarray(places, dtype=np.float64).reshape(-1, 2)
        out = np.zeros(flat.shape)
        _slopes(self.coefficients, self.start, 1.0 / self.pitch, flat, out)
        return out.reshape(places.shape)


def _fitted(heights: Array) -> Array:
    """Solve for the coefficients (n + 2, k) of not-a-knot cubics through heights (n, k)."""
    from scipy import sparse
    from scipy.sparse.linalg import splu

    n = len(heights)
    inside = sparse.diags_array([1 / 6, 4 / 6, 1 / 6], offsets=[0, 1, 2], shape=(n, n + 2))
    # The third derivative is continuous at the second and the last but one sample.
    ends = sparse.lil_array((2, n + 2))
    ends[0, :5] = ends[1, -5:] = [1, -4, 6, -4, 1]
    matrix = sparse.vstack([ends[:1], inside, ends[1:]]).tocsc()
    right = np.zeros((n + 2, heights.shape[1]))
    right[1:-1] = heights
    return np.asarray(splu(matrix).solve(right))


@njit(cache=True)
def _basis(t: float, w: Array) -> None:
    s = 1.0 - t
    w[0], w[3] = s * s * s / 6.0, t * t * t / 6.0
    w[1] = 2.0 / 3.0 - t * t + 0.5 * t * t * t
    w[2] = 2.0 / 3.0 - s * s + 0.5 * s * s * s


@njit(cache=True)
def _basis_slope(t: float, w: Array) -> None:
    s = 1.0 - t
    w[0], w[3] = -0.5 * s * s, 0.5 * t * t
    w[1] = -2.0 * t + 1.5 * t * t
    w[2] = 2.0 * s - 1.5 * s * s


@njit(cache=True, fastmath={"contract"})
def _heights(c: Array, start: Array, scale: Array, places: Array, out: Array) -> None:
    a, b = np.empty(4), np.empty(4)
    m, n = c.shape[0] - 3, c.shape[1] - 3
    for k in range(len(out)):
        x, y = (places[k, 0] - start[0]) * scale[0], (places[k, 1] - start[1]) * scale[1]
        if not (0.0 <= x <= m and 0.0 <= y <= n):
            out[k] = np.inf
            continue
        i, j = min(int(x), m - 1), min(int(y), n - 1)
        _basis(x - i, a)
        _basis(y - j, b)
        total = 0.0
        for p in range(4):
            row = c[i + p]
            inner = b[0] * row[j] + b[1] * row[j + 1] + b[2] * row[j + 2] + b[3] * row[j + 3]
            total += a[p] * inner
        out[k] = total


@njit(cache=True, fastmath={"contract"})
def _slopes(c: Array, start: Array, scale: Array, places: Array, out: Array) -> None:
    a, b, da, db = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    m, n = c.shape[0] - 3, c.shape[1] - 3
    for k in range(len(out)):
        x, y = (places[k, 0] - start[0]) * scale[0], (places[k, 1] - start[1]) * scale[1]
        if not (0.0 <= x <= m and 0.0 <= y <= n):
            continue
        i, j = min(int(x), m - 1), min(int(y), n - 1)
        _basis(x - i, a)
        _basis(y - j, b)
        _basis_slope(x - i, da)
        _basis_slope(y - j, db)
        along = across = 0.0
        for p in range(4):
            row = c[i + p]
            inner = b[0] * row[j] + b[1] * row[j + 1] + b[2] * row[j + 2] + b[3] * row[j + 3]
            along += da[p] * inner
            inner = db[0] * row[j] + db[1] * row[j + 1] + db[2] * row[j + 2] + db[3] * row[j + 3]
            across += a[p] * inner
        out[k, 0], out[k, 1] = along * scale[0], across * scale[1]
