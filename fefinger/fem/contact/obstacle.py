"""Rigid obstacles that travel along an axis: a profile of heights, placed and turned in space.

In small strain the gap to the obstacle is linearized about the point of the obstacle that lies
straight ahead: gap = n . axis (s - d) + n . u, with s the distance along the axis at first touch, d
the travel and n the obstacle's outward normal there. It is exact for points that move along the
axis, at every depth; sideways motion enters to first order. Finite strain takes the gap along the
axis itself, g = (x - origin) . axis + h - d, with its derivatives at the deformed point x.
"""

from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np

from fefinger.geometry.profiles import Plane, Profile, frame
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import InputError


FAR = 1e3  # mm, the gap of a point that the obstacle is not ahead of, where it has to be finite


@runtime_checkable
class Rigid(Protocol):
    """Interface of a rigid obstacle: its direction of travel and its distance from points."""

    @property
    def axis(self) -> Array:
        """Unit direction of travel (3,), into the body."""

    def gap(self, points: Array) -> tuple[Array, Array]:
        """Return the distance along the axis (...,) mm and the obstacle's normals (..., 3)."""

    def beyond(self, points: Array) -> Flags:
        """Return whether points (..., 3) lie beyond the rim of the obstacle's shape."""


@dataclass(frozen=True)
class Obstacle:
    """A rigid obstacle of a given profile; a plane by default.

    axis (3,) unit direction of travel, into the finger; origin (3,) mm the foremost point of the
    obstacle at first touch; roll degrees by which the profile is turned about the axis; touched
    (3,) mm the place that it touches first, where that is not its foremost point.
    """

    axis: Array
    origin: Array
    profile: Profile = field(default_factory=Plane)
    roll: float = 0.0
    touched: Array | None = None

    @property
    def first_touch(self) -> Array:
        """Place (3,) mm of the skin that it touches first, about."""
        return self.origin if self.touched is None else self.touched

    @property
    def frame(self) -> Array:
        """Rows (3, 3): the profile's two unit vectors across the axis, then the axis."""
        return frame(self.axis, self.roll)

    def gap(self, points: Array) -> tuple[Array, Array]:
        """Return the distance along the axis (...,) mm and the obstacle's normals (..., 3).

        The distance is infinite where the obstacle is not ahead of the point.
        """
        distance, gradient = self.implicit(points)
        return distance, gradient / np.linalg.norm(gradient, axis=-1, keepdims=True)

    def beyond(self, points: Array) -> Flags:
        """Return whether points (..., 3) lie beyond the rim of the obstacle's shape."""
        return self.profile.beyond(((points - self.origin) @ self.frame.T)[..., :2])

    def implicit(self, points: Array, depth: float = 0.0) -> tuple[Array, Array]:
        """Return g = (x - origin) . axis + h - depth and its gradient at points x (..., 3).

        g (...,) mm is positive where the point is free and negative where it is inside the
        obstacle; its gradient (..., 3), of which the part along the axis is 1, points out of the
        obstacle. Where the obstacle is not ahead, g is infinite and the gradient is the axis.
        """
        frame = self.frame
        local = (points - self.origin) @ frame.T
        h, slope, _ = self.profile.height(local[..., :2])
        return local[..., 2] + h - depth, self.axis + slope @ frame[:2]


@dataclass(frozen=True)
class OwnObstacle:
    """An obstacle of a user's own, with what it lacks filled in.

    given: any object with an `axis` (3,) and `gap(points)` as of `Rigid`; perhaps `beyond(points)`
    and an `origin` (3,) mm, the point of first touch.

    Raises InputError if it has no axis of three finite numbers, or no gap.
    """

    given: Any

    def __post_init__(self) -> None:
        """Check that there is an axis and a gap."""
        if not callable(getattr(self.given, "gap", None)) or not hasattr(self.given, "axis"):
            raise InputError(
                "indenter: expected an ff.Indenter, such as ff.Flat(30), or an object with an "
                f"`axis` and a `gap(points)`, received {self.given!r}"
            )
        axis = np.asarray(self.given.axis, dtype=np.float64)
        unit = 1e-6  # by which the length of an axis may differ from 1
        if axis.shape != (3,) or not abs(np.linalg.norm(axis) - 1.0) < unit:
            raise InputError(
                f"indenter.axis: expected a unit vector (3,), received {self.given.axis!r}"
            )

    @property
    def axis(self) -> Array:
        """Unit direction of travel (3,), into the body."""
        return np.asarray(self.given.axis, dtype=np.float64)

    @property
    def origin(self) -> Array:
        """Point of first touch (3,) mm; the origin of the frame where it is not given."""
        return np.asarray(getattr(self.given, "origin", np.zeros(3)), dtype=np.float64)

    def gap(self, points: Array) -> tuple[Array, Array]:
        """Return the distance along the axis (...,) mm and the obstacle's normals (..., 3).

        Raises InputError if the user's `gap` returns anything else.
        """
        answer, wanted = self.given.gap(points), (points.shape[:-1], points.shape)
        shapes = tuple(map(np.shape, answer)) if isinstance(answer, tuple | list) else None
        if shapes != wanted:
            received = shapes or f"{type(answer).__name__} {np.shape(answer)}"
            raise InputError(
                "indenter.gap(points): expected two arrays, distances along the axis and normals, "
                f"of shapes {wanted}, received {received}"
            )
        distance, normals = answer
        return np.asarray(distance, dtype=np.float64), np.asarray(normals, dtype=np.float64)

    def beyond(self, points: Array) -> Flags:
        """Return whether points (..., 3) lie beyond the rim of its shape; nowhere if not given."""
        if not hasattr(self.given, "beyond"):
            return np.zeros(points.shape[:-1], dtype=bool)
        return np.asarray(self.given.beyond(points), dtype=bool)
