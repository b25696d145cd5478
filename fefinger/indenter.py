"""The rigid objects that touch the finger."""

from dataclasses import dataclass
from typing import ClassVar

from fefinger.checks import number
from fefinger.lists import numbers


ANGLES = (0.0, 60.0)
"""Range of the plate's angle in degrees: 0 lies along the bone, beyond 60 the nail is in the way.

The thesis has 20 to 40 degrees (Pawluk 1997, section 2.2).
"""

TILTS = (-45.0, 45.0)
"""Range of the plate's tilt in degrees."""


@dataclass(frozen=True)
class Indenter:
    """A rigid frictionless object; messages call its fields "indenter.angle" and so on."""

    kind: ClassVar[str]


@dataclass(frozen=True)
class Flat(Indenter):
    """A rigid plate, large against the finger.

    Parameters
    ----------
    angle
        Degrees about y: 0 is parallel to the axis of the bone, positive against the tip side.
    tilt
        Degrees about x; not 0 breaks the symmetry of the finger.
    """

    kind = "flat"

    angle: float = 30.0
    tilt: float = 0.0

    def __post_init__(self) -> None:
        """Check the angles."""
        for name, (low, high) in (("angle", ANGLES), ("tilt", TILTS)):
            value = number(
                f"indenter.{name}", getattr(self, name), at_least=low, at_most=high, unit="degrees"
            )
            object.__setattr__(self, name, value)


@dataclass(frozen=True)
class Sphere(Indenter):
    """A rigid sphere of `radius` mm, which moves along the normal of the pad at `at`.

    `at` is (x, y) in mm in the contact frame; None is the point that the 30 degree plate touches.
    """

    kind = "sphere"

    radius: float
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check the radius and the place."""
        object.__setattr__(
            self, "radius", number("indenter.radius", self.radius, above=0, unit="mm")
        )
        _set_at(self, self.at)


@dataclass(frozen=True)
class Ellipsoid(Indenter):
    """A rigid ellipsoid with half axes `radii` in mm along x, y and the direction of travel.

    `at` as in `Sphere`.
    """

    kind = "ellipsoid"

    radii: tuple[float, float, float]
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check the half axes and the place."""
        radii = numbers("indenter.radii", self.radii, count=3, above=0, unit="mm")
        object.__setattr__(self, "radii", radii)
        _set_at(self, self.at)


def _set_at(indenter: Sphere | Ellipsoid, at: tuple[float, float] | None) -> None:
    if at is not None:
        object.__setattr__(indenter, "at", numbers("indenter.at", at, count=2, unit="mm"))


INDENTERS: dict[str, type[Indenter]] = {
    indenter.kind: indenter for indenter in (Flat, Sphere, Ellipsoid)
}
