"""Hodgkin-Huxley membrane of the squid axon, and a leaky integrate-and-fire membrane."""

import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.membranes.firing import (
    LARGEST_STEP,
    Firing,
    Run,
    fired,
    in_blocks,
    largest_step,
    signals,
    trimmed,
)
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, number


if TYPE_CHECKING:
    from fefinger.neural.membranes.equations import Block


BLOCK_MV, BLOCK_CURRENT, BLOCK_AFTER = 6.5, 50.0, 0.010
"""Definition of a depolarization block: current above BLOCK_CURRENT and potential above BLOCK_MV
without a spike for more than BLOCK_AFTER s over the speed, which is longer than any spike.

BLOCK_MV lies just below the trough of the oscillation that no longer reaches 40 mV (6.6 mV at 110
µA/cm²). BLOCK_CURRENT excludes a membrane that has accommodated to a slow rise: rest is unstable
from 9.8 µA/cm² on, but a membrane may stay there long just above that.
"""

METHODS = ("splitting", "runge-kutta")
"""Integrators, fastest first."""

_Q10, _MEASURED_AT = 3.0, 6.3  # factor per 10 C, and C of the rates: Hodgkin & Huxley (1952)

_SPLITTING_ERROR, _RUNGE_KUTTA_ERROR = 600.0, 112.0
"""95th percentile of the error of spike times in ms per s of firing, over speed * dt² and over
speed³ * dt⁴ with dt in ms. Measured on ramps of 0.5 s to 2 to 100 µA/cm² held for 0.5 to 5 s, for
speeds 1 and 1/6. The error is one of the rate, so it grows with time."""


@dataclass(frozen=True)
class HodgkinHuxley:
    """Membrane of the squid axon, its rates divided by `rate_divisor` and scaled by Q10 = 3.

    At 6.3 C a divisor of 1 is the standard membrane of the preliminary models, 6 the slowed one of
    thesis 4.3.2, which fires 5.0 to 5.4 times slower. The temperature in C multiplies all rates by
    3^((T - 6.3) / 10). V is the depolarization above rest. The signs in the rate functions are
    those that fit the printed constants (Eq. B.5 to B.10 print the opposite signs, with which the
    membrane never fires); B.1.2 divides the rates of all three gates.

    A spike is an upward crossing of 40 mV, counted again after falling below 20 mV; its time is
    that on the cubic through both ends of the step. Repetitive firing to a step begins at 6.260
    µA/cm² (6.198 for rates / 6) and fails the 40 mV rule above 111 (113).

    Hodgkin & Huxley (1952), J Physiol 117:500; Pawluk (1997), Eq. B.1 to B.17.
    """

    rate_divisor: float = 6.0
    temperature: float = _MEASURED_AT

    def __post_init__(self) -> None:
        number("rate_divisor", self.rate_divisor, at_least=1.0, at_most=100.0)
        number("temperature", self.temperature, at_least=0.0, at_most=40.0, unit="C")

    @property
    def speed(self) -> float:
        """Factor on all rates."""
        return float(_Q10 ** ((self.temperature - _MEASURED_AT) / 10) / self.rate_divisor)

    def rest(self) -> Array:
        """Compute the resting state (V in mV, n, m, h) by bisection."""
        from fefinger.neural.membranes import equations as compiled

        low, high = -1.0, 1.0
        for _ in range(60):
            v = 0.5 * (low + high)
            a_n, b_n, a_m, b_m, a_h, b_h = compiled.rates(v)
            n, m, h = a_n / (a_n + b_n), a_m / (a_m + b_m), a_h / (a_h + b_h)
            outward = compiled.slope(v, n, m, h, 0.0, 1.0, 1.0)[0] < 0.0
            low, high = (low, v) if outward else (v, high)
        return np.array([v, n, m, h])

    @property
    def block(self) -> "Block":
        """Definition of a depolarization block."""
        from fefinger.neural.membranes.equations import Block

        return Block(BLOCK_MV, BLOCK_CURRENT, 1e3 * BLOCK_AFTER / self.speed)

    def step_ms(self, dt: float | None) -> float:
        """Longest step in ms for `dt` in s (default LARGEST_STEP) at the speed of the membrane."""
        return 1e3 * min(largest_step(dt), LARGEST_STEP / max(1.0, self.speed))

    def integrator(self, tolerance: float, seconds: float = 1.0) -> tuple[str, float]:
        """Choose the cheapest method, and its step in s, with spike times within `tolerance` s.

        The tolerance holds for 95 % of the spikes of ramps that are held, in a run of `seconds`
        (shorter ones count as 1 s). Spikes that a slow oscillation near threshold causes are
        exponentially sensitive: no step bounds their error.

        Raises InputError for a tolerance below a billionth of the run.
        """
        # Least tolerance of spike times in s per s of the run: the exponentials of the compiled
        # equations are right to some 1e-9, and the order 8 that tests compare with is no better.
        finest = 1e-9
        least = finest * max(1.0, seconds)
        wanted = 1e3 * finest * number("tolerance", tolerance, at_least=least, unit="s") / least
        splitting = (wanted / (_SPLITTING_ERROR * self.speed)) ** 0.5
        # Step in ms below which the splitting costs as much as Runge-Kutta with LARGEST_STEP.
        worthwhile = 0.0125
        if splitting >= worthwhile:
            return "splitting", min(1e-3 * splitting, LARGEST_STEP)
        runge_kutta = (wanted / (_RUNGE_KUTTA_ERROR * self.speed**3)) ** 0.25
        return "runge-kutta", min(1e-3 * runge_kutta, LARGEST_STEP)

    def fire(
        self,
        time: ArrayLike,
        current: ArrayLike,
        *,
        dt: float | None = None,
        method: str | None = None,
        tolerance: float | None = None,
        stimulus_driven: bool = True,
    ) -> Firing:
        """Integrate from rest.

        Parameters
        ----------
        time
            (n_t,) s, not decreasing; each interval is divided into equal steps of at most `dt`.
        current
            (n_t,) or (n_t, n_units) µA/cm², linear between the samples.
        dt
            Longest step in s, at most 5e-5, which is the default; never longer than 5e-5 over the
            speed.
        method
            "runge-kutta" (default; fourth order) or "splitting" (second order, several times
            faster).
        tolerance
            Allowed error of spike times in s, from which `method` and `dt` are chosen.
        stimulus_driven
            Run again with frozen sodium activation, to count crossings by the current alone.

        Raises
        ------
        InputError
            Arrays of other shapes, times that decrease, a step that is too long, a current that is
            not finite or beyond 1e4 µA/cm², or a tolerance together with a method or step.
        """
        if tolerance is not None:
            if dt is not None or method is not None:
                raise InputError(
                    "tolerance: expected a tolerance or method and dt, received both; leave one out"
                )
            method, dt = self.integrator(tolerance, float(np.ptp(time)))
        method = choice("method", "runge-kutta" if method is None else method, METHODS)
        time_ms, columns = signals(time, current)
        run = partial(self._run, time_ms, columns, self.step_ms(dt), method == "splitting")
        return fired(run, stimulus_driven=stimulus_driven)

    def _run(
        self, time_ms: Array, current: Array, step: float, splitting: bool, frozen: bool
    ) -> Run:
        """Integrate all units: spike times in ms; per unit final state, peak in mV, ms in block."""
        from fefinger.neural.membranes import vectorized
        from fefinger.neural.membranes.equations import Stepping

        rest = self.rest()
        how = Stepping(step, splitting, self.speed, 0.0 if frozen else 1.0)
        # 2 spikes per ms are ten times what the membrane fires.
        room = int(2.0 * max(1.0, self.speed) * (time_ms[-1] - time_ms[0])) + 16

        def integrate(columns: Array) -> Run:
            n = columns.shape[1]
            spikes, counts = np.empty((n, room)), np.zeros(n, np.int64)
            rows = vectorized.integrate(time_ms, columns, how, rest, self.block, spikes, counts)
            return trimmed(spikes, counts), rows

        return in_blocks(integrate, current, vectorized.LANES, by_onset=True)


@dataclass(frozen=True)
class IntegrateAndFire:
    """Membrane with a leak, a threshold, a reset and a refractory time: the cheapest model.

    time_constant * du/dt = I / threshold - u, a spike where u passes 1, then u = 0 for
    `refractory`. Reported potentials are 40 mV times u. Between the samples of the current the
    solution is exact, so no step is chosen; there is no block.

    The defaults follow the rates of HodgkinHuxley(6) in constant currents of 10 to 100 µA/cm²
    within 13 %. They cannot follow its onset, which jumps to 10 Hz, nor its single spike to a step
    below the onset, its accommodation and its resonance: the rate of u falls to zero at threshold.

    `threshold` in µA/cm², `time_constant` and `refractory` in s. Lapicque (1907), J Physiol Pathol
    Gen 9:620; translated in Brunel & van Rossum (2007), Biol Cybern 97:337. Thesis 4.3.1.
    """

    threshold: float = 6.2
    time_constant: float = 0.045
    refractory: float = 0.038

    def __post_init__(self) -> None:
        number("threshold", self.threshold, above=0.0, unit="µA/cm²")
        number("time_constant", self.time_constant, above=0.0, unit="s")
        number("refractory", self.refractory, at_least=0.0, unit="s")

    @property
    def numbers(self) -> tuple[float, float, float]:
        """Threshold in µA/cm², time constant and refractory time in ms."""
        return self.threshold, 1e3 * self.time_constant, 1e3 * self.refractory

    def rate(self, current: float) -> float:
        """Return the firing rate in Hz in a constant current in µA/cm²."""
        if current <= self.threshold:
            return 0.0
        rise = -self.time_constant * math.log1p(-self.threshold / current)
        return 1.0 / (self.refractory + rise)

    def fire(
        self,
        time: ArrayLike,
        current: ArrayLike,
        *,
        dt: float | None = None,
        stimulus_driven: bool = True,
    ) -> Firing:
        """Solve from rest; parameters and errors as `HodgkinHuxley.fire`.

        `dt`, which is checked, and `stimulus_driven` exist for the common interface of membranes:
        the solution needs no step and has no sodium to freeze.
        """
        from fefinger.neural.membranes import equations

        largest_step(dt)
        time_ms, columns = signals(time, current)
        largest = float(columns.max())
        room = int(1e-3 * (time_ms[-1] - time_ms[0]) * self.rate(largest)) + 2

        def block(part: Array) -> Run:
            n = part.shape[1]
            spikes, counts = np.empty((n, room)), np.zeros(n, np.int64)
            rows = equations.integrate(time_ms, part, self.numbers, spikes, counts)
            return trimmed(spikes, counts), rows

        width = 64  # units per block: the current of one sample then fills a few cache lines
        times, rows = in_blocks(block, columns, width)
        spike_mv = 40.0  # mV that the threshold counts as: where a Hodgkin-Huxley spike counts
        return Firing(
            times=tuple(1e-3 * each for each in times),
            peak_mV=spike_mv * rows[:, 1],
            block_seconds=np.zeros(len(rows)),
            stimulus_driven=np.zeros(len(rows), np.int64),
            final=spike_mv * rows[:, :1],
        )
