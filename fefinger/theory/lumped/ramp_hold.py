"""Ramp-and-hold records: detection of ramp and hold, noise, smoothing, derivative, averages."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact.elastic import Array
from fefinger.theory.lumped.spring import Spring, force
from fefinger.theory.relaxation import Prony, exprel


SMOOTHING = 9  # samples of the moving average (Pawluk 1997, section 2.4.1)
FEWEST = 20  # smallest number of samples in the ramp in contact, and in the hold
RAMP_POINTS = 400  # largest number of averages on the ramp
STILL = 2e-3  # fraction of the travel within which a hold stays
STRAY = 6.0  # standard deviations that smoothed noise does not exceed in 1e5 samples
WHOLE = 1e-3  # tolerance, over the step, for differences of a rounded signal to be multiples of it
STEPPED = 0.5  # fraction of equal successive samples from which a force is read in steps
FILTERED = 0.01  # s after which filtered noise is uncorrelated


@dataclass(frozen=True)
class RampHold:
    """A checked record: time (n_t,) s, position (n_t,) mm, force (n_t,) N, and its parts.

    `touch`: first sample that is certainly in contact. `hold`: first sample of the hold, with which
    the record ends. `beyond`: first sample before the hold that is deeper than it, or `hold`.
    `force_noise` N and `position_noise` mm: standard deviations of one sample, with rounding.
    """

    time: Array
    position: Array
    force: Array
    touch: int
    hold: int
    beyond: int
    force_noise: float
    position_noise: float

    @property
    def hold_seconds(self) -> float:
        """Length of the hold in s."""
        return float(self.time[-1] - self.time[self.hold])

    @cached_property
    def averages(self) -> tuple[Array, Array, Array, Array]:
        """Averages (n,) of time, position and force over groups of samples, and the group sizes.

        The position is smoothed first (ramp and hold separately, to keep the corner), because
        position noise biases the fit. Groups are single samples early in the hold, then of a
        duration of 3 % of the time since its start (an exponential then changes by less than 5e-5
        within one); before the hold equal groups, at most 400 from touch on.
        """
        starts = group_starts(self, ((0, RAMP_POINTS), (self.touch, RAMP_POINTS)))
        size = np.diff([*starts, len(self.time)]).astype(float)
        time, position, force = (
            np.add.reduceat(values, starts) / size
            for values in (self.time, self.smooth_position, self.force)
        )
        return time, position, force, size

    @cached_property
    def smooth_position(self) -> Array:
        """The position (n_t,) mm, smoothed by local lines or cubics, ramp and hold separately.

        The window has as many points as nine averages of a ramp, or nine. The strongest smoothing
        that removes noise alone is used: none for a smooth start and stop with few samples.
        """
        ramp, rest = np.split(self.position, [self.hold])
        # | 1: a symmetric window has an odd number of points.
        wide = SMOOTHING * max(1, round((self.hold - self.touch) / RAMP_POINTS)) | 1
        noise = self.position_noise
        ways = ((wide, 1), (SMOOTHING, 1), (SMOOTHING, 3))
        return np.concatenate(
            [_denoised(ramp, noise, ways, self.touch), _denoised(rest, noise, ways[1:])]
        )


def split(time: ArrayLike, position: ArrayLike, force: ArrayLike) -> RampHold:
    """Check a record and find its ramp and hold.

    Raises ValueError for shapes that do not match, times that do not increase, values that are not
    finite, no contact, no hold, fewer than 20 samples in the ramp in contact or in the hold, or
    contact from the first sample on.
    """
    time, position, force = (np.asarray(values, float) for values in (time, position, force))
    _check(time, position, force)
    noise = _noise(position)
    beyond, hold, end = _hold(position, noise)
    largest = float(force[:end].max())
    above = np.flatnonzero(smooth(force)[:hold] < 0.02 * largest)
    touch = int(above[-1]) + 1 if above.size else 0
    _check_parts(time[:end], force[:end], touch, hold)
    _check_range(force[:end])
    force_noise = _held_noise(time[hold:end], force[hold:end])
    begun = 0.01  # first force, over the largest one, from which a record begins in contact
    if touch == 0 and force[0] > begun * largest + STRAY * force_noise:
        raise ValueError(
            f"force: expected a record that begins before touch, at 0 N, received {force[0]:.3g} N "
            "in its first sample; begin it before touch, and tare the force"
        )
    return RampHold(
        time=time[:end],
        position=position[:end],
        force=force[:end],
        touch=touch,
        hold=hold,
        beyond=beyond,
        force_noise=force_noise,
        position_noise=noise,
    )


def _check_parts(time: Array, force: Array, touch: int, hold: int) -> None:
    """Reject a force that begins below 0, and a record with too few samples of ramp or hold."""
    first = float(np.median(force[:SMOOTHING]))
    offset = 0.1  # largest offset below 0 of the first force, over the largest force
    if first < -offset * float(force.max()):
        msg = f"force: expected 0 N before touch, received {first:.3g} N; tare the force"
        raise ValueError(msg)
    for name, count in (("ramp in contact", hold - touch), ("hold", len(time) - hold)):
        if count <= 0:
            raise ValueError(
                f"{name}: expected a force that rises with the position, received one that does "
                "not; check that both columns are of this ramp and recorded at the same times"
            )
        if count < FEWEST:
            raise ValueError(
                f"{name}: expected at least {FEWEST} samples, received {count}, one every "
                f"{1e3 * float(np.median(np.diff(time))):.3g} ms; the record needs a fast ramp "
                "into the finger and then a rest at that position, both sampled often enough"
            )


def _check_range(force: Array) -> None:
    """Reject a force that stays at its largest value and then falls, as at the end of a range.

    A force that is read in steps is accepted.
    """
    largest = float(force.max())
    at_top = np.diff((force == largest).astype(np.int8), prepend=0)
    left = np.flatnonzero(at_top < 0)
    stays = left - np.flatnonzero(at_top > 0)[: len(left)]
    same = np.diff(force[(force > largest / 2) & (force < largest)]) == 0
    if stays.max(initial=0) >= FEWEST and same.size and same.mean() < STEPPED:
        raise ValueError(
            f"force: expected a peak, received {largest:.4g} N in {stays.max()} successive "
            "samples, as from a sensor at the end of its range; record within the range"
        )


def _hold(position: Array, noise: float) -> tuple[int, int, int]:
    """Find the first sample deeper than the hold, the first of the hold, and the one after its end.

    The hold is the longest rest. Overshoot before it belongs to the ramp.
    """
    smoothed = smooth(position)
    low, high = float(smoothed.min()), float(smoothed.max())
    levels = 50  # bins of the upper half of the travel; the hold is in the fullest one
    stays, edges = np.histogram(smoothed, levels, ((low + high) / 2, high))
    most = int(stays.argmax())
    reached = 0.98  # fraction of the travel from which the indenter is near its hold
    near = np.abs(smoothed - (edges[most] + edges[most + 1]) / 2) < (1 - reached) * (high - low)
    level = float(np.median(smoothed[near]))
    tolerance = max(STRAY * noise / np.sqrt(SMOOTHING), STILL * (high - low))
    away = np.abs(smoothed - level)
    # Twice the tolerance, so that noise at the entry does not end the rest.
    ends = np.flatnonzero(np.diff(away <= 2 * tolerance, prepend=False, append=False))
    if not ends.size:
        raise ValueError(
            f"hold: expected a rest of at least {FEWEST} samples at the end of the ramp, "
            "received a position that never rests; hold it, or cut the record to one ramp and hold"
        )
    start, end = max(ends.reshape(-1, 2).tolist(), key=lambda stay: stay[1] - stay[0])
    hold = start + int(np.argmax(away[start:end] <= tolerance))
    # The average shifts a sharp corner into the hold, so go back to the first sample at its level.
    first = max(hold - SMOOTHING // 2, 0)
    still = max(STRAY / 2 * noise, 1e-6 * (high - low))
    moving = np.flatnonzero(np.abs(position[first:hold] - level) > still)
    hold = first + int(moving[-1]) + 1 if moving.size else first
    over = smoothed[:hold] > level + 2 * tolerance
    return int(np.argmax(over)) if over.any() else hold, hold, end


def _check(time: Array, position: Array, force: Array) -> None:
    """Check shapes, number of samples, finite values, rising times and contact."""
    if time.ndim != 1 or not time.shape == position.shape == force.shape:
        raise ValueError(
            f"record: expected time, position and force of one shape (n_t,), "
            f"received {time.shape}, {position.shape} and {force.shape}"
        )
    if len(time) < 2 * FEWEST:
        raise ValueError(f"record: expected at least {2 * FEWEST} samples, received {len(time)}")
    if not all(np.isfinite(values).all() for values in (time, position, force)):
        raise ValueError("record: expected finite numbers in every sample")
    if np.any(np.diff(time) <= 0):
        raise ValueError("record: expected times that increase from sample to sample")
    if force.max() <= 0 or np.ptp(position) == 0:
        msg = "record: expected a force above 0 and a position that changes, received no contact"
        raise ValueError(msg)


def smooth(values: Array, width: int = SMOOTHING) -> Array:
    """Symmetric moving average over `width` samples, fewer at the ends."""
    window = np.ones(width)
    return np.convolve(values, window, "same") / np.convolve(np.ones_like(values), window, "same")


def free_samples(force: Array) -> int:
    """Return a number of samples certainly before contact, by which a force (n_t,) N is tared.

    Half of those up to the first that reads more: the first contact is faint.
    """
    smoothed = smooth(force)
    level = float(np.median(smoothed[:SMOOTHING]))
    noise = float(np.median(np.abs(np.diff(force)))) / (0.6745 * np.sqrt(2))
    # Part of the range of a force above its reading before touch from which it is in contact.
    left = 0.01
    limit = max(2 * noise, left * float(np.ptp(smoothed)))
    above = np.flatnonzero(np.abs(smoothed - level) > limit)
    return max(int(above[0]) - SMOOTHING, 0) // 2 if above.size else len(force)


def still_samples(position: Array) -> int:
    """Return a number of samples certainly before a position (n_t,) mm begins to move.

    Half of them, as of `free_samples`, whose force may wander by colored noise at rest.
    """
    smoothed = smooth(position)
    tolerance = max(STRAY * _noise(position) / np.sqrt(SMOOTHING), STILL * float(np.ptp(smoothed)))
    moving = np.flatnonzero(np.abs(smoothed - np.median(smoothed[:SMOOTHING])) > tolerance)
    return max(int(moving[0]) - SMOOTHING, 0) // 2 if moving.size else len(position)


def derivative(x: Array, y: Array) -> Array:
    """Return dy/dx (n - 4,) at the inner points, by the polynomial through 5 points.

    The points need not be equally spaced; it is exact for polynomials up to degree 4.

    Raises ValueError for fewer than 5 points, or two equal x among 5 neighbors.
    """
    if len(x) < 5:
        raise ValueError(f"derivative: expected at least 5 points, received {len(x)}")
    near, values = (np.lib.stride_tricks.sliding_window_view(v, 5) for v in (x, y))
    if np.any(np.diff(np.sort(near, axis=1), axis=1) == 0):
        msg = "derivative: expected positions that differ among 5 neighbors; smooth them first"
        raise ValueError(msg)
    apart = near - near[:, 2:3]
    width = np.abs(apart).max(axis=1)
    powers = (apart / width[:, None])[:, :, None] ** np.arange(5)
    return np.asarray(np.linalg.solve(powers, values[:, :, None])[:, 1, 0] / width)


def group_starts(record: RampHold, parts: Sequence[tuple[int, int]]) -> list[int]:
    """Return first samples of groups: by parts, then in the hold.

    parts: first sample and largest number of groups, of each part before the hold. In the hold a
    group lasts 3 % of the time since its start.
    """
    begins = [*(begin for begin, _ in parts), record.hold]
    starts = [
        start
        for (begin, most), stop in zip(parts, begins[1:], strict=True)
        for start in _even(begin, stop, most)
    ]
    since = record.time[record.hold :] - record.time[record.hold]
    at = 0
    hold_ratio = 1.03  # ratio of the times, since its start, of successive averages in the hold
    while at < len(since):
        starts.append(record.hold + at)
        at = max(at + 1, int(np.searchsorted(since, since[at] * hold_ratio, "right")) - 1)
    return starts


def _denoised(
    values: Array, noise: float, ways: tuple[tuple[int, int], ...], start: int = 0
) -> Array:
    """Smooth by the first of `ways` (points, degree) that keeps the signal after `start` unchanged.

    Test: smoothing twice distorts a signal about twice, but changes smoothed noise hardly.
    """
    from scipy.signal import savgol_filter

    for points, degree in ways:
        if points > len(values):
            continue
        once = savgol_filter(values, points, degree, mode="interp")
        twice = savgol_filter(once, points, degree, mode="interp")
        if np.abs(twice - once)[start:].max() <= noise * np.sqrt(SMOOTHING / points):
            return np.asarray(once)
    return values


def _even(start: int, stop: int, most: int) -> list[int]:
    """List the starts of at most `most` equal groups of the samples from `start` to `stop`."""
    count = min(stop - start, most)
    return np.linspace(start, stop, count, endpoint=False).astype(int).tolist() if count else []


def deviation_of(record: RampHold, spring: Spring, prony: Prony) -> Array:
    """Return the standard deviations (n,) N of the averages, from noise of force and position.

    The effect of position noise on the force of the model relaxes since the previous average.
    """
    time, x, f, size = record.averages
    passed = np.multiply.outer(np.diff(time, prepend=time[0]), np.array(prony.v))
    retained = prony.weights[0] + exprel(-passed) @ np.array(prony.weights[1:])
    stiffness = np.where(x > spring.x0, spring.stiffness(spring.force(x)), 0.0)
    sigma = np.hypot(record.force_noise, retained * stiffness * record.position_noise)
    return np.asarray(np.maximum(sigma, 1e-6 * f.max()) / np.sqrt(size))


def accounted(measured: Array, model: Array) -> float:
    """Variance accounted for, 1 - mse of Eq. 2.5; 1 for a perfect model."""
    about_mean = float(np.sum((measured - measured.mean()) ** 2))
    return 1.0 - float(np.sum((measured - model) ** 2)) / about_mean


def mse(record: RampHold, spring: Spring, prony: Prony) -> float:
    """Mean squared error of Eq. 2.5 as a fraction; the thesis gives it in percent.

    The model uses the smoothed position: at 6 N/mm, 3 um of noise would count as 18 mN.
    """
    model = force(spring, prony, record.time, record.smooth_position)
    return 1.0 - accounted(record.force, model)


def _noise(values: Array) -> float:
    """Estimate the standard deviation of white noise on a slow signal by second differences.

    The median excludes corners and steps. For a signal read in steps it is at least the noise of
    the rounding.
    """
    second = np.diff(values, 2)
    return max(_median_noise(second), _rounding(second, float(np.ptp(values))))


def _median_noise(second: Array) -> float:
    """Estimate the standard deviation of noise from second differences."""
    # 0.6745: median of |x| of a standard normal; 6 = 1 + 4 + 1: variance of a second difference.
    return float(np.median(np.abs(second - np.median(second)))) / (0.6745 * np.sqrt(6.0))


def _rounding(second: Array, size: float) -> float:
    """Estimate the standard deviation of rounding from the `second` differences of a signal.

    Those of a rounded signal are multiples of its step and alternate in sign. 0 for other signals.
    """
    steps = second[np.abs(second) > 1e-9 * size]
    turns = np.count_nonzero(steps[1:] * steps[:-1] < 0)
    if len(steps) < FEWEST or turns < len(steps) / 4:
        return 0.0
    step = float(np.abs(steps).min())
    whole = np.abs(steps / step - np.round(steps / step)) < WHOLE
    return step / np.sqrt(12.0) if whole.all() else 0.0


def _held_noise(time: Array, force: Array) -> float:
    """Estimate the standard deviation of the noise of a force in the hold.

    A filter before the sampling reduces differences of successive samples; the noise is then that
    of samples FILTERED s apart.
    """
    lag = int(FILTERED / float(np.median(np.diff(time))))
    near = _noise(force)
    if not 1 < lag < len(force) // (2 * FEWEST):
        return near
    far = _median_noise(force[2 * lag :] - 2 * force[lag:-lag] + force[: -2 * lag])
    # Ratio of noise over FILTERED to that between samples from which noise is filtered.
    colored = 1.3
    return far if far > colored * near else near
