"""Base classes of the objects that touch the finger: plates and placed ones."""

import hashlib
from abc import ABC
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from fefinger.geometry import profiles
from fefinger.geometry.surface import Surface
from fefinger.scene.key import Key, check, keys_of
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.registry import hyphenated
from fefinger.theory.contact.stack import Stack
from fefinger.theory.relaxation import ELASTIC, Prony


# Beyond 60 degrees the nail is in the way; the thesis has 20 to 40 (Pawluk 1997, section 2.2).
PLACING = {
    "angle": Key(
        "Rotation of the plate about y: 0 is parallel to the bone, positive presses the tip side",
        unit="degrees",
        at_least=0,
        at_most=60,
    ),
    "tilt": Key(
        "Rotation of the plate about x, positive against the side of positive y",
        unit="degrees",
        at_least=-45,
        at_most=45,
    ),
    "roll": Key(
        "Turn about the direction of travel: 0 lies across the finger, 90 along it",
        unit="degrees",
        at_least=-180,
        at_most=180,
    ),
    "at": Key(
        "Place [x, y]; by default the point that the 30 degree plate touches",
        unit="mm",
        at_least=-1e4,  # of an object that goes on for ever
        at_most=1e4,
    ),
}
"""Keys that place an object on the finger."""


class Plate(NamedTuple):
    """How a plate lies on the finger: degrees about y (`angle`) and about x (`tilt`)."""

    angle: float
    tilt: float = 0.0


@dataclass(frozen=True)
class Indenter(ABC):
    """An object. One of your own is a frozen dataclass with a `surface(x, y)`, and rigid.

    Its fields are keys of [indenter]: `width: Annotated[float, Key("Width", unit="mm", above=0)]`,
    or without facts `width: float`. Its `kind` is the name of the class in lower case, with hyphens
    between words. Some fields mean the same in every object:

    - `at`, (x, y) in mm in the contact frame: it moves along the normal of the pad there; None is
      the point that the 30 degree plate touches, as without the field.
    - `angle` and `tilt` in degrees: it lies as a plate, and touches the pad where it meets it
      first.
    - `roll` in degrees turns it about its travel: at 0 its own x runs along the finger.

    What depends on the kind of object is a property of the object, which a class may replace:
    nothing else needs to know the classes.

    Raises
    ------
    InputError
        A field out of its limits; heights that are not finite or not smooth, or grow away from the
        middle.
    """

    table: ClassVar[str] = "indenter"
    common: ClassVar[Mapping[str, Key]] = PLACING

    friction: Annotated[
        float, Key("Coulomb's coefficient of friction with the skin; 0 is frictionless", at_least=0)
    ] = field(default=0.0, kw_only=True, repr=False)

    friction_kinetic: Annotated[
        float | None,
        Key("Coefficient of skin that slips; by default that of skin that sticks", at_least=0),
    ] = field(default=None, kw_only=True, repr=False)

    kind: ClassVar[str]
    sharp: ClassVar[bool] = False
    """Whether it has edges or ridges that the skin folds around; a surface of your own has, unless
    its class says that it is round, and errs as a ball of its least radius."""

    def __init_subclass__(cls) -> None:
        """Name the kind after the class, unless the class does."""
        if "kind" not in cls.__dict__:
            cls.kind = hyphenated(cls.__name__)
        if "surface" in cls.__dict__ and "sharp" not in cls.__dict__:
            cls.sharp = True

    def __post_init__(self) -> None:
        """Check every field, and the heights."""
        check(self)
        _ = self._surface
        if self.kinetic > self.friction:
            raise InputError(
                "indenter.friction_kinetic: expected at most indenter.friction = "
                f"{self.friction:g}, the coefficient of skin that sticks, received {self.kinetic:g}"
            )

    def surface(self, x: Array, y: Array) -> Array:
        """Return heights (...,) mm toward the finger at places x, y (...,) mm, before `roll`.

        The highest place, near the middle, touches first. Edges are rounded: the slope has no jump.
        """
        raise NotImplementedError

    def gradient(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the derivatives (...,) of the height along x and y; by default by differences."""
        raise NotImplementedError

    @property
    def profile(self) -> profiles.Profile:
        """The surface across the travel, before `roll`; by default the one of the heights."""
        assert self._surface is not None
        return self._surface

    @property
    def _surface(self) -> Surface | None:
        """The surface of the heights, checked; None where the class has another `profile`."""
        own = type(self)
        if own.profile is not Indenter.profile:
            return None
        if own.surface is Indenter.surface:
            raise InputError(
                f"indenter.kind: expected a class with a method surface(x, y), which returns its "
                f"heights, received {own.__name__} without it"
            )
        return _checked_surface(self)

    @property
    def signature(self) -> str:
        """Text by which results of the object are kept: its fields and, of a function, heights."""
        if self._surface is None:
            return repr(self)
        return f"{self!r} {hashlib.sha256(self._surface.grid.tobytes()).hexdigest()}"

    @property
    def least_radius(self) -> float:
        """Smallest radius of curvature in mm of what the pad meets; infinite for a plane.

        A ball has it at its foremost point, a relief at its sharpest crest.
        """
        if self.hertzian is not None:
            return min(self.hertzian)
        if self._surface is not None:
            return self._surface.least_radius
        raise NotImplementedError(f"{type(self).__name__}.least_radius, beside its own profile")

    @property
    def narrowest(self) -> float:
        """Smallest width in mm of what its edges leave to the pad, infinite without edges."""
        return float("inf")

    def describe(self) -> str:
        """Return the object in words, with its sizes: "a rigid sphere of radius 5 mm"."""
        own = {
            name: known.key.unit
            for name, known in keys_of(type(self)).items()
            if name not in keys_of(Indenter) and name not in PLACING
        }
        values = {name: getattr(self, name) for name in own}
        sizes = (
            f"{name} {x:g} {own[name]}".rstrip() if isinstance(x, float) else f"{name} {x}"
            for name, x in values.items()
        )
        return f"a rigid {self.kind} ({', '.join(sizes)})".removesuffix(" ()")

    @property
    def plate(self) -> Plate | None:
        """Angle and tilt of a plate, smooth or not; None for an object that is placed."""
        angle = getattr(self, "angle", None)
        return None if angle is None else Plate(angle, getattr(self, "tilt", 0.0))

    @property
    def flat(self) -> Plate | None:
        """Angle and tilt of a smooth plate; None for every other object."""
        return None

    @property
    def place(self) -> tuple[float, float] | None:
        """Place (x, y) in mm of first touch; None: where the 30 degree plate touches."""
        return getattr(self, "at", None)

    def moved(self, place: tuple[float, float]) -> Self:
        """Return the object at another place (x, y) in mm; InputError for one without a place."""
        if not hasattr(self, "at"):
            raise InputError(
                f"indenter.kind: expected an object with a place, such as a pin or a sphere, "
                f"received {self.kind!r}"
            )
        changes: dict[str, Any] = {"at": place}
        return replace(self, **changes)

    @property
    def turn(self) -> float:
        """Degrees by which the object is turned about its travel; 0 if it is round or a plane."""
        return float(getattr(self, "roll", 0.0))

    @property
    def hertzian(self) -> tuple[float, float] | None:
        """Radii of curvature in mm along x and y at the foremost point, infinite for a plane.

        None for an object that does not touch as a paraboloid.
        """
        return None

    @property
    def ball_radius(self) -> float | None:
        """Radius in mm of a ball; None for every other object."""
        return None

    @property
    def soft_body(self) -> Stack | None:
        """The elastic body of a soft object, relaxed; None where it is rigid."""
        return None

    @property
    def soft_prony(self) -> Prony:
        """The relaxation of a soft object."""
        return ELASTIC

    @property
    def feature(self) -> float:
        """Width in mm of its smallest dot, ridge, groove or stroke; infinite where it has none."""
        return float("inf")

    @property
    def repeats(self) -> tuple[float, float]:
        """Distances in mm along its own x and y after which raised parts come again; inf: none."""
        return float("inf"), float("inf")

    @property
    def raised(self) -> bool:
        """Whether it is a plate with raised parts whose crests have a stated radius."""
        return False

    @property
    def half_sides(self) -> tuple[float, float]:
        """Lengths in mm from its middle to its ends along its own x and y; inf where it goes on."""
        return float("inf"), float("inf")

    @property
    def extent(self) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """Ranges in mm of its own x and y beyond which it ends; None where it goes on."""
        return None

    @property
    def mirrored(self) -> bool:
        """Whether the object, as placed, is its own mirror image in the medial plane."""
        upright = self.plate is None or self.plate.tilt == 0
        central = self.place is None or self.place[1] == 0
        if not (upright and central and self.turn % 90 == 0):
            return False
        return self._surface is None or self._surface.mirrored(0 if self.turn % 180 else 1)

    @property
    def kinetic(self) -> float:
        """Kinetic coefficient of friction."""
        return self.friction if self.friction_kinetic is None else self.friction_kinetic


@lru_cache(maxsize=64)
def _checked_surface(indenter: Indenter) -> Surface:
    """Return the surface of the heights of an object; objects of equal fields share it."""
    stated = type(indenter).gradient is not Indenter.gradient
    surface = Surface(indenter.surface, indenter.gradient if stated else None)
    surface.check()
    return surface


class Inclined(Protocol):
    """Anything with the two angles of a plate, in degrees."""

    @property
    def angle(self) -> float:
        """Degrees about y."""

    @property
    def tilt(self) -> float:
        """Degrees about x."""


def direction(plate: Inclined) -> Array:
    """Return the unit normal (3,) of a plate toward the finger, which is its travel."""
    angle, tilt = np.radians(plate.angle), np.radians(plate.tilt)
    up = np.cos(angle)
    return np.array([-np.sin(angle), -np.sin(tilt) * up, np.cos(tilt) * up])


def turned(roll: float) -> str:
    """Describe the direction of an elongated object on the finger."""
    return f", turned by {roll:g} degrees from across the finger" if roll else ", across the finger"
