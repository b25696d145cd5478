"""Plain fixed-step integrators of the Hodgkin-Huxley equations, to compare with.

One unit at a time, in a straightforward loop with library exponentials: what a compiler makes of
the textbook.
"""

import math

import numpy as np
from numpy.typing import NDArray

from fefinger.neural.membranes import equations as squid
from fefinger.support.compiled import njit


State = tuple[float, float, float, float]


@njit(cache=True)
def _exponential_euler(y: State, dt: float, current: float, slow: float) -> State:
    """Relax each variable exactly with all others held at the start of the step: first order."""
    v, n, m, h = y
    a_n, b_n, a_m, b_m, a_h, b_h = squid.rates(v)
    g_k, g_na = squid.G_K * n * n * n * n, squid.G_NA * m * m * m * h
    total = g_k + g_na + squid.G_LEAK
    end = (current + g_k * squid.V_K + g_na * squid.V_NA + squid.G_LEAK * squid.V_LEAK) / total
    n_end, m_end, h_end = a_n / (a_n + b_n), a_m / (a_m + b_m), a_h / (a_h + b_h)
    return (
        end + (v - end) * math.exp(-total * dt / squid.CAPACITANCE),
        n_end + (n - n_end) * math.exp(-slow * (a_n + b_n) * dt),
        m_end + (m - m_end) * math.exp(-slow * (a_m + b_m) * dt),
        h_end + (h - h_end) * math.exp(-slow * (a_h + b_h) * dt),
    )


@njit(cache=True, nogil=True)
def integrate(
    time: NDArray[np.float64],
    current: NDArray[np.float64],
    dt_max: float,
    exponential: bool,
    divisor: float,
    rest: NDArray[np.float64],
    spikes: NDArray[np.float64],
) -> int:
    """Fill `spikes` with the crossing times in ms of one unit; return their number.

    time (n_t,) ms, current (n_t,) uA/cm² linear in between, Runge-Kutta unless `exponential`.
    """
    slow, y, armed, count = 1.0 / divisor, (rest[0], rest[1], rest[2], rest[3]), True, 0
    for k in range(len(time) - 1):
        interval = time[k + 1] - time[k]
        steps = math.ceil(interval / dt_max - 1e-9)
        for j in range(steps):
            dt, per_step = interval / steps, (current[k + 1] - current[k]) / steps
            start = current[k] + j * per_step
            k1 = squid.slope(y[0], y[1], y[2], y[3], start, slow, 1.0)
            if exponential:
                new = _exponential_euler(y, dt, start, slow)
            else:
                new = squid.step(y, k1, dt, start + 0.5 * per_step, start + per_step, slow, 1.0)
            if armed and new[0] >= squid.SPIKE_MV:
                d1 = squid.slope(new[0], new[1], new[2], new[3], start + per_step, slow, 1.0)[0]
                spikes[count] = time[k] + dt * (j + squid.crossing(y[0], new[0], k1[0], d1, dt))
                count += 1
                armed = False
            elif new[0] < squid.REARM_MV:
                armed = True
            y = new
    return count
