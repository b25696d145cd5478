"""Ramp-and-hold records: where the hold is, smoothing, derivative and averages of samples."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.theory.lumped import Spring, force
from fefinger.theory.relaxation import Prony


Array = NDArray[np.float64]

SMOOTHING = 9  # samples of the moving average (Pawluk 1997, section 2.4.1)
FEWEST = 20  # samples that the ramp in contact and the hold need each
RAMP_POINTS = 400  # averages that are fitted on the ramp, at most
HOLD_RATIO = 1.03  # of the ends of successive averages in the hold
REACHED = 0.98  # part of the travel above which the indenter is near its hold
STILL = 2e-3  # part of the travel within which a hold stays
STRAY = 6.0  # standard deviations of smoothed noise that are not travel, in 1e5 samples


@dataclass(frozen=True)
class RampHold:
    """A checked record: time (n_t,) s, position (n_t,) mm, force (n_t,) N, and its parts.

    `touch` is the first sample that is surely in contact, `hold` the first of the hold; the record
    ends with the hold. `force_noise` in N and `position_noise` in mm are those of one sample.
    """

    time: Array
    position: Array
    force: Array
    touch: int
    hold: int
    force_noise: float
    position_noise: float

    @property
    def hold_seconds(self) -> float:
        """Length of the hold in s."""
        return float(self.time[-1] - self.time[self.hold])


def split(time: ArrayLike, position: ArrayLike, force: ArrayLike) -> RampHold:
    """Return a record with its ramp and hold found.

    Raises
    ------
    ValueError
        Shapes that do not match, times that do not increase, values that are not finite, no
        contact, no hold, or fewer than 20 samples in the ramp in contact or in the hold.
    """
    time, position, force = (np.asarray(values, float) for values in (time, position, force))
    _check(time, position, force)
    noise = _noise(position)
    smoothed = smooth(position)
    low, high = float(smoothed.min()), float(smoothed.max())
    reached = smoothed > low + REACHED * (high - low)
    level = float(np.median(smoothed[reached]))
    tolerance = max(STRAY * noise / np.sqrt(SMOOTHING), STILL * (high - low))
    away = np.abs(smoothed - level)
    hold = int(np.argmax(away <= tolerance))
    left = np.flatnonzero(away[hold:] > 2 * tolerance)  # twice: noise at the way in is no way out
    end = hold + int(left[0]) if left.size else len(time)
    above = np.flatnonzero(smooth(force)[:hold] < 0.02 * force[:end].max())
    touch = int(above[-1]) + 1 if above.size else 0
    for name, count in (("ramp in contact", hold - touch), ("hold", end - hold)):
        if count < FEWEST:
            apart = 1e3 * float(np.median(np.diff(time)))
            msg = (
                f"{name}: expected at least {FEWEST} samples, found {count}, one every "
                f"{apart:.3g} ms; the record needs a fast ramp into the finger and then a rest at "
                "that position, both sampled often enough"
            )
            raise ValueError(msg)
    return RampHold(
        time=time[:end],
        position=position[:end],
        force=force[:end],
        touch=touch,
        hold=hold,
        force_noise=_noise(force[hold:end]),
        position_noise=noise,
    )


def _check(time: Array, position: Array, force: Array) -> None:
    if time.ndim != 1 or not time.shape == position.shape == force.shape:
        msg = (
            f"record: expected time, position and force of one shape (n_t,), "
            f"received {time.shape}, {position.shape} and {force.shape}"
        )
        raise ValueError(msg)
    if len(time) < 2 * FEWEST:
        msg = f"record: expected at least {2 * FEWEST} samples, received {len(time)}"
        raise ValueError(msg)
    if not all(np.isfinite(values).all() for values in (time, position, force)):
        msg = "record: expected finite numbers in every sample"
        raise ValueError(msg)
    if np.any(np.diff(time) <= 0):
        msg = "record: expected times that increase from sample to sample"
        raise ValueError(msg)
    if force.max() <= 0 or np.ptp(position) == 0:
        msg = "record: expected a force above 0 and a position that changes, found no contact"
        raise ValueError(msg)


def smooth(values: Array, width: int = SMOOTHING) -> Array:
    """Return the symmetric moving average over `width` samples, fewer at the ends."""
    window = np.ones(width)
    return np.convolve(values, window, "same") / np.convolve(np.ones_like(values), window, "same")


def derivative(x: Array, y: Array) -> Array:
    """Return dy/dx (n - 4,) at the inner points by the polynomial through 5 points.

    The points need not be equally spaced; it is exact for polynomials up to degree 4.

    Raises
    ------
    ValueError
        Fewer than 5 points, or two equal x among 5 neighbors.
    """
    if len(x) < 5:
        msg = f"derivative: expected at least 5 points, received {len(x)}"
        raise ValueError(msg)
    near, values = (np.lib.stride_tricks.sliding_window_view(v, 5) for v in (x, y))
    apart = near[:, :, None] - near[:, None, :]
    equal = np.eye(5, dtype=bool)
    if np.any(apart[:, ~equal] == 0):
        msg = "derivative: expected positions that differ among 5 neighbors; smooth them first"
        raise ValueError(msg)
    center, others = 2, [0, 1, 3, 4]
    slope = (1.0 / apart[:, center, others]).sum(axis=1) * values[:, center]
    for j in others:
        rest = [k for k in others if k != j]
        numerator = np.prod(apart[:, center][:, rest], axis=1)
        denominator = np.prod(apart[:, j][:, [*rest, center]], axis=1)
        slope = slope + values[:, j] * numerator / denominator
    return slope


def averages(record: RampHold) -> tuple[Array, Array, Array, Array]:
    """Return time, position and force averaged over groups of samples, and the size of each group.

    The position is smoothed before (ramp and hold apart, to keep the corner), because a fit that
    takes noise for travel is biased.
    Single samples early in the hold, then groups whose length grows with the time since its start
    (3 %, so that an exponential changes by less than 5e-5 of itself within one); before the hold
    even groups, at most 400 from touch on.
    """
    ramp = _even(0, record.touch, RAMP_POINTS) + _even(record.touch, record.hold, RAMP_POINTS)
    starts, at = ramp, 0
    length = len(record.time) - record.hold
    while at < length:
        starts.append(record.hold + at)
        at = max(at + 1, int(at * HOLD_RATIO))
    size = np.diff([*starts, len(record.time)]).astype(float)
    time, position, force = (
        np.add.reduceat(values, starts) / size
        for values in (record.time, smooth_position(record), record.force)
    )
    return time, position, force, size


def smooth_position(record: RampHold) -> Array:
    """Return the position by straight lines through 9 points, of the ramp and of the hold."""
    from scipy.signal import savgol_filter

    parts = np.split(record.position, [record.hold])
    return np.concatenate([savgol_filter(part, SMOOTHING, 1, mode="interp") for part in parts])


def _even(start: int, stop: int, most: int) -> list[int]:
    count = min(stop - start, most)
    return np.linspace(start, stop, count, endpoint=False).astype(int).tolist() if count else []


def accounted(measured: Array, model: Array) -> float:
    """Return the variance accounted for, 1 - mse of Eq. 2.5; 1 is a perfect model."""
    about_mean = float(np.sum((measured - measured.mean()) ** 2))
    return 1.0 - float(np.sum((measured - model) ** 2)) / about_mean


def mse(record: RampHold, spring: Spring, prony: Prony) -> float:
    """Return the mse of Eq. 2.5 as a fraction; the thesis gives it in percent.

    The model moves by the smoothed position: at 6 N/mm, 3 um of noise would count as 18 mN.
    """
    model = force(spring, prony, record.time, smooth_position(record))
    return 1.0 - accounted(record.force, model)


def _noise(values: Array) -> float:
    """Return the standard deviation of white noise on a slow signal, from its second differences.

    The median keeps corners and steps out of it.
    """
    second = np.diff(values, 2)
    return float(np.median(np.abs(second - np.median(second)))) / (0.6745 * np.sqrt(6.0))
