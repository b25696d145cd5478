"""Heights on a uniform grid: as a spline for compiled code, and of the upper side of a mesh.

As SciPy's `RectBivariateSpline` (cubic, not-a-knot) through the same samples, but in uniform
B-splines: a place costs sixteen products, where FITPACK searches its knots.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np

from fefinger.geometry.finger_mesh import barycentric
from fefinger.geometry.surface_load import FARTHEST
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
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


MARGIN = 1e-9
"""Barycentric coordinate by which a place may lie outside a triangle, for those on its edge."""

MOST = 1_000_000
"""Largest number of heights: on all of the pad, a tenth of the edges of a mesh apart."""


def height_map(file: Path, pitch: float) -> tuple[Array, Array, Array]:
    """Return x (n_x,), y (n_y,) and the largest z (n_x, n_y) in mm of a surface file.

    The places are `pitch` mm apart and cover the surface from its smallest x and y on.

    Raises InputError if the file cannot be read, or its surface has a hole as seen along z.
    """
    import trimesh

    try:
        with np.errstate(over="ignore", invalid="ignore"):
            mesh = trimesh.load_mesh(file)
        corners = np.asarray(mesh.vertices, dtype=np.float64)[mesh.faces]
    except Exception as error:  # the readers raise whatever they meet
        raise InputError(f"indenter.file: cannot read the surface {str(file)!r}: {error}") from None
    if len(corners) == 0:
        raise InputError(f"indenter.file: expected triangles in {str(file)!r}, received none")
    if not (np.abs(corners) < FARTHEST).all():
        raise InputError(
            f"indenter.file: expected finite coordinates, below {FARTHEST:g} mm, in {str(file)!r}"
        )
    low, high = corners[..., :2].min(axis=(0, 1)), corners[..., :2].max(axis=(0, 1))
    counts = np.floor((high - low) / pitch * (1 + MARGIN)).astype(int) + 1
    if counts.prod(dtype=float) > MOST:
        raise InputError(
            f"indenter.pitch: expected at most {MOST} samples of {str(file)!r}, received "
            f"{counts[0]} x {counts[1]}; take a larger one"
        )
    x, y = (low[k] + pitch * np.arange(counts[k]) for k in (0, 1))
    heights = np.full(counts, -np.inf)
    _raise(heights, corners, low, pitch)
    if not np.isfinite(heights).all():
        share = float(np.isinf(heights).mean())
        raise InputError(
            f"indenter.file: expected a surface in {str(file)!r} that covers its box of "
            f"{' x '.join(f'{size:.3g}' for size in high - low)} mm as seen along z, received one "
            f"that leaves {100 * share:.0f} % of it open; cut it to a rectangle or put it on a "
            "plate, and check that it is in mm"
        )
    return x, y, heights


def _raise(heights: Array, triangles: Array, low: Array, pitch: float) -> None:
    """Raise the heights (n_x, n_y) to triangles (n, 3, 3); vertical ones have no places under them.

    low: x and y of the first place.
    """
    across = triangles[:, 1:, :2] - triangles[:, :1, :2]
    flat = np.square(across).max(axis=(1, 2), initial=0.0)
    triangles = triangles[np.abs(np.linalg.det(across)) > MARGIN * flat]
    ends = (triangles[..., :2].min(axis=1), triangles[..., :2].max(axis=1))
    first, last = ((end - low) / pitch for end in ends)
    # Part of a spacing, or of a triangle, by which a place may lie beyond a triangle that it is on.
    slack = 1e-6
    begin = np.maximum(np.ceil(first - slack).astype(int), 0)
    counts = np.minimum(np.floor(last + slack).astype(int) + 1, heights.shape) - begin
    counts = np.maximum(counts, 0)
    total = np.cumsum(counts.prod(axis=1))
    together = 500_000  # places in the boxes of triangles that are looked at together
    parts = np.searchsorted(total, np.arange(together, total[-1] if len(total) else 0, together))
    for part in np.split(np.arange(len(triangles)), np.unique(parts)):
        # Every place in the box of a triangle, one after another.
        sizes = counts[part].prod(axis=1)
        which = np.repeat(part, sizes)
        number = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        places = begin[which] + np.column_stack(np.divmod(number, counts[which, 1]))
        weights = barycentric(triangles[which, :, :2], low + pitch * places)
        inside = weights.min(axis=-1) >= -slack
        level = np.sum(weights * triangles[which, :, 2], axis=-1)[inside]
        np.maximum.at(heights, tuple(places[inside].T), level)
