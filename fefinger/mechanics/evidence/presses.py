"""Measured presses of `reports/evidence.json`, their features, and those nearest to a scene.

`validation/evidence/derive.py` makes that report of the measured ones. It has one layout: presses
with their features and their force and errors over the depth, by mechanics, mesh and quantity; the
factor of every mechanics and quantity; coefficients of cost.

Lengths of the object count against the thickness of the finger. Each number is scaled so that 1 is
a marked difference; logarithms, because errors follow ratios.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, NamedTuple, Self

import numpy as np

from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array
from fefinger.support.inputs import read_report


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


EVIDENCE = "evidence.json"


@dataclass(frozen=True, eq=False)
class Press:
    """A measured press of an object into a finger.

    part (n,): depth over the thickness of the finger; force (n,): that of finite strain in N, of
    relaxed tissue; thickness in mm and modulus in kPa (below the skin) of the finger; errors: by
    the label of a candidate and the quantity (n,), as fractions, nan where there is none.
    """

    name: str
    features: Features
    part: Array
    force: Array
    thickness: float
    modulus: float
    errors: Mapping[str, Mapping[str, Array]]

    @classmethod
    def of(cls, name: str, record: Mapping[str, Any], tabulation: Mapping[str, Any]) -> Self:
        """Read a press from its record.

        tabulation: errors over `part` by quantity. Those of `pressed` are of the mesh and of
        tabulation, which are independent.
        """
        errors = {
            label: {quantity: np.array(each, dtype=float) for quantity, each in row.items()}
            for label, row in record["errors"].items()
        }
        part, force = (np.array(record[key], dtype=float) for key in ("part", "force_N"))
        left_out = {
            quantity: np.interp(np.log(part), np.log(tabulation["part"]), each)
            for quantity, each in tabulation.items()
        }
        for label in [each for each in errors if each.startswith("solid")]:
            errors[label.replace("solid", "pressed")] = {
                quantity: np.hypot(each, left_out[quantity.partition(" ")[0]])
                for quantity, each in errors[label].items()
            }
        sizes = record["thickness_mm"], record["subcutaneous_kPa"]
        return cls(name, Features.read(record["features"]), part, force, *sizes, errors)

    def depth_under(self, force: float, thickness: float, modulus: float) -> float:
        """Return the depth over the thickness under a force in N, for a finger of that law.

        thickness in mm; modulus: that below the skin in kPa. Forces scale with the modulus and the
        square of the size. Beyond the largest force the depth is extrapolated linearly, an upper
        bound of tissue that stiffens.
        """
        scaled = force * self.modulus / modulus * (self.thickness / thickness) ** 2
        forces, parts = np.append(0.0, self.force), np.append(0.0, self.part)
        slope = (parts[-1] - parts[-2]) / (forces[-1] - forces[-2])
        return float(np.interp(scaled, forces, parts) + slope * max(scaled - forces[-1], 0.0))

    def steepness(self, part: float) -> float:
        """Return the smallest exponent of force over depth near a relative depth."""
        powers = np.diff(np.log(self.force)) / np.diff(np.log(self.part))
        at = int(np.searchsorted(self.part, part))
        return float(powers[max(at - 2, 0) : at + 1].min(initial=powers[-1]))


@cache
def read(name: str) -> dict[str, Any]:
    """Return a report as it is written."""
    return dict(json.loads(read_report(name)))


@cache
def presses() -> tuple[Press, ...]:
    """Return all measured presses."""
    evidence = read(EVIDENCE)
    left_out = evidence["tabulation"]
    return tuple(Press.of(name, row, left_out) for name, row in evidence["presses"].items())


@lru_cache(maxsize=64)
def nearest(features: Features) -> tuple[tuple[float, Press], ...]:
    """Return distance and press, of all that are raised as this object is or not, nearest first."""
    alike = [each for each in presses() if each.features.raised == features.raised]
    pairs = [(features.distance(each.features), each) for each in alike]
    return tuple(sorted(pairs, key=lambda pair: pair[0]))


def pressed(features: Features) -> Press:
    """Return the nearest press of an object without raised parts into tissue of the same law.

    Of the nearest law where none has that one.
    """
    plain = [press for _, press in nearest(features._replace(raised=False))]
    return next((each for each in plain if each.features.law == features.law), plain[0])
