"""Rigid smooth obstacles that travel along an axis: plane and ellipsoid.

In small strain the gap to the obstacle is linearized about the point of the obstacle that lies
straight ahead: gap = n . axis (s - d) + n . u, with s the distance along the axis at first touch, d
the travel and n the obstacle's outward normal there. It is exact for points that move along the
axis, at every depth; sideways motion enters to first order.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fefinger.fem.spaces import Array


class Rigid(Protocol):
    """What contact needs of an obstacle."""

    @property
    def axis(self) -> Array:
        """Unit direction of travel (3,), into the body."""

    def gap(self, points: Array) -> tuple[Array, Array]:
        """Return the distance along the axis (...,) mm and the obstacle's normals (..., 3)."""


@dataclass(frozen=True)
class Obstacle:
    """A rigid obstacle: `radii` (3,) mm of an ellipsoid, the last along the axis; None: a plane.

    axis (3,) unit direction of travel, into the finger; origin (3,) mm the foremost point of the
    obstacle at first touch.
    """

    axis: Array
    origin: Array
    radii: Array | None = None

    @property
    def frame(self) -> Array:
        """Rows: two unit vectors across the axis (the first in the x-z plane), then the axis."""
        across = np.cross([0.0, 1.0, 0.0], self.axis)
        first = across / np.linalg.norm(across)
        return np.array([first, np.cross(self.axis, first), self.axis])

    def gap(self, points: Array) -> tuple[Array, Array]:
        """Return the distance along the axis (...,) mm and the obstacle's normals (..., 3).

        The distance is infinite where the obstacle is not ahead of the point.
        """
        local = (points - self.origin) @ self.frame.T
        if self.radii is None:
            return local[..., 2], np.broadcast_to(self.axis, points.shape)
        scaled = local[..., :2] / self.radii[:2]
        inside = 1.0 - np.sum(scaled**2, axis=-1)
        ahead = inside > 0
        root = np.sqrt(np.where(ahead, inside, 1.0))
        surface = self.radii[2] * (root - 1.0)
        normal = np.concatenate(
            [scaled / self.radii[:2], (root / self.radii[2])[..., None]], axis=-1
        )
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        distance = np.where(ahead, local[..., 2] - surface, np.inf)
        return distance, normal @ self.frame
