"""Features of a press, and the distance between two of them; which fingers were pressed.

Lengths of the object count against the thickness of the finger. Each number is scaled so that 1 is
a marked difference; logarithms, because errors follow ratios.
"""

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple, Self

from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD


HELD = ("rigid", None, "fixed")
"""Bone, nail and cut of the fingers that were measured."""


def as_pressed(finger: Finger) -> bool:
    """Whether a finger has the form of those that were pressed: no scan, rigid bone, one G(t)."""
    held = (finger.bone, finger.nail, finger.cut) == HELD
    return held and finger.surface is None and finger.relaxation == "whole"


def published_tissue(finger: Finger) -> bool:
    """Whether the tissues are the published ones, but for their moduli and the skin's thickness."""
    tissues = library.tissue_set(library.PUBLISHED)
    pairs = (finger.skin, tissues.skin), (finger.subcutaneous, tissues.subcutaneous)
    poisson = 0.005  # difference of Poisson's ratios that counts as none
    return (
        as_pressed(finger)
        and (finger.tip_tissue, finger.tip_radius) == (None, None)
        and all(
            layer.law == own.law
            and layer.prony is None
            and abs(layer.poisson - own.poisson) <= poisson
            for layer, own in pairs
        )
    )


@cache
def largest_exponents() -> Mapping[str, float]:
    """Return the largest exponent of stiffening of each layer among the fingers of subjects."""
    fitted = [library.tissue_set(name) for name in library.TISSUE_SETS if library.fitted_to(name)]
    return {
        "skin": max(each.skin.exponent or 0.0 for each in fitted),
        "subcutaneous": max(each.subcutaneous.exponent or 0.0 for each in fitted),
    }


def calibrated_subject(finger: Finger) -> str | None:
    """Return the subject whose unchanged calibrated finger this is; None for other fingers."""
    name = finger.subject_name
    if name is None or finger.tissue != library.calibrated_name(name):
        return None
    shipped = Finger.subject(name, tissue=finger.tissue, resolution=finger.resolution)
    return name if finger == shipped else None


LOGARITHM = 0.7
"""Difference of logarithms that counts 1: a factor of two."""

DEGREES = 15.0
"""Difference of angle or tilt that counts 1."""

ROUND = "round"
"""Kind of plates, balls, ellipsoids and cylinders, which curvatures tell apart."""


class Features(NamedTuple):
    """Features of a press.

    law: name of the strain energy of the tissue below the skin; raised: whether the object is a
    plate with raised parts; kind: that of an object with edges, else ROUND; exponent: stiffening of
    that tissue, 0 without one; numbers: by name, scaled.
    """

    law: str
    raised: bool
    kind: str
    exponent: float
    numbers: tuple[float, ...]

    @classmethod
    def of(cls, finger: Finger, indenter: Indenter) -> Self:
        """Return the features of an object pressed into a finger."""
        tissue, plate = finger.subcutaneous, indenter.plate or STANDARD
        # Difference of the logarithm of the finger's thickness that counts 1: all fingers that were
        # measured have one thickness within a fifth.
        size = 0.2
        away = 2.0  # distance in mm from the middle of the pad that counts 1
        numbers = (
            *(x / LOGARITHM for x in _shape(indenter, finger.thickness)),
            plate.angle / DEGREES,
            abs(plate.tilt) / DEGREES,
            math.hypot(*(indenter.place or (0.0, 0.0))) / away,
            math.log(finger.thickness) / size,
            math.log(finger.skin.modulus / tissue.modulus) / LOGARITHM,
            math.log(tissue.exponent or 1.0) / LOGARITHM,
        )
        kind = indenter.kind if indenter.sharp and not indenter.raised else ROUND
        return cls(tissue.law, indenter.raised, kind, tissue.exponent or 0.0, numbers)

    @classmethod
    def read(cls, record: Mapping[str, Any]) -> Self:
        """Return the features of a record of the report."""
        return cls(**(dict(record) | {"numbers": tuple(record["numbers"])}))

    def distance(self, other: Self) -> float:
        """Return the distance to another press; another kind or law counts 1."""
        unlike = (self.kind != other.kind) + (self.law != other.law)
        return math.sqrt(unlike + math.dist(self.numbers, other.numbers) ** 2)

    def farthest(self, other: Self) -> str:
        """Name the feature in which another press differs most."""
        apart = [abs(a - b) for a, b in zip(self.numbers, other.numbers, strict=True)]
        apart += [float(self.kind != other.kind), float(self.law != other.law)]
        return NAMES[apart.index(max(apart))]


NAMES = (
    *("larger curvature", "smaller curvature", "width of its edges", "angle", "tilt"),
    *("place", "thickness of the finger", "modulus of the skin", "stiffening of the tissue"),
    *("kind of object", "law of the tissue"),
)
"""Names of the numbers, of the kind and of the law."""


def _shape(indenter: Indenter, thickness: float) -> tuple[float, ...]:
    """Return log(1 + thickness / length) of least and largest radius, and of the width of edges.

    0 for plates, smooth or with raised parts: what counts of those is measured as one.
    """
    if indenter.raised:
        return 0.0, 0.0, 0.0
    low, high = sorted(indenter.hertzian or (indenter.least_radius, math.inf))
    lengths = low, high, indenter.narrowest
    return tuple(math.log1p(thickness / length) for length in lengths)
