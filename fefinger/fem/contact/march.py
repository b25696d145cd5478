"""Contact history of a body under an obstacle that presses, and may slide and have friction."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fefinger.fem.contact import friction_state, friction_step, step_compiled
from fefinger.fem.contact import lcp_compiled as contact
from fefinger.fem.contact.travel import Travel
from fefinger.fem.contact.viscoelastic import History, Prescribed, Relaxation, SlidingHistory
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import PRESS_LESS, InputError


@dataclass(frozen=True)
class SlidingPath:
    """Path of an obstacle that slides: shift (n_t, 2) mm, and the slopes (n_t, 2) of a plate."""

    travel: Travel
    shift: Array
    inclines: Array | None = None

    def gap(self, k: int) -> tuple[Array, Flags]:
        """Return the weighted gaps (n,) mm³ of a step, and the rim (n,) of the obstacle."""
        return self.travel.gap(self.shift[k], self._incline(k))

    def push(self, k: int, rim: Flags, pressure: Array, time: float) -> Array:
        """Return the force (2,) mN of a pressure on slopes; InputError for one on the rim."""
        if rim.any() and (pressure[rim] > 0).any():
            x, y = self.shift[k]
            raise InputError(
                f"motion: expected a path on which the pad stays on the object, but at {time:.4g} "
                f"s, with the object moved by ({x:.3g}, {y:.3g}) mm, contact reaches its end; take "
                "a shorter path or a larger object"
            )
        return self.travel.push(self.shift[k], pressure, self._incline(k))

    def _incline(self, k: int) -> Array | None:
        return None if self.inclines is None else self.inclines[k]


def march(
    flexibility: Array,
    gap: Array | SlidingPath,
    projected: Array,
    relaxation: Relaxation,
    prescribed: Prescribed,
    progress: Callable[[float], None] = lambda fraction: None,
) -> History:
    """Compute the contact history of a body at rest before `prescribed.time[0]`.

    flexibility (n, n) mm per kPa mm², gap (n,) mm³, or the path that gives it, and projected (n,)
    mm² are those of the patch, for the relaxed body; the first value of `prescribed` is reached by
    a jump.

    Raises
    ------
    InputError
        If contact reaches the end of the obstacle.
    ConvergenceError
        If the contact or the depth under force control does not converge.
    """
    path, count = gap if isinstance(gap, SlidingPath) else None, len(prescribed.time)
    start = np.zeros(len(projected)) if isinstance(gap, SlidingPath) else gap
    s = contact.lcp_state(flexibility)
    m = step_compiled.pad_state(start, projected, relaxation.weights, relaxation.rates)
    time, by_force = prescribed.time, prescribed.control == "force"
    m.peak[0] = prescribed.value.max(initial=0.0)
    shape = (count, len(projected))
    depth, pressure, elastic = np.empty(count), np.empty(shape), np.empty(shape)
    slopes = np.empty((count, 2))
    for k, target in enumerate(prescribed.value):
        dt = float(time[k] - time[k - 1]) if k else 0.0
        if path is not None:
            m.gap[:], rim = path.gap(k)
        outcome = step_compiled.step(s, m, dt, float(target), by_force)
        step_compiled.check(outcome, advice=PRESS_LESS)
        if path is not None:
            slopes[k] = path.push(k, rim, s.x, time[k])
        depth[k], pressure[k], elastic[k] = m.depth[0], s.x, m.elastic
        progress((k + 1) / count)
    sliding = None if path is None else SlidingHistory(path.shift, slopes)
    return History(depth, pressure, elastic, int(s.counts[contact.SOLVED]), sliding)


def march_with_friction(
    flexibility: Array,
    mu: tuple[float, float],
    path: SlidingPath,
    projected: Array,
    relaxation: Relaxation,
    prescribed: Prescribed,
    progress: Callable[[float], None] = lambda fraction: None,
) -> History:
    """Compute the contact history with a flexibility (3n, 3n) and Coulomb's friction.

    mu: static and kinetic coefficient; the rest as for `march`.

    Raises
    ------
    InputError, ConvergenceError
        As `march`; and if no traction fits the law of friction.
    """
    n, count = len(projected), len(prescribed.time)
    s = friction_state.friction_state(flexibility, mu[0])
    weights, rates = relaxation.weights, relaxation.rates
    m = step_compiled.pad_state(np.zeros(n), projected, weights, rates, components=3)
    history = friction_step.friction_history(n, *mu)
    time, by_force = prescribed.time, prescribed.control == "force"
    m.peak[0] = prescribed.value.max(initial=0.0)
    depth, stress, elastic = np.empty(count), np.empty((count, 3 * n)), np.empty((count, 3 * n))
    bounds, moves = np.empty((count, n)), np.diff(path.shift, axis=0, prepend=path.shift[:1])
    slopes, slip, lost, worst = np.empty((count, 2)), np.empty((count, 2, n)), np.empty(count), 0.0
    for k, target in enumerate(prescribed.value):
        dt = float(time[k] - time[k - 1]) if k else 0.0
        m.gap[:], rim = path.gap(k)
        bounds[k] = s.mu
        x, y = moves[k].tolist()
        outcome = friction_step.step(s, m, history, dt, x, y, float(target), by_force)
        friction_step.check(outcome, mu[0], f"at {time[k]:.4g} s")
        slopes[k] = path.push(k, rim, s.x[:n], time[k])
        depth[k], stress[k], elastic[k], lost[k] = m.depth[0], s.x, m.elastic, history.lost[0]
        slip[k] = history.slip.reshape(2, n) / projected
        worst = max(worst, float(s.residual[0]))
        progress((k + 1) / count)
    pressure, traction = np.ascontiguousarray(stress[:, :n]), stress[:, n:].reshape(count, 2, n)
    sticking = sticks(pressure, traction, bounds)
    sliding = SlidingHistory(path.shift, slopes, traction, slip, sticking, lost, worst)
    return History(depth, pressure, elastic, int(s.counts[friction_state.SOLVED]), sliding)


def sticks(pressure: Array, traction: Array, mu: float | Array) -> Flags:
    """Flag the vertices (..., n) under pressure with less than the traction of slip."""
    size = np.hypot(traction[..., 0, :], traction[..., 1, :])
    return np.asarray((pressure > 0) & (size < mu * pressure * (1 - friction_step.STUCK)))
