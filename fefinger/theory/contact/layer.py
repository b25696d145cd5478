"""One elastic layer on a rigid base: exact compliance, and published approximations.

`indentation.py` solves the contact on a `Sheet` exactly; the polynomials give the ratio of
the force to that of Hertz at equal depth as functions of chi = sqrt(R depth) / h. Lengths in mm,
moduli in kPa. Sources: Lebedev and Ufliand 1958 (kernels); Dimitriadis et al., Biophys. J. 82,
2002, 2798; Garcia and Garcia, Biophys. J. 114, 2018, 2923.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array
from fefinger.theory.contact.stack import Base


DIMITRIADIS_RANGE = 0.2
"""Largest chi of the bonded polynomial of Dimitriadis: measured 1.1 % low at 0.2, 9 % at 0.55."""

GARCIA_RANGE = 0.55
"""Largest chi of the polynomial of Garcia and Garcia: measured 1.2 % low at 0.55, 17 % at 1.05."""

THIN_RANGE = 20.0
"""Smallest a / h of the thin limit: measured 4 % low at 20, 15 % at 10."""


@dataclass(frozen=True)
class Sheet:
    """An elastic layer of `thickness` mm, bonded to a rigid base or sliding on it without friction.

    modulus E in kPa, poisson nu in 0 to 0.5; ValueError for a value outside its range.
    """

    thickness: float
    modulus: float
    poisson: float
    base: Base = "bonded"

    def __post_init__(self) -> None:
        """Check the ranges."""
        elastic.require_positive("Sheet", thickness=self.thickness)
        elastic.require_elastic("Sheet", self.modulus, self.poisson)
        if self.base not in ("bonded", "sliding"):
            msg = f"Sheet: expected the base 'bonded' or 'sliding', received {self.base!r}"
            raise ValueError(msg)

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
        x = elastic.numbers("Sheet", "wavenumbers", xi, least=0.0) * self.thickness
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
    approach of the two bodies. ValueError for a value outside its
    range.
    """

    sheet: Sheet
    modulus: float
    poisson: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        elastic.require_elastic("Faced", self.modulus, self.poisson)

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


def dimitriadis(chi: ArrayLike, poisson: float, *, bonded: bool = True) -> Array:
    """Force ratio P / P_Hertz of Dimitriadis et al.; chi at most 0.2 (ValueError beyond).

    Against the exact layer: bonded and incompressible 0.9 % low at 0.19, growing fast; not bonded,
    right at nu = 0.3 only, since the exact sliding layer does not depend on nu and this one does
    (nu = 0.5: 2.7 % high at 0.19).
    """
    elastic.require_elastic("dimitriadis", 1.0, poisson)
    chi = _within("dimitriadis", chi, DIMITRIADIS_RANGE)
    if bonded:
        alpha = -(1.2876 - 1.4678 * poisson + 1.3442 * poisson**2) / (1 - poisson)
        beta = (0.6387 - 1.0277 * poisson + 1.5164 * poisson**2) / (1 - poisson)
    else:
        alpha = -0.347 * (3 - 2 * poisson) / (1 - poisson)
        beta = 0.056 * (5 - 2 * poisson) / (1 - poisson)
    pi = math.pi
    terms = [
        1.0,
        -2 * alpha / pi,
        4 * alpha**2 / pi**2,
        -8 / pi**3 * (alpha**3 + 4 * pi**2 * beta / 15),
        16 * alpha / pi**4 * (alpha**3 + 3 * pi**2 * beta / 5),
    ]
    return np.asarray(np.polynomial.polynomial.polyval(chi, terms))


def garcia(chi: ArrayLike) -> Array:
    """Force ratio P / P_Hertz of Garcia and Garcia: bonded, incompressible, chi at most 0.55."""
    chi = _within("garcia", chi, GARCIA_RANGE)
    return np.asarray(np.polynomial.polynomial.polyval(chi, [1, 1.133, 1.497, 1.469, 0.755]))


@dataclass(frozen=True)
class Thin:
    """Contact with a bonded incompressible layer far thinner than the contact: lubrication limit.

    thickness h, radius R and depth in mm, modulus E in kPa. ValueError for a / h below 20.
    """

    thickness: float
    radius: float
    depth: float
    modulus: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        elastic.require_positive(
            "Thin",
            thickness=self.thickness,
            radius=self.radius,
            depth=self.depth,
            modulus=self.modulus,
        )
        if self.contact_radius < THIN_RANGE * self.thickness:
            msg = (
                f"Thin: expected a contact radius of at least {THIN_RANGE:g} thicknesses, received "
                f"{self.contact_radius / self.thickness:.3g}; use indentation.paraboloid"
            )
            raise ValueError(msg)

    @property
    def contact_radius(self) -> float:
        """Contact radius a = 2 sqrt(R depth) in mm."""
        return 2 * math.sqrt(self.radius * self.depth)

    @property
    def force(self) -> float:
        """P = 2 pi G R² depth³ / h³ in mN."""
        shear = elastic.shear_modulus(self.modulus, 0.5)
        return 2 * math.pi * shear * self.radius**2 * (self.depth / self.thickness) ** 3

    def pressure(self, r: ArrayLike) -> Array:
        """Contact pressure 3 G (a² - r²)² / (32 R h³) in kPa at r (...,) mm, zero outside."""
        inside = np.maximum(self.contact_radius**2 - elastic.distances("Thin", r) ** 2, 0.0)
        shear = elastic.shear_modulus(self.modulus, 0.5)
        return 3 * shear / (32 * self.radius * self.thickness**3) * inside**2


def _within(owner: str, chi: ArrayLike, largest: float) -> Array:
    """Check that chi is in the range of a polynomial."""
    chi = np.asarray(chi, np.float64)
    if not np.all((chi >= 0) & (chi <= largest)):
        msg = (
            f"{owner}: expected chi = sqrt(R depth) / h in 0 to {largest:g}, where it was measured "
            f"against the exact layer; use indentation.paraboloid beyond"
        )
        raise ValueError(msg)
    return chi
