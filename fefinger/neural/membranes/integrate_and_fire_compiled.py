"""Compiled integrate-and-fire membrane; imported at its first run."""

import math

import numpy as np

from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


@njit(cache=True)
def _potential(u: float, level: float, rise: float, tau: float, s: float) -> float:
    """Potential after s ms in a current of level + rise s (in thresholds), from u.

    Written without cancellation of large terms, however short s and steep the rise of a jump.
    """
    if s <= 0.0:
        return u
    gone = -math.expm1(-s / tau)
    return u + (level - u) * gone + rise * s * (1.0 - gone * tau / s)


@njit(cache=True)
def _top(u: float, level: float, rise: float, tau: float, length: float) -> float:
    """Time in (0, length] of the maximum of the potential, or the length."""
    if rise < 0.0 and level > u:
        return min(length, tau * math.log1p((u - level) / (rise * tau)))
    return length


@njit(cache=True)
def _crossing(u: float, level: float, rise: float, tau: float, length: float) -> float:
    """First time in (0, length] at which the potential passes 1, or -1.

    The potential is convex or concave throughout, by the sign of u - level + rise tau. Newton's
    method from the left of a concave curve, or from the right of a convex one, runs to the crossing
    without overshoot.
    """
    end = _top(u, level, rise, tau, length)
    if _potential(u, level, rise, tau, end) <= 1.0:
        return -1.0
    s = 0.0 if u - level + rise * tau < 0.0 else end
    for _ in range(100):
        slope = (level - u) / tau * math.exp(-s / tau) - rise * math.expm1(-s / tau)
        if slope <= 0.0:
            break
        change = (1.0 - _potential(u, level, rise, tau, s)) / slope
        s += change
        if abs(change) < 1e-13 * tau:
            break
    return min(max(s, 0.0), end)


@njit(cache=True)
def eventful(
    state: Array,
    span: tuple[float, float],
    line: tuple[float, float],
    times: tuple[float, float],
    spikes: Array,
    count: int,
) -> int:
    """Advance one unit through an interval that contains spikes or the end of a refractory time.

    state: potential, highest potential, end of the refractory time. span: start and end in ms;
    line: current at the start, in thresholds, and its rise per ms; times: time constant and
    refractory time in ms. Returns the new count; it stops at one more than the length of `spikes`.
    """
    (t0, t1), (level, rise), (tau, refractory) = span, line, times
    while count <= len(spikes):
        start = max(t0, state[2])
        if start >= t1:
            return count
        here = level + rise * (start - t0)
        crossing_time = _crossing(state[0], here, rise, tau, t1 - start)
        if crossing_time < 0.0:
            top = _top(state[0], here, rise, tau, t1 - start)
            state[1] = max(state[1], _potential(state[0], here, rise, tau, top))
            state[0] = _potential(state[0], here, rise, tau, t1 - start)
            return count
        if count < len(spikes):
            spikes[count] = start + crossing_time
        count += 1
        state[0], state[1], state[2] = 0.0, 1.0, start + crossing_time + refractory
    return count


@njit(cache=True, nogil=True)
def integrate(
    time: Array,
    current: Array,
    numbers: tuple[float, float, float],
    spikes: Array,
    counts: Integers,
) -> Array:
    """Solve n units from rest over time (n_t,) ms with current (n_t, n) linear between.

    numbers: threshold in µA/cm², time constant and refractory time in ms. Fills spikes (n, :) in ms
    and counts (n,); returns (n, 3): potential, highest potential (thresholds), end of refractory
    time in ms.
    """
    threshold, tau, refractory = numbers
    units = current.shape[1]
    states = np.zeros((units, 3))
    states[:, 2] = time[0]
    for k in range(len(time) - 1):
        t0, t1 = time[k], time[k + 1]
        length = t1 - t0
        if length == 0.0:
            continue
        gone, scale = -math.expm1(-length / tau), 1.0 / threshold
        share = 1.0 - gone * tau / length
        for i in range(units):
            if states[i, 2] >= t1:
                continue
            level, after = scale * current[k, i], scale * current[k + 1, i]
            u = states[i, 0]
            end = u + (level - u) * gone + (after - level) * share
            turns = level > u and after < end
            if states[i, 2] > t0 or end > 1.0 or turns:
                line, times = (level, (after - level) / length), (tau, refractory)
                counts[i] = eventful(states[i], (t0, t1), line, times, spikes[i], counts[i])
            else:
                states[i, 0] = end
                states[i, 1] = max(states[i, 1], end)
    return states
