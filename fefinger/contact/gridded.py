"""Frictionless contact of a body whose compliance is known by wavenumber, on a periodic grid.

As `frictionless.py`, where the flexibility is a matrix: p = g y + h, and gap - depth + F y >= 0 is
a complementarity problem in p, here of every point of the grid.
"""

from collections.abc import Callable

import numpy as np

from fefinger.contact.active_set import DONE, ENDLESS, TURNED
from fefinger.contact.force_control import DEPTH
from fefinger.contact.grid_solver import ITERATIONS, GridSolver, winkler
from fefinger.contact.prony_history import load_history, prony_history, store_history
from fefinger.contact.stepper import Record, Stepper, Target
from fefinger.support.arrays import Array, Flags


CLOSED = 1e-6
"""Gap or penetration, over the largest displacement, that counts as none."""

FAR = 1e3  # mm, the gap where the object has ended

Heights = Callable[[tuple[float, float]], Array]
"""Gap (n_x, n_y) mm of the grid at a depth of 0, for a place (x, y) mm of the object; inf where it
has ended."""


class GridContact(Stepper):
    """Frictionless contact of a body on a periodic grid.

    Parameters
    ----------
    compliance, points
        As of `GridSolver`.
    spacing
        Distance in mm of the grid points.
    gap
        `Heights`.
    branches
        Weights and rates (m,) of the Prony terms, over the long-time modulus.
    tolerance
        Gap or penetration, over the largest displacement, that counts as none.
    """

    failures = dict(Stepper.failures) | {
        ENDLESS: f"contact: expected the gaps on the grid to close within {ITERATIONS} iterations, "
        "but they did not"
    }

    def __init__(
        self,
        compliance: Array,
        points: tuple[int, int],
        spacing: float,
        gap: Heights,
        branches: tuple[Array, Array],
        *,
        tolerance: float = CLOSED,
    ) -> None:
        self.solver, self.gap = GridSolver(compliance, points), gap
        self.area, self.tolerance = spacing**2, tolerance
        count = points[0] * points[1]
        history = prony_history(branches, count)
        limits = np.full(count, DONE, dtype=np.int64)
        super().__init__(self.solver, history, limits, moves=True)

    def _advance(self, dt: float, target: Target) -> int:
        here = self.gap(target.shift)
        ended = ~np.isfinite(here)
        free = np.where(ended, FAR, here).ravel()
        g = load_history(self.history, dt)
        outcome = self._balance(g, g * free - self.history.moved_past, target)
        if outcome != DONE:
            return outcome
        if ended.any() and (self.pressure.reshape(ended.shape)[beside(ended)] > 0.0).any():
            return TURNED
        store_history(self.history, self.solver.x, self.solver.moved, dt, g)
        return DONE

    def _balance(self, g: float, offset: Array, target: Target) -> int:
        """Solve at a depth or under a force; offset (n,) mm: g gap - F h at a depth of 0."""
        start = self.pressure.copy()
        if not target.by_force:
            self.search[DEPTH] = target.value
            return self.solver.solve(offset - g * target.value, start, self.tolerance)
        if target.value <= 0.0:
            self.search[DEPTH] = min(self.search[DEPTH], float(offset.min()) / g)
            self.solver.x[:] = 0.0
            self.solver.moved[:] = 0.0
            self.solver.place[:] = -1
            return DONE
        total = target.value / self.area
        if not start.any():
            start = winkler(offset, total, 1.0 / float(np.abs(self.solver.compliance).max()))
        outcome = self.solver.solve(offset, start, self.tolerance, total)
        self.search[DEPTH] = self.solver.rigid / g
        return outcome

    def _rebuild(self) -> None:
        """Nothing follows from the arrays of the state that is not in them."""

    @property
    def force(self) -> float:
        """Force in mN on the grid."""
        return float(self.pressure.sum()) * self.area

    def energy(self) -> float:
        """Return the stored energy in µJ."""
        m, displacement = self.history, self.solver.displacement
        stored = float(m.elastic @ m.moved_elastic)
        for weight, term in zip(m.weights, m.terms, strict=True):
            stored += float(term @ displacement(term)) / weight if weight > 0.0 else 0.0
        return stored * self.area / 2

    def record(self) -> Record:
        """Return the present values that a history holds, by their names."""
        return super().record() | {"slopes": np.zeros(2)}


def beside(ended: Flags) -> Flags:
    """Return whether a grid point (n_x, n_y) has a neighbor where the object has ended."""
    sides = [np.roll(ended, way, axis) for axis in (0, 1) for way in (1, -1)]
    return np.asarray(np.logical_or.reduce([ended, *sides]))
