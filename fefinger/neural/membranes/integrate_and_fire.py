"""Leaky integrate-and-fire membrane."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.membranes.firing import Firing, Run, in_blocks, largest_step, signals, trimmed
from fefinger.support.arrays import Array
from fefinger.support.checks import number


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
        from fefinger.neural.membranes import integrate_and_fire_compiled as compiled

        largest_step(dt)
        time_ms, columns = signals(time, current)
        largest = float(columns.max())
        room = int(1e-3 * (time_ms[-1] - time_ms[0]) * self.rate(largest)) + 2

        def block(part: Array) -> Run:
            n = part.shape[1]
            spikes, counts = np.empty((n, room)), np.zeros(n, np.int64)
            rows = compiled.integrate(time_ms, part, self.numbers, spikes, counts)
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
