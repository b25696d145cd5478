"""Analytic smooth closed surface of a finger, of half ellipses across it, and its triangulation.

Every plane x = const cuts it in two half ellipses that share the widest level z = middle, a palmar
one below and a dorsal one above. Three profiles along x (half width, palmar depth, dorsal height)
make the whole shape, and all end in the same rounded tip. The square r^2 of a profile is smooth at
the tip, so the square is what is stored.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from fefinger.support.arrays import Array, Flags, Integers


Table = tuple[Array, Array]
"""Profile as x ascending to the tip and half size r(x), which is zero at the tip, mm."""


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
        # With 400 nodes the splines agree with their tables to about 1e-6 mm.
        x = tip - (tip - cut) * np.linspace(1.0, 0.0, 400) ** 2
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


Triangles = tuple[Array, Integers]
"""Vertices (n, 3) in mm and triangles (m, 3), oriented outward."""


def half(shell: Shell, step: float, *, overhang: float = 0.0) -> Triangles:
    """Return the closed half y >= 0 of a shell with facets of about `step` mm.

    It begins `overhang` mm behind the cut.

    Rings of constant x run to a pole at the tip; a strip of columns closes the medial plane and a
    fan closes the cut.
    """
    rings = _stations(shell, step, shell.cut - overhang)
    girth = np.pi / 2 * max(float(np.max(part)) for part in shell.heights(rings))
    count = 2 * max(int(np.ceil(girth / step)), 6) + 1
    angle = np.linspace(0.0, np.pi, count)
    wide, low, high = (part[:, None] for part in shell.heights(rings))
    z = shell.middle - np.cos(angle) * np.where(angle < np.pi / 2, low, high)
    y = wide * np.sin(angle)
    y[:, [0, -1]] = 0.0
    outer = np.stack(np.broadcast_arrays(rings[:, None], y, z), axis=-1).reshape(-1, 3)
    axis = np.column_stack([rings, 0.0 * rings, np.full(len(rings), shell.middle)])
    pole = np.array([[shell.tip, 0.0, shell.middle]])
    points = np.concatenate([outer, axis, pole])
    index = np.arange(len(outer)).reshape(len(rings), count)
    column = len(outer) + np.arange(len(rings))
    last = len(points) - 1
    faces = [
        _strip(index.T, closed_by=None),
        _fan(index[-1], last)[:, ::-1],
        _strip(np.stack([column, index[:, 0]]), closed_by=last),
        _strip(np.stack([index[:, -1], column]), closed_by=last),
        _fan(index[0], column[0]),
    ]
    return points, np.concatenate(faces)


def without_caps(part: Triangles) -> Triangles:
    """Return a half surface without its medial plane and cut."""
    points, faces = part
    corners = points[faces]
    caps = np.all(corners[:, :, 1] == 0.0, axis=1)
    caps |= np.all(corners[:, :, 0] == points[0, 0], axis=1)
    return points, faces[~caps]


def ribbon(rows: Array) -> Triangles:
    """Return the surface through neighboring rows of points, (rows, count, 3) mm."""
    index = np.arange(rows[..., 0].size).reshape(rows.shape[:2])
    return rows.reshape(-1, 3), _strip(index, closed_by=None)


def volume(surface: Triangles) -> float:
    """Return the volume inside a closed outward surface, mm^3 (divergence theorem)."""
    corners = surface[0][surface[1]]
    return float(np.linalg.det(corners).sum() / 6.0)


def _stations(shell: Shell, step: float, start: float) -> Array:
    """Return x of the rings from the cut to the last one before the pole, even along the palm."""
    fine = shell.tip - (shell.tip - start) * np.linspace(1.0, 0.0, 2000) ** 2
    wide, low, _ = shell.heights(fine)
    arc = [np.hypot(np.diff(fine), np.diff(part)).cumsum() for part in (wide, low)]
    travel = np.concatenate([[0.0], np.maximum(*arc)])
    count = max(int(np.ceil(travel[-1] / step)), 8)
    return np.interp(np.linspace(0.0, travel[-1], count + 1)[:-1], travel, fine)


def _strip(rows: Integers, *, closed_by: int | None) -> Integers:
    """Return triangles between neighboring rows of vertices, with an end vertex if given."""
    a, b, c, d = rows[:-1, :-1], rows[:-1, 1:], rows[1:, 1:], rows[1:, :-1]
    quads = [np.stack([a, c, b], axis=-1), np.stack([a, d, c], axis=-1)]
    parts = [quad.reshape(-1, 3) for quad in quads]
    if closed_by is not None:
        end = np.full(len(rows) - 1, closed_by)
        parts.append(np.column_stack([rows[:-1, -1], rows[1:, -1], end]))
    return np.concatenate(parts)


def _fan(ring: Integers, center: int) -> Integers:
    """Return triangles between a ring of vertices and a center."""
    return np.column_stack([ring[:-1], np.full(len(ring) - 1, center), ring[1:]])
