"""Motions with a path: the indenter is pressed, and moves across its direction of travel.

x and y of a path lie in the plane across the travel: x distal, y radial, as on a plate before its
`roll`.

At the end the motions of force before `force=`, for one version: constructors that say what to
write.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from typing import Annotated, Any, TypeVar, final

import numpy as np
from numpy.typing import ArrayLike

from fefinger.geometry.profiles import frame
from fefinger.scene.indenter import PLACING, Inclined, Plate, direction
from fefinger.scene.key import Key
from fefinger.scene.motion import Motion
from fefinger.scene.motions import (
    AS_LONG_AS_FITS,
    FrequencySweep,
    Ramp,
    Ramped,
    RampHold,
    RampSinusoid,
    Sinusoid,
    Trapezoid,
    rest_limit,
)
from fefinger.scene.oscillation import about_mean, noise, to_and_fro
from fefinger.scene.samples import Depths, Forces, Measured, Sampled, SampledMotion, Times
from fefinger.scene.trajectory import Trajectory
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.recordings import Recording
from fefinger.support.vocabulary import Control


ANGLES = ("angle", "tilt")
"""Angles of a plate that a path may have."""

OTHER_TURNS = ("yaw", "pitch", "roll")
"""Names of columns with turns that it has not."""


@final
@dataclass(frozen=True)
class Slide(Ramped):
    """A press, and `passes` of `distance` mm at `speed` mm/s along `direction`.

    `direction` in degrees: 0 moves the object distally, 90 radially; a second pass returns.
    The press to `depth` mm takes `approach` mm/s, or that to `force` N takes `approach` N/s; it
    rests for `settle` s before the slide, from which on spikes count. All ramps are rounded by
    `corner` s.
    """

    shape = "slide"
    slides = True
    along_line = True

    speed: Annotated[float, Key("Speed", unit="mm/s", above=0)]
    depth: float | None = None
    _: KW_ONLY
    force: float | None = None
    distance: float
    direction: float = 0.0
    passes: int = 1
    settle: float = 0.5
    approach: float | None = None
    corner: float = AS_LONG_AS_FITS

    @property
    def ramp_duration(self) -> float:
        """Length of the press in s, with sharp corners."""
        assert self.approach is not None  # filled in, by the control
        return self.level / self.approach

    @property
    def pass_seconds(self) -> float:
        """Length of a pass in s, with sharp corners."""
        return self.distance / self.speed

    @property
    def corner_limits(self) -> tuple[float, ...]:
        """The lengths in s of press and pass, and twice the length of the rest between them."""
        return self.ramp_duration, self.pass_seconds, *rest_limit(self.settle)

    @property
    def recorded_from(self) -> float:
        """The start of the slide in s."""
        return self.ramp_and_rest(self.settle).duration

    @cached_property
    def along(self) -> Trajectory:
        """Distance in mm along the line."""
        count = self.passes + 1
        times = self.recorded_from + self.pass_seconds * np.arange(count)
        places = self.distance * (np.arange(count) % 2)
        return Trajectory.through(
            np.append(0.0, times), np.append(0.0, places), corner=self.corner, stop=True
        )

    @cached_property
    def trajectory(self) -> Trajectory:
        """Press, and rest for as long as the slide takes."""
        return self.ramp_and_rest(self.along.duration - self.ramp_duration - self.corner)

    @cached_property
    def paths(self) -> tuple[Trajectory, ...]:
        """The distance along the line."""
        return (self.along,)

    def shift(self, t: ArrayLike) -> Array:
        """Return the place (..., 2) mm of the object at the times `t` in s."""
        return self.along.value(t)[..., None] * self._heading

    def velocity(self, t: ArrayLike) -> Array:
        """Return the velocity (..., 2) mm/s of the object at the times `t` in s."""
        return self.along.rate(t)[..., None] * self._heading

    @property
    def _heading(self) -> Array:
        """Unit vector (2,) of the first pass, exact at right angles."""
        turns, rest = divmod(self.direction, 90.0)
        c, s = np.cos(np.radians(rest)), np.sin(np.radians(rest))
        for _ in range(int(turns) % 4):
            c, s = -s, c
        return np.array([c, s]) + 0.0  # no -0.0

    @property
    def mirrored(self) -> bool:
        """Whether the object stays in the medial plane."""
        return self.direction % 180 == 0


@final
@dataclass(frozen=True)
class SampledPath(SampledMotion):
    """Places x and y in mm across the travel, and depths in mm or forces in N, at times in s.

    They are joined by lines. `angle` and `tilt` in degrees, where given, are those of a plate that
    turns about the point of first touch, which travels along the normal of the angles of the
    indenter.
    """

    shape = "sampled-path"
    slides = True

    time: Times
    corner: float = field(default=0.0, kw_only=True)
    x: Annotated[tuple[float, ...], Key("Places along x", unit="mm")]
    y: Annotated[tuple[float, ...], Key("Places along y", unit="mm")]
    angle: Annotated[tuple[float, ...] | None, PLACING["angle"]] = field(default=None, kw_only=True)
    tilt: Annotated[tuple[float, ...] | None, PLACING["tilt"]] = field(default=None, kw_only=True)
    depth: Depths = None
    force: Forces = field(default=None, kw_only=True)
    measured: Measured = field(default=None, kw_only=True)

    @cached_property
    def paths(self) -> tuple[Trajectory, ...]:
        """Those of x and of y, and of the angles that are given."""
        return (self._through(self.x), self._through(self.y), *self._turns.values())

    @cached_property
    def _turns(self) -> dict[str, Trajectory]:
        """Trajectories in degrees of the angles that are given."""
        given = {"angle": self.angle, "tilt": self.tilt}
        return {name: self._through(each) for name, each in given.items() if each is not None}

    @cached_property
    def path_frequency(self) -> float | None:
        """Highest frequency in Hz with which the path goes to and fro, but for noise."""
        found = [self._frequency(name) for name in self._columns] if self.sample_rate else []
        return max(filter(None, found), default=None)

    def _frequency(self, column: str) -> float | None:
        time, values = self.evenly(column)
        frequency = to_and_fro(time, values)
        if frequency is None:
            return None
        per_cycle = 1 / (frequency * float(np.diff(time).mean()))
        swing = about_mean(values, per_cycle)
        return None if noise(swing, per_cycle, float(np.ptp(values))) else frequency

    @property
    def _columns(self) -> tuple[str, ...]:
        return ("x", "y", *(name for name in ANGLES if getattr(self, name) is not None))

    @property
    def turns_plate(self) -> bool:
        """Whether the plate has angles of its path."""
        return bool(self._turns)

    def inclines(self, t: ArrayLike, plate: Inclined) -> Array:
        """Return the slopes (..., 2) of the plate at the times `t` in s over that across `plate`.

        A plane with the normal n rises by -(n . a) / (n . travel) along a vector a across it; the
        slope of its distance from the skin is the opposite.
        """
        times = np.asarray(t, dtype=np.float64)
        still = {"angle": plate.angle, "tilt": plate.tilt}
        angle, tilt = (
            self._turns[name].value(times) if name in self._turns else np.full(times.shape, value)
            for name, value in still.items()
        )
        plates = zip(angle.ravel().tolist(), tilt.ravel().tolist(), strict=True)
        normals = np.array([direction(Plate(*each)) for each in plates])
        local = normals @ frame(direction(plate)).T
        return (local[:, :2] / local[:, 2:]).reshape(*times.shape, 2)

    def shift(self, t: ArrayLike) -> Array:
        """Return the place (..., 2) mm of the object at the times `t` in s."""
        return np.stack([each.value(t) for each in self.paths[:2]], axis=-1)

    def velocity(self, t: ArrayLike) -> Array:
        """Return the velocity (..., 2) mm/s of the object at the times `t` in s."""
        return np.stack([each.rate(t) for each in self.paths[:2]], axis=-1)

    @property
    def mirrored(self) -> bool:
        """Whether the object stays in the medial plane."""
        return not any(self.y) and not any(self.tilt or ())

    @classmethod
    def _read_columns(cls, record: Recording, named: Mapping[str, str]) -> tuple[str, ...]:
        """Time and path, and of the angles of the plate those that there are."""
        headers = [*(header.lower() for header in record.headers), *named]
        for header, values in zip(record.headers, record.values.T, strict=True):
            if header.lower().startswith(OTHER_TURNS) and np.ptp(values) > 0:
                raise InputError(
                    f"{record.source}: column {header!r}: expected no turn of a plate but "
                    f"{' and '.join(ANGLES)}, received one that changes, which is not modeled; "
                    "leave the column out to go without it"
                )
        turns = (name for name in ANGLES if any(each.startswith(name) for each in headers))
        return ("time", "x", "y", *turns)


Made = TypeVar("Made", bound=Motion)


def _former(name: str, motion: type[Made], *order: str, **fixed: Any) -> Callable[..., Made]:
    """Return the constructor of a former class, whose arguments by place have the names `order`."""

    def make(*values: Any, **named: Any) -> Made:
        keys = "control" if fixed else "force"
        warnings.warn(
            f"ff.{name} is ff.{motion.__name__} with {keys}= now, and goes with the next version",
            DeprecationWarning,
            stacklevel=2,
        )
        return motion(**dict(zip(order, values, strict=False)), **named, **fixed)

    return make


RATE_AND_FORCE = ("loading_rate", "force")
ForceRamp = _former("ForceRamp", Ramp, *RATE_AND_FORCE)
ForceRampHold = _former("ForceRampHold", RampHold, *RATE_AND_FORCE)
ForceTrapezoid = _former("ForceTrapezoid", Trapezoid, *RATE_AND_FORCE)
ForceRampSinusoid = _former("ForceRampSinusoid", RampSinusoid, *RATE_AND_FORCE)
ForceSinusoid = _former(
    *("ForceSinusoid", Sinusoid, "amplitude", "frequency", "cycles"), control=Control.FORCE
)
ForceSweep = _former("ForceSweep", FrequencySweep, "force")
ForceSampled = _former("ForceSampled", Sampled, "time", "force")
ForceSlide = _former("ForceSlide", Slide, "speed", "force")
ForceSampledPath = _former("ForceSampledPath", SampledPath, "time", "x", "y", "force")
