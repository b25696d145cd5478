"""The objects that touch the finger.

Some may be soft: an elastic half-space, or a layer on a rigid base.
"""

import math
from dataclasses import dataclass, field
from typing import Annotated, final

import numpy as np

from fefinger.geometry import profiles
from fefinger.scene.indenter import Indenter, Plate, turned
from fefinger.scene.key import Key
from fefinger.support import registry
from fefinger.support.checks import InputError, set_number
from fefinger.support.registry import Registry
from fefinger.theory.contact.stack import Layer, Stack
from fefinger.theory.relaxation import ELASTIC, Prony


POISSON = 0.5
"""Default of Poisson's ratio: gels, rubbers and tissue keep their volume, foams alone do not."""


@dataclass(frozen=True)
class Compliant(Indenter):
    """An object that is rigid, or elastic where it has a modulus.

    Its surface then gives way as that of a flat body, a half-space or a layer on a rigid base: the
    approximation of Hertz, for contacts that are small beside the radius of the object.
    """

    modulus: Annotated[
        float | None,
        Key(
            "Young's modulus of a soft object, relaxed; rigid by default",
            unit="kPa",
            above=0,
            written=False,
        ),
    ] = field(default=None, kw_only=True, repr=False)

    poisson: Annotated[
        float,
        Key("Poisson's ratio of a soft object", above=0, at_most=0.5, written=False),
    ] = field(default=POISSON, kw_only=True, repr=False)

    thickness: Annotated[
        float | None,
        Key(
            "Thickness of a soft object on a rigid base; a half-space by default",
            unit="mm",
            above=0,
            written=False,
        ),
    ] = field(default=None, kw_only=True, repr=False)

    prony: Annotated[
        Prony | None,
        Key("Relaxation of a soft object; elastic by default", written=False),
    ] = field(default=None, kw_only=True, repr=False)

    def __post_init__(self) -> None:
        """Check the fields, and that they belong together."""
        super().__post_init__()
        if self.modulus is None:
            for name, usual in (("poisson", POISSON), ("thickness", None), ("prony", None)):
                if getattr(self, name) != usual:
                    raise InputError(
                        f"indenter.modulus: expected a number in kPa beside indenter.{name}, which "
                        f"a soft object has, received none; give one, or leave {name} out"
                    )
            return
        if self.friction:
            raise InputError(
                "indenter.friction: expected 0 of a soft object, whose surface does not move "
                f"along the skin here, received {self.friction:g}; leave it or the modulus out"
            )
        radius = getattr(self, "radius", math.inf)
        if self.thickness is not None and self.thickness > radius:
            raise InputError(
                f"indenter.thickness: expected at most the radius of {radius:g} mm, received "
                f"{self.thickness:g}; leave it out for an object that is soft throughout"
            )

    @property
    def soft_body(self) -> Stack | None:
        """Its elastic body, as the flat one that gives way alike; None where it is rigid."""
        if self.modulus is None:
            return None
        return Stack((Layer(self.thickness or math.inf, self.modulus, self.poisson),))

    @property
    def soft_prony(self) -> Prony:
        """The relaxation of a soft object."""
        return self.prony or ELASTIC

    @property
    def signature(self) -> str:
        """Text by which results of the object are kept."""
        if self.modulus is None:
            return super().signature
        relaxation = "" if self.prony is None else f" {self.prony!r}"
        body = f"{self.modulus!r} {self.poisson!r} {self.thickness!r}"
        return f"{super().signature} {body}{relaxation}"

    @property
    def _stuff(self) -> tuple[str, str]:
        """Words for what it is made of: "rigid" and nothing, or "soft" and "50 kPa"."""
        if self.modulus is None:
            return "rigid", ""
        relaxed = " relaxed" if self.prony else ""
        layer = f" ({self.thickness:g} mm thick on a rigid base)" if self.thickness else ""
        return "soft", f"{self.modulus:g} kPa{relaxed}{layer}"

    def _described(self, noun: str, size: str) -> str:
        """Return "a rigid sphere of radius 5 mm", or "a soft sphere of 50 kPa, radius 5 mm"."""
        hardness, material = self._stuff
        return f"a {hardness} {noun} of {material}{', ' if material else ''}{size}"


ROUNDING = Key("Radius of the rounded corners or edge", unit="mm", above=0)

Radius = Annotated[float, Key("Radius", unit="mm", above=0)]
Width = Annotated[float, Key("Width over all", unit="mm", above=0)]


@final
@dataclass(frozen=True)
class Flat(Compliant):
    """A plate, large against the finger, at `angle` degrees about y and `tilt` about x.

    A tilt other than 0 breaks the symmetry of the finger.
    """

    hertzian = (np.inf, np.inf)

    angle: float = 30.0
    tilt: float = 0.0

    @property
    def profile(self) -> profiles.Plane:
        """A plane."""
        return profiles.Plane()

    @property
    def flat(self) -> Plate:
        """Angle and tilt in degrees."""
        return Plate(self.angle, self.tilt)

    def describe(self) -> str:
        """Return "a rigid flat plate", or "a soft flat plate of 50 kPa", with its angles."""
        tilt = f", rolled by {self.tilt:g} degrees" if self.tilt else ""
        hardness, material = self._stuff
        of = f" of {material}" if material else ""
        return f"a {hardness} flat plate{of} at {self.angle:g} degrees{tilt}"


STANDARD = Flat(angle=30.0)
"""The plate whose first touch is the origin, and whose small press is the reference of strain."""


@final
@dataclass(frozen=True)
class Sphere(Compliant):
    """A sphere of `radius` mm, placed at `at`."""

    radius: Radius
    at: tuple[float, float] | None = None

    @property
    def profile(self) -> profiles.Ellipsoid:
        """An ellipsoid of equal half axes."""
        return profiles.Ellipsoid((self.radius,) * 3)

    @property
    def hertzian(self) -> tuple[float, float]:
        """The radius in mm, twice."""
        return self.radius, self.radius

    @property
    def ball_radius(self) -> float:
        """The radius in mm."""
        return self.radius

    @property
    def half_sides(self) -> tuple[float, float]:
        """The radius in mm, twice."""
        return self.radius, self.radius

    def describe(self) -> str:
        """Return "a rigid sphere" or "a soft sphere of 50 kPa", with its radius."""
        return self._described("sphere", f"radius {self.radius:g} mm")


@final
@dataclass(frozen=True)
class Ellipsoid(Indenter):
    """A rigid ellipsoid with half axes `radii` in mm along x, y and the direction of travel."""

    radii: Annotated[
        tuple[float, float, float],
        Key("Half axes along x, y and the direction of travel", unit="mm", above=0),
    ]
    at: tuple[float, float] | None = None

    @property
    def profile(self) -> profiles.Ellipsoid:
        """The ellipsoid."""
        return profiles.Ellipsoid(self.radii)

    @property
    def hertzian(self) -> tuple[float, float]:
        """Radii in mm along x and y at the foremost point: half axes squared over the third."""
        a, b, c = self.radii
        return a**2 / c, b**2 / c

    @property
    def half_sides(self) -> tuple[float, float]:
        """The half axes in mm along x and y."""
        return self.radii[:2]

    def describe(self) -> str:
        """Return "a rigid ellipsoid", with its half axes."""
        return "a rigid ellipsoid of half axes {:g}, {:g}, {:g} mm".format(*self.radii)


@final
@dataclass(frozen=True)
class Cylinder(Compliant):
    """A long cylinder of `radius` mm, placed at `at` and turned by `roll`."""

    radius: Radius
    roll: float = 0.0
    at: tuple[float, float] | None = None

    @property
    def profile(self) -> profiles.Ellipsoid:
        """An ellipsoid with one infinite half axis."""
        return profiles.Ellipsoid((self.radius, np.inf, self.radius))

    @property
    def least_radius(self) -> float:
        """The radius in mm."""
        return self.radius

    @property
    def half_sides(self) -> tuple[float, float]:
        """The radius in mm; along y it goes on."""
        return self.radius, float("inf")

    def describe(self) -> str:
        """Return "a rigid cylinder" or a soft one, with its radius and how it lies."""
        return self._described("cylinder", f"radius {self.radius:g} mm{turned(self.roll)}")


class Edged(Indenter):
    """An object with a flat end `width` mm wide, whose edge is rounded to `corner` mm."""

    sharp = True

    width: Width
    corner: float | None

    def __post_init__(self) -> None:
        """Take the edge from the width where it is left out; it has to fit."""
        super().__post_init__()
        if self.corner is None:
            object.__setattr__(self, "corner", self.width / 5)
        set_number(self, "indenter.corner", above=0, at_most=self.width / 2, unit="mm")

    @property
    def narrowest(self) -> float:
        """The width in mm."""
        return self.width

    @property
    def least_radius(self) -> float:
        """The radius of the edge in mm."""
        assert self.corner is not None
        return self.corner


@final
@dataclass(frozen=True)
class Bar(Edged):
    """A long rigid bar, `width` mm wide over all, with corners rounded to `corner` mm.

    A corner of half the width makes it a rounded edge. It is placed at `at` and turned by `roll`.
    """

    width: Width
    corner: Annotated[float, ROUNDING]
    roll: float = 0.0
    at: tuple[float, float] | None = None

    @property
    def profile(self) -> profiles.Bar:
        """A flat strip between rounded corners."""
        return profiles.Bar(self.width, self.corner)

    @property
    def half_sides(self) -> tuple[float, float]:
        """Half of the width in mm; along y it goes on."""
        return self.width / 2, float("inf")

    def describe(self) -> str:
        """Return "a rigid bar", with its sizes and how it lies."""
        size = f"{self.width:g} mm wide with corners of {self.corner:g} mm"
        return f"a rigid bar {size}{turned(self.roll)}"


@final
@dataclass(frozen=True)
class Pin(Edged):
    """A round rigid pin with a flat end, `width` mm across, its edge rounded to `corner` mm.

    The probe of experiments on single afferents. By default the edge is a fifth of the width.
    """

    width: Width
    corner: Annotated[float | None, ROUNDING] = None
    at: tuple[float, float] | None = None

    @property
    def profile(self) -> profiles.Pin:
        """A flat disc with a rounded edge."""
        return profiles.Pin(self.width, self.least_radius)

    @property
    def half_sides(self) -> tuple[float, float]:
        """Half of the width in mm, twice."""
        return self.width / 2, self.width / 2

    def describe(self) -> str:
        """Return "a rigid pin", with its sizes."""
        return f"a rigid pin {self.width:g} mm wide with an edge of {self.corner:g} mm"


INDENTERS: Registry[type[Indenter]] = registry.INDENTERS
"""The classes of objects by kind, also those of the user."""
