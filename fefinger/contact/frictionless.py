"""Frictionless contact of a linear viscoelastic body: one step, of depth or force.

p = g y + h as in `prony_history`, with y the elastic pressure: gap - depth m + F y >= 0 is a
complementarity problem in p. A factor t on the elastic pressure (the thesis's modulus t(u) over a
constant one) enters as y = t q.
"""

from typing import TypedDict

import numpy as np

from fefinger.contact import active_set, force_control
from fefinger.contact.active_set import DONE, MISSED, LcpState
from fefinger.contact.force_control import DEPTH, FOUND, LOST
from fefinger.contact.prony_history import (
    PronyHistory,
    load_history,
    prony_history,
    store_history,
)
from fefinger.contact.stepper import Gaps, Record, Stepper, Target
from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit
from fefinger.support.tolerances import COMPLEMENTARITY, FORCE_MATCH


@njit(cache=True, inline="always")
def load_at_depth(
    search: Array, offset: Array, gap: Array, past: Array, stiffness: float, projected: Array
) -> None:
    """Set the offset (n,) of the complementarity problem at the depth of a search."""
    for j in range(len(gap)):
        offset[j] = (gap[j] - search[DEPTH] * projected[j]) * stiffness - past[j]


@njit(cache=True, inline="always")
def first_touch(gap: Array, past: Array, stiffness: float, projected: Array) -> float:
    """Compute the depth in mm at which the first of the gaps closes; arguments as of `press`."""
    depth = np.inf
    for j in range(len(gap)):
        depth = min(depth, (gap[j] - past[j] / stiffness) / projected[j])
    return depth


@njit(cache=True, inline="always")
def excess_force(projected: Array, pressure: Array, force: float) -> float:
    """Force in mN of a pressure (n,) kPa on areas (n,) mm² beyond a prescribed one."""
    excess = -force
    for j in range(len(projected)):
        excess += projected[j] * pressure[j]
    return excess


@njit(cache=True, inline="always")
def lifted(search: Array, touch: float, x: Array, moved: Array) -> None:
    """Set contact without force: open, where it was or where skin that creeps back pushes it to.

    Weighted gaps close some um beyond first touch.
    """
    search[DEPTH] = min(search[DEPTH], touch)
    x[:] = 0.0
    moved[:] = 0.0


@njit(cache=True, inline="always")
def limit(pressure: Array, limits: Integers, outcome: int) -> int:
    """Return the outcome of a step whose contact may be limited at some vertices."""
    for j in range(len(limits)):
        if outcome == DONE and pressure[j] > 0.0:
            outcome = limits[j]
    return outcome


@njit(cache=True, inline="always")
def press(
    s: LcpState,
    search: Array,
    gap: Array,
    past: Array,
    stiffness: float,
    projected: Array,
    limits: Integers,
    offset: Array,
    value: float,
    by_force: bool,
    tolerance: float,
) -> int:
    """Solve for the pressure at a depth in mm or a force in mN; return DONE or a failure.

    gap (n,) mm³: of a pad without pressure or past, at a depth of 0; past (n,): what the
    past moves it, times the `stiffness` (g t, see above); projected (n,) mm²: the areas m.
    """
    touch = first_touch(gap, past, stiffness, projected) if by_force else 0.0
    if not by_force:
        search[DEPTH] = value
    elif value <= 0.0:
        lifted(search, touch, s.x, s.moved)
        return DONE
    else:
        force_control.begin(search, touch, value, FORCE_MATCH)
    while True:
        load_at_depth(search, offset, gap, past, stiffness, projected)
        failed = active_set.solve(s, offset, tolerance)
        if failed != DONE or not by_force:
            break
        rise = stiffness * active_set.slope(s, projected)
        verdict = force_control.judge(search, excess_force(projected, s.x, value), rise)
        if verdict == LOST:
            return MISSED
        if verdict == FOUND:
            break
    return limit(s.x, limits, failed)


@njit(cache=True)
def _step(
    s: LcpState,
    m: PronyHistory,
    search: Array,
    gap: Array,
    projected: Array,
    limits: Integers,
    offset: Array,
    dt: float,
    value: float,
    by_force: bool,
    stiffening: float,
    tolerance: float,
) -> int:
    g = load_history(m, dt)
    stiffness, past = g * stiffening, m.moved_past
    failed = press(
        s, search, gap, past, stiffness, projected, limits, offset, value, by_force, tolerance
    )
    if failed == DONE:
        store_history(m, s.x, s.moved, dt, g)
    return failed


FrictionlessParts = tuple[Array, Array | Gaps, Array, tuple[Array, Array], *tuple[Integers, ...]]
"""Flexibility, gap, projected, branches and, if any, limits, as of `FrictionlessContact`."""


class FrictionlessOptions(TypedDict, total=False):
    """Options of a `FrictionlessContact`."""

    turns: bool
    tolerance: float


class FrictionlessContact(Stepper):
    """Frictionless contact of a body on its candidate vertices.

    Parameters
    ----------
    flexibility
        F (n, n) mm per kPa mm², of the relaxed body.
    gap
        (n,) mm³: the weighted gaps at a depth of 0; or `Gaps`, where the object moves.
    projected
        m (n,) mm²: the areas of the vertices across the axis.
    branches
        Weights and rates (m,) of the Prony terms, over the long-time modulus.
    limits
        As of `Stepper`; none by default.
    turns
        Whether the object is a plate that turns, by the slopes `Target.turn`.
    tolerance
        Penetration, over the largest gap or depth, that counts as none.

    Attributes
    ----------
    stiffening
        t at the end of the next step; 1 under force control.
    """

    def __init__(
        self,
        flexibility: Array,
        gap: Array | Gaps,
        projected: Array,
        branches: tuple[Array, Array],
        limits: Integers | None = None,
        *,
        turns: bool = False,
        tolerance: float = COMPLEMENTARITY,
    ) -> None:
        count = len(projected)
        self.gap = np.array(gap) if isinstance(gap, np.ndarray) else gap
        self.turns, self.tolerance, self.stiffening = turns, tolerance, 1.0
        self.projected = np.array(projected)
        self.lcp = active_set.lcp_state(flexibility)
        self.flexibility = self.lcp.flexibility
        self._offset = np.zeros(count)
        no_limits = np.full(count, DONE, dtype=np.int64) if limits is None else limits
        moves = not isinstance(gap, np.ndarray)
        super().__init__(self.lcp, prony_history(branches, count), no_limits, moves=moves)

    def _advance(self, dt: float, target: Target) -> int:
        gap, limits = gaps_at(self.gap, target, self.limits, turns=self.turns)
        return int(
            _step(
                self.lcp,
                self.history,
                self.search,
                gap,
                self.projected,
                limits,
                self._offset,
                dt,
                target.value,
                target.by_force,
                self.stiffening,
                self.tolerance,
            )
        )

    def _rebuild(self) -> None:
        active_set.rebuild(self.lcp)

    def energy(self) -> tuple[float, float]:
        """Return the stored energy in µJ and the dissipated power in µW, both without t(u)."""
        m, flexibility = self.history, self.flexibility
        stored, lost = m.elastic @ flexibility @ m.elastic / 2, 0.0
        for weight, rate, term in zip(m.weights, m.rates, m.terms, strict=True):
            held = float(term @ flexibility @ term / weight)
            stored, lost = stored + held / 2, lost + rate * held
        return float(stored), lost

    def push(self) -> Array:
        """Return the force (2,) mN of the pressure on inclined heights, across the axis."""
        return pushed(self.gap, self.pose, self.pressure, turns=self.turns)

    def record(self) -> Record:
        """Return the present values that a history holds, by their names."""
        slopes = {} if isinstance(self.gap, np.ndarray) else {"slopes": self.push()}
        return super().record() | slopes


def gaps_at(
    gap: Array | Gaps, target: Target, limits: Integers, *, turns: bool
) -> tuple[Array, Integers]:
    """Return the weighted gaps (n,) mm³ at the place of a target, and the limits (n,) there."""
    if isinstance(gap, np.ndarray):
        return gap, limits
    here, rim = gap.gap(np.array(target.shift), np.array(target.turn) if turns else None)
    return here, np.where(rim, active_set.TURNED, limits) if rim.any() else limits


def pushed(gap: Array | Gaps, pose: Array, pressure: Array, *, turns: bool) -> Array:
    """Return the force (2,) mN of pressures (n,) kPa on the heights of an object at a pose (4,)."""
    if isinstance(gap, np.ndarray):
        return np.zeros(2)
    return gap.push(pose[:2], pressure, pose[2:] if turns else None)
