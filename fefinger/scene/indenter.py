"""The rigid objects that touch the finger."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Protocol, Self, final

import numpy as np

from fefinger.geometry import profiles
from fefinger.scene.relief_file import read_heights
from fefinger.support.checks import InputError, number, numbers


ANGLES = (0.0, 60.0)
"""Range of the plate's angle in degrees: 0 lies along the bone, beyond 60 the nail is in the way.

The thesis has 20 to 40 degrees (Pawluk 1997, section 2.2).
"""

TILTS = (-45.0, 45.0)
"""Range of the plate's tilt in degrees."""

ROLLS = (-180.0, 180.0)
"""Range of the turn about the direction of travel in degrees."""

SAMPLES = 4
"""Least number of samples of a relief in x and in y: as many as a cubic needs."""


class Plate(NamedTuple):
    """How a plate lies on the finger: degrees about y (`angle`) and about x (`tilt`)."""

    angle: float
    tilt: float = 0.0


class Inclined(Protocol):
    """What has the two angles of a plate, in degrees."""

    @property
    def angle(self) -> float:
        """Degrees about y, 0 along the bone."""

    @property
    def tilt(self) -> float:
        """Degrees about x."""


@dataclass(frozen=True)
class Indenter(ABC):
    """A rigid frictionless object; messages call its fields "indenter.angle" and so on.

    A plate-like one has `angle` and `tilt` and touches the pad wherever it meets it first; others
    have `at`, (x, y) in mm in the contact frame, and move along the normal of the pad there (None:
    the point that the 30 degree plate touches). `roll` turns an object about its travel, in
    degrees: at 0 its ridge, edge or axis runs across the finger, at 90 along it.

    What depends on the kind of object is asked of the object: nothing outside this file needs to
    know the classes.
    """

    kind: ClassVar[str]
    sharp: ClassVar[bool] = False
    """Whether it has edges or ridges that the skin folds around."""

    @property
    @abstractmethod
    def profile(self) -> profiles.Profile:
        """Heights of the surface across the travel, before `roll`."""

    @property
    @abstractmethod
    def least_radius(self) -> float:
        """Smallest radius of curvature in mm of what the pad meets; infinite for a plane.

        That of a ball is at its foremost point, that of a relief the one at its sharpest crest.
        """

    @abstractmethod
    def describe(self) -> str:
        """Return the object in words, with its sizes: "a rigid sphere of radius 5 mm"."""

    @property
    def plate(self) -> Plate | None:
        """Angle and tilt of a plate, smooth or not; None for an object that is placed."""
        return None

    @property
    def flat(self) -> Plate | None:
        """Angle and tilt of a smooth plate; None for every other object."""
        return None

    @property
    def place(self) -> tuple[float, float] | None:
        """Place (x, y) in mm of first touch; None: where a plate does."""
        return None

    @property
    def turn(self) -> float:
        """Degrees by which the object is turned about its travel; 0 if it is round or a plane."""
        return 0.0

    @property
    def hertzian(self) -> tuple[float, float] | None:
        """Radii of curvature in mm along x and y at the foremost point, infinite for a plane.

        None for an object whose contact is not that of a paraboloid.
        """
        return None

    @property
    def ball_radius(self) -> float | None:
        """Radius in mm of a ball; None for every other object."""
        return None

    @property
    def mirrored(self) -> bool:
        """Whether the object, as placed, is its own mirror image in the medial plane."""
        upright = self.plate is None or self.plate.tilt == 0
        central = self.place is None or self.place[1] == 0
        return upright and central and self.turn % 90 == 0

    def _set(self, name: str, **limits: Any) -> None:
        value = number(f"indenter.{name}", getattr(self, name), **limits)
        object.__setattr__(self, name, value)

    def _set_roll(self) -> None:
        self._set("roll", at_least=ROLLS[0], at_most=ROLLS[1], unit="degrees")


class PlateLike(Indenter):
    """An object with the angles of a plate, which touches the pad wherever it meets it first."""

    angle: float
    tilt: float

    @property
    def plate(self) -> Plate:
        """Angle and tilt in degrees."""
        return Plate(self.angle, self.tilt)

    def _set_angles(self) -> None:
        self._set("angle", at_least=ANGLES[0], at_most=ANGLES[1], unit="degrees")
        self._set("tilt", at_least=TILTS[0], at_most=TILTS[1], unit="degrees")


class Placed(Indenter):
    """An object that moves along the normal of the pad at a place."""

    at: tuple[float, float] | None

    @property
    def place(self) -> tuple[float, float] | None:
        """Place (x, y) in mm of first touch; None: where the 30 degree plate touches."""
        return self.at

    def _set_place(self) -> None:
        if self.at is not None:
            object.__setattr__(self, "at", numbers("indenter.at", self.at, count=2, unit="mm"))


@final
@dataclass(frozen=True)
class Flat(PlateLike):
    """A rigid plate, large against the finger.

    Parameters
    ----------
    angle
        Degrees about y: 0 is parallel to the axis of the bone, positive against the tip side.
    tilt
        Degrees about x, positive against the side of positive y; not 0 breaks the symmetry of the
        finger.
    """

    kind = "flat"

    angle: float = 30.0
    tilt: float = 0.0

    def __post_init__(self) -> None:
        """Check the angles."""
        self._set_angles()

    @property
    def profile(self) -> profiles.Plane:
        """A plane."""
        return profiles.Plane()

    @property
    def least_radius(self) -> float:
        """Infinite."""
        return float("inf")

    @property
    def flat(self) -> Plate:
        """Angle and tilt in degrees."""
        return self.plate

    @property
    def hertzian(self) -> tuple[float, float]:
        """Two infinite radii."""
        return float("inf"), float("inf")

    def describe(self) -> str:
        """Return "a rigid flat plate", with its angles."""
        tilt = f", rolled by {self.tilt:g} degrees" if self.tilt else ""
        return f"a rigid flat plate at {self.angle:g} degrees{tilt}"


@final
@dataclass(frozen=True)
class Sphere(Placed):
    """A rigid sphere of `radius` mm, placed at `at`."""

    kind = "sphere"

    radius: float
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check the radius and the place."""
        self._set("radius", above=0, unit="mm")
        self._set_place()

    @property
    def profile(self) -> profiles.Ellipsoid:
        """An ellipsoid of equal half axes."""
        return profiles.Ellipsoid((self.radius,) * 3)

    @property
    def least_radius(self) -> float:
        """The radius in mm."""
        return self.radius

    @property
    def hertzian(self) -> tuple[float, float]:
        """The radius in mm, twice."""
        return self.radius, self.radius

    @property
    def ball_radius(self) -> float:
        """The radius in mm."""
        return self.radius

    def describe(self) -> str:
        """Return "a rigid sphere", with its radius."""
        return f"a rigid sphere of radius {self.radius:g} mm"


@final
@dataclass(frozen=True)
class Ellipsoid(Placed):
    """A rigid ellipsoid with half axes `radii` in mm along x, y and the direction of travel."""

    kind = "ellipsoid"

    radii: tuple[float, float, float]
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check the half axes and the place."""
        radii = numbers("indenter.radii", self.radii, count=3, above=0, unit="mm")
        object.__setattr__(self, "radii", radii)
        self._set_place()

    @property
    def profile(self) -> profiles.Ellipsoid:
        """The ellipsoid."""
        return profiles.Ellipsoid(self.radii)

    @property
    def least_radius(self) -> float:
        """The smaller radius in mm at the foremost point."""
        return min(self.hertzian)

    @property
    def hertzian(self) -> tuple[float, float]:
        """Radii in mm along x and y at the foremost point: half axes squared over the third."""
        a, b, c = self.radii
        return a**2 / c, b**2 / c

    def describe(self) -> str:
        """Return "a rigid ellipsoid", with its half axes."""
        return "a rigid ellipsoid of half axes {:g}, {:g}, {:g} mm".format(*self.radii)


@final
@dataclass(frozen=True)
class Cylinder(Placed):
    """A long rigid cylinder of `radius` mm, placed at `at` and turned by `roll`."""

    kind = "cylinder"

    radius: float
    roll: float = 0.0
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check the radius and the place."""
        self._set("radius", above=0, unit="mm")
        self._set_roll()
        self._set_place()

    @property
    def profile(self) -> profiles.Ellipsoid:
        """An ellipsoid with one infinite half axis."""
        return profiles.Ellipsoid((self.radius, np.inf, self.radius))

    @property
    def least_radius(self) -> float:
        """The radius in mm."""
        return self.radius

    @property
    def turn(self) -> float:
        """The roll in degrees."""
        return self.roll

    def describe(self) -> str:
        """Return "a rigid cylinder", with its radius and how it lies."""
        return f"a rigid cylinder of radius {self.radius:g} mm{_turned(self.roll)}"


@final
@dataclass(frozen=True)
class Bar(Placed):
    """A long rigid bar, `width` mm wide over all, with corners rounded to `corner` mm.

    A corner of half the width makes it a rounded edge. It is placed at `at` and turned by `roll`.
    """

    kind = "bar"
    sharp = True

    width: float
    corner: float
    roll: float = 0.0
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check the sizes and the place."""
        self._set("width", above=0, unit="mm")
        self._set("corner", above=0, at_most=self.width / 2, unit="mm")
        self._set_roll()
        self._set_place()

    @property
    def profile(self) -> profiles.Bar:
        """A flat strip between rounded corners."""
        return profiles.Bar(self.width, self.corner)

    @property
    def least_radius(self) -> float:
        """The radius of its corners in mm."""
        return self.corner

    @property
    def turn(self) -> float:
        """The roll in degrees."""
        return self.roll

    def describe(self) -> str:
        """Return "a rigid bar", with its sizes and how it lies."""
        size = f"{self.width:g} mm wide with corners of {self.corner:g} mm"
        return f"a rigid bar {size}{_turned(self.roll)}"


@final
@dataclass(frozen=True)
class Pin(Placed):
    """A round rigid pin with a flat end, `width` mm across, its edge rounded to `corner` mm.

    The probe of experiments on single afferents. By default the edge is a fifth of the width.
    """

    kind = "pin"
    sharp = True

    width: float
    corner: float | None = None
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check the sizes and the place."""
        self._set("width", above=0, unit="mm")
        if self.corner is None:
            object.__setattr__(self, "corner", self.width / 5)
        self._set("corner", above=0, at_most=self.width / 2, unit="mm")
        self._set_place()

    @property
    def profile(self) -> profiles.Pin:
        """A flat disc with a rounded edge."""
        return profiles.Pin(self.width, self.least_radius)

    @property
    def least_radius(self) -> float:
        """The radius of its edge in mm."""
        assert self.corner is not None
        return self.corner

    def describe(self) -> str:
        """Return "a rigid pin", with its sizes."""
        return f"a rigid pin {self.width:g} mm wide with an edge of {self.corner:g} mm"


@final
@dataclass(frozen=True)
class Grating(PlateLike):
    """A rigid plate with rounded ridges, `period` mm apart and `depth` mm high.

    `ridge` mm is the width of a ridge at half its height. The middle of a ridge passes through the
    point that the smooth plate would touch first, `shift` mm moves it. `angle` and `tilt` are those
    of the plate, `roll` turns the ridges in it.
    """

    kind = "grating"
    sharp = True

    period: float
    ridge: float
    depth: float
    shift: float = 0.0
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        """Check the sizes and the place."""
        self._set("period", above=0, unit="mm")
        self._set("ridge", above=0, below=self.period, unit="mm")
        self._set("depth", above=0, unit="mm")
        self._set("shift", unit="mm")
        self._set_angles()
        self._set_roll()

    @property
    def profile(self) -> profiles.Grating:
        """Rounded ridges."""
        return profiles.Grating(self.period, self.ridge, self.depth, self.shift)

    @property
    def least_radius(self) -> float:
        """The radius in mm of its ridges where they are sharpest, within 1 %."""
        across = np.column_stack([np.linspace(0, self.period, 401), np.zeros(401)])
        return profiles.sharpest_radius(self.profile, across)

    @property
    def turn(self) -> float:
        """The roll in degrees."""
        return self.roll

    def describe(self) -> str:
        """Return "a rigid grating", with the sizes of its ridges and how they lie."""
        size = f"{self.ridge:g} mm wide every {self.period:g} mm, {self.depth:g} high"
        return f"a rigid grating of ridges {size}{_turned(self.roll)}"

    @property
    def mirrored(self) -> bool:
        """Whether it is its own mirror image: ridges along the finger must not be shifted."""
        return super().mirrored and (self.shift == 0 or self.roll % 180 == 0)


@final
@dataclass(frozen=True)
class Relief(PlateLike):
    """A rigid plate with a relief of your own: `heights` mm towards the finger at x, y in mm.

    x (n_x,) and y (n_y,) are the grid lines on the plate, x towards the tip before `roll`, with the
    point that the smooth plate would touch first at (0, 0); heights (n_x, n_y). A bicubic spline
    runs through the samples, and beyond the outermost ones the plate ends.
    """

    kind = "relief"
    sharp = True

    x: tuple[float, ...]
    y: tuple[float, ...]
    heights: tuple[tuple[float, ...], ...]
    angle: float = 30.0
    tilt: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        """Check the grid, the heights and the place."""
        for name in ("x", "y"):
            lines = numbers(f"indenter.{name}", getattr(self, name), unit="mm")
            if len(lines) < SAMPLES or any(after <= before for before, after in pairwise(lines)):
                msg = (
                    f"indenter.{name}: expected at least {SAMPLES} rising numbers, "
                    f"received {len(lines)}: {list(lines[:5])} ..."
                )
                raise InputError(msg)
            object.__setattr__(self, name, lines)
        given: Any = self.heights
        given = given.tolist() if isinstance(given, np.ndarray) else given
        listed = isinstance(given, Sequence) and not isinstance(given, str)
        if not listed or len(given) != len(self.x):
            msg = (
                f"indenter.heights: expected one row for each of the {len(self.x)} values of x, "
                f"received {f'{len(given)} rows' if listed else repr(given)}"
            )
            raise InputError(msg)
        rows = (
            numbers(f"indenter.heights[{i}]", row, count=len(self.y), unit="mm")
            for i, row in enumerate(given)
        )
        object.__setattr__(self, "heights", tuple(rows))
        self._set_angles()
        self._set_roll()

    @property
    def profile(self) -> profiles.Relief:
        """The spline through the samples."""
        return profiles.Relief(*map(np.array, (self.x, self.y, self.heights)))

    @property
    def least_radius(self) -> float:
        """The radius in mm of its sharpest crest, of places a fifth of the samples apart."""
        fine = (
            np.interp(np.arange(0, len(x) - 1, 0.2), np.arange(len(x)), x) for x in (self.x, self.y)
        )
        places = np.stack(np.meshgrid(*fine, indexing="ij"), axis=-1).reshape(-1, 2)
        return profiles.sharpest_radius(self.profile, places)

    @property
    def turn(self) -> float:
        """The roll in degrees."""
        return self.roll

    def describe(self) -> str:
        """Return "a rigid relief", with the number of its heights."""
        return f"a rigid relief of {len(self.x)} by {len(self.y)} heights"

    @property
    def mirrored(self) -> bool:
        """False: whether the samples are symmetric is not looked at."""
        return False

    @classmethod
    def of(cls, function: Callable[[Any, Any], Any], x: Any, y: Any, **placing: float) -> Self:
        """Return the relief of a function of arrays x and y in mm, sampled at the grid lines."""
        with np.errstate(all="ignore"):
            surface = np.asarray(function(*np.meshgrid(x, y, indexing="ij")), dtype=float)
        if surface.shape != (len(x), len(y)):
            msg = (
                f"indenter.heights: expected a function that returns one height for each of "
                f"{len(x)} x {len(y)} places, received an array of shape {surface.shape}"
            )
            raise InputError(msg)
        return cls(tuple(x), tuple(y), tuple(map(tuple, surface.tolist())), **placing)

    @classmethod
    def from_file(cls, file: str | Path, **placing: float) -> Self:
        """Read x, y and height in mm from a CSV file or an NPZ archive, see `read_heights`."""
        x, y, heights = read_heights(Path(file))
        return cls(x, y, heights, **placing)


STANDARD = Flat(angle=30.0)
"""The plate whose first touch is the origin, and whose small press is the reference of strain."""


def direction(plate: Inclined) -> profiles.Array:
    """Return the unit normal (3,) of a plate towards the finger, which is its travel."""
    angle, tilt = np.radians(plate.angle), np.radians(plate.tilt)
    up = np.cos(angle)
    return np.array([-np.sin(angle), -np.sin(tilt) * up, np.cos(tilt) * up])


def _turned(roll: float) -> str:
    """Describe the direction of an elongated object on the finger."""
    return f", turned by {roll:g} degrees from across the finger" if roll else ", across the finger"


INDENTERS: dict[str, type[Indenter]] = {
    indenter.kind: indenter
    for indenter in (Flat, Sphere, Ellipsoid, Cylinder, Bar, Pin, Grating, Relief)
}
