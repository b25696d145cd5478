"""Frictionless contact of a plate that rolls over a body: its normal turns from step to step.

As the normal turns, so does the traction of the stress history, so the history is one of vectors in
the plane of rolling. In a step the flexibility is that along the present normal n: n . F n.
"""

import numpy as np

from fefinger.contact import active_set
from fefinger.contact.active_set import BEYOND, DONE, LcpState
from fefinger.contact.frictionless import press
from fefinger.contact.prony_history import (
    PronyHistory,
    load_history,
    prony_history,
    store_history,
)
from fefinger.contact.stepper import Stepper, Target
from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit
from fefinger.support.tolerances import COMPLEMENTARITY


@njit(cache=True)
def _step(
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
        self.columns = np.ascontiguousarray(flexibility.reshape(2 * n, 2 * n))
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
        outcome, g = _step(
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
