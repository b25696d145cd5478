"""Contact history of a body under an obstacle that slides over it, with or without friction."""

from collections.abc import Callable

import numpy as np

from fefinger.fem.contact import friction_state, friction_step, step_compiled
from fefinger.fem.contact import lcp_compiled as contact
from fefinger.fem.contact.travel import Travel
from fefinger.fem.contact.viscoelastic import History, Prescribed, Relaxation, SlidingHistory
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import PRESS_LESS, InputError


def slide(
    flexibility: Array,
    travel: Travel,
    projected: Array,
    relaxation: Relaxation,
    prescribed: Prescribed,
    shift: Array,
    progress: Callable[[float], None] = lambda fraction: None,
    inclines: Array | None = None,
) -> History:
    """Compute the contact history without friction; `shift` (n_t, 2) mm, the rest as for `march`.

    inclines (n_t, 2): slopes of a plate that turns.

    Raises
    ------
    InputError
        If contact reaches the end of the obstacle.
    ConvergenceError
        If the contact or the depth under force control does not converge.
    """
    s = contact.lcp_state(flexibility)
    m = step_compiled.pad_state(
        np.zeros(len(projected)), projected, relaxation.weights, relaxation.rates
    )
    time, by_force = prescribed.time, prescribed.control == "force"
    m.peak[0] = prescribed.value.max(initial=0.0)
    shape = (len(time), len(projected))
    depth, pressure, elastic = np.empty(len(time)), np.empty(shape), np.empty(shape)
    slopes = np.empty((len(time), 2))
    for k, target in enumerate(prescribed.value):
        dt = float(time[k] - time[k - 1]) if k else 0.0
        incline = None if inclines is None else inclines[k]
        m.gap[:], rim = travel.gap(shift[k], incline)
        outcome = step_compiled.step(s, m, dt, float(target), by_force)
        step_compiled.check(outcome, advice=PRESS_LESS)
        check_ahead(rim, s.x, shift[k], time[k])
        depth[k], pressure[k], elastic[k] = m.depth[0], s.x, m.elastic
        slopes[k] = travel.push(shift[k], s.x, incline)
        progress((k + 1) / len(time))
    count = int(s.counts[contact.SOLVED])
    return History(depth, pressure, elastic, count, SlidingHistory(shift, slopes))


def slide_with_friction(
    flexibility: Array,
    mu: tuple[float, float],
    travel: Travel,
    projected: Array,
    relaxation: Relaxation,
    prescribed: Prescribed,
    shift: Array,
    progress: Callable[[float], None] = lambda fraction: None,
    inclines: Array | None = None,
) -> History:
    """Compute the contact history with a flexibility (3n, 3n) and Coulomb's friction.

    mu: static and kinetic coefficient; inclines (n_t, 2): slopes of a plate that turns.

    Raises
    ------
    InputError, ConvergenceError
        As `slide`; and if no traction fits the law of friction.
    """
    n = len(projected)
    s = friction_state.friction_state(flexibility, mu[0])
    m = step_compiled.pad_state(
        np.zeros(3 * n), np.zeros(3 * n), relaxation.weights, relaxation.rates
    )
    history = friction_step.friction_history(np.zeros(n), projected, *mu)
    time, by_force = prescribed.time, prescribed.control == "force"
    m.peak[0] = prescribed.value.max(initial=0.0)
    count = len(time)
    depth, x, elastic = np.empty(count), np.empty((count, 3 * n)), np.empty((count, 3 * n))
    bounds = np.empty((count, n))
    slopes, slip, lost, worst = np.empty((count, 2)), np.empty((count, 2, n)), np.empty(count), 0.0
    for k, target in enumerate(prescribed.value):
        dt = float(time[k] - time[k - 1]) if k else 0.0
        moved = shift[k] - shift[k - 1] if k else np.zeros(2)
        incline = None if inclines is None else inclines[k]
        history.gap[:], rim = travel.gap(shift[k], incline)
        bounds[k] = s.mu
        outcome = friction_step.step(
            s, m, history, dt, float(moved[0]), float(moved[1]), float(target), by_force
        )
        friction_step.check(outcome, mu[0], f"at {time[k]:.4g} s")
        check_ahead(rim, s.x[:n], shift[k], time[k])
        depth[k], x[k], elastic[k], lost[k] = m.depth[0], s.x, m.elastic, history.lost[0]
        slopes[k] = travel.push(shift[k], s.x[:n], incline)
        slip[k] = history.slip.reshape(2, n) / projected
        worst = max(worst, float(s.residual[0]))
        progress((k + 1) / count)
    pressure, traction = np.ascontiguousarray(x[:, :n]), x[:, n:].reshape(count, 2, n)
    sticking = sticks(pressure, traction, bounds)
    sliding = SlidingHistory(shift, slopes, traction, slip, sticking, lost, worst)
    return History(depth, pressure, elastic, int(s.counts[friction_state.SOLVED]), sliding)


def sticks(pressure: Array, traction: Array, mu: float | Array) -> Flags:
    """Flag the vertices (..., n) under pressure with less than the traction of slip."""
    size = np.hypot(traction[..., 0, :], traction[..., 1, :])
    return np.asarray((pressure > 0) & (size < mu * pressure * (1 - friction_step.STUCK)))


def check_ahead(rim: Flags, pressure: Array, shift: Array, time: float) -> None:
    """Raise InputError where vertices of the rim (n,) of the obstacle are under pressure."""
    if rim.any() and (pressure[rim] > 0).any():
        raise InputError(left(shift, time))


def left(shift: Array, time: float) -> str:
    """Error message for a path that leaves the object."""
    return (
        f"motion: expected a path on which the pad stays on the object, but at {time:.4g} s, with "
        f"the object moved by ({shift[0]:.3g}, {shift[1]:.3g}) mm, contact reaches its end; take "
        "a shorter path or a larger object"
    )
