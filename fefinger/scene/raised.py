"""Plates with raised parts of one height.

Their sides rise as the smooth step S (`profiles.smooth_step`): seen from above a side of `height`
mm whose sharpest crest has the radius r is a flank of sqrt(10 / sqrt(3) r height) mm. It has to fit
on the part, and into the gap beside it. Sizes across are taken at half of the height.
"""

from abc import abstractmethod
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from fefinger.geometry import profiles
from fefinger.scene.indenter import Indenter
from fefinger.scene.key import Key
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


FLANK_SAMPLES = 10
"""Samples of a flank."""

FINEST = 0.02
"""Least distance in mm of samples: 10 million of them cover 60 x 60 mm."""

Crest = Annotated[
    float | None,
    Key("Radius of the crests; by default one that fits the other sizes", unit="mm", above=0),
]
"""Radius of the crests of raised parts."""

SHORTEST = 4 * FINEST
"""Least length in mm of a flank: in four samples its crest has the stated radius within 15 %."""


class FlankLimit(NamedTuple):
    """Largest width in mm of a flank that the sizes of an object allow, and the field to change."""

    field: str
    sizes: str
    width: float


def radius_of(flank: float, height: float) -> float:
    """Radius in mm of the crest of a flank in mm."""
    return flank**2 / profiles.flank_of(1.0, height) ** 2


def check_edge(edge: float, height: float, limit: FlankLimit, least: float = SHORTEST) -> None:
    """Raise InputError for an edge whose flank does not fit, or is shorter than `least` mm."""
    _, sizes, width = limit
    if profiles.flank_of(edge, height) > width * (1 + 1e-12):
        raise InputError(
            f"indenter.edge: expected at most {radius_of(width, height):.3g} mm, which makes its "
            f"flank as wide as the {width:.3g} mm that {sizes} leave it, received {edge:g}"
        )
    if profiles.flank_of(edge, height) < least * (1 - 1e-12):
        raise InputError(
            f"indenter.edge: expected at least {radius_of(least, height):.3g} mm at a height of "
            f"{height:.3g} mm, where its flank is {least:g} mm long, received {edge:g}"
        )


class Raised(Indenter):
    """A plate with raised parts of one height, `edge` mm the radius of their crests.

    By default that is `usual_edge`, or less where only a sharper one fits.
    """

    sharp = True
    raised = True
    usual_edge: ClassVar[float]

    height: float
    edge: Crest
    roll: float

    def __post_init__(self) -> None:
        """Check the edge, and what is between raised parts, besides."""
        super().__post_init__()
        narrowest = min(self.flank_limits, key=lambda each: each.width)
        field, sizes, width = narrowest
        if width < SHORTEST:
            raise InputError(
                f"indenter.{field}: expected sizes that leave the sides of raised parts at least "
                f"{SHORTEST:g} mm, received {sizes}, which leave {max(width, 0.0):.3g} mm"
            )
        if self.edge is not None:
            check_edge(self.edge, self.height, narrowest)

    @property
    @abstractmethod
    def flank_limits(self) -> tuple[FlankLimit, ...]:
        """Widths that the sizes leave to the sides of raised parts."""

    @property
    def feature(self) -> float:
        """Width in mm of the narrowest part, or gap between parts."""
        return min(each.width for each in self.flank_limits)

    @property
    def crest(self) -> float:
        """The radius of the crests in mm."""
        return self.edge or min(self.usual_edge, radius_of(self.feature, self.height))

    @property
    def flank(self) -> float:
        """Length in mm of their sides, seen from above."""
        return profiles.flank_of(self.crest, self.height)

    @property
    def pitch(self) -> float:
        """Distance in mm of the samples of the surface."""
        return max(self.flank / FLANK_SAMPLES, FINEST)

    @property
    def least_radius(self) -> float:
        """The radius of the crests in mm."""
        return self.crest

    def rising(self, inside: Array) -> Array:
        """Return the height in mm at places `inside` mm within the outline at half height."""
        t = np.clip(0.5 + inside / self.flank, 0.0, 1.0)
        return self.height * profiles.smooth_step(t)

    def _check_samples(self, field: str, value: object, sides: tuple[float, float]) -> None:
        """Raise InputError for a surface with `sides` mm that takes too many samples."""
        count = float(np.prod([side / self.pitch for side in sides]))
        # Largest number of samples of a surface, which takes some seconds and 1 GB.
        most = 10_000_000
        if count > most:
            raise InputError(
                f"indenter.{field}: expected a surface of at most {most:.0e} samples, received "
                f"{value!r}, whose {sides[0]:.3g} x {sides[1]:.3g} mm take {count:.1e} of them, "
                f"{self.pitch:.2g} mm apart; take a smaller one, or a rounder edge"
            )
