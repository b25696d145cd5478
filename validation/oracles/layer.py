"""Exact compliance of one elastic layer on a rigid base, and a paraboloid at a given depth.

`indentation.py` solves the contact on a `Sheet`. Lengths in mm, moduli in kPa. Source:
Lebedev and Ufliand 1958 (kernels).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array
from fefinger.theory.contact.indentation import Contact, LayeredBody, paraboloid
from fefinger.theory.contact.stack import Base


@dataclass(frozen=True)
class Sheet:
    """An elastic layer of `thickness` mm, bonded to a rigid base or sliding on it without friction.

    modulus E in kPa, poisson nu in 0 to 0.5.
    """

    thickness: float
    modulus: float
    poisson: float
    base: Base = "bonded"

    @property
    def surface(self) -> tuple[float, float]:
        """Modulus in kPa and Poisson's ratio."""
        return self.modulus, self.poisson

    @property
    def scales(self) -> tuple[float, float]:
        """Smallest and largest length in mm of the body: the thickness."""
        return self.thickness, self.thickness

    def compliance(self, xi: ArrayLike) -> Array:
        """Return L (n,) at wavenumbers xi (n,) in 1/mm: u_z over that of a half-space.

        Multiplied through by exp(-2 xi h), so that nothing overflows.
        """
        x = np.asarray(xi, np.float64) * self.thickness
        decay, double = np.exp(-2 * x), np.exp(-4 * x)
        if self.base == "sliding":
            return (1 - decay) ** 2 / (1 - double + 4 * x * decay)
        kappa = 3 - 4 * self.poisson
        top = kappa * (1 - double) - 4 * x * decay
        bottom = kappa * (1 + double) + (4 * x**2 + 1 + kappa**2) * decay
        return top / bottom


@dataclass(frozen=True)
class Faced:
    """A sheet in contact with an elastic body, such as a ball, instead of a rigid one.

    modulus E in kPa and poisson nu of that body, a half-space as in Hertz's theory. The compliances
    add: 1 - L is that of the sheet times its fraction of the sum. The depth of a contact is the
    approach of the two bodies.
    """

    sheet: Sheet
    modulus: float
    poisson: float

    @property
    def surface(self) -> tuple[float, float]:
        """Modulus in kPa and Poisson's ratio of a half-space as compliant as both at the top.

        At high wavenumbers the sheet is a half-space.
        """
        return 0.75 / (self._above + self._under), 0.5

    @property
    def scales(self) -> tuple[float, float]:
        """Smallest and largest length in mm: the thickness of the sheet."""
        return self.sheet.scales

    def compliance(self, xi: ArrayLike) -> Array:
        """Return L (n,) at wavenumbers xi (n,) in 1/mm: both u_z over those of two half-spaces."""
        part = self._under / (self._above + self._under)
        return 1 - part * (1 - self.sheet.compliance(xi))

    @property
    def _above(self) -> float:
        """Compliance 1 / E* of the touching body."""
        return 1 / elastic.plane_modulus(self.modulus, self.poisson)

    @property
    def _under(self) -> float:
        """Compliance 1 / E* of the sheet at high wavenumbers."""
        return 1 / elastic.plane_modulus(*self.sheet.surface)


def paraboloid_at(body: LayeredBody, radius: float, *, depth: float) -> Contact:
    """Solve the contact of a rigid paraboloid at an approach of `depth` mm, by a root in a.

    ValueError as `indentation.paraboloid`.
    """
    elastic.require_positive("paraboloid", radius=radius, depth=depth)
    guess = min(radius, math.sqrt(radius * depth))
    widest = radius * (1 - 1e-12)

    def excess(log_a: float) -> float:
        contact = paraboloid(body, radius, contact_radius=min(math.exp(log_a), widest))
        return math.log(contact.depth / depth)

    low, high = math.log(guess) - 0.7, math.log(guess) + 0.7
    # On a thin layer a tends to twice the Hertz value; under a stiff skin it falls far below it.
    while excess(low) > 0:
        low -= 0.7
    while excess(high) < 0:
        if high >= math.log(widest):
            raise ValueError(
                "paraboloid: expected a depth whose contact is at most as wide as the radius "
                f"{radius:g} mm (small strain), received {depth:g}"
            )
        high += 0.7
    a = math.exp(brentq(excess, low, high, xtol=1e-13, rtol=1e-13))
    return paraboloid(body, radius, contact_radius=min(a, widest))
