"""Analytic smooth closed surface of a finger, made of half ellipses across it.

Every plane x = const cuts it in two half ellipses that share the widest level z = middle, a palmar
one below and a dorsal one above. Three profiles along x (half width, palmar depth, dorsal height)
make the whole shape, and all end in the same rounded tip. The square r^2 of a profile is smooth at
the tip, so the square is what is stored.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from fefinger.support.arrays import Array, Flags


Table = tuple[Array, Array]
"""Profile as x ascending to the tip and half size r(x), which is zero at the tip, mm."""

NODES = 400
"""Spline nodes per profile; the profiles then agree with their tables to about 1e-6 mm."""


@dataclass(frozen=True)
class Shell:
    """Closed smooth surface between a cut plane and a rounded tip.

    Attributes
    ----------
    cut, tip : x of the cut plane and of the foremost point, mm.
    middle : z of the widest level, mm.
    palmar, dorsal : squared half height below and above `middle` against x, mm^2.
    palmar_ratio, dorsal_ratio : squared half height over squared half width against x.

    """

    cut: float
    tip: float
    middle: float
    palmar: CubicSpline
    dorsal: CubicSpline
    palmar_ratio: CubicSpline
    dorsal_ratio: CubicSpline

    @classmethod
    def of(cls, middle: float, *, cut: float, palmar: Table, dorsal: Table, side: Table) -> "Shell":
        """Return the shell with three profiles that end at the same tip.

        A table that begins distal of the cut is extrapolated; the shell extends behind the cut.
        """
        tip = float(palmar[0][-1])
        x = tip - (tip - cut) * np.linspace(1.0, 0.0, NODES) ** 2
        wide, low, high = (_square(table, x) for table in (side, palmar, dorsal))
        ratios = [np.append(part[:-1] / wide[:-1], 0.0) for part in (low, high)]
        for ratio in ratios:
            ratio[-1] = np.polyval(np.polyfit(x[-6:-1] - tip, ratio[-6:-1], 2), 0.0)
        splines = [CubicSpline(x, values) for values in (low, high, *ratios)]
        return cls(cut, tip, middle, *splines)

    def heights(self, x: Array) -> tuple[Array, Array, Array]:
        """Return half width, palmar depth and dorsal height at x, each (n,), mm."""
        x = np.minimum(x, self.tip)
        low, high = (np.maximum(spline(x), 0.0) for spline in (self.palmar, self.dorsal))
        # Splines of a scan's profiles may swing below 0 beside the tip, where all are 0.
        wide = np.maximum(low / self.palmar_ratio(x), 0.0)
        return np.sqrt(wide), np.sqrt(low), np.sqrt(high)

    def level(self, points: Array) -> Array:
        """Return a signed distance, first-order exact at the surface, negative inside, (n,) mm."""
        value, gradient = self._implicit(points)
        return np.asarray(value / np.maximum(np.linalg.norm(gradient, axis=1), 1e-9))

    def normals(self, points: Array) -> Array:
        """Return the unit outward normals (n, 3) at points of the surface."""
        gradient = self._implicit(points)[1]
        return np.asarray(gradient / np.linalg.norm(gradient, axis=1)[:, None])

    def project(self, points: Array, *, free: Flags | None = None) -> Array:
        """Return points (n, 3) moved onto the surface along its gradient.

        `free` (n, 3) or (3,): the coordinates that may change: a point of the medial plane keeps
        its y, one of the cut keeps its x.
        """
        moved = np.array(points, dtype=float)
        mask = np.ones_like(moved) if free is None else np.broadcast_to(free, moved.shape)
        for _ in range(40):
            value, gradient = self._implicit(moved)
            gradient *= mask
            size = np.maximum(np.linalg.norm(gradient, axis=1), 1e-9)
            step = np.clip(value / size, -0.5, 0.5)
            moved -= (step / size)[:, None] * gradient
            if np.max(np.abs(step), initial=0.0) < 1e-12:
                break
        return moved

    def _implicit(self, points: Array) -> tuple[Array, Array]:
        """Return q y^2 + (z - middle)^2 - b^2 and its gradient, with q = b^2/a^2."""
        x, y, z = np.asarray(points, dtype=float).T
        inside = np.minimum(x, self.tip)
        below = z < self.middle
        square = np.where(below, self.palmar(inside), self.dorsal(inside))
        slope = np.where(below, self.palmar(inside, 1), self.dorsal(inside, 1))
        ratio = np.where(below, self.palmar_ratio(inside), self.dorsal_ratio(inside))
        change = np.where(below, self.palmar_ratio(inside, 1), self.dorsal_ratio(inside, 1))
        change = np.where(x > self.tip, 0.0, change)
        height = z - self.middle
        value = ratio * y**2 + height**2 - square - slope * (x - inside)
        gradient = np.column_stack([change * y**2 - slope, 2.0 * ratio * y, 2.0 * height])
        return value, gradient


def offset(table: Table, distance: float) -> Table:
    """Return the parallel curve of a profile, `distance` mm inward along its normals."""
    x, r = table
    # The slope of r is infinite at the tip, that of r^2 is finite, and (-r r', r) is a normal too.
    slope = np.gradient(r**2, x, edge_order=2) / 2.0
    size = np.hypot(slope, r)
    moved_x, moved_r = x + distance * slope / size, r - distance * r / size
    moved_x[-1], moved_r[-1] = x[-1] - distance, 0.0
    return moved_x, moved_r


def _square(table: Table, x: Array) -> Array:
    """Return r^2 at x, with zero at the tip."""
    nodes, first = np.unique(table[0], return_index=True)
    square = CubicSpline(nodes, (table[1] ** 2)[first])(x)
    square[-1] = 0.0
    return np.asarray(square)
