"""Obstacles that slide: their heights travel over the fixed nodes of a pad.

The pressure acts along the axis of the obstacle, not along the normals of its slopes, so that the
unit loads, and with them the flexibility, are the same at every place of the obstacle: only the
weighted gaps change. It is the small-slope limit of contact mechanics, in which the force along
the plane is the pressure times the slope (Johnson, Contact Mechanics, 1985, section 1.4).
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import repeat
from typing import Self

import numpy as np
from scipy import sparse

from fefinger.fem.contact.obstacle import FAR, Obstacle, Rigid
from fefinger.fem.contact.patch import Patch, smooth_places, trace_of
from fefinger.fem.elements.assembly import scattered
from fefinger.fem.elements.spaces import Space
from fefinger.geometry.profiles import Plane, frame
from fefinger.support.arrays import Array, Flags, Integers


@dataclass(frozen=True)
class Swept:
    """All that an obstacle passes over on its way; a body with an `axis` and a `gap`.

    shifts (k, 2) mm: places of the obstacle across its axis; inclines (k, 2): the slopes of a plate
    that turns.
    """

    obstacle: Obstacle
    shifts: Array
    inclines: Array | None = None

    @property
    def axis(self) -> Array:
        """Unit direction of travel (3,), into the body."""
        return self.obstacle.axis

    def gap(self, points: Array) -> tuple[Array, Array]:
        """Return the least distance along the axis (...,) mm of any place, and the axis."""
        over = Heights.over(self.obstacle, points.reshape(-1, 3))
        nearest = np.full(len(over.along), np.inf)
        inclines = repeat(None) if self.inclines is None else self.inclines
        for shift, incline in zip(self.shifts, inclines, strict=False):
            nearest = np.minimum(nearest, over.distance(shift, incline))
        return nearest.reshape(points.shape[:-1]), np.broadcast_to(self.axis, points.shape)

    def beyond(self, points: Array) -> Flags:
        """Return False: where the shape ends is looked at on the way, see `Travel.gap`."""
        return np.zeros(points.shape[:-1], dtype=bool)


def envelope(obstacle: Obstacle, path: Array, inclines: Array | None = None) -> Rigid:
    """Return the union of an obstacle along a path (n, 2) mm, by which candidates are chosen.

    That of a plate with a level texture is its plane, unless it turns to `inclines` (n, 2).
    """
    if inclines is not None:
        every: Array = np.unique(np.hstack([path, inclines]).round(2), axis=0)
        return Swept(obstacle, every[:, :2], every[:, 2:])
    if obstacle.profile.level:
        return Obstacle(obstacle.axis, obstacle.origin, Plane())
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
    stride = 0.2  # mm of a path between the places at which the reach of a sliding object is taken
    chosen = np.searchsorted(length, np.append(np.arange(0.0, length[-1], stride), length[-1]))
    return Swept(obstacle, np.unique(path[chosen], axis=0))


@dataclass(frozen=True)
class Heights:
    """The obstacle over fixed points of the pad.

    across (n, 2) and along (n,) mm: the points, from the obstacle's origin, across and along its
    axis; `turn` (2, 2) is its roll.
    """

    obstacle: Obstacle
    across: Array
    along: Array

    @classmethod
    def over(cls, obstacle: Obstacle, points: Array) -> Self:
        """Return the obstacle over points (n, 3) mm."""
        local = (points - obstacle.origin) @ frame(obstacle.axis).T
        return cls(obstacle, np.ascontiguousarray(local[:, :2]), np.ascontiguousarray(local[:, 2]))

    @cached_property
    def turn(self) -> Array:
        """Matrix (2, 2) from places across the axis to those on the obstacle."""
        return np.asarray(self.obstacle.frame[:2] @ frame(self.obstacle.axis)[:2].T)

    def places(self, shift: Array, chosen: slice | Integers = slice(None)) -> Array:
        """Return where the points lie on the obstacle (n, 2) mm, moved by (2,) mm."""
        return np.asarray((self.across[chosen] - shift) @ self.turn.T)

    def distance(self, shift: Array, incline: Array | None = None) -> Array:
        """Return the distance along the axis (n,) mm; infinite where the obstacle is not ahead.

        That of a plate with the slopes `incline` (2,) about its moved origin is exact.
        """
        profile = self.obstacle.profile
        if incline is not None:
            return np.asarray(self.along + (self.across - shift) @ incline)
        return self.along if profile.plane else self.along + profile.rise(self.places(shift))

    def distances(self, shifts: Array, inclines: Array | None = None) -> Array:
        """Return the distance (n_t, n) mm along the axis at shifts (n_t, 2) mm, FAR for none."""
        if inclines is not None:
            return np.array([self.distance(*each) for each in zip(shifts, inclines, strict=True)])
        if self.obstacle.profile.plane:
            return np.broadcast_to(self.along, (len(shifts), len(self.along)))
        every = np.array([self.distance(shift) for shift in shifts])
        return np.where(np.isfinite(every), every, FAR)

    def slopes(self, shift: Array, chosen: Integers) -> Array:
        """Return the derivative (k, 2) of the distance of points by their place across the axis."""
        incline = self.obstacle.profile.incline(self.places(shift, chosen))
        return np.asarray(incline @ self.turn)


@dataclass(frozen=True)
class Travel:
    """Weighted gaps of a patch under an obstacle that slides over it.

    over: the obstacle over the quadrature points; weights (n, n_q) mm²: their shares in the hats;
    vertices: the obstacle over the vertices of the patch.
    """

    over: Heights
    weights: sparse.csr_matrix
    vertices: Heights

    @classmethod
    def of(cls, space: Space, normals: Array, on: Patch, obstacle: Obstacle) -> Self:
        """Place an obstacle at first touch over a patch whose loads act along its axis."""
        part, owner = trace_of(space, on)
        places = smooth_places(space.points, normals, part).reshape(-1, 3)
        numbers = np.arange(len(places)).reshape(len(owner), 1, -1)
        shape = (len(on.vertices), len(places))
        weights = scattered(part.hats, owner[:, :, None], numbers, shape).tocsr()
        vertices = Heights.over(obstacle, space.points[on.vertices])
        return cls(Heights.over(obstacle, places), weights, vertices)

    def gap(self, shift: Array, incline: Array | None = None) -> tuple[Array, Flags]:
        """Return the weighted gaps (n,) mm³ at a place (2,) mm, and the rim (n,) of the obstacle.

        Where it is not ahead of all that the hat of a vertex covers, that stays out of contact; the
        vertices beside those are the rim, and those at which its shape has ended.
        """
        distance, profile = self.over.distance(shift, incline), self.over.obstacle.profile
        ahead, ended = np.isfinite(distance), profile.beyond(self.vertices.places(shift))
        if ahead.all():
            return self.weights @ distance, ended
        beyond = self.weights @ (~ahead).astype(float) > 0
        gaps = self.weights @ np.where(ahead, distance, FAR)
        gaps[beyond] = FAR * self._areas[beyond]
        beside = self.weights @ (self._shares @ beyond.astype(float)) > 0
        return gaps, ended | (beside & ~beyond)

    @cached_property
    def _areas(self) -> Array:
        return np.asarray(self.weights.sum(axis=1)).ravel()

    @cached_property
    def _shares(self) -> sparse.csr_matrix:
        return self.weights.T.tocsr()

    def push(self, shift: Array, pressure: Array, incline: Array | None = None) -> Array:
        """Return the force (2,) mN of pressures (n,) kPa on inclined heights, across the axis.

        It is the work of the pressure in a displacement of the obstacle, whose heights then move.
        """
        if incline is not None:
            return np.asarray(float(self._areas @ pressure) * incline)
        if self.over.obstacle.profile.plane:
            return np.zeros(2)
        loads = self._shares @ pressure
        pressed = np.flatnonzero(loads)
        return np.asarray(loads[pressed] @ self.over.slopes(shift, pressed))
