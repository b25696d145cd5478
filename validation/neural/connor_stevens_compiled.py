"""Compiled Connor-Stevens membrane; imported at its first run.

Equations and constants: Dayan & Abbott (2001), Theoretical Neuroscience, section 6.6, Eq. 6.27 to
6.38.
"""

import math

import numpy as np
from numpy.typing import NDArray

from fefinger.neural.membranes.equations import REARM_MV, SPIKE_MV, crossing
from fefinger.support.compiled import njit


G_NA, G_K, G_LEAK = 120.0, 20.0, 0.3
E_NA, E_K, E_A, E_LEAK = 55.0, -72.0, -75.0, -17.0


@njit(cache=True)
def _linoid(x: float) -> float:
    """Return x / (1 - exp(-x)), regular at 0."""
    if abs(x) < 1e-6:
        return 1.0 + 0.5 * x
    return x / -math.expm1(-x)


@njit(cache=True)
def kinetics(
    e: float,
) -> tuple[float, float, float, float, float, float, float, float, float, float]:
    """Rate in 1/ms and steady state of n, m, h, a and b in turn at the absolute potential e mV."""
    a_n, b_n = 0.2 * _linoid(0.1 * (e + 45.7)), 0.25 * math.exp(-0.0125 * (e + 55.7))
    a_m, b_m = 3.8 * _linoid(0.1 * (e + 29.7)), 15.2 * math.exp(-0.0556 * (e + 54.7))
    a_h = 0.266 * math.exp(-0.05 * (e + 48.0))
    b_h = 3.8 / (1.0 + math.exp(-0.1 * (e + 18.0)))
    r_a = 1.0 / (0.3632 + 1.158 / (1.0 + math.exp(0.0497 * (e + 55.96))))
    r_b = 1.0 / (1.24 + 2.678 / (1.0 + math.exp(0.0624 * (e + 50.0))))
    a = 0.0761 * math.exp(0.0314 * (e + 94.22)) / (1.0 + math.exp(0.0346 * (e + 1.17)))
    b = 1.0 / (1.0 + math.exp(0.0688 * (e + 53.3)))
    n, m, h = a_n / (a_n + b_n), a_m / (a_m + b_m), a_h / (a_h + b_h)
    return a_n + b_n, n, a_m + b_m, m, a_h + b_h, h, r_a, a ** (1.0 / 3.0), r_b, b**4


@njit(cache=True)
def membrane(y: NDArray[np.float64], e: float, transient: float) -> tuple[float, float]:
    """Total conductance in mS/cm² and its current in uA/cm² at 0 mV, for the gates in y at e mV."""
    n2 = y[1] * y[1]
    g_k, g_na = G_K * n2 * n2, G_NA * y[2] * y[2] * y[2] * y[3]
    g_a = transient * y[4] * y[4] * y[4] * y[5]
    total = g_k + g_na + g_a + G_LEAK
    return total, g_k * E_K + g_na * E_NA + g_a * E_A + G_LEAK * E_LEAK


@njit(cache=True)
def _relax(y: NDArray[np.float64], e: float, step: float, m_rate_factor: float) -> None:
    """Relax the five gates exactly for `step` ms at a fixed e."""
    r_n, n, r_m, m, r_h, h, r_a, a, r_b, b = kinetics(e)
    y[1] += (y[1] - n) * math.expm1(-step * r_n)
    y[2] += (y[2] - m) * math.expm1(-step * m_rate_factor * r_m)
    y[3] += (y[3] - h) * math.expm1(-step * r_h)
    y[4] += (y[4] - a) * math.expm1(-step * r_a)
    y[5] += (y[5] - b) * math.expm1(-step * r_b)


@njit(cache=True, nogil=True)
def integrate(
    time: NDArray[np.float64],
    current: NDArray[np.float64],
    dt_max: float,
    numbers: tuple[float, float, float],
    frozen: bool,
    rest: NDArray[np.float64],
    spikes: NDArray[np.float64],
) -> tuple[int, float, float, NDArray[np.float64]]:
    """Integrate one unit from rest over time (n_t,) ms with current (n_t,) linear in between.

    Strang splitting: gates for half a step, potential for a step, gates for half a step, each
    exact with the other held. numbers: g_A in mS/cm², the speed of all gates, and after how many ms
    above REARM_MV a stay is a block. rest: potential in mV and gates. Fills `spikes`; returns their
    number, the highest potential above rest, the ms in block and the final state (6,).
    """
    transient, speed, block_after = numbers
    m_rate_factor, y, e0 = 0.0 if frozen else 1.0, rest.copy(), rest[0]
    armed, count, peak, block, above = True, 0, 0.0, 0.0, 0.0
    for k in range(len(time) - 1):
        interval = time[k + 1] - time[k]
        # 1e-9: rounding must not add a step to an interval that is a multiple of the step.
        steps = math.ceil(interval / dt_max - 1e-9)
        for j in range(steps):
            dt = interval / steps
            middle = current[k] + (current[k + 1] - current[k]) * ((j + 0.5) / steps)
            before = y[0]
            _relax(y, before, 0.5 * speed * dt, m_rate_factor)
            g, drive = membrane(y, before, transient)
            d0 = drive + middle - g * before
            y[0] = before + d0 / g * -math.expm1(-g * dt)
            d1 = drive + middle - g * y[0]
            _relax(y, y[0], 0.5 * speed * dt, m_rate_factor)
            new = y[0] - e0
            above = above + dt if new > REARM_MV else 0.0
            if armed and new >= SPIKE_MV:
                armed, above = False, 0.0
                if count < len(spikes):
                    spikes[count] = time[k] + dt * (j + crossing(before - e0, new, d0, d1, dt))
                count += 1
            elif new < REARM_MV:
                armed = True
            if above > block_after:
                block += min(dt, above - block_after)
            peak = max(peak, new)
    return count, peak, block, y
