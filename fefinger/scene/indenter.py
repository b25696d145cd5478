"""The rigid objects that touch the finger."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar, Self

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


@dataclass(frozen=True)
class Indenter:
    """A rigid frictionless object; messages call its fields "indenter.angle" and so on.

    A plate-like one has `angle` and `tilt` and touches the pad wherever it meets it first; others
    have `at`, (x, y) in mm in the contact frame, and move along the normal of the pad there (None:
    the point that the 30 degree plate touches). `roll` turns an object about its travel, in
    degrees: at 0 its ridge, edge or axis runs across the finger, at 90 along it.
    """

    kind: ClassVar[str]

    @property
    def profile(self) -> profiles.Profile:
        """Heights of the surface across the travel, before `roll`."""
        raise NotImplementedError

    @property
    def mirrored(self) -> bool:
        """Whether the object, as placed, is its own mirror image in the medial plane."""
        at, roll = getattr(self, "at", None), getattr(self, "roll", 0.0)
        return not getattr(self, "tilt", 0.0) and (at is None or at[1] == 0) and roll % 90 == 0

    def _set(self, name: str, **limits: Any) -> None:
        value = number(f"indenter.{name}", getattr(self, name), **limits)
        object.__setattr__(self, name, value)

    def _set_place(self) -> None:
        """Check whatever of angle, tilt, roll and at the object has."""
        for name, (low, high) in (("angle", ANGLES), ("tilt", TILTS), ("roll", ROLLS)):
            if hasattr(self, name):
                self._set(name, at_least=low, at_most=high, unit="degrees")
        at = getattr(self, "at", None)
        if at is not None:
            object.__setattr__(self, "at", numbers("indenter.at", at, count=2, unit="mm"))


@dataclass(frozen=True)
class Flat(Indenter):
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
        self._set_place()

    @property
    def profile(self) -> profiles.Plane:
        """A plane."""
        return profiles.Plane()


@dataclass(frozen=True)
class Sphere(Indenter):
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


@dataclass(frozen=True)
class Ellipsoid(Indenter):
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


@dataclass(frozen=True)
class Cylinder(Indenter):
    """A long rigid cylinder of `radius` mm, placed at `at` and turned by `roll`."""

    kind = "cylinder"

    radius: float
    roll: float = 0.0
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check the radius and the place."""
        self._set("radius", above=0, unit="mm")
        self._set_place()

    @property
    def profile(self) -> profiles.Ellipsoid:
        """An ellipsoid with one infinite half axis."""
        return profiles.Ellipsoid((self.radius, np.inf, self.radius))


@dataclass(frozen=True)
class Bar(Indenter):
    """A long rigid bar, `width` mm wide over all, with corners rounded to `corner` mm.

    A corner of half the width makes it a rounded edge. It is placed at `at` and turned by `roll`.
    """

    kind = "bar"

    width: float
    corner: float
    roll: float = 0.0
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check the sizes and the place."""
        self._set("width", above=0, unit="mm")
        self._set("corner", above=0, at_most=self.width / 2, unit="mm")
        self._set_place()

    @property
    def profile(self) -> profiles.Bar:
        """A flat strip between rounded corners."""
        return profiles.Bar(self.width, self.corner)


@dataclass(frozen=True)
class Grating(Indenter):
    """A rigid plate with rounded ridges, `period` mm apart and `depth` mm high.

    `ridge` mm is the width of a ridge at half its height. The middle of a ridge passes through the
    point that the smooth plate would touch first, `shift` mm moves it. `angle` and `tilt` are those
    of the plate, `roll` turns the ridges in it.
    """

    kind = "grating"

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
        self._set_place()

    @property
    def profile(self) -> profiles.Grating:
        """Rounded ridges."""
        return profiles.Grating(self.period, self.ridge, self.depth, self.shift)

    @property
    def mirrored(self) -> bool:
        """Whether it is its own mirror image: ridges along the finger must not be shifted."""
        return super().mirrored and (self.shift == 0 or self.roll % 180 == 0)


@dataclass(frozen=True)
class Relief(Indenter):
    """A rigid plate with a relief of your own: `heights` mm towards the finger at x, y in mm.

    x (n_x,) and y (n_y,) are the grid lines on the plate, x towards the tip before `roll`, with the
    point that the smooth plate would touch first at (0, 0); heights (n_x, n_y). A bicubic spline
    runs through the samples, and beyond the outermost ones the plate ends.
    """

    kind = "relief"

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
        self._set_place()

    @property
    def profile(self) -> profiles.Relief:
        """The spline through the samples."""
        return profiles.Relief(*map(np.array, (self.x, self.y, self.heights)))

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


def direction(flat: Flat | Grating | Relief) -> profiles.Array:
    """Return the unit normal (3,) of a plate towards the finger, which is its travel."""
    angle, tilt = np.radians(flat.angle), np.radians(flat.tilt)
    up = np.cos(angle)
    return np.array([-np.sin(angle), -np.sin(tilt) * up, np.cos(tilt) * up])


INDENTERS: dict[str, type[Indenter]] = {
    indenter.kind: indenter
    for indenter in (Flat, Sphere, Ellipsoid, Cylinder, Bar, Grating, Relief)
}
