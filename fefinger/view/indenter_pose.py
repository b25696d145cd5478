"""Where the indenter is in pictures: its position, direction, surface, and medial outline."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fefinger.geometry.profiles import Plane, Profile, frame
from fefinger.results.result_record import ResultRecord
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array
from fefinger.view.frames import whole


SAMPLES, STEPS = 1201, 8  # points of an outline; iterations of its places in the medial plane


class Pose(NamedTuple):
    """An indenter in space: foremost point (3,) mm, direction of travel (3,), shape, and roll."""

    origin: Array
    axis: Array
    profile: Profile
    roll: float = 0.0

    @property
    def frame(self) -> Array:
        """Rows (3, 3) of unit vectors: the two directions of the shape, and the axis."""
        return frame(self.axis, self.roll)

    def places(self, across: Array) -> Array:
        """Return points (..., 3) of the surface from places (..., 2) mm across; inf beyond it."""
        height = self.profile.height(across)[0]
        frame = self.frame
        there = (np.isfinite(height) & ~self.profile.beyond(across))[..., None]
        back = np.where(there, height[..., None], 0.0) * frame[2]
        return np.where(there, self.origin + across @ frame[:2] - back, np.inf)

    def outline(self, reach: float) -> Array:
        """Return the outline (n, 2) in the medial plane, x and z in mm; n is 0 where it misses it.

        The outline goes `reach` mm to either side.
        """
        ahead = self.axis[[0, 2]] / np.hypot(self.axis[0], self.axis[2])
        if self.profile.half_axes is not None and self.roll == 0:
            return self._ring(ahead, self.profile.half_axes)
        front = self._front(reach)
        if not len(front):
            return front
        low = float((front @ ahead).min()) - 0.06 * reach
        back = front + np.outer(low - front @ ahead, ahead)
        return np.concatenate([front, back[[-1, 0]]])

    def _ring(self, ahead: Array, radii: tuple[float, float, float]) -> Array:
        """Return the ellipse (n, 2) in which the medial plane cuts an ellipsoid; `radii` in mm."""
        center = self.origin - radii[2] * self.axis
        inside = 1 - (center[1] / radii[1]) ** 2
        if inside <= 0:
            return np.empty((0, 2))
        turn = np.linspace(0, 2 * np.pi, 181)[:, None]
        along = np.array([ahead[1], -ahead[0]])
        ring = radii[0] * np.cos(turn) * along + radii[2] * np.sin(turn) * ahead
        return np.asarray(center[[0, 2]] + np.sqrt(inside) * ring)

    def _front(self, reach: float) -> Array:
        """Return the line (n, 2) in which the surface meets the medial plane y = 0."""
        unrolled = self._replace(roll=0.0).frame
        along = np.linspace(-reach, reach, SAMPLES)
        aside = np.full(SAMPLES, -self.origin[1] / unrolled[1, 1])
        turn = (self.frame @ unrolled.T)[:2, :2].T
        for _ in range(STEPS):
            across = np.column_stack([along, aside]) @ turn
            height = self.profile.height(across)[0]
            height = np.where(np.isfinite(height), height, 0.0)
            aside = (height * self.axis[1] - self.origin[1]) / unrolled[1, 1]
        places = self.places(across)
        return places[np.isfinite(places).all(axis=1)][:, [0, 2]]


def pose(result: ResultRecord, depth: float, time: float | None = None) -> Pose:
    """Return the pose of the indenter after `depth` mm of travel, at a time in s if it slides.

    Without a time, for pictures of an indenter of constant shape, a sliding texture is the plane
    through its crests.
    """
    first = _first(result, depth)
    if result.lateral is None or not result.scene.motion.slides:
        return first
    if time is None:
        return first._replace(profile=Plane()) if first.profile.level else first
    shift = result.lateral.shift
    moved = np.array([np.interp(time, result.time, shift[:, k]) for k in (0, 1)])
    across, motion = frame(first.axis)[:2], result.scene.motion
    here, plate = first._replace(origin=first.origin + moved @ across), result.scene.indenter.flat
    if plate is None or not motion.turns_plate:
        return here
    normal = first.axis + motion.inclines(time, plate) @ across
    return here._replace(axis=normal / np.linalg.norm(normal))


@dataclass(frozen=True)
class Texture:
    """A sliding plate with a texture, drawn as heights that change over fixed places.

    first: its pose before it moves; shift(t) (2,) mm: how far it has moved along its plane.
    """

    first: Pose
    shift: Callable[[float], Array]

    def rise(self, time: float, points: Array) -> Array:
        """Distances (n,) mm of drawn points (n, 3) from the surface at a time in s.

        Along the direction of travel; 0 where the surface has no height.
        """
        local = (points - self.first.origin) @ self.first.frame.T
        turn = self.first.frame[:2] @ frame(self.first.axis)[:2].T
        height = self.first.profile.rise(local[:, :2] - turn @ self.shift(time))
        return np.where(np.isfinite(height), -height - local[:, 2], 0.0)


def texture(result: ResultRecord) -> Texture | None:
    """Return the texture of an indenter that slides; None where it has none."""
    first = _first(result, 0.0)
    if result.lateral is None or not result.scene.motion.slides:
        return None
    if first.profile.plane or not first.profile.level:
        return None
    return Texture(first, result.scene.motion.shift)


def _first(result: ResultRecord, depth: float) -> Pose:
    """Return the pose of the indenter before it slides."""
    indenter = result.scene.indenter
    plate, at, pad = indenter.plate, indenter.place, result.pad
    origin, axis = np.zeros(3), direction(STANDARD if plate is None else plate)
    if plate is not None:
        if plate != STANDARD.plate and result.fields is not None:
            points = whole(result.fields).points
            origin = points[int(np.argmin(points @ axis))]
    elif at is not None and pad is not None:
        palmar = np.where(pad.normals[:, 2] < 0, 0.0, np.inf)
        away = np.sum((pad.points[:, :2] - at) ** 2, axis=1) + palmar
        here = int(np.argmin(away))
        origin, axis = pad.points[here], -pad.normals[here]
        # Distance in mm from the next vertex of the pad from which on a place is beside it.
        next_to = 1.0
        if away[here] > next_to**2:  # beside the pad: it moves along z
            axis = np.array([0.0, 0.0, 1.0])
            across = (pad.points - [*at, 0.0]) @ frame(axis, indenter.turn)[:2].T
            origin = np.array([*at, (pad.points[:, 2] + indenter.profile.rise(across)).min()])
    return Pose(origin + depth * axis, axis, indenter.profile, indenter.turn)
