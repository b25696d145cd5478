"""The motions of a scene: ramps, holds, sinusoids and samples, of depth in mm or force in N.

Each final class holds its own fields, and a shape of `motion_shapes.py` made of them; what motions
have in common is in their abstract base `Motion`.
"""

from abc import ABC, abstractmethod
from dataclasses import KW_ONLY, dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.scene import motion_shapes as shapes
from fefinger.scene.trajectory import Trajectory
from fefinger.support.checks import InputError, number, numbers
from fefinger.support.csv_columns import read_columns


Array = NDArray[np.float64]

LONGEST = 1e9
"""s: a rest of thirty years, beyond which nothing is learned."""

LIMITS: dict[str, dict[str, Any]] = {
    "speed": {"above": 0, "unit": "mm/s"},
    "loading_rate": {"above": 0, "unit": "N/s"},
    "depth": {"above": 0, "unit": "mm"},
    "preload": {"above": 0, "unit": "mm"},
    "held": {"at_least": 0, "at_most": LONGEST, "unit": "s"},
    "seconds": {"above": 0, "at_most": LONGEST, "unit": "s"},
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

APPROACH = 10.0
"""Speed in mm/s with which a vibrating probe takes its preload; it has left no trace when the
vibration begins."""

MOST_CYCLES = 1_000_000
"""Largest number of cycles of a vibration; far fewer have the time steps that memory holds."""

_AS_LONG_AS_FITS: Any = None


@dataclass(frozen=True)
class Motion(ABC):
    """A motion of the indenter; its depth in mm or its force in N follows `trajectory`.

    Every number is checked; the messages call the fields "motion.depth" and so on.
    """

    kind: ClassVar[str]
    control: ClassVar[shapes.Quantity]

    @property
    @abstractmethod
    def shape(self) -> shapes.Shape:
        """The motion in time, without its unit."""

    def __post_init__(self) -> None:
        """Check every field, then build the trajectory, which finds corners that are too long."""
        given = self._check_fields()
        if "corner" in given and given["corner"] is _AS_LONG_AS_FITS:
            self._set(corner=min(CORNER, *self.shape.corner_limits))
        if "cycles" in given:
            self._set(cycles=_whole(given["cycles"]))
        _ = self.trajectory

    def _check_fields(self) -> dict[str, Any]:
        """Store every number that its limits allow; return the fields by name."""
        given = {}
        for name in (each.name for each in fields(self)):
            given[name] = getattr(self, name)
            if not (name == "corner" and given[name] is _AS_LONG_AS_FITS):
                given[name] = number(f"motion.{name}", given[name], **LIMITS[name])
                self._set(**{name: given[name]})
        return given

    def _set(self, **values: Any) -> None:
        """Store fields while a frozen motion is made."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @cached_property
    def trajectory(self) -> Trajectory:
        """The motion as quadratics in time."""
        return self.shape.trajectory()

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

    @property
    def recorded_from(self) -> float:
        """Time in s from which spikes count: after the preparation of an experiment."""
        return 0.0

    def value(self, t: ArrayLike) -> Array:
        """Return the depth in mm or the force in N at the times `t` in s."""
        value = self.trajectory.value(t)
        # No force that is asked for is below 0 N, but a ramp back to 0 may round to one.
        return np.maximum(value, 0.0) if self.control == "force" else value

    def rate(self, t: ArrayLike) -> Array:
        """Return the speed in mm/s or the rate in N/s at the times `t` in s."""
        return self.trajectory.rate(t)


def _whole(cycles: float) -> int:
    """Return a number of cycles as an int, or raise InputError if it is not a whole one."""
    if cycles != int(cycles):
        msg = f"motion.cycles: expected a whole number of cycles, received {cycles:g}"
        raise InputError(msg)
    return int(cycles)


class SampledMotion(Motion):
    """Times in s from 0 on, and a column named as `control`; straight lines between them."""

    time: tuple[float, ...]
    corner: float

    @property
    def shape(self) -> shapes.SamplesShape:
        """Straight lines between the samples."""
        return shapes.SamplesShape(
            self.control, self.time, getattr(self, self.control), self.corner
        )

    def _check_fields(self) -> dict[str, Any]:
        self._set(corner=number("motion.corner", self.corner, **LIMITS["corner"]))
        for name in ("time", self.control):
            self._set(**{name: numbers(f"motion.{name}", getattr(self, name))})
        return {}

    @classmethod
    def from_csv(cls, file: str | Path, *, corner: float = 0.0) -> Self:
        """Read the columns time (s) and depth (mm) or force (N), named in the first line."""
        time, values = read_columns("motion.file", Path(file), ("time", cls.control))
        columns: dict[str, Any] = {"time": time, cls.control: values, "corner": corner}
        return cls(**columns)


@final
@dataclass(frozen=True)
class Ramp(Motion):
    """A ramp from rest at `speed` mm/s to `depth` mm, which ends while moving."""

    kind = "ramp"
    control = "depth"

    speed: float
    depth: float
    _: KW_ONLY
    corner: float = _AS_LONG_AS_FITS

    @property
    def shape(self) -> shapes.RampShape:
        """One straight line."""
        return shapes.RampShape(self.speed, self.depth, self.corner)


@final
@dataclass(frozen=True)
class RampHold(Motion):
    """A ramp at `speed` mm/s to `depth` mm, and then a rest of `hold` s."""

    kind = "ramp-hold"
    control = "depth"

    speed: float
    depth: float
    _: KW_ONLY
    hold: float
    corner: float = _AS_LONG_AS_FITS

    @property
    def shape(self) -> shapes.RampHoldShape:
        """A line and a rest."""
        return shapes.RampHoldShape(self.speed, self.depth, self.hold, self.corner)


@final
@dataclass(frozen=True)
class Trapezoid(Motion):
    """A ramp at `speed` mm/s to `depth` mm, a rest of `hold` s, and the same ramp back to 0."""

    kind = "trapezoid"
    control = "depth"

    speed: float
    depth: float
    _: KW_ONLY
    hold: float
    corner: float = _AS_LONG_AS_FITS

    @property
    def shape(self) -> shapes.TrapezoidShape:
        """Two lines and the rest between them."""
        return shapes.TrapezoidShape(self.speed, self.depth, self.hold, self.corner)


@final
@dataclass(frozen=True)
class RampSinusoid(Motion):
    """A ramp at `speed` mm/s to `depth` mm, `settle` s of rest, then a sine about that depth.

    The sine starts upward (`cycles` whole ones of `amplitude` mm at `frequency` Hz); its amplitude
    rises over `corner` s, which keeps the speed continuous, or is there at once if corner is 0.
    An amplitude above `depth` lifts the indenter off the finger.
    """

    kind = "ramp-sinusoid"
    control = "depth"

    speed: float
    depth: float
    _: KW_ONLY
    amplitude: float
    frequency: float
    cycles: int
    settle: float = 0.0
    corner: float = _AS_LONG_AS_FITS

    @property
    def shape(self) -> shapes.RampSinusoidShape:
        """A line, a rest and a sine."""
        base = shapes.RampHoldShape(self.speed, self.depth, self.settle, self.corner)
        return shapes.RampSinusoidShape(
            self.control, base, self.amplitude, self.frequency, self.cycles
        )


@final
@dataclass(frozen=True)
class Sinusoid(Motion):
    """Depths amplitude (1 - cos(2 pi frequency t)) in mm: from first touch, at rest at both ends.

    `amplitude` in mm is half of the largest depth, `frequency` in Hz, `cycles` whole ones (Pawluk
    1997, Eq. 4.1 and 4.2 as appendix B starts them).
    """

    kind = "sinusoid"
    control = "depth"

    amplitude: float
    frequency: float
    cycles: int

    @property
    def shape(self) -> shapes.SinusoidShape:
        """A sine."""
        return shapes.SinusoidShape(self.amplitude, self.frequency, self.cycles)


@final
@dataclass(frozen=True)
class Vibration(Motion):
    """A preload of `preload` mm, held for `held` s, then a sine about it for `seconds`.

    The experiment of vibrotaction: spikes count from the start of the sine, when the units have
    adapted to the preload. The sine (whole cycles of `amplitude` mm at `frequency` Hz, one or more)
    starts upward; its amplitude rises over `corner` s.
    """

    kind = "vibration"
    control = "depth"

    preload: float
    _: KW_ONLY
    amplitude: float
    frequency: float
    seconds: float = 1.0
    held: float = 120.0
    corner: float = _AS_LONG_AS_FITS

    @property
    def shape(self) -> shapes.RampSinusoidShape:
        """A line, a rest and a sine."""
        base = shapes.RampHoldShape(APPROACH, self.preload, self.held, self.corner)
        cycles = max(1, round(min(self.seconds * self.frequency, 1e18)))
        if cycles > MOST_CYCLES:
            msg = (
                f"motion.frequency: expected at most {MOST_CYCLES:g} cycles in motion.seconds, "
                f"received {self.frequency:g} Hz for {self.seconds:g} s"
            )
            raise InputError(msg)
        return shapes.RampSinusoidShape(self.control, base, self.amplitude, self.frequency, cycles)

    @property
    def recorded_from(self) -> float:
        """The start of the sine in s."""
        return self.shape.base.trajectory().duration


@final
@dataclass(frozen=True)
class Sampled(SampledMotion):
    """Depths in mm at times in s, joined by straight lines, rounded only if a corner is given.

    The times start at 0 and increase; below a depth of 0 the indenter is off the finger.
    """

    kind = "sampled"
    control = "depth"

    time: tuple[float, ...]
    corner: float = field(default=0.0, kw_only=True)
    depth: tuple[float, ...]


@final
@dataclass(frozen=True)
class ForceRamp(Motion):
    """A ramp of the force from 0 at `loading_rate` N/s to `force` N, which ends while rising."""

    kind = "force-ramp"
    control = "force"

    loading_rate: float
    force: float
    _: KW_ONLY
    corner: float = _AS_LONG_AS_FITS

    @property
    def shape(self) -> shapes.RampShape:
        """One straight line."""
        return shapes.RampShape(self.loading_rate, self.force, self.corner)


@final
@dataclass(frozen=True)
class ForceRampHold(Motion):
    """A ramp of the force at `loading_rate` N/s to `force` N, and then `hold` s at that force."""

    kind = "force-ramp-hold"
    control = "force"

    loading_rate: float
    force: float
    _: KW_ONLY
    hold: float
    corner: float = _AS_LONG_AS_FITS

    @property
    def shape(self) -> shapes.RampHoldShape:
        """A line and a rest."""
        return shapes.RampHoldShape(self.loading_rate, self.force, self.hold, self.corner)


@final
@dataclass(frozen=True)
class ForceTrapezoid(Motion):
    """A ramp of the force at `loading_rate` N/s to `force` N, `hold` s there, and back to 0."""

    kind = "force-trapezoid"
    control = "force"

    loading_rate: float
    force: float
    _: KW_ONLY
    hold: float
    corner: float = _AS_LONG_AS_FITS

    @property
    def shape(self) -> shapes.TrapezoidShape:
        """Two lines and the rest between them."""
        return shapes.TrapezoidShape(self.loading_rate, self.force, self.hold, self.corner)


@final
@dataclass(frozen=True)
class ForceRampSinusoid(Motion):
    """As `RampSinusoid`, with a force in N at `loading_rate` N/s; amplitude below the force."""

    kind = "force-ramp-sinusoid"
    control = "force"

    loading_rate: float
    force: float
    _: KW_ONLY
    amplitude: float
    frequency: float
    cycles: int
    settle: float = 0.0
    corner: float = _AS_LONG_AS_FITS

    @property
    def shape(self) -> shapes.RampSinusoidShape:
        """A line, a rest and a sine."""
        base = shapes.RampHoldShape(self.loading_rate, self.force, self.settle, self.corner)
        return shapes.RampSinusoidShape(
            self.control, base, self.amplitude, self.frequency, self.cycles
        )


@final
@dataclass(frozen=True)
class ForceSinusoid(Motion):
    """As `Sinusoid`, with forces in N: from none to twice the amplitude."""

    kind = "force-sinusoid"
    control = "force"

    amplitude: float
    frequency: float
    cycles: int

    @property
    def shape(self) -> shapes.SinusoidShape:
        """A sine."""
        return shapes.SinusoidShape(self.amplitude, self.frequency, self.cycles)


@final
@dataclass(frozen=True)
class ForceSampled(SampledMotion):
    """Forces in N, none below 0, at times in s, joined by straight lines."""

    kind = "force-sampled"
    control = "force"

    time: tuple[float, ...]
    corner: float = field(default=0.0, kw_only=True)
    force: tuple[float, ...]


MOTIONS: dict[str, type[Motion]] = {
    motion.kind: motion
    for motion in (
        Ramp,
        RampHold,
        RampSinusoid,
        Sinusoid,
        Trapezoid,
        Vibration,
        Sampled,
        ForceRamp,
        ForceRampHold,
        ForceRampSinusoid,
        ForceSinusoid,
        ForceTrapezoid,
        ForceSampled,
    )
}
