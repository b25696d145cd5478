"""What the motions share: their checks and their shapes in time, of depth in mm or force in N."""

from dataclasses import KW_ONLY, dataclass, fields
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.scene.trajectory import Trajectory, Wave
from fefinger.support.checks import InputError, number, numbers
from fefinger.support.csv_columns import read_columns


Array = NDArray[np.float64]

LONGEST = 1e9
"""s: a rest of thirty years, beyond which nothing is learned."""

LIMITS: dict[str, dict[str, Any]] = {
    "speed": {"above": 0, "unit": "mm/s"},
    "loading_rate": {"above": 0, "unit": "N/s"},
    "depth": {"above": 0, "unit": "mm"},
    "force": {"above": 0, "unit": "N"},
    "hold": {"at_least": 0, "at_most": LONGEST, "unit": "s"},
    "settle": {"at_least": 0, "at_most": LONGEST, "unit": "s"},
    "corner": {"at_least": 0, "unit": "s"},
    "amplitude": {"above": 0},
    "frequency": {"above": 0, "unit": "Hz"},
    "cycles": {"at_least": 1},
}

CORNER = 0.01
"""Default corner of the ramps in s, the rounding of Pawluk (1997), section 4.3.5; shorter where a
part of the motion is."""

_AS_LONG_AS_FITS: Any = None


@dataclass(frozen=True)
class Motion:
    """A motion of the indenter; its depth in mm or its force in N follows `trajectory`.

    Every number is checked; the messages call the fields "motion.depth" and so on.
    """

    kind: ClassVar[str]
    control: ClassVar[Literal["depth", "force"]]

    def __post_init__(self) -> None:
        """Check every field, then build the trajectory."""
        for field in fields(self):
            limits, given = LIMITS.get(field.name), getattr(self, field.name)
            free = field.name == "corner" and given is _AS_LONG_AS_FITS
            if limits is not None and not free:
                value = number(f"motion.{field.name}", given, **limits)
                object.__setattr__(self, field.name, value)
        if getattr(self, "corner", 0.0) is _AS_LONG_AS_FITS:
            object.__setattr__(self, "corner", min(CORNER, *self._parts()))
        self._check()

    def _parts(self) -> tuple[float, ...]:
        """Return what bounds a corner in s: the ramp, and what follows it."""
        pace, level = self._leg()
        return (level / pace,)

    def _check(self) -> None:
        """Build the trajectory, which finds corners that are too long."""
        _ = self.trajectory

    def _build(self) -> Trajectory:
        raise NotImplementedError

    def _leg(self) -> tuple[float, float]:
        """Return the pace of the ramp and the level that it reaches."""
        raise NotImplementedError

    @cached_property
    def trajectory(self) -> Trajectory:
        """The motion as quadratics in time."""
        return self._build()

    @property
    def duration(self) -> float:
        """Length of the motion in s."""
        return self.trajectory.duration

    @property
    def peak(self) -> float:
        """Largest depth in mm, or largest force in N."""
        return self.trajectory.peak

    @property
    def breaks(self) -> tuple[float, ...]:
        """Times in s at which a derivative jumps, the start and the end among them."""
        return self.trajectory.breaks

    @property
    def moving(self) -> tuple[tuple[float, float], ...]:
        """Intervals (t0, t1) in s in which the depth or the force changes."""
        return self.trajectory.moving

    def value(self, t: ArrayLike) -> Array:
        """Return the depth in mm or the force in N at the times `t` in s."""
        value = self.trajectory.value(t)
        # No force that is asked for is below 0 N, but a ramp back to 0 may round to one.
        return np.maximum(value, 0.0) if self.control == "force" else value

    def rate(self, t: ArrayLike) -> Array:
        """Return the speed in mm/s or the rate in N/s at the times `t` in s."""
        return self.trajectory.rate(t)


@dataclass(frozen=True)
class DepthMotion(Motion):
    """Moved at `speed` mm/s to `depth` mm."""

    control = "depth"

    speed: float
    depth: float

    def _leg(self) -> tuple[float, float]:
        return self.speed, self.depth


@dataclass(frozen=True)
class ForceMotion(Motion):
    """Pushed at `loading_rate` N/s to `force` N."""

    control = "force"

    loading_rate: float
    force: float

    def _leg(self) -> tuple[float, float]:
        return self.loading_rate, self.force


@dataclass(frozen=True)
class RampShape(Motion):
    """A ramp from rest, which ends while moving."""

    _: KW_ONLY
    corner: float = _AS_LONG_AS_FITS

    def _build(self) -> Trajectory:
        pace, level = self._leg()
        return Trajectory.through([0, level / pace], [0, level], corner=self.corner, stop=False)


@dataclass(frozen=True)
class RampHoldShape(Motion):
    """A ramp and a rest of `hold` s."""

    _: KW_ONLY
    hold: float
    corner: float = _AS_LONG_AS_FITS

    def _parts(self) -> tuple[float, ...]:
        return (*super()._parts(), *([2 * self.hold] if self.hold else []))

    def _build(self) -> Trajectory:
        return _ramp_hold(*self._leg(), self.hold, self.corner)


def _ramp_hold(pace: float, level: float, hold: float, corner: float) -> Trajectory:
    top, rest = level / pace, hold + corner / 2
    times, levels = ([0, top, top + rest], [0, level, level]) if rest else ([0, top], [0, level])
    return Trajectory.through(times, levels, corner=corner, stop=False)


@dataclass(frozen=True)
class TrapezoidShape(Motion):
    """A ramp, a rest of `hold` s and the same ramp back."""

    _: KW_ONLY
    hold: float
    corner: float = _AS_LONG_AS_FITS

    def _build(self) -> Trajectory:
        pace, level = self._leg()
        top, rest = level / pace, self.hold + self.corner
        times, levels = [0, top, top + rest, 2 * top + rest], [0, level, level, 0]
        if rest == 0:
            times, levels = [0, top, 2 * top], [0, level, 0]
        return Trajectory.through(times, levels, corner=self.corner, stop=True)


@dataclass(frozen=True)
class RampSinusoidShape(Motion):
    """A ramp, a rest of `settle` s and a sine about that level."""

    _: KW_ONLY
    amplitude: float
    frequency: float
    cycles: int
    settle: float = 0.0
    corner: float = _AS_LONG_AS_FITS

    def _parts(self) -> tuple[float, ...]:
        rest = [2 * self.settle] if self.settle else []
        return (*super()._parts(), self.cycles / self.frequency, *rest)

    def _check(self) -> None:
        _whole(self)
        longest = self.cycles / self.frequency
        if self.corner > longest:
            msg = (
                f"motion.corner: expected at most the length of the sinusoid, {longest:g} s, "
                f"received {self.corner:g}; 0 starts it at once"
            )
            raise InputError(msg)
        level = self._leg()[1]
        if self.control == "force" and self.amplitude >= level:
            msg = (
                f"motion.amplitude: expected less than the mean force of {level:g} N, "
                f"received {self.amplitude:g}; a contact cannot pull"
            )
            raise InputError(msg)
        super()._check()

    def _build(self) -> Trajectory:
        base = _ramp_hold(*self._leg(), self.settle, self.corner)
        wave = Wave(base.duration, self.amplitude, self.frequency, self.corner)
        return base.followed_by(wave, self.cycles)


@dataclass(frozen=True)
class SinusoidShape(Motion):
    """A sine from nothing to twice its amplitude, at rest at both ends."""

    amplitude: float
    frequency: float
    cycles: int

    def _check(self) -> None:
        _whole(self)
        super()._check()

    def _build(self) -> Trajectory:
        wave = Wave(0.0, self.amplitude, self.frequency, 0.0, phase=-np.pi / 2)
        return Trajectory.level(self.amplitude, wave, self.cycles)


def _whole(motion: RampSinusoidShape | SinusoidShape) -> None:
    """Store the number of cycles as an int, once it is a whole one."""
    if motion.cycles != int(motion.cycles):
        msg = f"motion.cycles: expected a whole number of cycles, received {motion.cycles:g}"
        raise InputError(msg)
    object.__setattr__(motion, "cycles", int(motion.cycles))


@dataclass(frozen=True)
class SampledMotion(Motion):
    """Times in s from 0 on, and a column named as `control`; straight lines between them."""

    time: tuple[float, ...]
    _: KW_ONLY
    corner: float = 0.0

    @property
    def _column(self) -> tuple[float, ...]:
        """The depths or the forces."""
        values: tuple[float, ...] = getattr(self, self.control)
        return values

    def __post_init__(self) -> None:
        """Check the corner, the times and the values."""
        corner = number("motion.corner", self.corner, **LIMITS["corner"])
        object.__setattr__(self, "corner", corner)
        for name in ("time", self.control):
            object.__setattr__(self, name, numbers(f"motion.{name}", getattr(self, name)))
        self._check()

    def _check(self) -> None:
        time, values, name = self.time, self._column, self.control
        if len(time) != len(values) or len(time) < 2:
            msg = (
                f"motion.{name}: expected as many values as times, at least 2, "
                f"received {len(values)} values and {len(time)} times"
            )
            raise InputError(msg)
        if time[0] != 0:
            msg = (
                f"motion.time: expected times that start at 0 s, received {time[0]:g} first; "
                "subtract it from all of them"
            )
            raise InputError(msg)
        for i, (before, after) in enumerate(pairwise(time), start=1):
            if after <= before:
                msg = (
                    f"motion.time[{i}]: expected a time above {before!r} s, received {after!r}; "
                    "sort the samples and keep one of each time"
                )
                raise InputError(msg)
        if max(values) <= 0:
            msg = (
                f"motion.{name}: expected a value above 0, received at most {max(values):g}; "
                "so the indenter never touches the finger"
            )
            raise InputError(msg)
        if name == "force" and min(values) < 0:
            msg = (
                f"motion.force: expected forces of at least 0 N, received {min(values):g}; "
                "a contact cannot pull"
            )
            raise InputError(msg)
        super()._check()

    def _build(self) -> Trajectory:
        return Trajectory.through(self.time, self._column, corner=self.corner, stop=False)

    @classmethod
    def from_csv(cls, file: str | Path, *, corner: float = 0.0) -> Self:
        """Read the columns time (s) and depth (mm) or force (N), named in the first line."""
        time, values = read_columns("motion.file", Path(file), ("time", cls.control))
        columns: dict[str, Any] = {"time": time, cls.control: values}
        return cls(corner=corner, **columns)
