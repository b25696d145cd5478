"""Shapes of motions in time: ramp, hold, trapezoid, sinusoid, sweep.

A shape is abstract: `motions.py` has its two final classes, of depth in mm and of force in N.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fefinger.scene.motion import Motion
from fefinger.scene.trajectory import Sweep, Trajectory, Wave
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


CORNER = 0.01
"""Default corner of the ramps in s, the rounding of Pawluk (1997), section 4.3.5; shorter where a
part of the motion is."""

AS_LONG_AS_FITS: Any = None
"""Default of the field `corner`: CORNER, or less."""

ANSWERED = 200
"""Frequencies at which a sweep is answered in closed form."""


class RampMotion(Motion):
    """A ramp from rest to a depth or a force, which ends while moving."""

    corner: float

    @property
    def level(self) -> float:
        """Depth in mm or force in N at the end of the ramp."""
        return float(getattr(self, self.control))

    @property
    def steady_level(self) -> float:
        """The level of the ramp."""
        return self.level

    @property
    def ramp_duration(self) -> float:
        """Length of the ramp in s, with sharp corners."""
        pace = getattr(self, "loading_rate" if self.control == "force" else "speed")
        return float(self.level / pace)

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """Lengths in s that a corner should not exceed: the ramp, and what follows it."""
        return (self.ramp_duration,)

    def _checked(self, name: str) -> Any:
        if name == "corner" and self.corner is AS_LONG_AS_FITS:  # the last field
            return min(CORNER, *self.corner_limits)
        return super()._checked(name)

    @cached_property
    def trajectory(self) -> Trajectory:
        """The ramp."""
        times = [0, self.ramp_duration]
        return Trajectory.through(times, [0, self.level], corner=self.corner, stop=False)

    def ramp_and_rest(self, hold: float) -> Trajectory:
        """Return the ramp, and a rest of `hold` s after its corner."""
        rest = hold + self.corner / 2
        ramp = self.ramp_duration
        times, levels = [0, ramp, ramp + rest], [0, self.level, self.level]
        if rest == 0:
            times, levels = times[:2], levels[:2]
        return Trajectory.through(times, levels, corner=self.corner, stop=False)


def rest_limit(hold: float) -> tuple[float, ...]:
    """Return twice the length of a rest in s, the longest corner before it; none without rest."""
    return (2 * hold,) if hold else ()


class RampHoldMotion(RampMotion):
    """A ramp and a rest of `hold` s."""

    hold: float

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The length of the ramp in s, and twice that of the rest."""
        return self.ramp_duration, *rest_limit(self.hold)

    @cached_property
    def trajectory(self) -> Trajectory:
        """Ramp and rest."""
        return self.ramp_and_rest(self.hold)


class TrapezoidMotion(RampMotion):
    """A ramp, a rest of `hold` s and the same ramp back to 0."""

    hold: float

    @cached_property
    def trajectory(self) -> Trajectory:
        """Both ramps and the rest."""
        ramp, rest = self.ramp_duration, self.hold + self.corner
        times, levels = [0, ramp, ramp + rest, 2 * ramp + rest], [0, self.level, self.level, 0]
        if rest == 0:
            times, levels = [0, ramp, 2 * ramp], [0, self.level, 0]
        return Trajectory.through(times, levels, corner=self.corner, stop=True)


class RampSinusoidMotion(RampMotion):
    """A ramp, a rest of `settle` s, and `cycles` of a sine about the level of the ramp."""

    amplitude: float
    frequency: float
    cycles: int
    settle: float

    @property
    def settle_duration(self) -> float:
        """Length of the rest in s."""
        return self.settle

    @property
    def n_cycles(self) -> int:
        """Number of cycles of the sine."""
        return self.cycles

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The lengths in s of the ramp and of the sine, and twice that of the rest."""
        return self.ramp_duration, *rest_limit(self.settle_duration), self.n_cycles / self.frequency

    @cached_property
    def trajectory(self) -> Trajectory:
        """Ramp, rest and sine; InputError for a force that would pull."""
        longest = self.n_cycles / self.frequency
        if self.corner > longest:
            raise InputError(
                f"motion.corner: expected at most the length of the sinusoid, {longest:g} s, "
                f"received {self.corner:g}; 0 starts it at once"
            )
        if self.control == "force" and self.amplitude >= self.level:
            raise InputError(
                f"motion.amplitude: expected less than the mean force of {self.level:g} N, "
                f"received {self.amplitude:g}; a contact cannot pull"
            )
        base = self.ramp_and_rest(self.settle_duration)
        wave = Wave(base.duration, self.amplitude, self.frequency, self.corner)
        return base.followed_by(wave, self.n_cycles)


class SweepMotion(RampMotion):
    """A ramp, a rest of `settle` s, and a sine about its level that runs through frequencies."""

    amplitude: float
    start: float
    stop: float
    seconds: float
    settle: float

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The lengths in s of the ramp and of the sine, and twice that of the rest."""
        return self.ramp_duration, *rest_limit(self.settle), self.seconds

    @property
    def frequencies(self) -> Array:
        """Frequencies (ANSWERED,) in Hz from `start` to `stop`, even per octave."""
        return np.geomspace(self.start, self.stop, ANSWERED)

    @property
    def recorded_from(self) -> float:
        """The start of the sine in s."""
        return self.ramp_and_rest(self.settle).duration

    @cached_property
    def trajectory(self) -> Trajectory:
        """Ramp, rest and sine; InputError for an amplitude that leaves the finger."""
        if self.amplitude >= self.level:
            raise InputError(
                f"motion.amplitude: expected less than the preload of {self.level:g} {self.unit}, "
                f"received {self.amplitude:g}; a sweep stays in contact"
            )
        base, highest = self.ramp_and_rest(self.settle), max(self.start, self.stop)
        wave = Sweep(
            start=base.duration,
            amplitude=self.amplitude,
            frequency=highest,
            rise=self.corner,
            first=self.start,
            last=self.stop,
            length=self.seconds,
        )
        return base.followed_by(wave, self.seconds * highest)


@dataclass(frozen=True)
class SinusoidMotion(Motion):
    """`cycles` of a sine from nothing to twice its amplitude, at rest at both ends."""

    amplitude: float
    frequency: float
    cycles: int

    @property
    def steady_level(self) -> float:
        """The mean: one amplitude."""
        return self.amplitude

    @cached_property
    def trajectory(self) -> Trajectory:
        """The sine."""
        wave = Wave(0.0, self.amplitude, self.frequency, 0.0, phase=-np.pi / 2)
        level, still = np.array([self.amplitude]), np.zeros(1)
        return Trajectory(still, level, still, still, self.cycles / self.frequency, wave)
