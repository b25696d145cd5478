"""Vectorized Hodgkin-Huxley integration of 16 units at a time: Runge-Kutta and a splitting.

The loops over LANES have no branch, no call and no library exponential, so that the compiler turns
them into vector instructions; imported when a membrane first runs.
"""

import math

import numpy as np

from fefinger.neural.membranes.equations import (
    CAPACITANCE,
    G_K,
    G_LEAK,
    G_NA,
    REARM_MV,
    SPIKE_MV,
    V_K,
    V_LEAK,
    V_NA,
    Block,
    Stepping,
    crossing,
    slope,
)
from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


LANES = 16  # units side by side, two or four vector registers wide

_V, _N, _M, _H, _RISE, _BEFORE, _START, _END, _PEAK, _ARMED, _HIT, _ABOVE, _BLOCK = range(
    0, 13 * LANES, LANES
)
"""Offsets of the rows in the array of a block. One array, because the compiler then needs no checks
at run time that rows do not overlap."""

_LOW, _HIGH = -150.0, 200.0
"""Range of potential in mV within which the rates depend on it; beyond, gates are open or shut."""

_SETTLED = 1e-6
"""Distance from rest, in mV and of gates, below which a unit without current is at rest."""

_FAST = {"contract", "arcp", "nsz", "reassoc"}


@njit(cache=True, forceinline=True, fastmath=_FAST, error_model="numpy")
def _powers(v: float) -> tuple[float, float, float, float]:
    """Compute exp of -v/80, -v/20, -v/18 and -v/10, all powers of exp(-v/720).

    Eight terms of its series leave a relative error of 1e-9 in the highest power at 118 mV, the
    top of a spike, and of 1e-7 at 200 mV, which only a stimulus-driven membrane reaches.
    """
    x = v * (-1.0 / 720.0)
    x2 = x * x
    low = (1.0 + x) + x2 * (0.5 + x * (1.0 / 6.0))
    high = (1.0 / 24.0 + x * (1.0 / 120.0)) + x2 * (1.0 / 720.0 + x * (1.0 / 5040.0))
    e1 = low + (x2 * x2) * high
    e2 = e1 * e1
    e4 = e2 * e2
    e5 = e4 * e1
    e9 = e4 * e5
    e10 = e5 * e5
    e20 = e10 * e10
    e18 = e9 * e9
    e36 = e18 * e18
    return e9, e36, e20 * e20, e36 * e36


@njit(cache=True, forceinline=True, fastmath=_FAST, error_model="numpy")
def _linoid(v: float, threshold: float, e: float) -> tuple[float, float]:
    """Return x = (threshold - v) / 10 and e - 1 = exp(x) - 1, or 1 and 1 where both vanish."""
    x = 0.1 * (threshold - v)
    regular = abs(x) > 1e-6
    return (x if regular else 1.0), (e - 1.0 if regular else 1.0)


@njit(cache=True, forceinline=True, fastmath=_FAST, error_model="numpy")
def _slope(
    v: float, n: float, m: float, h: float, current: float, slow: float, m_rate_scale: float
) -> tuple[float, float, float, float]:
    """Time derivative as `equations.slope`, by one division, without an exponential.

    m_rate_scale: slow * m_rate_factor.
    """
    inside = min(max(v, _LOW), _HIGH)
    e80, e20, e18, e10 = _powers(inside)
    # exp((10 - v) / 10), exp((25 - v) / 10) and exp((30 - v) / 10) from one power: the constants
    # are e, e^2.5 and e^3.
    x_n, d_n = _linoid(inside, 10.0, 2.718281828459045 * e10)
    x_m, d_m = _linoid(inside, 25.0, 12.182493960703473 * e10)
    d_h = 20.085536923187668 * e10 + 1.0
    both = d_n * d_m
    one = 1.0 / (both * d_h)
    a_n, a_m, b_h = 0.1 * x_n * (d_m * d_h * one), x_m * (d_n * d_h * one), both * one
    n2 = n * n
    ionic = G_K * n2 * n2 * (v - V_K) + G_NA * m * m * m * h * (v - V_NA) + G_LEAK * (v - V_LEAK)
    dn = slow * (a_n - (a_n + 0.125 * e80) * n)
    dm = m_rate_scale * (a_m - (a_m + 4.0 * e18) * m)
    dh = slow * (0.07 * e20 - (0.07 * e20 + b_h) * h)
    return (current - ionic) * (1.0 / CAPACITANCE), dn, dm, dh


@njit(cache=True, forceinline=True, fastmath=_FAST, error_model="numpy")
def _observe(s: Array, i: int, new: float, dt: float, high: bool, block_after: float) -> int:
    """Record spike, peak and block of lane i at its new potential; return 1 for a spike."""
    s[_PEAK + i] = max(s[_PEAK + i], new)
    armed = s[_ARMED + i]
    hit = (armed > 0.5) & (new >= SPIKE_MV)
    s[_HIT + i] = 1.0 if hit else 0.0
    s[_ARMED + i] = 0.0 if hit else (1.0 if new < REARM_MV else armed)
    above = 0.0 if hit else s[_ABOVE + i]
    above = above + dt if high else 0.0
    s[_ABOVE + i] = above
    s[_BLOCK + i] += min(dt, max(above - block_after, 0.0))
    return 1 if hit else 0


@njit(cache=True, fastmath=_FAST, error_model="numpy")
def _runge_kutta(
    s: Array,
    lanes: int,
    at: float,
    part: float,
    dt: float,
    slow: float,
    m_rate_factor: float,
    block: Block,
) -> int:
    """Advance `lanes` units (8 or 16) by a classical Runge-Kutta step of dt ms; return spikes.

    The step begins at the fraction `at` between two samples of the current and is `part` long.
    """
    hits = 0
    m_rate_scale = slow * m_rate_factor
    half, sixth = 0.5 * dt, dt / 6.0
    for i in range(lanes):
        v, n, m, h = s[_V + i], s[_N + i], s[_M + i], s[_H + i]
        rise = s[_END + i] - s[_START + i]
        start = s[_START + i] + at * rise
        middle, end = start + 0.5 * part * rise, start + part * rise
        a, b, c, d = _slope(v, n, m, h, start, slow, m_rate_scale)
        e, f, g, j = _slope(
            v + half * a, n + half * b, m + half * c, h + half * d, middle, slow, m_rate_scale
        )
        p, q, r, u = _slope(
            v + half * e, n + half * f, m + half * g, h + half * j, middle, slow, m_rate_scale
        )
        w, x, y, z = _slope(v + dt * p, n + dt * q, m + dt * r, h + dt * u, end, slow, m_rate_scale)
        new = v + sixth * (a + 2.0 * (e + p) + w)
        s[_RISE + i], s[_BEFORE + i], s[_V + i] = a, v, new
        s[_N + i] = n + sixth * (b + 2.0 * (f + q) + x)
        s[_M + i] = m + sixth * (c + 2.0 * (g + r) + y)
        s[_H + i] = h + sixth * (d + 2.0 * (j + u) + z)
        hits += _observe(
            s, i, new, dt, (new > block.potential) & (start > block.current), block.longest
        )
    return hits


@njit(cache=True, forceinline=True, fastmath=_FAST, error_model="numpy")
def _relaxed(x: float, rise: float, total: float, scale: float) -> float:
    """Return x after a step of dx/dt = (rise - total x) / scale; both contain the step.

    The (1, 2) Pade approximant of the exponential: third order, and damped for any step.
    """
    upper = (rise - total * x) * (scale + total * (1.0 / 6.0))
    return x + upper / (scale * scale + total * (scale * (2.0 / 3.0) + total * (1.0 / 6.0)))


@njit(cache=True, fastmath=_FAST, error_model="numpy")
def _split(
    s: Array,
    at: float,
    gate_step: float,
    dt: float,
    slow: float,
    m_rate_factor: float,
    block: Block,
) -> int:
    """Advance the gates by `gate_step` ms, then the potential by dt ms; return the spikes.

    The gates are half a step ahead of the potential: a Strang splitting that merges the two half
    steps of the gates on either side of a potential step. `at` is the middle of the step, as a
    fraction between two samples of the current.
    """
    hits = 0
    step, charge = slow * gate_step, dt / CAPACITANCE
    m_rate_scale = step * m_rate_factor
    for i in range(LANES):
        v = s[_V + i]
        inside = min(max(v, _LOW), _HIGH)
        e80, e20, e18, e10 = _powers(inside)
        x, d = _linoid(inside, 10.0, 2.718281828459045 * e10)
        n = _relaxed(s[_N + i], step * 0.1 * x, step * (0.1 * x + 0.125 * e80 * d), d)
        x, d = _linoid(inside, 25.0, 12.182493960703473 * e10)
        m = _relaxed(s[_M + i], m_rate_scale * x, m_rate_scale * (x + 4.0 * e18 * d), d)
        d = 20.085536923187668 * e10 + 1.0
        x = 0.07 * e20 * d
        h = _relaxed(s[_H + i], step * x, step * (x + 1.0), d)
        current = s[_START + i] + at * (s[_END + i] - s[_START + i])
        g_k, g_na = G_K * (n * n) * (n * n), G_NA * m * m * m * h
        drive = current + g_k * V_K + g_na * V_NA + G_LEAK * V_LEAK
        new = _relaxed(v, charge * drive, charge * (g_k + g_na + G_LEAK), 1.0)
        s[_BEFORE + i], s[_V + i] = v, new
        s[_N + i], s[_M + i], s[_H + i] = n, m, h
        hits += _observe(
            s, i, new, dt, (new > block.potential) & (current > block.current), block.longest
        )
    return hits


@njit(cache=True)
def _spiked(
    s: Array, i: int, slow: float, m_rate_factor: float, dt: float, current: float, split: bool
) -> float:
    """Fraction of the last step at which lane i spiked.

    Of a Runge-Kutta step `current` and gates are known at its end. Of a split step they are known
    in its middle: half a step either way gives the slopes at its ends.
    """
    v0, v1 = s[_BEFORE + i], s[_V + i]
    n, m, h = s[_N + i], s[_M + i], s[_H + i]
    d0 = s[_RISE + i]
    d1, dn, dm, dh = slope(v1, n, m, h, current, slow, m_rate_factor)
    if split:
        b = 0.5 * dt
        d1 = slope(v1, n + b * dn, m + b * dm, h + b * dh, current, slow, m_rate_factor)[0]
        _, dn, dm, dh = slope(v0, n, m, h, current, slow, m_rate_factor)
        d0 = slope(v0, n - b * dn, m - b * dm, h - b * dh, current, slow, m_rate_factor)[0]
    return crossing(v0, v1, d0, d1, dt)


@njit(cache=True)
def _resting(s: Array, rest: Array) -> bool:
    """Test whether no lane has current in this interval and all are at rest."""
    for i in range(LANES):
        if s[_START + i] != 0.0 or s[_END + i] != 0.0:
            return False
        for row in range(4):
            if abs(s[row * LANES + i] - rest[row]) > _SETTLED:
                return False
    return True


@njit(cache=True)
def at_rest(rest: Array) -> Array:
    """Create the state of a block of LANES units at rest."""
    s = np.zeros(13 * LANES)
    for row in range(4):
        s[row * LANES : (row + 1) * LANES] = rest[row]
    s[_PEAK : _PEAK + LANES] = rest[0]
    s[_ARMED : _ARMED + LANES] = 1.0
    return s


@njit(cache=True, nogil=True)
def interval(
    s: Array,
    before: Array,
    after: Array,
    begin: float,
    length: float,
    last: float,
    how: Stepping,
    rest: Array,
    block: Block,
    spikes: Array,
    counts: Integers,
) -> float:
    """Advance a block through an interval from `begin` ms on, in which currents are linear.

    before, after: current (n,) at its ends. last: the previous step in ms. Returns the last step of
    this interval. Other arguments as in `integrate`.
    """
    split, slow, m_rate_factor = how.splitting, how.speed, how.m_rate_factor
    units = len(before)
    lanes = LANES // 2 if units <= LANES // 2 else LANES
    # 1e-9: rounding must not add a step to an interval that is a multiple of the step.
    steps = math.ceil(length / how.longest - 1e-9)
    for i in range(units):
        s[_START + i], s[_END + i] = before[i], after[i]
    if steps == 0 or _resting(s, rest):
        return last
    dt = length / steps
    for j in range(steps):
        if split:
            hits = _split(s, (j + 0.5) / steps, 0.5 * (last + dt), dt, slow, m_rate_factor, block)
        else:
            hits = _runge_kutta(s, lanes, j / steps, 1.0 / steps, dt, slow, m_rate_factor, block)
        last = dt
        if hits > 0:
            at = (j + (0.5 if split else 1.0)) / steps
            for i in range(units):
                if s[_HIT + i] > 0.5:
                    if counts[i] < spikes.shape[1]:
                        level = s[_START + i] + at * (s[_END + i] - s[_START + i])
                        where = _spiked(s, i, slow, m_rate_factor, dt, level, split)
                        spikes[i, counts[i]] = begin + dt * (j + where)
                    counts[i] += 1
    return last


@njit(cache=True, nogil=True)
def integrate(
    time: Array,
    current: Array,
    how: Stepping,
    rest: Array,
    block: Block,
    spikes: Array,
    counts: Integers,
) -> Array:
    """Integrate n <= 16 units from rest over time (n_t,) ms with current (n_t, n), linear between.

    Fills spikes (n, :) with crossing times in ms and counts (n,), which keep counting where
    `spikes` is full. Returns (n, 6): final v, n, m, h, the highest potential and the ms in block.
    """
    s, last = at_rest(rest), 0.0
    for k in range(len(time) - 1):
        length = time[k + 1] - time[k]
        last = interval(
            s, current[k], current[k + 1], time[k], length, last, how, rest, block, spikes, counts
        )
    if how.splitting:  # the gates still lack their last half step
        _split(s, 0.0, 0.5 * last, 0.0, how.speed, how.m_rate_factor, block)
    units = len(counts)
    ends = np.empty((units, 6))
    for i in range(units):
        for row in range(4):
            ends[i, row] = s[row * LANES + i]
        ends[i, 4], ends[i, 5] = s[_PEAK + i], s[_BLOCK + i]
    return ends
