"""Base class of the motions of the indenter: a depth in mm, or a force in N, in time.

A motion with `depth=` prescribes the depth, one with `force=` the force; a scene file says which by
its kind, "ramp" or "force-ramp". Messages call the fields "motion.depth" and so on.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from fefinger.scene.indenter import Inclined
from fefinger.scene.key import Key, check, keys_of, keys_of_kind
from fefinger.scene.trajectory import Trajectory
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import Control


LONGEST = 1e9
"""Longest time in s that a motion may hold or last: thirty years."""

SECONDS: dict[str, Any] = {"unit": "s", "at_least": 0, "at_most": LONGEST}

KEYS = {
    "speed": Key("Speed", unit="mm/s", above=0, control=Control.DEPTH),
    "depth": Key("Travel after first touch", unit="mm", above=0, control=Control.DEPTH),
    "loading_rate": Key("Rate of the force", unit="N/s", above=0, control=Control.FORCE),
    "force": Key("Force", unit="N", above=0, control=Control.FORCE),
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
        "Speed of the press before the slide, or rate of the force",
        unit="mm/s or N/s",
        above=0,
        usual=(10.0, 5.0),
    ),
    "control": Key("What the motion prescribes; in a scene its kind says so"),
}
"""Keys of the motions, which mean the same in all of them."""


@dataclass(frozen=True)
class Motion(ABC):
    """A motion of the indenter; its depth in mm or its force in N follows `trajectory`."""

    table: ClassVar[str] = "motion"
    common: ClassVar[Mapping[str, Key]] = KEYS

    shape: ClassVar[str]
    """Its course in time, whatever it prescribes: the kind of it that prescribes the depth."""

    slides: ClassVar[bool] = False
    """Whether it has a path across the direction of travel."""

    along_line: ClassVar[bool] = False
    """Whether that path is a line."""

    @cached_property
    @abstractmethod
    def trajectory(self) -> Trajectory:
        """The motion as quadratics in time; InputError for numbers that do not fit together."""

    def __post_init__(self) -> None:
        """Check every field, then build the trajectory, which finds corners that are too long."""
        check(self)
        self._complete()
        _ = self.trajectory

    def _complete(self) -> None:
        """Fill in what depends on the control; InputError for keys of both, or of none."""
        keys, control = keys_of_kind(type(self), self.kind), self.control
        for name, known in keys_of(type(self)).items():
            value = getattr(self, name)
            if name not in keys:
                if value is not None and known.hint is not Control:
                    raise InputError(
                        f"motion.{name}: expected none in a motion of {control} ({control.unit}), "
                        f"received {value!r}; give depth or force, and what belongs to it"
                    )
            elif value is None and keys[name].needed:
                raise InputError(
                    f"motion.{name}: missing; a motion takes {' and '.join(self._needs(control))}, "
                    f"or {' and '.join(self._needs(control.other))}"
                )
            elif value is None and known.key.usual:
                object.__setattr__(self, name, keys[name].default)

    @classmethod
    def _needs(cls, control: Control) -> list[str]:
        """Keys without a default that only motions of depth, or of force, have."""
        keys = keys_of_kind(cls, control.of("", "force-"))
        return [name for name, each in keys.items() if each.needed and each.key.control]

    @property
    def control(self) -> Control:
        """What it prescribes, and the name of the field that holds it."""
        return Control.DEPTH if getattr(self, "force", None) is None else Control.FORCE

    @property
    def by_force(self) -> bool:
        """Whether it prescribes the force, and not the depth."""
        return self.control is Control.FORCE

    @property
    def kind(self) -> str:
        """Its kind in a scene, such as "ramp" or "force-ramp"."""
        return self.control.of("", "force-") + self.shape

    @property
    def deepest(self) -> float | None:
        """Largest depth in mm, where the motion prescribes the depth."""
        return self.control.of(self.peak, None)

    @property
    def hardest(self) -> float | None:
        """Largest force in N, where the motion prescribes the force."""
        return self.control.of(None, self.peak)

    @property
    def turns_plate(self) -> bool:
        """Whether a plate turns on its path."""
        return False

    def inclines(self, t: ArrayLike, plate: Inclined) -> Array:
        """Return the slopes (..., 2) of a plate that turns, over the plane across its travel.

        It moves along the normal of `plate`, and is level where it has the angles of that.
        """
        return np.zeros((*np.shape(t), 2))

    @property
    def unit(self) -> str:
        """Unit of what is controlled: mm of depth or N of force."""
        return self.control.unit

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
    def begins(self) -> float:
        """Time in s of the first of samples, which counts as 0."""
        return 0.0

    @property
    def tare(self) -> float:
        """Mean of the force in N that samples have before contact, which is subtracted."""
        return 0.0

    def beside(self, t: ArrayLike) -> Array | None:
        """Interpolate the force in N or depth in mm recorded beside the motion; None without one.

        t (...,) s.
        """
        return None

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
        # Part of the duration by which times of two trajectories are the same but for rounding.
        same = 1e-12
        apart = np.diff(every, prepend=-np.inf) > (same if self.paths else 0.0) * self.duration
        return tuple(np.array(every)[apart].tolist())

    @property
    def moving(self) -> tuple[tuple[float, float], ...]:
        """Intervals (t0, t1) in s in which the depth or the force changes."""
        return merged(span for each in (self.trajectory, *self.paths) for span in each.moving)

    @property
    def even_spans(self) -> tuple[tuple[float, float], ...]:
        """Intervals (t0, t1) in s in which it keeps one velocity across its travel, within 1 %."""
        knots, spans = np.array(self.breakpoints), list[tuple[float, float]]()
        first, middle = self.velocity(knots[:-1]), self.velocity((knots[1:] + knots[:-1]) / 2)
        start, kept = 0.0, np.zeros(2)
        for i, velocity in enumerate(middle):
            # Between two knots the velocity changes linearly.
            allowed = 0.01 * float(np.hypot(*velocity))
            even = bool(np.hypot(*(first[i] - velocity)) < allowed)
            if even and np.hypot(*(velocity - kept)) < allowed:
                continue
            if kept.any():
                spans.append((start, float(knots[i])))
            start, kept = float(knots[i]), velocity if even else np.zeros(2)
        return (*spans, (start, float(knots[-1]))) if kept.any() else tuple(spans)

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
        return np.maximum(value, 0.0) if self.by_force else value

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
