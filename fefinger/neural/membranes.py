"""Membranes: from generator current to spikes."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.checks import InputError, number


LARGEST_STEP = 5e-5
"""Longest integration step in s; spike counts in steps and ramps are converged there."""

BLOCK_MV, BLOCK_CURRENT, BLOCK_AFTER = 6.5, 50.0, 0.010
"""Depolarization block: for more than BLOCK_AFTER s times the rate divisor, which is longer than
any spike, the current stays above BLOCK_CURRENT and the potential above BLOCK_MV without a spike.

The potential lies just below the trough of the oscillation that no longer reaches 40 mV (6.6 mV at
110 uA/cm²). The current excludes a membrane that a slow rise has accommodated: rest is unstable
from 9.8 uA/cm² on, but may take long to be left just above that.
"""

_LARGEST_INPUT = 1e4
"""uA/cm² up to which the fixed step is stable."""


@dataclass(frozen=True, kw_only=True)
class Firing:
    """What membranes did: one entry per unit.

    times: ascending spike times in s. peak_mV: highest potential above rest. block_seconds: time
    in depolarization block. stimulus_driven: crossings of 40 mV with sodium activation frozen at
    rest (zeros where that was not asked). final: (n_units, 4) potential in mV and gates n, m, h.
    """

    times: tuple[NDArray[np.float64], ...]
    peak_mV: NDArray[np.float64]
    block_seconds: NDArray[np.float64]
    stimulus_driven: NDArray[np.int64]
    final: NDArray[np.float64]


@dataclass(frozen=True)
class HodgkinHuxley:
    """The squid axon at 6.3 C, with all six rates divided by `rate_divisor`.

    1 is the standard membrane of the preliminary models, 6 the slowed one of thesis 4.3.2, which
    fires 5.0 to 5.4 times slower. V is the depolarization above rest. The rate functions carry the
    signs that belong to the printed constants (Eq. B.5 to B.10 as printed have the opposite ones,
    and then nothing fires); B.1.2 divides the rates of all three gates.

    A spike is an upward crossing of 40 mV, re-armed below 20 mV, its time found on the cubic
    through both ends of the step. Repetitive firing to a step begins at 6.260 uA/cm² (6.198 for
    rates / 6) and fails the 40 mV rule above 111 (113).

    Hodgkin & Huxley (1952), J Physiol 117:500; Pawluk (1997), Eq. B.1 to B.17.
    """

    rate_divisor: float = 6.0

    def __post_init__(self) -> None:
        """Check the divisor."""
        number("rate_divisor", self.rate_divisor, at_least=1.0, at_most=100.0)

    def rest(self) -> NDArray[np.float64]:
        """Return the resting state (V in mV, n, m, h), found by bisection."""
        from fefinger.neural import _hodgkin_huxley as compiled

        low, high = -1.0, 1.0
        for _ in range(60):
            v = 0.5 * (low + high)
            a_n, b_n, a_m, b_m, a_h, b_h = compiled.rates(v)
            n, m, h = a_n / (a_n + b_n), a_m / (a_m + b_m), a_h / (a_h + b_h)
            outward = compiled.slope(v, n, m, h, 0.0, 1.0, 1.0)[0] < 0.0
            low, high = (low, v) if outward else (v, high)
        return np.array([v, n, m, h])

    def fire(
        self,
        time: ArrayLike,
        current: ArrayLike,
        *,
        dt: float = LARGEST_STEP,
        stimulus_driven: bool = True,
    ) -> Firing:
        """Integrate from rest by classical Runge-Kutta steps of at most `dt`.

        Parameters
        ----------
        time
            (n_t,) s, not decreasing; each interval is divided into equal steps of at most `dt`.
        current
            (n_t,) or (n_t, n_units) uA/cm², linear between the samples.
        dt
            Longest step in s, at most 5e-5.
        stimulus_driven
            Run once more with sodium activation frozen, to count what the current alone does.

        Raises
        ------
        InputError
            Arrays that do not fit, times that decrease, a step that is too long, or a current
            that is not finite or beyond 1e4 uA/cm².
        """
        dt = number("dt", dt, above=0.0, at_most=LARGEST_STEP, unit="s")
        time, current = np.asarray(time, float), np.asarray(current, float)
        _check_signals(time, current)
        columns = current.reshape(len(time), -1)
        runs = [self._run(1e3 * time, column, dt, frozen=False) for column in columns.T]
        driven = np.zeros(len(runs), np.int64)
        if stimulus_driven:
            frozen = [self._run(1e3 * time, column, dt, frozen=True) for column in columns.T]
            driven = np.array([len(run[0]) for run in frozen], np.int64)
        return Firing(
            times=tuple(run[0] for run in runs),
            peak_mV=np.array([run[1] for run in runs]),
            block_seconds=np.array([run[2] for run in runs]),
            stimulus_driven=driven,
            final=np.array([run[3] for run in runs]),
        )

    def _run(
        self, time_ms: NDArray[np.float64], column: NDArray[np.float64], dt: float, *, frozen: bool
    ) -> tuple[NDArray[np.float64], float, float, NDArray[np.float64]]:
        from fefinger.neural import _hodgkin_huxley as compiled

        spikes = np.empty(int((time_ms[-1] - time_ms[0]) / 0.5) + 16)
        count, peak, block, final = compiled.integrate(
            time_ms,
            np.ascontiguousarray(column),
            1e3 * dt,
            float(self.rate_divisor),
            frozen,
            self.rest(),
            BLOCK_MV,
            BLOCK_CURRENT,
            1e3 * BLOCK_AFTER * self.rate_divisor,
            spikes,
        )
        if count > len(spikes):
            msg = (
                f"current: swings {count} times through 40 mV, faster than any membrane can follow"
            )
            raise InputError(msg)
        return 1e-3 * spikes[:count], peak, 1e-3 * block, final


def _check_signals(time: NDArray[np.float64], current: NDArray[np.float64]) -> None:
    """Raise InputError where time and current cannot be integrated."""
    shaped = current.ndim in (1, 2) and current.shape[:1] == time.shape
    if not shaped or len(time) < 2:
        msg = (
            f"time, current: expected (n_t,) and (n_t,) or (n_t, n_units) with two samples or "
            f"more, received {time.shape} and {current.shape}"
        )
        raise InputError(msg)
    if not np.isfinite(time).all() or np.any(np.diff(time) < 0):
        msg = "time: expected finite times in s that never decrease"
        raise InputError(msg)
    largest = float(np.abs(current).max(initial=0.0))
    if not math.isfinite(largest) or largest > _LARGEST_INPUT:
        msg = (
            f"current: expected at most {_LARGEST_INPUT:g} uA/cm², received {largest:g}; "
            "lower the gain or use the saturating generator"
        )
        raise InputError(msg)
