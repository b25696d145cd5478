"""Statistics of spike trains: rates, intervals, histograms, phase locking and distances.

All take arrays of ascending spike times in s, as in `SpikeTrains.times`.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.trains import SpikeTrains
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number


def mean_rates(trains: SpikeTrains, start: float | None = None, stop: float | None = None) -> Array:
    """Return spikes per second of each unit from `start` up to `stop` s, (n_units,) Hz.

    By default from start to end of what was recorded, `t_start` and `t_stop` of the trains,
    which is the counted part where spikes before it were left out. InputError for times beyond:
    nothing is known of the spikes there.
    """
    first, last = trains.t_start, trains.t_stop
    start = number("start", first if start is None else start, unit="s")
    stop = number("stop", last if stop is None else stop, above=start, unit="s")
    # Time in s by which a window may extend beyond what was recorded: sums of steps round.
    rounding = 1e-9
    if start < first - rounding or stop > last + rounding:
        raise InputError(
            f"start, stop: expected times from {first:.6g} to {last:.6g} s, within which spikes "
            f"were recorded, received {start:.6g} to {stop:.6g} s"
        )
    start, stop = max(start, first), min(stop, last)
    return np.array([np.sum((t >= start) & (t < stop)) for t in trains.times]) / (stop - start)


def intervals(times: ArrayLike) -> Array:
    """Return the intervals (n - 1,) in s between n spikes."""
    return np.diff(_ascending(times))


def interval_variation(times: ArrayLike) -> float:
    """Return the coefficient of variation of the intervals; nan with fewer than two of them."""
    gaps = intervals(times)
    return float(gaps.std(ddof=1) / gaps.mean()) if len(gaps) > 1 else float("nan")


def psth(trials: Sequence[ArrayLike], edges: ArrayLike) -> Array:
    """Return the mean rate in Hz over trials, or over units, in each bin (n_bins,).

    edges: (n_bins + 1,) ascending s; a bin holds its left edge, the last one both.
    """
    edges = np.asarray(edges, float)
    increasing = edges.ndim == 1 and len(edges) > 1 and bool(np.all(np.diff(edges) > 0))
    if not (increasing and np.isfinite(edges).all()):
        msg = f"edges: expected two finite times in s or more that increase, received {edges}"
        raise InputError(msg)
    if len(trials) == 0:
        raise InputError("trials: expected one spike train or more, received none")
    counts = np.histogram(np.concatenate([_ascending(t) for t in trials]), edges)[0]
    return np.asarray(counts / (len(trials) * np.diff(edges)), np.float64)


class Locking(NamedTuple):
    """Phase locking of spikes to a cycle.

    strength: length of the mean of exp(2 pi i t / period), 0 to 1. phase: its angle, 0 to 360
    degrees of the cycle. chance: probability of at least this strength for spikes without a phase
    (Rayleigh test, Wilkie's approximation). spikes: their number; without spikes the rest is nan.
    """

    strength: float
    phase: float
    chance: float
    spikes: int


def locking(times: ArrayLike, frequency: float, *, start: float = 0.0) -> Locking:
    """Phase locking of spikes to a sinusoid of `frequency` Hz whose cycle begins at `start` s."""
    frequency = number("frequency", frequency, above=0.0, unit="Hz")
    start = number("start", start, unit="s")
    times = _ascending(times)
    n = len(times)
    if not n:
        return Locking(float("nan"), float("nan"), float("nan"), 0)
    mean = np.exp(2j * np.pi * frequency * (times - start)).mean()
    strength = float(min(abs(mean), 1.0))
    silent = n**2 * (1.0 - strength**2)
    chance = float(np.exp(np.sqrt(1.0 + 4.0 * n + 4.0 * silent) - (1.0 + 2.0 * n)))
    return Locking(strength, float(np.degrees(np.angle(mean)) % 360.0), min(chance, 1.0), n)


def per_cycle(times: ArrayLike, frequency: float, start: float, stop: float) -> float:
    """Return impulses per cycle of `frequency` Hz from `start` up to `stop` s."""
    frequency = number("frequency", frequency, above=0.0, unit="Hz")
    length = number("stop", stop, above=number("start", start), unit="s") - start
    times = _ascending(times)
    return float(np.sum((times >= start) & (times < stop)) / (frequency * length))


def van_rossum(a: ArrayLike, b: ArrayLike, tau: float) -> float:
    """Return the distance of van Rossum (2001), Neural Comput 13:751, between two trains.

    Each spike becomes exp(-(t - t_i) / tau) from t_i on; the distance is the square root of the
    integral of the squared difference over tau. One extra spike costs sqrt(1/2). tau in s.
    """
    tau = number("tau", tau, above=0.0, unit="s")
    times = np.concatenate([_ascending(a), _ascending(b)])
    sign = np.repeat([1.0, -1.0], [np.size(a), np.size(b)])
    order = np.argsort(times, kind="stable")
    times, sign = times[order], sign[order]
    decay = np.exp(-np.diff(times, prepend=times[:1]) / tau)
    total = trace = 0.0
    for s, fade in zip(sign, decay, strict=True):
        trace *= fade
        total += s * (trace + 0.5 * s)
        trace += s
    return float(np.sqrt(max(total, 0.0)))


def victor_purpura(a: ArrayLike, b: ArrayLike, cost: float) -> float:
    """Return the distance of Victor & Purpura (1996), J Neurophysiol 76:1310, between two trains.

    The cheapest way to turn one into the other: 1 to add or remove a spike, `cost` per s to move
    one. 0 compares counts; large costs compare coincidences.
    """
    cost = number("cost", cost, at_least=0.0, unit="1/s")
    first, second = _ascending(a), _ascending(b)
    row = np.arange(len(second) + 1, dtype=float)
    ones = np.arange(len(second) + 1, dtype=float)
    for i, time in enumerate(first):
        moved = row[:-1] + cost * np.abs(time - second)
        best = np.append(i + 1.0, np.minimum(row[1:] + 1.0, moved))
        # Adding spikes one by one is a running minimum of best[j] - j.
        row = np.minimum.accumulate(best - ones) + ones
    return float(row[-1])


def _ascending(times: ArrayLike) -> Array:
    """Check that spike times ascend and convert them to an array."""
    try:
        array = np.asarray(times, float)
    except (TypeError, ValueError):
        array = np.array(np.nan)
    if array.ndim != 1 or not np.isfinite(array).all() or np.any(np.diff(array) < 0):
        raise InputError("times: expected finite spike times in s that ascend")
    return array
