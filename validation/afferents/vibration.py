"""Responses of units to a probe that vibrates about a preload, and their thresholds."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from fefinger.validation.afferents import data
from fefinger.validation.afferents.experiments import HELD
from scipy.stats import norm

from fefinger.neural import recorded_compiled as compiled
from fefinger.neural.recorded import LONGEST, Recorded, units_of
from fefinger.neural.recorded_compiled import fire
from fefinger.support.arrays import Array


UNITS = 7
"""Number of units that stand for a population, at equal steps of probability of their gains."""

SEED = 1
"""Seed of the noise."""

LASTING = {
    20.0: (0.6, 0.1),
    50.0: (0.4, 0.1),
    100.0: (0.4, 0.1),
    300.0: (0.25, 0.05),
    600.0: (0.2, 0.05),
}
"""Length of a vibration in s, by frequency in Hz, and its begin that does not count."""


@dataclass(frozen=True)
class Probed:
    """A unit under the probe: its type, parameters, and its input in mm at the preload."""

    kind: str
    unit: Recorded
    preload: float

    def gains(self, count: int = UNITS) -> Array:
        """Factors (n,) on the gains of the units of a population."""
        middles = (np.arange(count) + 0.5) / count
        return np.exp(self.unit.spread * np.asarray(norm.ppf(middles)))

    def times(
        self, frequency: float, amplitudes: Array, factors: Array, seconds: float, seed: int = SEED
    ) -> list[Array]:
        """Spike times (n_amplitudes * n_factors) in s in a sine of amplitudes (n,) mm."""
        amplitude, factor = (
            each.ravel() for each in np.meshgrid(amplitudes, factors, indexing="ij")
        )
        time = np.linspace(0.0, seconds, round(seconds * frequency * samples(frequency)) + 1)
        x = self.preload + amplitude * np.sin(2 * np.pi * frequency * time)[:, None]
        return self.fire(time, x, factor, seed)

    def fire(self, time: Array, x: Array, factors: Array, seed: int = SEED) -> list[Array]:
        """Spike times (n,) in s with inputs x (n_t, n) mm that begin at the preload."""
        n = len(factors)
        units = units_of([self.unit] * n, factors=factors, seed=seed)
        times, _ = fire(units, self.adapted(units), time, x, np.full(n, LONGEST[self.kind]))
        return times

    def adapted(self, units: compiled.Units) -> Array:
        """States (n, SIZE) of units that the preload was held on for HELD s."""
        states = compiled.rested(units, np.full(len(units.gain), self.preload))
        states[:, compiled.MODE : compiled.THIRD + 1] = 0.0
        for i, state in enumerate(states):
            compiled.generate(units, i, state)
        left = -np.expm1(-HELD / self.unit.adaptation)
        states[:, compiled.ADAPTED] = left * states[:, compiled.CURRENT]
        return states

    def rates(self, frequency: float, amplitudes: Array, *, single: bool = False) -> Array:
        """Mean rates (n_amplitudes,) in Hz of a population, or of its median unit."""
        factors = np.ones(1) if single else self.gains()
        seconds, since = LASTING[frequency]
        times = self.times(frequency, amplitudes, factors, seconds)
        counts = np.array([np.count_nonzero(each >= since) for each in times])
        return np.asarray(counts.reshape(len(amplitudes), -1).mean(axis=1) / (seconds - since))

    def rate_at_rest(self, seconds: float = 5.0, units: int = 16) -> float:
        """Mean rate in Hz of units under a probe that rests, by noise alone."""
        time = np.linspace(0.0, seconds, 101)
        times = self.fire(time, np.full((len(time), units), self.preload), np.ones(units))
        return sum(map(len, times)) / (seconds * units)

    def thresholds(self, frequencies: Sequence[float] | Array) -> Array:
        """Amplitudes (n,) in mm from which the unit fires without noise."""
        return np.array([self.threshold(float(frequency)) for frequency in frequencies])

    def threshold(self, frequency: float) -> float:
        """Amplitude in mm at which the periodic potential without noise reaches threshold.

        In closed form up to the rectifier: the filter by its frequency response, adaptation and
        membrane by theirs, on one cycle. 10 mm where it never does.
        """
        unit, phase = self.unit, 2 * np.pi * np.arange(512) / 512
        filtered = unit.frequency_response(np.array(frequency))
        wave = abs(filtered) * np.sin(phase + np.angle(filtered))
        still = unit.static**unit.order * self.preload
        s = 2j * np.pi * frequency * np.arange(257)
        passed = (1.0 - unit.adapting / (1.0 + s * unit.adaptation)) / (1.0 + s * unit.membrane)
        passed[0] = 1.0 + unit.adapting * np.expm1(-HELD / unit.adaptation)

        def peak(amplitude: float) -> float:
            y = still + amplitude * wave
            u = unit.gain * np.abs(y)
            current = np.where(y > 0, 1.0, unit.negative) * u / (1.0 + u / unit.largest)
            return float(np.fft.irfft(np.fft.rfft(current) * passed, 512).max())

        low, high = 1e-7, 10.0
        while high / low > 1.0 + 1e-4:
            middle = float(np.sqrt(low * high))
            low, high = (middle, high) if peak(middle) < 1.0 else (low, middle)
        return high


def samples(frequency: float) -> int:
    """Return samples per cycle: as in a scene, 0.2 ms apart or less, and at least 20.

    The filter of FAII differentiates twice: the corners of straight lines further apart drive it.
    """
    return max(20, round(5000.0 / frequency))


def determination(computed: Array, recorded: Array) -> float:
    """R²: 1 less the sum of squared errors over that about the mean of the recorded."""
    errors = np.sum((computed - recorded) ** 2)
    return float(1.0 - errors / np.sum((recorded - recorded.mean()) ** 2))


def fit_of_rates(probed: Probed, *, single: bool = False) -> tuple[Array, Array]:
    """Compute rates (n,) in Hz at all points of the data; return them and the recorded ones."""
    computed, recorded = [], []
    for frequency in data.FREQUENCIES:
        amplitudes, rates = data.rates(probed.kind, frequency)
        computed.append(probed.rates(frequency, amplitudes, single=single))
        recorded.append(rates)
    return np.concatenate(computed), np.concatenate(recorded)


def entrained(probed: Probed) -> float:
    """Amplitude in um from which units fire 95 % of one impulse per cycle at 300 Hz."""
    amplitudes = np.geomspace(1e-3, 0.05, 18)
    reached = probed.rates(300.0, amplitudes) >= 0.95 * 300.0
    return float(1e3 * amplitudes[np.argmax(reached)]) if reached.any() else np.nan


def best_frequency(probed: Probed, low: float, high: float) -> float:
    """Frequency in Hz of the lowest threshold."""
    frequencies = np.geomspace(low, high, 60)
    return float(frequencies[np.argmin(probed.thresholds(frequencies))])


def _thresholds(probed: Probed, low: float, high: float) -> tuple[Array, Array]:
    """Logarithms of recorded frequencies from low to high Hz; thresholds (2, n): own, recorded."""
    frequency, amplitude = data.thresholds(probed.kind)
    of = (frequency >= low) & (frequency <= high)
    own = probed.thresholds(frequency[of])
    return np.log(frequency[of]), np.log([own, amplitude[of]])


def slope(probed: Probed, low: float, high: float) -> float:
    """Logarithm, to 2, of the slope of the threshold curve over the recorded one in a range."""
    at, thresholds = _thresholds(probed, low, high)
    own, recorded = (np.polyfit(at, each, 1)[0] for each in thresholds)
    return float(np.log2(own / recorded)) if own / recorded > 0 else np.nan


def thresholds_off(probed: Probed, low: float, high: float) -> float:
    """Largest factor of thresholds in a range off the recorded ones, up to a constant."""
    apart = np.subtract(*_thresholds(probed, low, high)[1])
    return float(np.exp(np.ptp(apart) / 2))


FREQUENCIES = (1, 2, 5, 10, 20, 40, 60, 100, 150, 200, 250, 300, 400, 600, 800)
"""Hz."""

AMPLITUDES = np.geomspace(5e-4, 1.0, 20)
"""mm, peak."""

BEFORE = 0.2
"""Least time in s of a vibration before its rate counts, over a second."""


@cache
def rates(probed: Probed) -> Array:
    """Mean rates (n_frequencies, n_amplitudes) in Hz of a population, far beyond recorded points.

    A vibration that grows does not fire recorded units less, and fast ones fire them once per cycle
    at most. Neither is fitted where nothing was recorded.
    """
    factors, rows = probed.gains(), []
    for frequency in FREQUENCIES:
        since = np.ceil(BEFORE * frequency) / frequency
        times = probed.times(float(frequency), AMPLITUDES, factors, since + 1.0)
        counts = np.array([np.count_nonzero(each >= since) for each in times])
        rows.append(counts.reshape(len(AMPLITUDES), -1).mean(axis=1))
    return np.array(rows)


def largest_fall(probed: Probed) -> float:
    """Largest fall of the rate as the amplitude grows, over the highest rate at the frequency."""
    table = rates(probed)
    falls = (np.maximum.accumulate(table, axis=1) - table).max(axis=1)
    return float(np.max(falls / np.maximum(table.max(axis=1), 1.0)))


FAST = 150.0
"""Frequency in Hz from which a second impulse per cycle is refused."""


def most_per_cycle(probed: Probed) -> float:
    """Most impulses per cycle from FAST on."""
    fast = np.array(FREQUENCIES) >= FAST
    return float(np.max(rates(probed)[fast].max(axis=1) / np.array(FREQUENCIES)[fast]))
