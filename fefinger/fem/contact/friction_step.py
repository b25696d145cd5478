"""Compiled contact step of a linear viscoelastic body with friction.

As `step_compiled`, with history and elastic stress of three components per vertex: the pressure and
the traction in two directions across the axis. With one relaxation function the displacement at the
end of a step is F y of the elastic traction y = (x - h) / g, so that the slip of a step is
(F x - F h) / g less the displacement before it and less what the obstacle moved.

Where the kinetic coefficient is less than the static one, a vertex has the kinetic one from the
step after its first slip to the step in which it sticks again, or leaves contact.
"""

from typing import NamedTuple

import numpy as np

from fefinger.fem.contact import friction_compiled as friction
from fefinger.fem.contact import step_compiled
from fefinger.fem.contact.friction_state import FrictionState, restore, save
from fefinger.fem.contact.lcp_compiled import DONE, MISSED
from fefinger.fem.contact.step_compiled import (
    PadState,
    excess_force,
    first_touch,
    load_history,
    store_history,
)
from fefinger.fem.contact.viscoelastic import CORRECTIONS, corrected
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError
from fefinger.support.compiled import njit
from fefinger.support.tolerances import COMPLEMENTARITY, LEAST_FORCE, SMALL_FORCE


STUCK = 1e-6
"""Traction short of mu times the pressure, over that, from which a vertex counts as sticking."""

MATCH = 1e-7
"""Relative error of the force under force control, above what the residual of the cone leaves."""


class FrictionHistory(NamedTuple):
    """Friction state of a pad: weighted slip, friction coefficients and dissipated work.

    slip (2n,) mm³: weighted slip since first contact; static and kinetic (1,): coefficients; lost
    (1,) µJ; stiffness (1,) mN/mm: of the last steps under force control; limits (n,): outcome of a
    step with contact at the vertex, as of `Output`.
    """

    slip: Array
    static: Array
    kinetic: Array
    lost: Array
    stiffness: Array
    limits: Integers


def friction_history(n: int, static: float, kinetic: float) -> FrictionHistory:
    """Allocate the memory of a pad of n vertices at rest, with the coefficients of friction."""
    return FrictionHistory(
        slip=np.zeros(2 * n),
        static=np.array([static], dtype=np.float64),
        kinetic=np.array([kinetic], dtype=np.float64),
        lost=np.zeros(1),
        stiffness=np.zeros(1),
        limits=np.zeros(n, dtype=np.int64),
    )


@njit(cache=True)
def reset(s: FrictionState, m: PadState, c: FrictionHistory) -> None:
    """Reset the pad to rest: no contact and no history."""
    step_compiled.reset(s, m)
    s.mu[:] = c.static[0]
    for row in (c.slip, c.lost, c.stiffness):
        row[:] = 0.0


@njit(cache=True)
def step(
    s: FrictionState,
    m: PadState,
    c: FrictionHistory,
    dt: float,
    x: float,
    y: float,
    target: float,
    by_force: bool,
) -> int:
    """Advance by `dt` s, with the obstacle moved by (x, y) mm, to a depth in mm or a force in mN.

    Return DONE or a failure, after which the state is as it was.
    """
    n, depth, peak = len(m.gap), m.depth[0], m.peak[0]
    save(s)
    g = load_history(m, dt)
    for j in range(n):
        for a, moved in ((1, x), (2, y)):
            k = a * n + j
            m.offset[k] = -m.moved_past[k] - g * (m.moved_elastic[k] + m.projected[j] * moved)
    if by_force:
        failed = _at_force(s, m, c, g, target)
    else:
        m.depth[0] = target
        failed = _at_depth(s, m, g, target)
    for j in range(n):
        if failed == DONE and s.x[j] > 0.0:
            failed = c.limits[j]
    if failed != DONE:
        restore(s)
        m.depth[0], m.peak[0] = depth, peak
        return failed
    _slip(s, m, c, g)
    store_history(m, s.x, s.moved, dt, g)
    return DONE


@njit(cache=True)
def _at_depth(s: FrictionState, m: PadState, g: float, depth: float) -> int:
    for j in range(len(m.gap)):
        m.offset[j] = (m.gap[j] - depth * m.projected[j]) * g - m.moved_past[j]
    return friction.solve(s, m.offset, COMPLEMENTARITY)


@njit(cache=True)
def _at_force(s: FrictionState, m: PadState, c: FrictionHistory, g: float, force: float) -> int:
    """Find the depth at a force in mN: secants inside a bracket that starts at first touch."""
    touch = first_touch(m, m.gap, m.moved_past, g)
    if force <= 0.0:  # as in `step_compiled.solve_target`
        m.depth[0] = min(m.depth[0], touch)
        s.x[:] = 0.0
        s.moved[:] = 0.0
        return DONE
    m.peak[0] = max(m.peak[0], force)
    close = MATCH * max(force, SMALL_FORCE * m.peak[0], LEAST_FORCE)
    low, high, last_depth, last = touch, np.inf, touch, -force
    depth = max(m.depth[0], touch + 1e-6 * (1.0 + abs(touch)))
    for _ in range(CORRECTIONS):
        failed = _at_depth(s, m, g, depth)
        if failed != DONE:
            return failed
        excess = excess_force(m.projected, s.x, force)
        if abs(excess) <= close:
            m.depth[0] = depth
            return DONE
        slope = (excess - last) / (depth - last_depth) if depth != last_depth else 0.0
        if last == -force and c.stiffness[0] > slope:
            slope = c.stiffness[0]  # the first secant, from first touch, is too soft
        last_depth, last = depth, excess
        if slope > 0.0:
            c.stiffness[0] = slope
        depth, low, high = corrected(depth, excess, slope, low, high, touch)
    return MISSED


@njit(cache=True)
def _slip(s: FrictionState, m: PadState, c: FrictionHistory, g: float) -> None:
    """Update slip, coefficients and lost work from the solution.

    The slip times g is F x + b: b, the history and the path, is still in `offset`.
    """
    n = len(m.gap)
    for j in range(n):
        pressed = s.x[j] > 0.0
        slips = pressed and np.hypot(s.x[n + j], s.x[2 * n + j]) >= s.mu[j] * s.x[j] * (1 - STUCK)
        s.mu[j] = c.kinetic[0] if slips else c.static[0]
        for a in range(2):
            k = (a + 1) * n + j
            slid = (s.moved[k] + m.offset[k]) / g if pressed else 0.0
            c.slip[a * n + j] = c.slip[a * n + j] + slid if pressed else 0.0
            c.lost[0] -= s.x[k] * slid


def check(outcome: int, mu: float, at: str) -> None:
    """Raise ConvergenceError for a failed step with the coefficient mu."""
    if outcome == DONE:
        return
    message = (
        f"contact: expected pressures and tractions that obey Coulomb's law with "
        f"indenter.friction = {mu:g}, found none {at}; take a smaller coefficient or a slower "
        "motion"
    )
    if outcome == MISSED:
        message = (
            f"force control: expected to reach the force within {CORRECTIONS} corrections {at}, "
            "did not; take a slower motion"
        )
    raise ConvergenceError(message)
