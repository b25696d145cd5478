"""Contact with Coulomb friction of a body on a periodic grid: one step, of depth or force.

As `frictional.py`, where the flexibility is a matrix: history, slip, work of friction and the
kinetic coefficient are the same, here of every point of the grid.
"""

import numpy as np

from fefinger.contact.active_set import ENDLESS
from fefinger.contact.frictional import STUCK, UNSOLVED, begin_step, finish_step
from fefinger.contact.grid_coulomb import Flexibility, GridCoulomb
from fefinger.contact.gridded import CLOSED, GridStepper, Heights
from fefinger.contact.prony_history import prony_history
from fefinger.contact.stepper import Record, Target
from fefinger.support.arrays import Array, Flags


class GridFriction(GridStepper):
    """Contact with Coulomb friction of a body on a periodic grid.

    Parameters
    ----------
    flexibility, points
        As of `GridCoulomb`.
    mu
        Static and kinetic coefficient.
    spacing, gap, branches, tolerance
        As of `GridContact`.

    Attributes
    ----------
    bounds
        (n,): the coefficient of each point in the last step.
    """

    def __init__(
        self,
        flexibility: Flexibility,
        points: tuple[int, int],
        mu: tuple[float, float],
        spacing: float,
        gap: Heights,
        branches: tuple[Array, Array],
        *,
        tolerance: float = CLOSED,
    ) -> None:
        count = points[0] * points[1]
        self.coulomb = GridCoulomb(flexibility, points, mu[0])
        self.mu, self.bounds = np.array(mu, dtype=np.float64), self.coulomb.mu.copy()
        self._lost, self._slip = np.zeros(1), np.zeros(2 * count)
        self._ones = np.ones(count)
        kept = self.coulomb.mu, self.bounds, self._slip, self._lost
        history = prony_history(branches, 3 * count)
        super().__init__(self.coulomb, history, spacing, gap, tolerance, kept)
        self.failures = {**self.failures, ENDLESS: UNSOLVED.format(mu[0])}

    @property
    def traction(self) -> Array:
        """Traction (2, n) kPa on the skin along both axes of the grid."""
        return self.coulomb.x[len(self.pressure) :].reshape(2, -1)

    @property
    def slip(self) -> Array:
        """Slip (2, n) mm of the skin over the object, summed since first contact."""
        return self._slip.reshape(2, -1)

    @property
    def sticking(self) -> Flags:
        """Flag the points (n,) under pressure with less than the traction of slip."""
        stuck = np.hypot(*self.traction) < self.bounds * self.pressure * (1 - STUCK)
        return np.asarray((self.pressure > 0) & stuck)

    @property
    def lost(self) -> float:
        """Work of friction so far in µJ."""
        return float(self._lost[0]) * self.area

    def _begin(self, dt: float, target: Target) -> float:
        x, y = target.shift[0] - self.pose[0], target.shift[1] - self.pose[1]
        return begin_step(self.history, self._ones, self._offset, dt, float(x), float(y))

    def _finish(self, dt: float, g: float) -> None:
        solver = self.coulomb
        self.bounds[:] = solver.mu
        state = solver.x, solver.moved, solver.mu, self.mu, self._slip, self._lost
        finish_step(self.history, *state, self._offset, dt, g)

    def reset(self) -> None:
        """Return to rest: no contact and no history."""
        super().reset()
        self.coulomb.mu[:] = self.bounds[:] = self.mu[0]

    def record(self) -> Record:
        """Return the present values that a history holds, by their names."""
        friction: Record = {"traction": self.traction, "slip": self.slip, "sticking": self.sticking}
        friction |= {"lost": self.lost, "cone": self.coulomb.residual}
        return super().record() | friction
