"""Amplitude spectra of signals and of spikes, with a Hann window over a span of time.

A sinusoid within the span has its amplitude at its frequency. It is seen two over the length of the
span to either side; what is slower than that, or a line through the whole span, is no part of a
spectrum.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.statistics import psth
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number


BIN = 1e-4
"""Bins of spikes in s: they take 0.4 % of an amplitude at 500 Hz."""

FINER = 4
"""Frequencies to those that the span has alone: between two of these a line would look lower."""

SHORTEST = 16
"""Least number of samples in a span."""


class Spectrum(NamedTuple):
    """Frequencies (n_f,) Hz above 0, and amplitudes (n_f,) or (n_f, ...) of sinusoids at them."""

    frequency: Array
    amplitude: Array


def signal_spectrum(time: ArrayLike, values: ArrayLike, start: float, stop: float) -> Spectrum:
    """Return the spectrum of signals from `start` to `stop` s, in their unit.

    time (n_t,) ascending s, values (n_t, ...), linear in between. The frequencies end at half the
    rate of the samples, which is one over the median of their steps. InputError for times beyond.
    """
    from scipy.interpolate import make_interp_spline

    time, values = np.asarray(time, float), np.asarray(values, float)
    inside = (time >= start) & (time <= stop)
    rounding = 1e-9  # s that sums of steps may be beyond
    within = len(time) > 0 and time[0] - rounding <= start and stop <= time[-1] + rounding
    if not within or np.count_nonzero(inside) < SHORTEST:
        raise InputError(
            f"start, stop: expected a span of {SHORTEST} samples or more within those of the "
            f"signal, received {start:.6g} to {stop:.6g} s with {np.count_nonzero(inside)}"
        )
    step = float(np.median(np.diff(time[inside])))
    even = np.arange(start, stop - step / 2, step)
    return _spectrum(make_interp_spline(time, values, k=1)(even), step)


def spike_spectrum(trains: Sequence[ArrayLike], start: float, stop: float) -> Spectrum:
    """Return the spectrum of the firing rate from `start` to `stop` s in Hz, of units (n_f,).

    trains: ascending spike times in s of each unit. The amplitude is the root mean square over the
    units, which fire at other phases where they lie at other places. A unit that fires evenly has
    twice its rate at the rate and at its multiples.
    """
    start = number("start", start, unit="s")
    length = number("stop", stop, above=start, unit="s") - start
    count = int(length / BIN)
    if count < SHORTEST or len(trains) == 0:
        raise InputError(
            f"trains, start, stop: expected one spike train or more and {SHORTEST * BIN:g} s or "
            f"more, received {len(trains)} and {length:.3g} s"
        )
    edges = start + BIN * np.arange(count + 1)
    each = [_spectrum(psth([times], edges), BIN) for times in trains]
    power = np.mean([one.amplitude**2 for one in each], axis=0)
    return Spectrum(each[0].frequency, np.sqrt(power))


def _spectrum(values: Array, step: float) -> Spectrum:
    """Return the spectrum of samples (n, ...) that are `step` s apart."""
    from scipy.signal import periodogram

    shown = {"nfft": FINER * len(values), "scaling": "spectrum", "axis": 0}
    frequency, power = periodogram(values, 1 / step, window="hann", detrend="linear", **shown)
    # The power of a sinusoid is half of the square of its amplitude.
    return Spectrum(frequency[1:], np.sqrt(2 * power[1:]))
