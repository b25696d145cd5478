"""Acceleration of a fixed-point iteration by the differences of its last iterates."""

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.checks import PRESS_LESS, ConvergenceError


class Anderson:
    """Anderson acceleration with the last `depth` iterates; a depth of 1 is the plain iteration.

    Anderson, J. ACM 12:547, 1965.
    """

    def __init__(self, depth: int) -> None:
        self.depth = depth
        self.points: list[Array] = []
        self.changes: list[Array] = []

    def next(self, point: Array, change: Array) -> Array:
        """Return the next point (n,) after `point`, which the iteration would move by `change`.

        Raises
        ------
        ConvergenceError
            If changes have grown beyond numbers.
        """
        self.points = [*self.points, point][-self.depth :]
        self.changes = [*self.changes, change][-self.depth :]
        if len(self.points) == 1:
            return point + change
        differences = np.diff(self.changes, axis=0)
        square = differences @ differences.T
        if not np.isfinite(square).all():
            message = f"equilibrium: the iteration diverged; {PRESS_LESS}"
            raise ConvergenceError(message)
        weights = np.linalg.lstsq(square, differences @ change, rcond=1e-12)[0]
        moved = np.diff(self.points, axis=0) + differences
        return np.asarray(point + change - weights @ moved)
