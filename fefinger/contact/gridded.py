"""Contact of a body whose compliance is known by wavenumber, on a periodic grid: one step.

As `frictionless.py`, where the flexibility is a matrix: p = g y + h, and gap - depth + F y >= 0 is
a complementarity problem in p, here of every point of the grid.

With friction history, slip, work of friction and the kinetic coefficient are those of
`frictional.py`.
"""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from fefinger.contact.active_set import DONE, ENDLESS, TURNED
from fefinger.contact.force_control import DEPTH
from fefinger.contact.frictional import STUCK, UNSOLVED, begin_step, finish_step
from fefinger.contact.grid_coulomb import Flexibility, GridCoulomb
from fefinger.contact.grid_solver import ITERATIONS, GridSolver, displacement
from fefinger.contact.prony_history import (
    PronyHistory,
    load_history,
    prony_history,
    store_history,
)
from fefinger.contact.stepper import Record, State, Stepper, StepSolver, Target
from fefinger.support.arrays import Array, Flags


CLOSED = 1e-6
"""Gap or penetration, over the largest displacement, that counts as none."""

Heights = Callable[[tuple[float, float]], Array]
"""Gap (n_x, n_y) mm of the grid at a depth of 0, for a place (x, y) mm of the object; inf where it
has ended."""


GridParts = tuple[Array, tuple[int, int], float, Heights, tuple[Array, Array]]
"""Arguments of `GridContact`."""


class GridSolution(StepSolver, Protocol):
    """Solver of a step on a grid; `solve` starts from its last solution."""

    moved: Array

    @property
    def rigid(self) -> float:
        """The depth in mm at which x has the prescribed sum, over the one of the offset."""

    def solve(self, offset: Array, tolerance: float, total: float = 0.0) -> int:
        """Solve with an offset in mm, or under a total of pressures; return DONE or a failure."""

    def displacement(self, x: Array) -> Array:
        """Return the displacements in mm of stresses."""

    def clear(self) -> None:
        """Return to no contact."""


class GridStepper(Stepper):
    """Contact of a body on a periodic grid, `spacing` mm apart; see `GridContact`."""

    failures = dict(Stepper.failures) | {
        ENDLESS: f"contact: expected the gaps on the grid to close within {ITERATIONS} iterations, "
        "but they did not"
    }

    def __init__(
        self,
        solver: GridSolution,
        history: PronyHistory,
        spacing: float,
        gap: Heights,
        tolerance: float,
        kept: State = (),
    ) -> None:
        self.solver, self.gap = solver, gap
        self.area, self.tolerance = spacing**2, tolerance
        self._offset = np.zeros_like(history.elastic)
        limits = np.full(len(solver.place), DONE, dtype=np.int64)
        super().__init__(solver, history, limits, kept, moves=True)

    def _advance(self, dt: float, target: Target) -> int:
        here = self.gap(target.shift)
        ended, n = ~np.isfinite(here), here.size
        far = 1e3  # mm, the gap where the object has ended
        free = np.where(ended, far, here).ravel()
        g = self._begin(dt, target)
        self._offset[:n] = g * free - self._past(g)[:n]
        outcome = self._balance(g, target)
        if outcome != DONE:
            return outcome
        if ended.any() and (self.pressure.reshape(ended.shape)[beside(ended)] > 0.0).any():
            return TURNED
        self._finish(dt, g)
        return DONE

    def _begin(self, dt: float, target: Target) -> float:
        """Load the history of a step; return the ratio g of its stiffness to the relaxed one."""
        return load_history(self.history, dt)

    def _past(self, g: float) -> Array:
        """Return the displacement that the past leaves, times the stiffness g of the step."""
        return self.history.moved_past

    def _finish(self, dt: float, g: float) -> None:
        """Add a step that is solved to the history."""
        store_history(self.history, self.solver.x, self.solver.moved, dt, g)

    def _balance(self, g: float, target: Target) -> int:
        """Solve at a depth or under a force, from an offset at a depth of 0."""
        solver, n = self.solver, len(self.pressure)
        if not target.by_force:
            self.search[DEPTH] = target.value
            self._offset[:n] -= g * target.value
            return solver.solve(self._offset, self.tolerance)
        if target.value <= 0.0:
            touch = float(self._offset[:n].min()) / g
            self.search[DEPTH] = min(self.search[DEPTH], touch)
            solver.clear()
            return DONE
        outcome = solver.solve(self._offset, self.tolerance, target.value / self.area)
        self.search[DEPTH] = solver.rigid / g
        return outcome

    def _rebuild(self) -> None:
        """Nothing follows from the arrays of the state that is not in them."""

    @property
    def force(self) -> float:
        """Force in mN on the grid."""
        return float(self.pressure.sum()) * self.area

    def displacement(self, x: Array) -> Array:
        """Return the displacements in mm of the body under stresses in kPa."""
        return self.solver.displacement(x)

    def energy(self) -> float:
        """Return the stored energy in µJ."""
        return stored_energy(self.history, self.displacement) * self.area

    def record(self) -> Record:
        """Return the present values that a history holds, by their names."""
        return super().record() | {"slopes": np.zeros(2)}


class GridContact(GridStepper):
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
        history = prony_history(branches, points[0] * points[1])
        self.on_grid = GridSolver(compliance, points)
        super().__init__(self.on_grid, history, spacing, gap, tolerance)


class SoftGridContact(GridContact):
    """Frictionless contact of a body on a periodic grid with a soft object.

    The object gives way as in `soft.py`: the step has the compliance F + g C / k.

    soft: C (n_x, n_y // 2 + 1) mm/kPa of every wave, and the object's Prony terms; the rest as of
    `GridContact`.
    """

    def __init__(
        self,
        soft: tuple[Array, tuple[Array, Array]],
        *parts: *GridParts,
        tolerance: float = CLOSED,
    ) -> None:
        super().__init__(*parts, tolerance=tolerance)
        own, branches = soft
        self.own, self.compliance = np.array(own), self.on_grid.compliance
        self.object_history = prony_history(branches, len(self.pressure))
        self._state += self.object_history.state
        self._yields, self._part = 1.0, 0.0

    def displacement(self, x: Array) -> Array:
        """Return the displacements (n,) mm of the body alone under a pressure (n,) kPa."""
        return displacement(x, self.compliance, self.on_grid.points)

    def _begin(self, dt: float, target: Target) -> float:
        g, self._yields = super()._begin(dt, target), load_history(self.object_history, dt)
        if (part := g / self._yields) != self._part:  # exact: steps of a length give a number
            self.on_grid.give(self.compliance + part * self.own)
            self._part = part
        return g

    def _past(self, g: float) -> Array:
        return super()._past(g) + g / self._yields * self.object_history.moved_past

    def _finish(self, dt: float, g: float) -> None:
        pressure = self.solver.x
        store_history(self.history, pressure, self.displacement(pressure), dt, g)
        store_history(self.object_history, pressure, self._recession(pressure), dt, self._yields)

    def _recession(self, x: Array) -> Array:
        """Return the displacements (n,) mm of the object under an elastic pressure (n,) kPa."""
        return displacement(x, self.own, self.on_grid.points)

    def energy(self) -> float:
        """Return the stored energy of both bodies in µJ."""
        own = stored_energy(self.object_history, self._recession)
        return super().energy() + own * self.area


def stored_energy(m: PronyHistory, moved: Callable[[Array], Array]) -> float:
    """Return the stored energy of a body in µJ, over the area of a point in mm².

    moved: its displacements in mm under stresses in kPa.
    """
    stored = float(m.elastic @ m.moved_elastic)
    for weight, term in zip(m.weights, m.terms, strict=True):
        stored += float(term @ moved(term)) / weight if weight > 0.0 else 0.0
    return stored / 2


def beside(ended: Flags) -> Flags:
    """Return whether a grid point (n_x, n_y) has a neighbor where the object has ended."""
    sides = [np.roll(ended, way, axis) for axis in (0, 1) for way in (1, -1)]
    return np.asarray(np.logical_or.reduce([ended, *sides]))


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
