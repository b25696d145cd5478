"""Noise of a force that its samples share with their neighbors: estimated, and in averages.

Averages over many samples are known less well than those of white noise of the same size, where a
sensor drifts (1 / f) or has a filter.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from fefinger.support.arrays import Array
from fefinger.theory.lumped.ramp_hold import RampHold


LOWEST = 4
"""First period of a part that counts: a trend that was taken away took slower noise with it."""

FEWEST = 8
"""Fewest periods of a band, over which the periodogram is averaged."""

BAND = 1.1
"""Largest ratio of the frequencies of a band, if it has so many."""

DECADE = 10.0
"""Ratio of the frequencies by which the spectrum below the lowest band is told."""

STEEPEST = -1.0
"""Largest slope there: that of 1 / f. Spectra of filters that rise faster end soon."""

GOES_ON = 0.5
"""Part of the slope of the lowest decade with which a spectrum goes on below: that of a filter ends
there, 1 / f goes on."""

SURE = 100.0
"""Gain of the logarithm of the likelihood, twice, over twice the number of the lowest bands, from
which noise is colored. White noise gains 1.8 a band; of 1000 draws none gained more than 81 beyond
2."""

LEAST = 0.1
"""White variance that is added, over the variance: a filter makes neighbors equal, and their
difference would be surer than the model is."""

RELAXING = 12
"""Exponentials that are taken from the force of a hold, with time constants even in logarithm."""

SETTLED = 0.01
"""Time in s after the corner from which the force of a hold is smooth."""


@dataclass(frozen=True)
class Noise:
    """Stationary noise at even times, by its autocovariance (m,) N²; (1,) of white noise."""

    by_lag: Array

    @property
    def colored(self) -> bool:
        """Whether samples share noise with their neighbors."""
        return len(self.by_lag) > 1

    @property
    def sd(self) -> float:
        """Standard deviation in N of one sample."""
        return float(np.sqrt(self.by_lag[0]))

    def scaled(self, sd: float) -> Self:
        """Return noise of the same color, with a standard deviation in N of one sample."""
        return type(self)(self.by_lag * (sd / self.sd) ** 2)

    def of_sums(self) -> Array:
        """Return the variances (m + 1,) N² of sums of 0 to m successive samples."""
        grown = 2 * np.cumsum(self.by_lag) - self.by_lag[0]
        return np.append(0.0, np.cumsum(grown))

    def of_average(self, count: int) -> float:
        """Return the standard deviation in N of an average over `count` successive samples."""
        if not self.colored:
            return self.sd / float(np.sqrt(count))
        return float(np.sqrt(self.of_sums()[count])) / count

    def covariance(self, size: Array) -> Array:
        """Return the covariance (n, n) N² of successive averages over `size` (n,) samples.

        By the variance V of sums: twice the covariance of the sums over [a, b) and [c, d) is
        V(d - a) + V(b - c) - V(c - a) - V(d - b).
        """
        if not self.colored:
            return np.diag(self.by_lag / size)
        edges = np.cumsum(np.append(0, size)).astype(int)
        of_sums = self.of_sums()[np.abs(np.subtract.outer(edges, edges))]
        twice = of_sums[1:, :-1] + of_sums[:-1, 1:] - of_sums[:-1, :-1] - of_sums[1:, 1:]
        return np.asarray(twice / (2 * np.multiply.outer(size, size)))


def white(sd: float) -> Noise:
    """Return noise of a standard deviation in N that no sample shares with others."""
    return Noise(np.array([sd**2]))


def estimated(parts: Sequence[Array], length: int, sd: float) -> Noise:
    """Return the noise of `length` samples by detrended parts (n_t,) N of them.

    By the averages of their periodograms over bands, between which the spectrum is a power of the
    frequency; below the lowest band it continues. sd: standard deviation in N of one sample, of
    noise whose spectrum is level as far as the bands tell.
    """
    angle, power, count = spectrum(parts)
    if not _is_colored(power, count):
        return white(sd)
    whole = 2 ** int(np.ceil(np.log2(2 * length)))  # twice, as the transform is periodic
    at = 2 * np.pi * np.arange(1, whole // 2 + 1) / whole
    found = np.interp(np.log(at), np.log(angle), np.log(power))
    found += _slope(angle, power) * np.minimum(np.log(at / angle[0]), 0)
    by_lag = np.fft.irfft(np.exp(np.append(found[0], found)))[:length]
    by_lag[0] *= 1 + LEAST
    return Noise(by_lag)


def _slope(angle: Array, power: Array) -> float:
    """Return the power of the frequency with which a spectrum goes on below its lowest band."""
    low = angle < DECADE * angle[0]
    slope, _ = np.polyfit(np.log(angle[low]), np.log(power[low]), 1)
    return GOES_ON * float(np.clip(slope, STEEPEST, 0))


def _is_colored(power: Array, count: Array) -> bool:
    """Whether powers (m,) that are averages of `count` (m,) periods differ beyond chance."""
    if len(power) < 2:
        return False
    level = np.average(power, weights=count)
    gained = np.cumsum(2 * count * (np.log(level / power) + power / level - 1))
    return bool((gained > 2 * np.arange(1, len(gained) + 1) + SURE).any())


def spectrum(parts: Sequence[Array]) -> tuple[Array, Array, Array]:
    """Return angular frequencies (m,) per sample, powers (m,) N² and the periods of each band.

    The LOWEST of every part is left out, with its trend.
    """
    found = []
    for part in parts:
        if len(part) >= 4 * LOWEST:
            taper = np.hanning(len(part) + 2)[1:-1]
            power = np.abs(np.fft.rfft(taper * part)) ** 2 / np.sum(taper**2)
            at = np.arange(LOWEST, len(power) - 1)
            found.append((2 * np.pi * at / len(part), power[at]))
    if not found:
        return np.empty(0), np.empty(0), np.empty(0)
    angle, power = (np.concatenate(each) for each in zip(*found, strict=True))
    order = np.argsort(angle)
    angle, power = angle[order], power[order]
    starts = [0]
    while (wide := int(np.searchsorted(angle, BAND * angle[starts[-1]]))) < len(angle) - FEWEST:
        starts.append(max(wide, starts[-1] + FEWEST))
    count = np.diff([*starts, len(angle)]).astype(float)
    angle = np.exp(np.add.reduceat(np.log(angle), starts) / count)
    return angle, np.maximum(np.add.reduceat(power, starts) / count, 1e-300), count


def of_hold(record: RampHold) -> Array:
    """Return the force (n_t,) N of a hold without its relaxation, from SETTLED on."""
    since = record.time[record.hold :] - record.time[record.hold]
    force = record.force[record.hold :][since > SETTLED]
    since = since[since > SETTLED]
    constants = np.geomspace(SETTLED, since[-1], RELAXING)
    smooth = np.column_stack([np.ones_like(since), np.exp(-since[:, None] / constants)])
    return np.asarray(force - smooth @ np.linalg.lstsq(smooth, force, rcond=1e-9)[0])
