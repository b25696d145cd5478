"""Frictionless contact of a linear viscoelastic body: one step, of an object or a rolling plate.

p = g y + h as in `prony_history`, with y the elastic pressure: gap - depth m + F y >= 0 is a
complementarity problem in p. A factor t on the elastic pressure (the thesis's modulus t(u) over a
constant one) enters as y = t q.

Under a plate that rolls the normal turns, and with it the traction of the stress history, so the
history is one of vectors in the plane of rolling. In a step the flexibility is that along the
present normal n: n . F n.
"""

from typing import TypedDict

import numpy as np

from fefinger.contact import active_set, force_control
from fefinger.contact.active_set import BEYOND, DONE, MISSED, LcpState
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
        return energy(self.history, self.flexibility)

    def push(self) -> Array:
        """Return the force (2,) mN of the pressure on inclined heights, across the axis."""
        return pushed(self.gap, self.pose, self.pressure, turns=self.turns)

    def record(self) -> Record:
        """Return the present values that a history holds, by their names."""
        slopes = {} if isinstance(self.gap, np.ndarray) else {"slopes": self.push()}
        return super().record() | slopes


def energy(m: PronyHistory, flexibility: Array) -> tuple[float, float]:
    """Return the stored energy in µJ and the dissipated power in µW of a body that relaxes."""
    stored, lost = m.elastic @ flexibility @ m.elastic / 2, 0.0
    for weight, rate, term in zip(m.weights, m.rates, m.terms, strict=True):
        held = float(term @ flexibility @ term / weight)
        stored, lost = stored + held / 2, lost + rate * held
    return float(stored), lost


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


@njit(cache=True)
def _rolling_step(
    s: LcpState,
    m: PronyHistory,
    search: Array,
    moments: Array,
    first: float,
    weights: Array,
    limits: Integers,
    work: Array,
    dt: float,
    x: float,
    z: float,
    value: float,
    by_force: bool,
) -> tuple[int, float]:
    """Solve for the pressure of a plate with the normal (x, z); return the outcome, and g."""
    n = len(weights)
    g = load_history(m, dt)
    offset, gap, past = work[0], work[1], work[2]
    for j in range(n):
        gap[j] = x * moments[0, j] + z * moments[1, j] - first * weights[j]
        past[j] = x * m.moved_past[j] + z * m.moved_past[n + j]
    failed = press(
        s, search, gap, past, g, weights, limits, offset, value, by_force, COMPLEMENTARITY
    )
    return failed, g


@njit(cache=True)
def _finish(
    m: PronyHistory,
    columns: Array,
    pressure: Array,
    traction: Array,
    moved: Array,
    chosen: Integers,
    factor: Array,
    dt: float,
    g: float,
    x: float,
    z: float,
) -> None:
    """Update the history with the traction (2n,) of the pressure (n,) along the normal (x, z)."""
    n = len(pressure)
    for j in range(n):
        traction[j], traction[n + j] = x * pressure[j], z * pressure[j]
    active_set.combine(moved, columns, traction, chosen, factor)
    store_history(m, traction, moved, dt, g)


@njit(cache=True, fastmath={"contract"})
def _project(s: LcpState, forms: Array, x: float, z: float) -> None:
    """Project the flexibility on the normal (x, z), and update F x of the last pressure."""
    n = len(s.x)
    a, b, c = x * x, x * z, z * z
    for i in range(n):
        row, xx, xz, zz = s.flexibility[i], forms[0, i], forms[1, i], forms[2, i]
        for j in range(n):
            row[j] = a * xx[j] + b * xz[j] + c * zz[j]
    active_set.product(s)


class RollingContact(Stepper):
    """Contact of a body under a plate that rolls; `Target.turn` is its unit normal (x, z).

    Parameters
    ----------
    flexibility
        (2, n, 2, n): of the relaxed body under tractions along both directions.
    moments, weights
        (2, n) mm³ and (n,) mm² of the vertices: the gap to a plate through the origin with the
        normal (x, z) is x moments[0] + z moments[1].
    outline
        (k, 2) mm: points of the skin, the foremost of which meets the plate at a depth of 0.
    rim
        (k,): vertices where contact is a failure.
    branches
        As of `FrictionlessContact`.
    """

    def __init__(
        self,
        flexibility: Array,
        moments: Array,
        weights: Array,
        outline: Array,
        rim: Integers,
        branches: tuple[Array, Array],
    ) -> None:
        n = len(weights)
        (xx, xz), (zx, zz) = flexibility.transpose(0, 2, 1, 3)
        self._forms = np.array([xx, xz + zx, zz])
        # A copy, as one that is read from a file cannot be written: to numba that is another type.
        self.columns = np.array(flexibility.reshape(2 * n, 2 * n), order="C")
        self.moments, self.weights = np.ascontiguousarray(moments), np.ascontiguousarray(weights)
        self.outline, self._normal = outline, (0.0, 0.0)
        self._work, self._traction, self._moved = np.zeros((3, n)), np.zeros(2 * n), np.zeros(2 * n)
        self._chosen, self._factor = np.zeros(2 * n, dtype=np.int64), np.zeros(2 * n)
        self.lcp = active_set.lcp_state(np.zeros((n, n)))  # made when the plate has an angle
        limits = np.full(n, DONE, dtype=np.int64)
        limits[rim] = BEYOND
        super().__init__(self.lcp, prony_history(branches, 2 * n), limits, moves=True)

    def _advance(self, dt: float, target: Target) -> int:
        x, z = float(target.turn[0]), float(target.turn[1])
        self._turn(x, z)
        first = float((self.outline @ (x, z)).min())
        arrays = self.moments, first, self.weights, self.limits, self._work
        outcome, g = _rolling_step(
            *(self.lcp, self.history, self.search, *arrays),
            *(dt, x, z, target.value, target.by_force),
        )
        if outcome == DONE:
            work = self._traction, self._moved, self._chosen, self._factor
            _finish(self.history, self.columns, self.pressure, *work, dt, g, x, z)
        return int(outcome)

    def _turn(self, x: float, z: float) -> None:
        if (x, z) != self._normal:
            _project(self.lcp, self._forms, x, z)
            self._normal = x, z

    def _rebuild(self) -> None:
        x, z = self.pose[2:].tolist()
        if x or z:
            self._turn(x, z)
        active_set.rebuild(self.lcp)
