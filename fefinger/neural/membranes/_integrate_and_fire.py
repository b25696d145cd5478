"""The compiled integrate-and-fire membrane; imported when one first runs."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def _crossing(u: float, level: float, rise: float, tau: float, length: float) -> float:
    """Return the first time in (0, length] at which the potential passes 1, or -1.

    The potential is level + rise (s - tau) + c exp(-s/tau) with c = u - level + rise tau, convex
    or concave throughout. Newton's method from the left of a concave curve, or from the right of
    a convex one, runs to the crossing without overshoot.
    """
    c = u - level + rise * tau
    end = length
    if c < 0.0 and rise < 0.0 and rise * tau / c < 1.0:
        end = min(length, -tau * math.log(rise * tau / c))
    if level + rise * (end - tau) + c * math.exp(-end / tau) <= 1.0:
        return -1.0
    s = 0.0 if c < 0.0 else end
    for _ in range(100):
        decay = c * math.exp(-s / tau)
        slope = rise - decay / tau
        if slope <= 0.0:
            break
        change = (1.0 - level - rise * (s - tau) - decay) / slope
        s += change
        if abs(change) < 1e-13 * tau:
            break
    return min(max(s, 0.0), end)


@njit(cache=True)
def _eventful(
    state: NDArray[np.float64],
    t0: float,
    t1: float,
    level: float,
    rise: float,
    tau: float,
    refractory: float,
    spikes: NDArray[np.float64],
    count: int,
) -> int:
    """Take one unit through an interval with spikes or the end of a refractory time in it.

    state: potential, highest potential, time at which it is free. Returns the new count, which
    ends at one more than `spikes` has room for.
    """
    while count <= len(spikes):
        start = max(t0, state[2])
        if start >= t1:
            return count
        here = level + rise * (start - t0)
        found = _crossing(state[0], here, rise, tau, t1 - start)
        if found < 0.0:
            c = state[0] - here + rise * tau
            state[0] = here + rise * (t1 - start - tau) + c * math.exp((start - t1) / tau)
            state[1] = max(state[1], state[0])
            return count
        if count < len(spikes):
            spikes[count] = start + found
        count += 1
        state[0], state[1], state[2] = 0.0, 1.0, start + found + refractory
    return count


@njit(cache=True, nogil=True)
def integrate(
    time: NDArray[np.float64],
    current: NDArray[np.float64],
    numbers: tuple[float, float, float],
    spikes: NDArray[np.float64],
    counts: NDArray[np.int64],
) -> NDArray[np.float64]:
    """Solve n units from rest over time (n_t,) ms with current (n_t, n) linear between.

    numbers: threshold in uA/cm², time constant and refractory time in ms. Fills spikes (n, :) in
    ms and counts (n,); returns (n, 3): potential, highest potential (thresholds), ms when free.
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
        decay, scale, steep = math.exp(-length / tau), 1.0 / threshold, tau / length
        for i in range(units):
            if states[i, 2] >= t1:
                continue
            level, after = scale * current[k, i], scale * current[k + 1, i]
            lag = steep * (after - level)
            c = states[i, 0] - level + lag
            end = after - lag + c * decay
            turns = lag - c > 0.0 and lag - c * decay < 0.0
            if states[i, 2] > t0 or end > 1.0 or turns:
                counts[i] = _eventful(
                    states[i], t0, t1, level, lag / tau, tau, refractory, spikes[i], counts[i]
                )
            else:
                states[i, 0] = end
                states[i, 1] = max(states[i, 1], end)
    return states
