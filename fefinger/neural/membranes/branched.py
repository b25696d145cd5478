"""Compiled integration of the membranes of one branched unit; imported at its first run."""

import math

import numpy as np
from numba import njit

from fefinger.neural.membranes.equations import REARM_MV, SPIKE_MV, crossing, slope, step
from fefinger.support.arrays import Array


@njit(cache=True, nogil=True)
def race(
    time: Array,
    current: Array,
    dt_max: float,
    slow: float,
    rest: Array,
    block: tuple[float, float, float],
    spikes: Array,
) -> tuple[int, float, float, Array]:
    """Integrate the branches of one unit from rest; the first to fire resets the others.

    time (n_t,) ms, current (n_t, n_branches); slow: factor on all rates. The branch that first
    reaches a spike fires the unit, and the others take over its state. `block`: potential, current
    and time of a depolarization block; the longest block of the branches counts. Returns the number
    of spikes, the peak, the ms in block and the final states.
    """
    n = current.shape[1]
    y = np.empty((n, 4))
    y[:] = rest
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
                high = new[0] > block[0] and start > block[1]
                above[b] = above[b] + dt if high else 0.0
                if above[b] > block[2]:
                    blocked[b] += min(dt, above[b] - block[2])
                peak = max(peak, new[0])
                y[b, 0], y[b, 1], y[b, 2], y[b, 3] = new
            if winner >= 0:
                if count < len(spikes):
                    spikes[count] = time[k] + dt * (j + first)
                count += 1
                y[:] = y[winner].copy()
                armed[:] = False
                above[:] = 0.0
    return count, peak, blocked.max(), y
