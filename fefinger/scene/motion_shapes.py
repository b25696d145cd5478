"""Shapes of motions in time, of depth in mm or force in N alike: numbers in, trajectories out.

A shape has no kind and no unit of its own: the motions of `motion.py` hold one. Its messages call
the numbers "motion.corner" and so on, as the motion does.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, Protocol

import numpy as np

from fefinger.scene.trajectory import Trajectory, Wave
from fefinger.support.checks import InputError


Quantity = Literal["depth", "force"]


class Shape(Protocol):
    """A shape of a motion."""

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """Lengths in s that a corner should not exceed: the ramp, and what follows it."""

    def trajectory(self) -> Trajectory:
        """Return the shape as quadratics in time; InputError for numbers that do not fit."""


@dataclass(frozen=True)
class RampShape:
    """A ramp from rest, at `pace` per s to `level`, which ends while moving."""

    pace: float
    level: float
    corner: float

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The length of the ramp in s."""
        return (self.level / self.pace,)

    def trajectory(self) -> Trajectory:
        """Return the ramp."""
        times, levels = [0, self.level / self.pace], [0, self.level]
        return Trajectory.through(times, levels, corner=self.corner, stop=False)


@dataclass(frozen=True)
class RampHoldShape:
    """A ramp at `pace` per s to `level`, and a rest of `hold` s."""

    pace: float
    level: float
    hold: float
    corner: float

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The length of the ramp in s, and twice that of the rest."""
        return (self.level / self.pace, *([2 * self.hold] if self.hold else []))

    def trajectory(self) -> Trajectory:
        """Return ramp and rest."""
        top, rest = self.level / self.pace, self.hold + self.corner / 2
        times, levels = [0, top, top + rest], [0, self.level, self.level]
        if rest == 0:
            times, levels = times[:2], levels[:2]
        return Trajectory.through(times, levels, corner=self.corner, stop=False)


@dataclass(frozen=True)
class TrapezoidShape:
    """A ramp at `pace` per s to `level`, a rest of `hold` s and the same ramp back to 0."""

    pace: float
    level: float
    hold: float
    corner: float

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The length of the ramp in s."""
        return (self.level / self.pace,)

    def trajectory(self) -> Trajectory:
        """Return both ramps and the rest."""
        top, rest = self.level / self.pace, self.hold + self.corner
        times, levels = [0, top, top + rest, 2 * top + rest], [0, self.level, self.level, 0]
        if rest == 0:
            times, levels = [0, top, 2 * top], [0, self.level, 0]
        return Trajectory.through(times, levels, corner=self.corner, stop=True)


@dataclass(frozen=True)
class RampSinusoidShape:
    """A ramp to a level of a quantity, a rest, and `cycles` of a sine about that level."""

    quantity: Quantity
    base: RampHoldShape
    amplitude: float
    frequency: float
    cycles: int

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The lengths in s of the ramp and of the sine, and twice that of the rest."""
        return (*self.base.corner_limits, self.cycles / self.frequency)

    def trajectory(self) -> Trajectory:
        """Return ramp, rest and sine; InputError for a force that would pull."""
        longest, corner, level = self.cycles / self.frequency, self.base.corner, self.base.level
        if corner > longest:
            msg = (
                f"motion.corner: expected at most the length of the sinusoid, {longest:g} s, "
                f"received {corner:g}; 0 starts it at once"
            )
            raise InputError(msg)
        if self.quantity == "force" and self.amplitude >= level:
            msg = (
                f"motion.amplitude: expected less than the mean force of {level:g} N, "
                f"received {self.amplitude:g}; a contact cannot pull"
            )
            raise InputError(msg)
        base = self.base.trajectory()
        wave = Wave(base.duration, self.amplitude, self.frequency, corner)
        return base.followed_by(wave, self.cycles)


@dataclass(frozen=True)
class SinusoidShape:
    """`cycles` of a sine from nothing to twice its amplitude, at rest at both ends."""

    amplitude: float
    frequency: float
    cycles: int

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """None: a sine has no corners."""
        return ()

    def trajectory(self) -> Trajectory:
        """Return the sine."""
        wave = Wave(0.0, self.amplitude, self.frequency, 0.0, phase=-np.pi / 2)
        return Trajectory.level(self.amplitude, wave, self.cycles)


@dataclass(frozen=True)
class SamplesShape:
    """Values of a quantity at times in s from 0 on, with straight lines between them."""

    quantity: Quantity
    time: tuple[float, ...]
    values: tuple[float, ...]
    corner: float

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """None: the corner of samples is given, by default 0."""
        return ()

    def trajectory(self) -> Trajectory:
        """Return the lines; InputError for times or values that are none of a motion."""
        self._check()
        return Trajectory.through(self.time, self.values, corner=self.corner, stop=False)

    def _check(self) -> None:
        time, values, name = self.time, self.values, self.quantity
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
