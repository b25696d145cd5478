"""Contact area with sub-element accuracy, from the gap outside the contact.

Outside the rim of a smooth contact the gap grows as the distance to the power 3/2, so that
phi = gap^(2/3) is linear in the distance (Johnson, Contact Mechanics, 1985, section 5.1). Around
each vertex near the rim phi is fitted to the gaps outside, as c0 + c1 s + c2 t + c3 t² along and
across its gradient, and its zero level is the rim. Pressures are not used, because at
vertices next to the rim they alternate about the exact ones.

At an edge of the obstacle, as of a bar or a pin, contact ends at that edge: at the point between a
vertex in contact and a free one where the obstacle protrudes most. Edges rounded as widely as the
facets count too, since the power does not hold within their rounding.
"""

from dataclasses import dataclass
from functools import cached_property
from math import hypot, sqrt

import numpy as np
from scipy.spatial import cKDTree

from fefinger.fem.contact.obstacle import FAR, Rigid
from fefinger.fem.elements.assembly import numbering
from fefinger.geometry.finger_mesh import triangle_areas
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.compiled import njit


SIDES = np.array([[0, 1], [1, 2], [2, 0]])
PLACES = np.linspace(0.0, 1.0, 33)  # positions along a side at which an edge is sought

PLAUSIBLE = 1.2, 1.5  # ratios to the area of the vertices: the fit counts up to, nothing from here
ROWS = 4096  # fits in one batch, so that the work arrays stay in cache
SAME = 1e-9  # relative change of the gap below which the last area is reused

REACH = 2.0  # radius of a fit in edges
LEAST, FIRST = 5, 8  # fewest points of a fit; with fewer within REACH, it takes the nearest 8
RIDGE = 1e-9  # ridge regularization over the trace, for points that do not determine the fit


@dataclass(frozen=True)
class CandidateSurface:
    """Contact candidates as a triangle mesh, projected along `axis`; measures the contact area.

    points (n, 3) mm; triangles (n_tri, 3); axis (3,): direction of travel; obstacle: given where
    it has edges.
    """

    points: Array
    triangles: Integers
    axis: Array
    obstacle: Rigid | None = None

    def area(self, pressed: Flags, gap: Array) -> Array:
        """Contact area (n_t,) mm² over time.

        pressed (n_t, n) are the vertices under pressure, gap (n_t, n) mm the distance of every
        vertex from the obstacle, along its normal; FAR where the obstacle is not ahead.
        """
        measured = np.zeros(len(gap))
        closed = pressed | (gap <= 0)  # pressures oscillate toward an edge, some are zero there
        source = _sources(pressed, gap)
        by_edges: dict[bytes, float | None] = {}
        times_of: dict[bytes, list[int]] = {}
        for k in np.unique(source[source >= 0]).tolist():
            key = closed[k].tobytes()
            if key not in by_edges:
                by_edges[key] = self._edge_area(closed[k])
            area = by_edges[key]
            if area is None:
                times_of.setdefault(pressed[k].tobytes(), []).append(k)
            else:
                measured[k] = area
        for times in times_of.values():
            measured[times] = self._rim_area(pressed[times[0]], gap[times])
        return np.asarray(np.where(source >= 0, measured[source], 0.0))

    @cached_property
    def _areas(self) -> Array:
        return triangle_areas(self.points[self.triangles])

    @cached_property
    def _across(self) -> Array:
        """The points projected along the axis, (n, 2) mm."""
        # The null space of the axis: two unit vectors across it.
        return np.asarray(self.points @ np.linalg.svd(self.axis[None])[2][1:].T)

    @cached_property
    def _near(self) -> Integers:
        """The neighbors (n, k) of the points, nearest first."""
        # A list of ranks, because a single rank 1 would drop a dimension.
        neighbors = 40  # nearest vertices from which a fit takes its points
        ranks = np.arange(1, min(neighbors, len(self.points)) + 1)
        return np.asarray(cKDTree(self.points).query(self.points, k=ranks)[1])

    @cached_property
    def _edge(self) -> Array:
        """Mean length (n,) mm of the sides around each point."""
        corners, count = self.triangles.ravel(), len(self.points)
        total = np.bincount(corners, np.repeat(self._areas, 3), minlength=count)
        return np.sqrt(2 * total / np.maximum(np.bincount(corners, minlength=count), 1))

    def _edge_area(self, closed: Flags) -> float | None:
        """Area in mm² of a contact (n,) that ends at edges; None where none lies along its rim.

        Between a vertex in contact and a free one it ends where the obstacle protrudes most over
        the chord between them; on a side without an edge, half way.
        """
        if self.obstacle is None:
            return None
        count = closed[self.triangles].sum(axis=1)
        mixed = np.flatnonzero((count > 0) & (count < 3))
        at, edged = self._edges_along(mixed)
        sides = self.triangles[mixed][:, SIDES]
        start, end = closed[sides[..., 0]], closed[sides[..., 1]]
        crossed = start != end
        edge = crossed & edged
        if not edge.any():
            return None
        at = np.where(edge, at, 0.5)
        reach = np.where(start, at, 1 - at)
        alone = np.where(crossed, reach, 1.0).prod(axis=1)
        both = 1 - np.where(crossed, 1 - reach, 1.0).prod(axis=1)
        share = count / 3
        share[mixed] = np.where(count[mixed] == 1, alone, both)
        return float(share @ self._areas)

    @cached_property
    def _known_edges(self) -> tuple[Flags, Array, Flags]:
        """Whether triangles (n_tri,) were looked at, and what was found along their sides."""
        count = len(self.triangles)
        return np.zeros(count, bool), np.full((count, 3), 0.5), np.zeros((count, 3), bool)

    def _edges_along(self, chosen: Integers) -> tuple[Array, Flags]:
        """Places (n, 3) at which the obstacle turns away along the sides of triangles, and if so.

        They are kept: contact ends in the same triangles again and again.
        """
        known, places, edged = self._known_edges
        new = chosen[~known[chosen]]
        known[new] = True
        sides = self.triangles[new][:, SIDES]
        length = np.linalg.norm(np.diff(self.points[sides], axis=2)[:, :, 0], axis=2)
        distance, rise, walled = self._rises(sides, length)
        sharp = 0.05  # least protrusion of an edge over the length of a side
        edged[new] = (rise.max(axis=2) > sharp * length) & (walled | _turned(distance, rise))
        places[new] = PLACES[rise.argmax(axis=2)]
        return places[chosen], edged[chosen]

    def _rises(self, sides: Integers, length: Array) -> tuple[Array, Array, Flags]:
        """Distance (..., n) mm of the obstacle at PLACES of sides, and its protrusion over a chord.

        And whether sides pass a wall (...,), behind which it is not ahead. length (...,) mm: of the
        sides. Walls, and what is steeper than 45 degrees, count as that steep.
        """
        assert self.obstacle is not None
        first, last = (self.points[sides[..., end]][..., None, :] for end in (0, 1))
        along = PLACES[:, None]
        distance, _ = self.obstacle.gap((1 - along) * first + along * last)
        ahead = np.isfinite(distance)
        walled = np.asarray(ahead.any(axis=-1) & ~ahead.all(axis=-1))
        distance = np.minimum(distance, (distance.min(axis=-1) + length)[..., None])
        chord = (1 - PLACES) * distance[..., :1] + PLACES * distance[..., -1:]
        rise = np.where(np.isfinite(distance), chord - distance, 0.0)
        return np.where(np.isfinite(distance), distance, 0.0), rise, walled

    def _rim_area(self, pressed: Flags, gap: Array) -> Array:
        """Areas (n_t,) mm² at times with gaps (n_t, n) mm and the same pressed vertices (n,)."""
        count = pressed[self.triangles].sum(axis=1)
        edge = np.zeros(len(pressed), dtype=bool)
        edge[self.triangles[(count > 0) & (count < 3)]] = True
        by_rim = edge[self.triangles]  # the rim may lie one triangle farther out or in
        crossed = np.asarray(by_rim.any(axis=1))
        inner = float(self._areas[~crossed & (count == 3)].sum())
        rim = np.unique(self.triangles[crossed])
        if not len(rim):
            return np.full(len(gap), inner)
        few = range(max(1, ROWS // len(rim)), len(gap), max(1, ROWS // len(rim)))
        parts = [self._cut(rim, crossed, pressed, part) for part in np.split(gap, list(few))]
        whole = count[crossed] / 3 * self._areas[crossed]
        fitted = inner + np.concatenate([np.where(k, c, whole).sum(axis=1) for c, k in parts])
        # A contact of few facets has no room for the power 3/2 of the gap: there the area of its
        # vertices counts, and between the two as much as the fit, without a jump.
        vertices = float(count @ self._areas) / 3
        apart = np.abs(np.log(np.maximum(fitted, 1e-300) / vertices))
        weight = np.interp(apart, np.log(PLAUSIBLE), [1.0, 0.0])
        return np.asarray(weight * fitted + (1 - weight) * vertices)

    def _cut(
        self, rim: Integers, crossed: Flags, pressed: Flags, gap: Array
    ) -> tuple[Array, Flags]:
        """Areas in contact (n_t, n_crossed) mm² of triangles near the rim, and if all fits hold."""
        fits, fitted = np.empty((len(gap), len(rim), 2)), np.empty((len(gap), len(rim)), dtype=bool)
        edge = self._edge[rim]
        near = self._near[rim]
        projected = self._across[near] - self._across[rim][:, None]
        # Of their length in space: only projected, points far up the sides of a body would appear
        # next to the rim.
        apart = np.linalg.norm(self.points[near] - self.points[rim][:, None], axis=2)
        short = np.linalg.norm(projected, axis=2)
        stretch = np.where(short > 0, apart / np.where(short > 0, short, 1.0), 1.0)
        offset = projected * stretch[..., None] / edge[:, None, None]
        whole = np.ascontiguousarray(pressed), np.ascontiguousarray(gap)  # compiled for one type
        fit_rims(near, offset, *whole, fits, fitted)
        phi, bend = fits[..., 0], fits[..., 1] / edge  # and the curvature of its zero level in 1/mm
        place = numbering(rim, len(pressed))
        corner, shape = place[self.triangles[crossed]], (len(gap), int(crossed.sum()))
        corners = np.tile(self._across[self.triangles[crossed]], (len(gap), 1, 1))
        share, chord = (
            x.reshape(shape) for x in _below_zero(phi[:, corner].reshape(-1, 3), corners)
        )
        # Segment between the curved rim and its chord of length c: curvature c³ / 12.
        curved = np.clip(bend[:, corner].mean(axis=2) * chord, -1.0, 1.0) * chord**2 / 12
        reliable = np.asarray(fitted[:, corner].all(axis=2))
        return share * self._areas[crossed] + curved, reliable


def _sources(pressed: Flags, gap: Array) -> Integers:
    """Index (n_t,) of the time whose area holds at each time; -1 without contact.

    While the gaps do not change (a hold), it is the index of the last computed area.
    """
    sources, last = np.full(len(gap), -1), -1
    for k in np.flatnonzero(pressed.any(axis=1)).tolist():
        same = last >= 0 and np.array_equal(pressed[k], pressed[last])
        if not same or np.abs(gap[k] - gap[last]).max() > SAME * np.abs(gap[k]).max():
            last = k
        sources[k] = last
    return sources


def _turned(distance: Array, rise: Array) -> Flags:
    """Whether the obstacle turns away within a part of sides (...,), as at an edge.

    distance and rise (..., n) mm at PLACES.
    """
    most = rise.argmax(axis=-1)
    slope, quarter = np.diff(distance), len(PLACES) // 4
    ends = [np.clip(most + k, 0, slope.shape[-1] - 1) for k in (-quarter - 1, quarter)]
    before, after = (np.take_along_axis(slope, k[..., None], -1)[..., 0] for k in ends)
    turned = 0.6  # share of the change of slope within half a side: 1 at an edge, 1/2 on an arc
    return np.asarray(after - before >= turned * (slope[..., -1] - slope[..., 0]))


def _below_zero(phi: Array, corners: Array) -> tuple[Array, Array]:
    """Share of the area of triangles with phi (n, 3) < 0, and length (n,) of the zero line."""
    order = np.argsort(phi, axis=1)
    low, middle, high = np.take_along_axis(phi, order, axis=1).T
    a, b, c = np.moveaxis(np.take_along_axis(corners, order[:, :, None], axis=1), 1, 0)
    alone = middle > 0  # the lowest corner alone is below zero, else the highest alone above
    tip, ends = (
        np.where(alone, low, high),
        (np.where(alone, middle, low), np.where(alone, high, middle)),
    )
    cut = (low < 0) & (high > 0)
    parts = [np.where(cut, tip / np.where(cut & (tip != end), tip - end, 1.0), 0.0) for end in ends]
    small = parts[0] * parts[1]
    share = np.where(cut, np.where(alone, small, 1 - small), low < 0)
    origin = np.where(alone[:, None], a, c)
    tips = (np.where(alone[:, None], b, a), np.where(alone[:, None], c, b))
    first, second = (
        part[:, None] * (tip_ - origin) for part, tip_ in zip(parts, tips, strict=True)
    )
    return share, np.where(cut, np.linalg.norm(first - second, axis=1), 0.0)


@njit(cache=True)
def fit_rims(
    near: Integers, offset: Array, pressed: Flags, gap: Array, fits: Array, fitted: Flags
) -> None:
    """Fit phi = gap^(2/3) around the vertices near the rim, as c0 + c1 s + c2 t + c3 t².

    near (n_rim, k): the neighbors of each, nearest first; offset (n_rim, k, 2): their offsets in
    edge lengths; pressed (n,) and gap (n_t, n) mm of all vertices. Output: fits (n_t, n_rim, 2), c0
    and the curvature 2 c3 / c1 of the zero level in 1/edge; fitted (n_t, n_rim), whether they hold.
    """
    count = near.shape[1]
    used, values, weights = np.empty(count, np.bool_), np.empty(count), np.empty(count)
    basis = np.empty((count, 4))
    for t in range(len(gap)):
        for r in range(len(near)):
            points = _choose(near[r], offset[r], pressed, gap[t], used)
            _weigh(near[r], gap[t], used, values, weights)
            c0, c1, c3 = _fit(offset[r], used, values, weights, basis)
            fitted[t, r] = points >= LEAST and c1 > 0
            fits[t, r, 0] = c0
            fits[t, r, 1] = 2 * c3 / c1 if fitted[t, r] else 0.0


@njit(cache=True)
def _choose(near: Integers, offset: Array, pressed: Flags, gap: Array, used: Flags) -> int:
    """Mark the neighbors (k,) outside the contact that the fit uses; return their number."""
    left = 0.0  # residual gap of pressed vertices: smaller gaps are numerical noise
    for i in range(len(near)):
        if pressed[near[i]] and hypot(offset[i, 0], offset[i, 1]) < REACH:
            left = max(left, abs(gap[near[i]]))
    close = first = 0
    for i in range(len(near)):
        outside = not pressed[near[i]] and left < gap[near[i]] < FAR
        used[i] = outside and hypot(offset[i, 0], offset[i, 1]) < REACH
        close += used[i]
    if close >= LEAST:
        return close
    for i in range(len(near)):
        outside = not pressed[near[i]] and left < gap[near[i]] < FAR
        used[i] = outside and first < FIRST
        first += used[i]
    return first


@njit(cache=True)
def _weigh(near: Integers, gap: Array, used: Flags, values: Array, weights: Array) -> None:
    """Fill phi and the weights (k,) of the points used: phi², divided by the largest."""
    most = 1e-300
    for i in range(len(near)):
        values[i] = max(gap[near[i]], 0.0) ** (2 / 3) if used[i] else 0.0
        weights[i] = values[i] ** 2
        most = max(most, weights[i])
    for i in range(len(near)):
        weights[i] /= most


@njit(cache=True)
def _fit(
    offset: Array, used: Flags, values: Array, weights: Array, basis: Array
) -> tuple[float, float, float]:
    """Return c0, c1 and c3; the direction of s is the gradient of a plane fitted first."""
    for i in range(len(offset)):
        basis[i, 0], basis[i, 1], basis[i, 2] = 1.0, offset[i, 0], offset[i, 1]
    plane = _least_squares(basis, used, values, weights, 3)
    steep = max(sqrt(plane[1] ** 2 + plane[2] ** 2), 1e-300)
    x, y = plane[1] / steep, plane[2] / steep
    for i in range(len(offset)):
        across = offset[i, 1] * x - offset[i, 0] * y
        basis[i, 1] = offset[i, 0] * x + offset[i, 1] * y
        basis[i, 2], basis[i, 3] = across, across**2
    fit = _least_squares(basis, used, values, weights, 4)
    return fit[0], fit[1], fit[3]


@njit(cache=True)
def _least_squares(basis: Array, used: Flags, values: Array, weights: Array, n: int) -> Array:
    """Return the coefficients (n,) of the first n columns of the basis (k, 4)."""
    matrix, right, trace = np.zeros((n, n)), np.zeros(n), 0.0
    for k in range(len(values)):
        if used[k]:
            for i in range(n):
                weighted = weights[k] * basis[k, i]
                right[i] += weighted * values[k]
                for j in range(i + 1):
                    matrix[i, j] += weighted * basis[k, j]
    for i in range(n):
        trace += matrix[i, i]
    for i in range(n):
        matrix[i, i] += RIDGE * trace + 1e-300
    return _solve(matrix, right)


@njit(cache=True)
def _solve(matrix: Array, right: Array) -> Array:
    """Return the solution (n,), from the lower half of a positive definite matrix (n, n).

    By its factors L D L', in its place.
    """
    n = len(right)
    for j in range(n):
        for k in range(j):
            matrix[j, j] -= matrix[j, k] ** 2 * matrix[k, k]
        for i in range(j + 1, n):
            for k in range(j):
                matrix[i, j] -= matrix[i, k] * matrix[j, k] * matrix[k, k]
            matrix[i, j] /= matrix[j, j]
    for i in range(n):
        for k in range(i):
            right[i] -= matrix[i, k] * right[k]
    for i in range(n):
        right[i] /= matrix[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            right[i] -= matrix[k, i] * right[k]
    return right
