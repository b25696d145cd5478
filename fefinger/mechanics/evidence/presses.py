"""Measured presses, as `reports/evidence.json` holds them, and those nearest to a scene.

`validation/evidence/derive.py` makes that report of the measured ones. It has one layout: presses
with their features and their force and errors over the depth, by mechanics, mesh and quantity; the
factor of every mechanics and quantity; coefficients of cost.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, Self

import numpy as np

from fefinger.mechanics.evidence.features import Features
from fefinger.support.arrays import Array
from fefinger.support.inputs import read_report


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
