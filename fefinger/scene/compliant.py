"""Objects that may be soft: an elastic half-space, or a layer on a rigid base."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from fefinger.scene.indenter import Indenter
from fefinger.scene.key import Key
from fefinger.support.checks import InputError
from fefinger.theory.contact.stack import Layer, Stack


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
            "Young's modulus of a soft object; rigid by default", unit="kPa", above=0, written=False
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

    def __post_init__(self) -> None:
        """Check the fields, and that they belong together."""
        super().__post_init__()
        if self.modulus is None:
            for name, usual in (("poisson", POISSON), ("thickness", None)):
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
    def signature(self) -> str:
        """Text by which results of the object are kept."""
        if self.modulus is None:
            return super().signature
        return f"{super().signature} {self.modulus!r} {self.poisson!r} {self.thickness!r}"

    @property
    def _stuff(self) -> tuple[str, str]:
        """Words for what it is made of: "rigid" and nothing, or "soft" and "50 kPa"."""
        if self.modulus is None:
            return "rigid", ""
        layer = f" ({self.thickness:g} mm thick on a rigid base)" if self.thickness else ""
        return "soft", f"{self.modulus:g} kPa{layer}"

    def _described(self, noun: str, size: str) -> str:
        """Return "a rigid sphere of radius 5 mm", or "a soft sphere of 50 kPa, radius 5 mm"."""
        hardness, material = self._stuff
        return f"a {hardness} {noun} of {material}{', ' if material else ''}{size}"
