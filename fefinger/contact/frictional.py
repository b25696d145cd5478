"""Contact with Coulomb friction of a linear viscoelastic body: one step, of depth or force.

As `frictionless`, with history and elastic stress of three components per vertex: the pressure and
the traction in two directions across the axis. With one relaxation function the displacement at the
end of a step is F y of the elastic traction y = (x - h) / g, so that the slip of a step is
(F x - F h) / g less the displacement before it and less what the object moved.

Where the kinetic coefficient is less than the static one, a vertex has the kinetic one from the
step after its first slip to the step in which it sticks again, or leaves contact.
"""

import numpy as np

from fefinger.contact import force_control
from fefinger.contact.active_set import DONE, ENDLESS, MISSED, SINGULAR
from fefinger.contact.coulomb import CoulombSolver
from fefinger.contact.force_control import DEPTH, FOUND, TRY
from fefinger.contact.frictionless import (
    excess_force,
    first_touch,
    gaps_at,
    lifted,
    limit,
    load_at_depth,
    pushed,
)
from fefinger.contact.prony_history import (
    PronyHistory,
    load_history,
    prony_history,
    store_history,
)
from fefinger.contact.stepper import Gaps, Record, Stepper, Target
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.compiled import njit
from fefinger.support.tolerances import COMPLEMENTARITY


STUCK = 1e-6
"""Traction short of mu times the pressure, over that, from which a vertex counts as sticking."""

UNSOLVED = (
    "contact: expected pressures and tractions that obey Coulomb's law with indenter.friction = "
    "{:g}, found none (a smaller coefficient may have some)"
)


@njit(cache=True)
def begin_step(
    m: PronyHistory, areas: Array, offset: Array, dt: float, x: float, y: float
) -> float:
    """Set the offset (3n,) of the tractions, where the object moves by (x, y) mm; return g."""
    n, g = len(areas), load_history(m, dt)
    for j in range(n):
        for a, moved in ((1, x), (2, y)):
            k = a * n + j
            offset[k] = -m.moved_past[k] - g * (m.moved_elastic[k] + areas[j] * moved)
    return g


@njit(cache=True)
def finish_step(
    m: PronyHistory,
    x: Array,
    moved: Array,
    bounds: Array,
    mu: Array,
    slip: Array,
    lost: Array,
    offset: Array,
    dt: float,
    g: float,
) -> None:
    """Update history, slip (2n,), lost work (1,) and coefficients `bounds` (n,) after a step.

    The slip times g is F x + b: b, the history and the path, is still in `offset`. mu (2,): the
    static and the kinetic coefficient.
    """
    n = len(bounds)
    for j in range(n):
        pressed = x[j] > 0.0
        slips = pressed and np.hypot(x[n + j], x[2 * n + j]) >= bounds[j] * x[j] * (1 - STUCK)
        bounds[j] = mu[1] if slips else mu[0]
        for a in range(2):
            k = (a + 1) * n + j
            slid = (moved[k] + offset[k]) / g if pressed else 0.0
            slip[a * n + j] = slip[a * n + j] + slid if pressed else 0.0
            lost[0] -= x[k] * slid
    store_history(m, x, moved, dt, g)


class FrictionalContact(Stepper):
    """Contact with Coulomb friction of a body on its candidate vertices.

    Parameters
    ----------
    flexibility
        F (3n, 3n): pressures, then tractions along both directions across the axis.
    mu
        Static and kinetic coefficient.
    gap, projected, branches, limits, turns
        As of `FrictionlessContact`.

    Attributes
    ----------
    bounds
        (n,): the coefficient of each vertex in the last step.
    lost
        (1,) µJ: the work of friction so far.
    """

    def __init__(
        self,
        flexibility: Array,
        mu: tuple[float, float],
        gap: Array | Gaps,
        projected: Array,
        branches: tuple[Array, Array],
        limits: Integers | None = None,
        *,
        turns: bool = False,
    ) -> None:
        count = len(projected)
        self.gap = np.array(gap) if isinstance(gap, np.ndarray) else gap
        self.turns, self.mu = turns, np.array(mu, dtype=np.float64)
        self.projected = np.array(projected)
        self.coulomb = CoulombSolver(flexibility, mu[0])
        self.bounds = self.coulomb.mu.copy()
        self.lost, self._slip, self._offset = np.zeros(1), np.zeros(2 * count), np.zeros(3 * count)
        no_limits = np.full(count, DONE, dtype=np.int64) if limits is None else limits
        kept = self.coulomb.mu, self.bounds, self._slip, self.lost
        history = prony_history(branches, 3 * count)
        super().__init__(self.coulomb, history, no_limits, kept, moves=True)
        unsolved = UNSOLVED.format(mu[0])
        self.failures = {**self.failures, ENDLESS: unsolved, SINGULAR: unsolved}

    @property
    def traction(self) -> Array:
        """Traction (2, n) kPa on the skin in both directions across the axis."""
        return self.coulomb.x[len(self.projected) :].reshape(2, -1)

    @property
    def slip(self) -> Array:
        """Slip (2, n) mm of the skin over the object, summed since first contact."""
        return self._slip.reshape(2, -1) / self.projected

    @property
    def sticking(self) -> Flags:
        """Flag the vertices (n,) under pressure with less than the traction of slip."""
        size = np.hypot(*self.traction)
        stuck = size < self.bounds * self.pressure * (1 - STUCK)
        return np.asarray((self.pressure > 0) & stuck)

    def _advance(self, dt: float, target: Target) -> int:
        gap, limits = gaps_at(self.gap, target, self.limits, turns=self.turns)
        x, y = target.shift[0] - self.pose[0], target.shift[1] - self.pose[1]
        g = begin_step(self.history, self.projected, self._offset, dt, float(x), float(y))
        outcome = int(limit(self.pressure, limits, self._press(gap, g, target)))
        if outcome == DONE:
            solver = self.coulomb
            self.bounds[:] = solver.mu
            state = solver.x, solver.moved, solver.mu, self.mu, self._slip, self.lost
            finish_step(self.history, *state, self._offset, dt, g)
        return outcome

    def _press(self, gap: Array, g: float, target: Target) -> int:
        """Solve for pressure and traction at a depth in mm or a force in mN, from an offset (3n,).

        The slope of the force is not known: the search takes secants.
        """
        solver, search, offset, areas = self.coulomb, self.search, self._offset, self.projected
        past, value = self.history.moved_past, target.value
        if target.by_force:
            touch = first_touch(gap, past, g, areas)
            if value <= 0.0:
                lifted(search, touch, solver.x, solver.moved)
                return DONE
            # Relative error of the force under force control, above what the residual of the cone
            # leaves.
            match = 1e-7
            force_control.begin(search, touch, value, match)
        else:
            search[DEPTH] = value
        while True:
            load_at_depth(search, offset, gap, past, g, areas)
            failed = solver.solve(offset, COMPLEMENTARITY)
            if failed != DONE or not target.by_force:
                return failed
            verdict = force_control.judge(search, excess_force(areas, solver.x, value), 0.0)
            if verdict != TRY:
                return DONE if verdict == FOUND else MISSED

    def _rebuild(self) -> None:
        self.coulomb.rebuild()

    def reset(self) -> None:
        """Return to rest: no contact and no history."""
        super().reset()
        self.coulomb.mu[:] = self.bounds[:] = self.mu[0]

    def push(self) -> Array:
        """Return the force (2,) mN of the pressure on inclined heights, across the axis."""
        return pushed(self.gap, self.pose, self.pressure, turns=self.turns)

    def record(self) -> Record:
        """Return the present values that a history holds, by their names."""
        friction: Record = {"traction": self.traction, "slip": self.slip, "sticking": self.sticking}
        work: Record = {"lost": float(self.lost[0]), "cone": self.coulomb.residual}
        return super().record() | {"slopes": self.push()} | friction | work
