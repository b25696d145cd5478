"""A value in time in closed form: quadratics joined at breakpoints, and at most one sine on top."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


_STRAIGHT = 1e-9
"""Change of slope, relative to the steeper one beside a knot, below which it is no corner."""

_ROUNDING = 16 * float(np.finfo(float).eps)
"""Relative error of times and values that is rounding: a last segment that short is no motion."""


_SHORTEST = 1024 * float(np.finfo(float).eps)
"""Length of a segment in motion over the time at its end, below which too few digits of the length
are left: their rounding changes the slope by a thousandth."""


@dataclass(frozen=True, eq=False)
class Wave:
    """A sine that starts at `start` s and rises to its amplitude over `rise` s (a cubic step).

    `phase`: of the sine at its start, in radians; a rise of 0 starts it at its amplitude.
    """

    start: float
    amplitude: float
    frequency: float
    rise: float
    phase: float = 0.0

    def value(self, t: Array) -> Array:
        """Return the wave (...,) in mm or N at the times `t` (...,) in s."""
        tau = np.maximum(t - self.start, 0.0)
        envelope, _ = self._envelope(tau)
        return self.amplitude * envelope * np.sin(self.angle(tau))

    def rate(self, t: Array) -> Array:
        """Return the derivative (...,) of the wave per s at times `t` (...,), from the right."""
        tau = np.maximum(t - self.start, 0.0)
        envelope, slope = self._envelope(tau)
        angle = self.angle(tau)
        speed = envelope * self._omega(tau) * np.cos(angle) + slope * np.sin(angle)
        return self.amplitude * np.where(t >= self.start, speed, 0.0)

    def angle(self, tau: Array) -> Array:
        """Return the phase (...,) in radians at times `tau` (...,) in s after the start."""
        return self._omega(tau) * tau + self.phase

    def _omega(self, tau: Array) -> Array:
        """Angular frequency in 1/s, the derivative of the angle."""
        return np.full_like(tau, 2 * np.pi * self.frequency)

    @property
    def last_frequency(self) -> float:
        """Frequency in Hz with which it ends."""
        return self.frequency

    @property
    def first_crest(self) -> float:
        """Cycles from the start to the first crest of the sine, at most 1."""
        return (0.25 - self.phase / (2 * np.pi)) % 1.0

    def last_crest(self, end: float) -> float:
        """Return the time in s of the last crest before `end`, than which none is higher.

        While the envelope rises, a crest lies up to a quarter of a cycle after the sine's.
        """
        count = max(np.floor((end - self.start) * self.frequency - self.first_crest), 0.0)
        low = self.start + (self.first_crest + count) / self.frequency
        if low >= self.start + self.rise:
            return float(low)
        high = min(low + 0.25 / self.frequency, end)
        # After 50 bisections of a quarter of a cycle only rounding is left.
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (middle, high) if self.rate(np.array(middle)) > 0 else (low, middle)
        return float(high)

    def crests(self, end: float) -> Array:
        """Return times in s of crests before `end`, among them the highest."""
        last = min(end - self.start, self.rise + 1 / self.frequency)
        first = self.first_crest
        crests = np.arange(first, last * self.frequency + first, 1.0) / self.frequency
        return np.append(self.start + crests, self.last_crest(end))

    def _envelope(self, tau: Array) -> tuple[Array, Array]:
        if self.rise == 0:
            return np.ones_like(tau), np.zeros_like(tau)
        x = np.minimum(tau / self.rise, 1.0)
        return x * x * (3 - 2 * x), 6 * x * (1 - x) / self.rise


@dataclass(frozen=True, eq=False)
class Sweep(Wave):
    """A sine whose frequency rises, or falls, evenly per octave within `length` s.

    From `first` Hz to `last` Hz; `frequency` is the higher of both.
    """

    first: float = 1.0
    last: float = 1.0
    length: float = 1.0

    @property
    def last_frequency(self) -> float:
        """Frequency in Hz with which it ends."""
        return self.last

    def crests(self, end: float) -> Array:
        """Return times in s close to the crests before `end`."""
        cycles = float(self.angle(np.array(min(end - self.start, self.length)))) / (2 * np.pi)
        counts = np.arange(0.25, cycles, 1.0)
        if self._growth == 0.0:
            return self.start + counts / self.first
        return self.start + np.log1p(self._growth * counts / self.first) / self._growth

    @property
    def _growth(self) -> float:
        return float(np.log(self.last / self.first)) / self.length

    def angle(self, tau: Array) -> Array:
        """Return the phase (...,) in radians at times `tau` (...,) in s after the start."""
        growth = self._growth
        cycles = tau if growth == 0.0 else np.expm1(growth * tau) / growth
        return np.asarray(2 * np.pi * self.first * cycles)

    def _omega(self, tau: Array) -> Array:
        return np.asarray(2 * np.pi * self.first * np.exp(self._growth * tau))


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Piecewise quadratic motion from 0 to `duration` s, with at most one wave on top.

    start, value0, rate0, bend (n,): on segment i the value is
    value0 + rate0 tau + bend tau^2 / 2 with tau = t - start. It rests before 0 and after the end.
    """

    start: Array
    value0: Array
    rate0: Array
    bend: Array
    duration: float
    wave: Wave | None = None

    @classmethod
    def through(
        cls, times: ArrayLike, values: ArrayLike, *, corner: float, stop: bool
    ) -> "Trajectory":
        """Join knots by straight lines, with a parabola of `corner` s about every kink.

        Starting from rest is a kink, and so is stopping at the end if `stop`. The first parabola
        begins at t = 0, so a corner delays every knot by corner / 2 and no level is missed.
        """
        t, y = np.asarray(times, float), np.asarray(values, float)
        if not np.all(np.diff(t) > np.where(np.diff(y) == 0, 0.0, _SHORTEST * t[1:])):
            raise InputError(
                f"motion: expected parts longer than rounding, received knots at "
                f"{t.tolist()} s; change the speed or the hold"
            )
        with np.errstate(over="ignore"):
            slope = np.diff(y) / np.diff(t)
        before = np.concatenate([[0.0], slope])
        after = np.concatenate([slope, [0.0 if stop else slope[-1]]])
        _check_pace(np.abs(slope).max(), corner)
        kink = _kinks(t, y, before, after)
        # The parabolas about two kinks must not overlap, nor the last one go beyond the end.
        longest = float(np.diff(t[kink]).min(initial=np.inf))
        if kink.any() and not kink[-1]:
            longest = min(longest, float(2 * (t[-1] - t[kink][-1])))
        if corner > longest * (1 + _STRAIGHT):
            raise InputError(
                f"motion.corner: expected at most {longest:.6g} s, the shortest straight part, "
                f"received {corner:g}; take a shorter one, or 0 for sharp ones"
            )
        least = _SHORTEST * float(t[kink].max(initial=0.0))
        if 0 < corner < least:
            raise InputError(
                f"motion.corner: expected at least {least:.3g} s, above rounding, or 0 for sharp "
                f"ones, received {corner:g}"
            )
        # About a kink with a corner a parabola, and then a line; else a line alone.
        rounded = kink & (corner > 0)
        begins = np.flatnonzero((kink | (np.arange(len(t)) == 0)) & ~rounded)
        delay = np.where(begins > 0, corner / 2, 0.0)
        lines = t[begins] + delay, y[begins], after[begins], np.zeros(len(begins))
        at, low, high = t[rounded], before[rounded], after[rounded]
        bend = (high - low) / corner if corner > 0 else np.zeros(len(at))
        bends = at, y[rounded] - low * corner / 2, low, bend
        ends = at + corner, y[rounded] + high * corner / 2, high, np.zeros(len(at))
        table = np.concatenate([np.column_stack(part) for part in (lines, ends, bends)])
        table = table[np.argsort(table[:, 0], kind="stable")]
        end = float(t[-1] + (corner if kink[-1] else corner / 2))
        table = table[end - table[:, 0] > _ROUNDING * end]
        return cls(table[:, 0], table[:, 1], table[:, 2], table[:, 3], end)

    def followed_by(self, wave: Wave, cycles: float) -> "Trajectory":
        """Return this trajectory with `cycles` of `wave` about its last value at its end."""
        end = self.duration
        return Trajectory(
            start=np.append(self.start, end),
            value0=np.append(self.value0, self.value(end)),
            rate0=np.append(self.rate0, 0.0),
            bend=np.append(self.bend, 0.0),
            duration=end + cycles / wave.frequency,
            wave=wave,
        )

    def value(self, t: ArrayLike) -> Array:
        """Return the value at the times `t` in s, of any shape."""
        at = np.clip(np.asarray(t, float), 0.0, self.duration)
        i = self._segment(at)
        tau = at - self.start[i]
        value = self.value0[i] + (self.rate0[i] + 0.5 * self.bend[i] * tau) * tau
        return value if self.wave is None else value + self.wave.value(at)

    def rate(self, t: ArrayLike) -> Array:
        """Return the derivative per s at the times `t`, from the right (at the end, the left)."""
        at = np.asarray(t, float)
        i = self._segment(at)
        rate = self.rate0[i] + self.bend[i] * (at - self.start[i])
        if self.wave is not None:
            rate = rate + self.wave.rate(at)
        return np.where((at >= 0) & (at <= self.duration), rate, 0.0)

    def _segment(self, t: Array) -> NDArray[np.intp]:
        return np.clip(np.searchsorted(self.start, t, side="right") - 1, 0, None)

    @cached_property
    def breakpoints(self) -> tuple[float, ...]:
        """Times in s at which a derivative jumps, the start and the end among them."""
        times = {0.0, *self.start.tolist(), self.duration}
        if self.wave is not None:
            times |= {self.wave.start, self.wave.start + self.wave.rise}
        return tuple(sorted(times))

    @property
    def moving(self) -> tuple[tuple[float, float], ...]:
        """Intervals (t0, t1) in s in which the value changes; one may begin where another ends."""
        ends = np.append(self.start[1:], self.duration)
        moves = (self.rate0 != 0) | (self.bend != 0)
        if self.wave is not None:
            moves |= self.start >= self.wave.start
        return tuple(zip(self.start[moves].tolist(), ends[moves].tolist(), strict=True))

    @cached_property
    def peak(self) -> float:
        """The largest value."""
        bent = self.bend != 0
        turns = self.start[bent] - self.rate0[bent] / self.bend[bent]
        ends = np.append(self.start[1:], self.duration)[bent]
        turns = turns[(turns > self.start[bent]) & (turns < ends)]
        times = np.concatenate([self.breakpoints, turns])
        if self.wave is not None:
            times = np.concatenate([times, self.wave.crests(self.duration)])
        return float(self.value(times).max())


def _check_pace(steepest: float, corner: float) -> None:
    """Raise InputError for a slope per s, or a corner in s, whose squares are no numbers."""
    fastest = 1e100  # largest slope and bend, whose squares are still numbers
    if not steepest <= fastest:
        raise InputError(
            f"motion: expected a speed of at most {fastest:g} per s, received {steepest:.3g}; "
            "check whether times are in s"
        )
    if 0 < corner < steepest / fastest:
        raise InputError(
            f"motion.corner: expected at least {steepest / fastest:.3g} s, or 0 for sharp ones, "
            f"received {corner:g}"
        )


def _kinks(t: Array, y: Array, before: Array, after: Array) -> NDArray[np.bool_]:
    """Knots (n,) at which the slope changes, but for changes by rounding or that lead nowhere.

    Against the steepest slope of the whole motion, a jump would hide all that is slow.
    """
    length = np.diff(t)
    longer = np.maximum(np.append(length[0], length), np.append(length, length[-1]))
    steeper = np.maximum(np.abs(before), np.abs(after))
    rounding = _ROUNDING * (t / longer * steeper + np.abs(y) / longer)
    kinks = np.asarray(np.abs(after - before) > _STRAIGHT * steeper + rounding)
    bent = np.flatnonzero(kinks[:-1])
    # A knot that is closer to the line before it is on that line.
    ends, tolerance = np.append(bent, len(t) - 1)[1:], 1e-12 * float(np.abs(y).max())
    last, slope = 0, 0.0
    for knot, end in zip(bent.tolist(), ends.tolist(), strict=True):
        kinks[knot] = abs(y[last] + slope * (t[end] - t[last]) - y[end]) > tolerance
        if kinks[knot]:
            last, slope = knot, after[knot]
    return kinks
