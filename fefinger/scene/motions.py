"""The motions of a scene that are given by numbers: ramps, holds, sinusoids, sweeps.

Motions of samples are in `samples.py`, those across the direction of travel in `sliding.py`.
"""

from abc import abstractmethod
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Annotated, Any, final

import numpy as np

from fefinger.scene.key import Key, check
from fefinger.scene.motion import Motion
from fefinger.scene.trajectory import Sweep, Trajectory, Wave
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import Control


CORNER = 0.01
"""Default corner of the ramps in s, the rounding of Pawluk (1997), section 4.3.5; shorter where a
part of the motion is."""

AS_LONG_AS_FITS: Any = None
"""Default of the field `corner`: CORNER, or less."""

SWEEP_FREQUENCIES = 200
"""Frequencies at which a sweep is answered in closed form."""

APPROACH = 10.0
"""Speed in mm/s, or rate in N/s, with which a vibrating probe takes its preload; it has left no
trace when the vibration begins."""

APPROACHES = (APPROACH, APPROACH)


class Ramped(Motion):
    """A motion that begins with a ramp from rest to a depth or a force."""

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
        return float(self.level / getattr(self, self.control.pace))

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """Lengths in s that a corner should not exceed: the ramp, and what follows it."""
        return (self.ramp_duration,)

    def __post_init__(self) -> None:
        """Check every field, and make the corner as long as fits where it is left out."""
        check(self)
        self._complete()
        if self.corner is AS_LONG_AS_FITS:
            object.__setattr__(self, "corner", min(CORNER, *self.corner_limits))
        _ = self.trajectory

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


@final
@dataclass(frozen=True)
class Ramp(Ramped):
    """A ramp from rest, which ends while moving.

    At `speed` mm/s to `depth` mm, or at `loading_rate` N/s to `force` N.
    """

    shape = "ramp"

    speed: float | None = None
    depth: float | None = None
    _: KW_ONLY
    loading_rate: float | None = None
    force: float | None = None
    corner: float = AS_LONG_AS_FITS

    @cached_property
    def trajectory(self) -> Trajectory:
        """The ramp."""
        times = [0, self.ramp_duration]
        return Trajectory.through(times, [0, self.level], corner=self.corner, stop=False)


@final
@dataclass(frozen=True)
class RampHold(Ramped):
    """A ramp, and then a rest of `hold` s at its end.

    At `speed` mm/s to `depth` mm, or at `loading_rate` N/s to `force` N.
    """

    shape = "ramp-hold"

    speed: float | None = None
    depth: float | None = None
    _: KW_ONLY
    loading_rate: float | None = None
    force: float | None = None
    hold: float
    corner: float = AS_LONG_AS_FITS

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The length of the ramp in s, and twice the length of the rest."""
        return self.ramp_duration, *rest_limit(self.hold)

    @cached_property
    def trajectory(self) -> Trajectory:
        """Ramp and rest."""
        return self.ramp_and_rest(self.hold)


@final
@dataclass(frozen=True)
class Trapezoid(Ramped):
    """A ramp, a rest of `hold` s, and the same ramp back to 0.

    At `speed` mm/s to `depth` mm, or at `loading_rate` N/s to `force` N.
    """

    shape = "trapezoid"

    speed: float | None = None
    depth: float | None = None
    _: KW_ONLY
    loading_rate: float | None = None
    force: float | None = None
    hold: float
    corner: float = AS_LONG_AS_FITS

    @cached_property
    def trajectory(self) -> Trajectory:
        """Both ramps and the rest."""
        ramp, rest = self.ramp_duration, self.hold + self.corner
        times, levels = [0, ramp, ramp + rest, 2 * ramp + rest], [0, self.level, self.level, 0]
        if rest == 0:
            times, levels = [0, ramp, 2 * ramp], [0, self.level, 0]
        return Trajectory.through(times, levels, corner=self.corner, stop=True)


class Vibrating(Ramped):
    """A ramp, a rest, and whole cycles of a sine about the level of the ramp."""

    amplitude: float
    frequency: float

    @property
    @abstractmethod
    def rest(self) -> float:
        """Length of the rest in s."""

    @property
    @abstractmethod
    def n_cycles(self) -> int:
        """Number of cycles of the sine."""

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The lengths in s of the ramp and of the sine, and twice the length of the rest."""
        return self.ramp_duration, *rest_limit(self.rest), self.n_cycles / self.frequency

    @cached_property
    def trajectory(self) -> Trajectory:
        """Ramp, rest and sine; InputError for a force that would pull."""
        longest = self.n_cycles / self.frequency
        if self.corner > longest:
            raise InputError(
                f"motion.corner: expected at most the length of the sinusoid, {longest:g} s, "
                f"received {self.corner:g}; 0 starts it at once"
            )
        if self.by_force and self.amplitude >= self.level:
            raise InputError(
                f"motion.amplitude: expected less than the mean force of {self.level:g} N, "
                f"received {self.amplitude:g}; a contact cannot pull"
            )
        base = self.ramp_and_rest(self.rest)
        wave = Wave(base.duration, self.amplitude, self.frequency, self.corner)
        return base.followed_by(wave, self.n_cycles)


@final
@dataclass(frozen=True)
class RampSinusoid(Vibrating):
    """A ramp, `settle` s of rest, then a sine about the level that the ramp reached.

    The ramp goes at `speed` mm/s to `depth` mm, or at `loading_rate` N/s to `force` N. The sine
    starts upward (`cycles` whole ones of `amplitude` mm or N at `frequency` Hz); its amplitude
    rises over `corner` s, which keeps the speed continuous, or is there at once if corner is 0.
    An amplitude above `depth` lifts the indenter off the finger; one of a force is less than it.
    """

    shape = "ramp-sinusoid"

    speed: float | None = None
    depth: float | None = None
    _: KW_ONLY
    loading_rate: float | None = None
    force: float | None = None
    amplitude: float
    frequency: float
    cycles: int
    settle: float = 0.0
    corner: float = AS_LONG_AS_FITS

    @property
    def rest(self) -> float:
        """Length of the rest in s."""
        return self.settle

    @property
    def n_cycles(self) -> int:
        """Number of cycles of the sine."""
        return self.cycles


@final
@dataclass(frozen=True)
class Vibration(Vibrating):
    """A preload of `preload` mm, held for `held` s, then a sine about it for `seconds`.

    The experiment of vibrotaction: spikes count from the start of the sine, when the units have
    adapted to the preload. The sine (whole cycles of `amplitude` mm at `frequency` Hz, one or more)
    starts upward; its amplitude rises over `corner` s.
    """

    shape = "vibration"

    preload: float
    _: KW_ONLY
    amplitude: float
    frequency: float
    seconds: float = 1.0
    held: float = 120.0
    corner: float = AS_LONG_AS_FITS

    @property
    def level(self) -> float:
        """The preload in mm."""
        return self.preload

    @property
    def ramp_duration(self) -> float:
        """Length of the approach in s."""
        return self.preload / APPROACH

    @property
    def rest(self) -> float:
        """Length of the hold in s."""
        return self.held

    @property
    def n_cycles(self) -> int:
        """Number of cycles: whole ones, nearest to `seconds`."""
        cycles = self.seconds * self.frequency
        # Largest number of cycles of a vibration; far fewer have the time steps that memory holds.
        most_cycles = 1_000_000
        if cycles > most_cycles:
            raise InputError(
                f"motion.frequency: expected at most {most_cycles:g} cycles in motion.seconds, "
                f"received {self.frequency:g} Hz for {self.seconds:g} s"
            )
        return max(1, round(cycles))

    @property
    def recorded_from(self) -> float:
        """The start of the sine in s."""
        return self.ramp_and_rest(self.held).duration


@final
@dataclass(frozen=True)
class FrequencySweep(Ramped):
    """A preload, and a sine about it from `start` Hz to `stop` Hz in `seconds`.

    The preload is `depth` mm, approached at `speed` mm/s, or `force` N at `loading_rate` N/s; the
    `amplitude` in mm or N is less. The frequency changes evenly per octave, after a rest of
    `settle` s. The result has the harmonic answer about the preload as well.
    """

    shape = "sweep"

    depth: float | None = None
    _: KW_ONLY
    force: float | None = None
    amplitude: float
    start: float
    stop: float
    seconds: float = 2.0
    settle: float = 1.0
    speed: Annotated[
        float | None,
        Key("Speed", unit="mm/s", above=0, control=Control.DEPTH, usual=APPROACHES),
    ] = None
    loading_rate: Annotated[
        float | None,
        Key("Rate of the force", unit="N/s", above=0, control=Control.FORCE, usual=APPROACHES),
    ] = None
    corner: float = AS_LONG_AS_FITS

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The lengths in s of the ramp and of the sine, and twice the length of the rest."""
        return self.ramp_duration, *rest_limit(self.settle), self.seconds

    @property
    def frequencies(self) -> Array:
        """Frequencies (SWEEP_FREQUENCIES,) in Hz from `start` to `stop`, even per octave."""
        return np.geomspace(self.start, self.stop, SWEEP_FREQUENCIES)

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


@final
@dataclass(frozen=True)
class Sinusoid(Motion):
    """`cycles` of amplitude (1 - cos(2 pi frequency t)): from first touch, at rest at both ends.

    `amplitude` is half of the largest depth in mm or, with control = "force", of the largest force
    in N; `frequency` in Hz, `cycles` whole ones (Pawluk 1997, Eq. 4.1 and 4.2 as appendix B starts
    them).
    """

    shape = "sinusoid"

    amplitude: float
    frequency: float
    cycles: int
    _: KW_ONLY
    control: Control = Control.DEPTH

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
