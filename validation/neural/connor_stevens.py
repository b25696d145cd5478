"""Connor-Stevens membrane: Hodgkin-Huxley with a fast transient potassium (A) current.

Equations and constants: Dayan & Abbott (2001), Theoretical Neuroscience, section 6.6, Eq. 6.27 to
6.38.
"""

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from fefinger.neural.membranes.equations import REARM_MV, SPIKE_MV, crossing
from fefinger.neural.membranes.firing import (
    Firing,
    Run,
    fired,
    in_blocks,
    largest_step,
    signals,
    trimmed,
)
from fefinger.support.arrays import Array
from fefinger.support.checks import number
from fefinger.support.compiled import njit


BLOCK_AFTER = 0.010
"""Time in s from which a stay of more than 20 mV above rest without a spike is a block; spikes are
shorter."""

_FINEST = 1e-5
"""Longest step in s; spike times at 9 to 40 uA/cm² are right to 0.04 ms in the first 0.15 s."""


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
    numbers: tuple[float, float],
    frozen: bool,
    rest: NDArray[np.float64],
    spikes: NDArray[np.float64],
) -> tuple[int, float, float, NDArray[np.float64]]:
    """Integrate one unit from rest over time (n_t,) ms with current (n_t,) linear in between.

    Strang splitting: gates for half a step, potential for a step, gates for half a step, each
    exact with the other held. numbers: g_A in mS/cm², and after how many ms above REARM_MV
    a stay is a block. rest: potential in mV and gates. Fills `spikes`; returns their
    number, the highest potential above rest, the ms in block and the final state (6,).
    """
    transient, block_after = numbers
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
            _relax(y, before, 0.5 * dt, m_rate_factor)
            g, drive = membrane(y, before, transient)
            d0 = drive + middle - g * before
            y[0] = before + d0 / g * -math.expm1(-g * dt)
            d1 = drive + middle - g * y[0]
            _relax(y, y[0], 0.5 * dt, m_rate_factor)
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


@dataclass(frozen=True)
class ConnorStevens:
    """Membrane with Hodgkin-Huxley currents and a fast transient potassium current: thesis 4.4.2.

    The A current opens below threshold and inactivates slowly, which delays the next spike: firing
    starts at any low rate, where HodgkinHuxley jumps to 50 Hz (10 Hz with rates / 6), at kinetics
    that are not slowed. At 16 Hz, where HodgkinHuxley(6) gives one impulse per cycle of A (1 - cos
    wt) at A = 6.25, 12.5, 25 and 50 uA/cm², this one gives 1, 4, 8 and 13.5; the frequency of one
    impulse per cycle depends on the amplitude. `transient` is the conductance of the A current in
    mS/cm²; at 20 and below the membrane fires without a stimulus.

    The nerve of a crab leg at 18 C: Connor, Walter & McKown (1977), Biophys J 18:81. Spikes as in
    HodgkinHuxley: upward through 40 mV above rest, re-armed below 20 mV.
    """

    transient: float = 47.7

    def __post_init__(self) -> None:
        """Check the conductance."""
        number("transient", self.transient, at_least=30.0, at_most=60.0, unit="mS/cm²")

    def rest(self) -> Array:
        """Find the lowest state without net current: absolute potential in mV and n, m, h, a, b."""

        def state(e: float) -> Array:
            return np.array([e, *kinetics(e)[1::2]])

        def inward(e: float) -> float:
            total, drive = membrane(state(e), e, self.transient)
            return float(drive - total * e)

        scan = np.linspace(-80.0, 0.0, 801)
        first = int(np.argmax([inward(e) < 0.0 for e in scan]))
        return state(brentq(inward, scan[first - 1], scan[first], xtol=1e-13))

    def fire(
        self,
        time: ArrayLike,
        current: ArrayLike,
        *,
        dt: float | None = None,
        stimulus_driven: bool = True,
    ) -> Firing:
        """Integrate from rest; parameters and errors as `HodgkinHuxley.fire`.

        A Strang splitting, second order, with steps of at most `dt` and 1e-5 s. The five gates in
        `final` are n, m, h, a and b.
        """
        time_ms, columns = signals(time, current)
        step = 1e3 * min(largest_step(dt), _FINEST)
        return fired(partial(self._run, time_ms, columns, step), stimulus_driven=stimulus_driven)

    def _run(
        self,
        time_ms: Array,
        columns: Array,
        step: float,
        frozen: bool,
    ) -> Run:
        """Integrate all units: spike times in ms; per unit final state, peak in mV, ms in block."""
        rest = self.rest()
        numbers = self.transient, 1e3 * BLOCK_AFTER
        room = int(2.0 * (time_ms[-1] - time_ms[0])) + 16

        def unit(column: Array) -> Run:
            spikes = np.empty((1, room))
            count, peak, block, final = integrate(
                time_ms, column[:, 0], step, numbers, frozen, rest, spikes[0]
            )
            final[0] -= rest[0]
            return trimmed(spikes, np.array([count])), np.array([[*final, peak, block]])

        return in_blocks(unit, columns, 1)
