"""Compiled equations of the membranes; imported when one first runs.

Hodgkin-Huxley with the race of branches, and integrate-and-fire.

Hodgkin & Huxley (1952), J Physiol 117:500; Pawluk (1997), Eq. B.1 to B.17, with the signs of the
rate functions corrected (see `HodgkinHuxley`).
"""

import math
from typing import NamedTuple

import numpy as np

from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


CAPACITANCE, G_NA, G_K, G_LEAK = 1.0, 120.0, 36.0, 0.3  # uF/cm², mS/cm²
V_NA, V_K, V_LEAK = 115.0, -12.0, 10.613  # mV above rest
SPIKE_MV, REARM_MV = 40.0, 20.0  # a spike is an upward crossing, counted again after falling below


class Block(NamedTuple):
    """A depolarization block: potential in mV, current in µA/cm² and time in ms that it exceeds."""

    potential: float
    current: float
    longest: float


class Stepping(NamedTuple):
    """Steps of a membrane: the longest in ms, splitting or not, and factors on its rates.

    speed: on all rates; m_rate_factor: on the rate of m, 0 for frozen sodium activation, else 1.
    """

    longest: float
    splitting: bool
    speed: float
    m_rate_factor: float


@njit(cache=True, inline="always")
def _linoid(x: float, e: float) -> float:
    """Return x / (e - 1) with e = exp(x), regular at 0."""
    if abs(x) < 1e-4:
        return 1.0 - x / 2.0 + x * x / 12.0
    return x / (e - 1.0)


@njit(cache=True)
def rates(v: float) -> tuple[float, float, float, float, float, float]:
    """Return opening and closing rates (an, bn, am, bm, ah, bh) in 1/ms at v mV above rest."""
    # All exponentials of v / 10 and v / 20 from one: the constants are e, e^2.5 and e^3.
    tenth = math.exp(-v / 10.0)
    a_n = 0.1 * _linoid((10.0 - v) / 10.0, 2.718281828459045 * tenth)
    a_m = _linoid((25.0 - v) / 10.0, 12.182493960703473 * tenth)
    b_h = 1.0 / (20.085536923187668 * tenth + 1.0)
    a_h = 0.07 * math.sqrt(tenth)
    return a_n, 0.125 * math.exp(-v / 80.0), a_m, 4.0 * math.exp(-v / 18.0), a_h, b_h


@njit(cache=True)
def slope(
    v: float, n: float, m: float, h: float, current: float, slow: float, m_rate_factor: float
) -> tuple[float, float, float, float]:
    """Time derivative of (v, n, m, h) per ms.

    `slow` scales the rates of all gates, `m_rate_factor` also the rate of m: 0 holds m constant.
    """
    a_n, b_n, a_m, b_m, a_h, b_h = rates(v)
    n2 = n * n
    ionic = G_K * n2 * n2 * (v - V_K) + G_NA * m * m * m * h * (v - V_NA) + G_LEAK * (v - V_LEAK)
    dn = slow * (a_n * (1.0 - n) - b_n * n)
    dm = slow * m_rate_factor * (a_m * (1.0 - m) - b_m * m)
    dh = slow * (a_h * (1.0 - h) - b_h * h)
    return (current - ionic) / CAPACITANCE, dn, dm, dh


@njit(cache=True)
def step(
    y: tuple[float, float, float, float],
    k1: tuple[float, float, float, float],
    dt: float,
    middle: float,
    end: float,
    slow: float,
    m_rate_factor: float,
) -> tuple[float, float, float, float]:
    """Take one classical Runge-Kutta step; k1 is the slope at its start."""
    v, n, m, h = y
    a, b, c, d = k1
    s = 0.5 * dt
    e, f, g, i = slope(v + s * a, n + s * b, m + s * c, h + s * d, middle, slow, m_rate_factor)
    p, q, r, u = slope(v + s * e, n + s * f, m + s * g, h + s * i, middle, slow, m_rate_factor)
    w, x, j, z = slope(v + dt * p, n + dt * q, m + dt * r, h + dt * u, end, slow, m_rate_factor)
    s = dt / 6.0
    return (
        v + s * (a + 2.0 * (e + p) + w),
        n + s * (b + 2.0 * (f + q) + x),
        m + s * (c + 2.0 * (g + r) + j),
        h + s * (d + 2.0 * (i + u) + z),
    )


@njit(cache=True)
def crossing(v0: float, v1: float, d0: float, d1: float, dt: float) -> float:
    """Fraction of a step at which the cubic Hermite polynomial of its ends reaches SPIKE_MV."""
    low, high = 0.0, 1.0
    for _ in range(45):
        x = 0.5 * (low + high)
        y = 1.0 - x
        value = y * y * ((1.0 + 2.0 * x) * v0 + x * dt * d0)
        value += x * x * ((3.0 - 2.0 * x) * v1 - y * dt * d1)
        if value < SPIKE_MV:
            low = x
        else:
            high = x
    return 0.5 * (low + high)


@njit(cache=True, inline="always")
def _take_over(y: Array, b: int, state: Array) -> None:
    """Set the state (4,) of a branch."""
    for i in range(4):
        y[b, i] = state[i]


@njit(cache=True, nogil=True)
def race(
    time: Array,
    current: Array,
    dt_max: float,
    slow: float,
    rest: Array,
    block: Block,
    spikes: Array,
) -> tuple[int, float, float, Array]:
    """Integrate the branches of one unit from rest; the first to fire resets the others.

    time (n_t,) ms, current (n_t, n_branches); slow: factor on all rates. The branch that first
    reaches a spike fires the unit, and the others take over its state. The longest block of the
    branches counts. Returns the number of spikes, the peak, the ms in block and the final states.
    """
    n = current.shape[1]
    y = np.empty((n, 4))
    for b in range(n):
        _take_over(y, b, rest)
    armed, above, blocked = np.ones(n, np.bool_), np.zeros(n), np.zeros(n)
    count, peak = 0, rest[0]
    for k in range(len(time) - 1):
        interval = time[k + 1] - time[k]
        # 1e-9: rounding must not add a step to an interval that is a multiple of the step.
        steps = math.ceil(interval / dt_max - 1e-9)
        for j in range(steps):
            dt, winner, first = interval / steps, -1, 2.0
            for b in range(n):
                per_step = (current[k + 1, b] - current[k, b]) / steps
                start = current[k, b] + j * per_step
                end, old = start + per_step, (y[b, 0], y[b, 1], y[b, 2], y[b, 3])
                k1 = slope(old[0], old[1], old[2], old[3], start, slow, 1.0)
                new = step(old, k1, dt, start + 0.5 * per_step, end, slow, 1.0)
                if armed[b] and new[0] >= SPIKE_MV:
                    d1 = slope(new[0], new[1], new[2], new[3], end, slow, 1.0)[0]
                    fraction = crossing(old[0], new[0], k1[0], d1, dt)
                    if fraction < first:
                        winner, first = b, fraction
                elif new[0] < REARM_MV:
                    armed[b] = True
                high = new[0] > block.potential and start > block.current
                above[b] = above[b] + dt if high else 0.0
                if above[b] > block.longest:
                    blocked[b] += min(dt, above[b] - block.longest)
                peak = max(peak, new[0])
                y[b, 0], y[b, 1], y[b, 2], y[b, 3] = new
            if winner >= 0:
                if count < len(spikes):
                    spikes[count] = time[k] + dt * (j + first)
                count += 1
                for b in range(n):
                    _take_over(y, b, y[winner])
                armed[:] = False
                above[:] = 0.0
    return count, peak, blocked.max(), y


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
