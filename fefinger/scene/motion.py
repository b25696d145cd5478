"""Base class of the motions of the indenter, and their shapes in time: ramps, sinusoids, sweeps.

Messages call the fields "motion.depth" and so on. A shape is abstract: `motions.py` has its two
final classes, of depth in mm and of force in N. Shapes with samples are in `samples.py`, those with
a path in `sliding.py`.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from fefinger.scene.indenter import Inclined
from fefinger.scene.key import Key, check
from fefinger.scene.trajectory import Sweep, Trajectory, Wave
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


LONGEST = 1e9
"""Longest time in s that a motion may hold or last: thirty years."""

SAME = 1e-12
"""Part of the duration by which times of two trajectories are the same but for rounding."""

CORNER = 0.01
"""Default corner of the ramps in s, the rounding of Pawluk (1997), section 4.3.5; shorter where a
part of the motion is."""

AS_LONG_AS_FITS: Any = None
"""Default of the field `corner`: CORNER, or less."""

ANSWERED = 200
"""Frequencies at which a sweep is answered in closed form."""

SECONDS: dict[str, Any] = {"unit": "s", "at_least": 0, "at_most": LONGEST}

KEYS = {
    "speed": Key("Speed", unit="mm/s", above=0),
    "depth": Key("Travel after first touch", unit="mm", above=0),
    "loading_rate": Key("Rate of the force", unit="N/s", above=0),
    "force": Key("Force", unit="N", above=0),
    "hold": Key("Rest after the ramp", **SECONDS),
    "corner": Key(
        "Time over which the speed changes at a corner; 0 makes it sharp", unit="s", at_least=0
    ),
    "amplitude": Key("Amplitude of the depth or of the force", unit="mm or N", above=0),
    "frequency": Key("Frequency", unit="Hz", above=0),
    "cycles": Key("Number of whole cycles", at_least=1),
    "settle": Key("Rest before the sine or the slide", **SECONDS),
    "preload": Key("Depth that is held before the vibration", unit="mm", above=0),
    "held": Key("Rest at the preload before the sine, in which units adapt", **SECONDS),
    "seconds": Key("Length of the vibration", unit="s", above=0, at_most=LONGEST),
    "start": Key("First frequency", unit="Hz", above=0),
    "stop": Key("Last frequency", unit="Hz", above=0),
    "distance": Key("Distance of a pass", unit="mm", above=0),
    "direction": Key(
        "Direction of the first pass: 0 moves the object distally, 90 radially",
        unit="degrees",
        at_least=-360,
        at_most=360,
    ),
    "passes": Key("Number of passes; every second one returns", at_least=1, at_most=1000),
    "approach": Key(
        "Speed of the press before the slide, or rate of the force", unit="mm/s or N/s", above=0
    ),
}
"""Keys of the motions, which mean the same in all of them."""


@dataclass(frozen=True)
class Motion(ABC):
    """A motion of the indenter; its depth in mm or its force in N follows `trajectory`."""

    table: ClassVar[str] = "motion"
    common: ClassVar[Mapping[str, Key]] = KEYS

    kind: ClassVar[str]
    control: ClassVar[Literal["depth", "force"]] = "depth"
    """What it prescribes, and the name of the field that holds it."""

    slides: ClassVar[bool] = False
    """Whether it has a path across the direction of travel."""

    straight: ClassVar[bool] = False
    """Whether that path is a line, along which it has a `heading`."""

    @cached_property
    @abstractmethod
    def trajectory(self) -> Trajectory:
        """The motion as quadratics in time; InputError for numbers that do not fit together."""

    def __post_init__(self) -> None:
        """Check every field, then build the trajectory, which finds corners that are too long."""
        check(self)
        _ = self.trajectory

    @property
    def turns_plate(self) -> bool:
        """Whether a plate turns on its path."""
        return False

    def inclines(self, t: ArrayLike, plate: Inclined) -> Array:
        """Return the slopes (..., 2) of a plate that turns, over the plane across its travel.

        It moves along the normal of `plate`, and is level where it has the angles of that.
        """
        return np.zeros((*np.shape(t), 2))

    def heading(self, t: ArrayLike) -> Array:
        """Return the direction (..., 2) in which a plate slides: a unit vector at full speed.

        It is shorter below full speed, stays as it was where the plate stops, and is zero without
        a slide along a line.
        """
        return np.zeros((*np.shape(t), 2))

    @property
    def unit(self) -> str:
        """Unit of what is controlled: mm of depth or N of force."""
        return "N" if self.control == "force" else "mm"

    @property
    def wave_frequency(self) -> float | None:
        """Frequency in Hz of the sine in the motion; None without one."""
        wave = self.trajectory.wave
        return None if wave is None else wave.frequency

    @property
    def highest_frequency(self) -> float | None:
        """Highest frequency in Hz of an oscillation in the motion; None without one."""
        return self.wave_frequency

    @property
    def path_frequency(self) -> float | None:
        """Highest frequency in Hz of an oscillation across the travel; None without one."""
        return None

    @property
    def frequencies(self) -> Array | None:
        """Frequencies (n_f,) in Hz whose harmonic answer belongs to the result; None for most."""
        return None

    @property
    def sample_rate(self) -> float | None:
        """Samples per s of a motion of samples; None of others."""
        return None

    @property
    def noise(self) -> float:
        """Root mean square in mm or N of noise in a motion of samples."""
        return 0.0

    @property
    def missing(self) -> tuple[tuple[float, float], ...]:
        """Times (start, stop) in s between which samples are missing, in a vibration or not."""
        return ()

    @property
    def pulling(self) -> float:
        """Largest force in N below 0 among samples, which counts as 0."""
        return 0.0

    @property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Times (start, stop) in s between which samples of a vibration are missing."""
        return ()

    @property
    def steady_level(self) -> float:
        """Depth in mm or force in N about which the motion vibrates, or else its largest."""
        return self.peak

    @property
    def oscillation_amplitude(self) -> float:
        """Amplitude in mm or N of what vibrates, or else the whole motion."""
        return float(getattr(self, "amplitude", self.peak))

    @property
    def paths(self) -> tuple[Trajectory, ...]:
        """Trajectories in mm of what moves across the direction of travel; none by default."""
        return ()

    @property
    def duration(self) -> float:
        """Length of the motion in s."""
        return max(each.duration for each in (self.trajectory, *self.paths))

    @property
    def peak(self) -> float:
        """Largest depth in mm, or largest force in N."""
        return self.trajectory.peak

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times in s at which a derivative jumps, the start and the end among them."""
        every = sorted(t for each in (self.trajectory, *self.paths) for t in each.breakpoints)
        apart = np.diff(every, prepend=-np.inf) > (SAME if self.paths else 0.0) * self.duration
        return tuple(np.array(every)[apart].tolist())

    @property
    def moving(self) -> tuple[tuple[float, float], ...]:
        """Intervals (t0, t1) in s in which the depth or the force changes."""
        return merged(span for each in (self.trajectory, *self.paths) for span in each.moving)

    @property
    def recorded_from(self) -> float:
        """Time in s from which spikes count: after the preparation of an experiment."""
        return 0.0

    @property
    def mirrored(self) -> bool:
        """Whether it is its own mirror image in the medial plane."""
        return True

    def shift(self, t: ArrayLike) -> Array:
        """Return the place (..., 2) mm of the indenter across its travel at the times `t` in s."""
        return np.zeros((*np.shape(t), 2))

    def velocity(self, t: ArrayLike) -> Array:
        """Return its velocity (..., 2) mm/s across its travel at the times `t` in s."""
        return np.zeros((*np.shape(t), 2))

    def value(self, t: ArrayLike) -> Array:
        """Return the depth (...,) in mm or the force in N at the times `t` (...,) in s."""
        value = self.trajectory.value(t)
        # No prescribed force is below 0 N, but a ramp back to 0 may round to one.
        return np.maximum(value, 0.0) if self.control == "force" else value

    def vibration(self, t: ArrayLike) -> Array:
        """Return the part of the value that vibrates about its slow course, at the times `t` in s.

        (...,) in mm or N, of the shape of `t`; 0 in a motion without a vibration.
        """
        wave, at = self.trajectory.wave, np.asarray(t, float)
        if wave is None:
            return np.zeros_like(at)
        return wave.value(np.clip(at, 0.0, self.trajectory.duration))

    def rate(self, t: ArrayLike) -> Array:
        """Return the speed (...,) in mm/s or the rate in N/s at the times `t` (...,) in s."""
        return self.trajectory.rate(t)


def merged(spans: Iterable[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Union of intervals, sorted; those that touch are one."""
    union: list[tuple[float, float]] = []
    for start, stop in sorted(spans):
        if union and start <= union[-1][1]:
            union[-1] = (union[-1][0], max(stop, union[-1][1]))
        else:
            union.append((start, stop))
    return tuple(union)


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

    def __post_init__(self) -> None:
        """Check every field, and make the corner as long as fits where it is left out."""
        check(self)
        if self.corner is AS_LONG_AS_FITS:
            object.__setattr__(self, "corner", min(CORNER, *self.corner_limits))
        _ = self.trajectory

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
        """The length of the ramp in s, and twice the length of the rest."""
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
        """The lengths in s of the ramp and of the sine, and twice the length of the rest."""
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
        """The lengths in s of the ramp and of the sine, and twice the length of the rest."""
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
