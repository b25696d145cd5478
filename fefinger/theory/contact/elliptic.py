"""Hertz contact with two different curvatures: an elliptic contact under a rigid indenter.

Lengths in mm, moduli and stresses in kPa, forces in mN. Source: Hertz 1881; Johnson, Contact
Mechanics, 1985, 4.2. The elliptic integrals are Carlson's (DLMF 19.25.1), which do not cancel as
the ellipse becomes a circle.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import ellipkm1, elliprd

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


LONGEST = 1e6
"""Largest ratio of the radii: beyond, the contact is a line, whose depth is undefined."""


@dataclass(frozen=True)
class Elliptic:
    """A rigid indenter with gap x² / 2R' + y² / 2R'' pressed by `depth` mm into a half-space.

    Parameters
    ----------
    long_radius, short_radius
        Principal relative radii R' >= R'' in mm; the contact is longest along x.
    depth
        Approach in mm, at most R''.
    modulus, poisson
        E in kPa and nu in 0 to 0.5.

    Raises
    ------
    ValueError
        A value outside its range, R' < R'', or R' / R'' above 1e6.
    """

    long_radius: float
    short_radius: float
    depth: float
    modulus: float
    poisson: float

    def __post_init__(self) -> None:
        elastic.require_positive(
            "Elliptic",
            long_radius=self.long_radius,
            short_radius=self.short_radius,
            depth=self.depth,
        )
        elastic.require_elastic("Elliptic", self.modulus, self.poisson)
        if not 1 <= self.long_radius / self.short_radius <= LONGEST:
            raise ValueError(
                f"Elliptic: expected long_radius / short_radius in 1 to {LONGEST:g}, received "
                f"{self.long_radius:g} / {self.short_radius:g} mm"
            )
        elastic.require_small(
            "Elliptic", "a depth", self.depth, limit=self.short_radius, of="the short radius"
        )

    @cached_property
    def axis_ratio(self) -> float:
        """Ratio k = b / a <= 1 of the axes, from R' / R'' = [E/k² - K] / [K - E]."""
        target = self.long_radius / self.short_radius
        if target == 1:
            return 1.0

        def excess(log_k: float) -> float:
            square = math.exp(2 * log_k)
            return math.log(elliprd(0.0, 1.0, square) / elliprd(0.0, square, 1.0) / target)

        return math.exp(brentq(excess, -math.log(target), 0.0, xtol=1e-14, rtol=1e-14))

    @property
    def semi_axes(self) -> tuple[float, float]:
        """Half axes a >= b of the contact in mm."""
        k, near = self.axis_ratio, self._mean
        effective = math.sqrt(self.long_radius * self.short_radius)
        a = math.sqrt(2 * self.depth * effective * near / self._complete)
        return a, k * a

    @property
    def force(self) -> float:
        """P = 2 pi a E* depth / 3K in mN."""
        stiff = elastic.plane_modulus(self.modulus, self.poisson)
        return 2 * math.pi * self.semi_axes[0] * stiff * self.depth / (3 * self._complete)

    @property
    def area(self) -> float:
        """Contact area pi a b in mm²."""
        a, b = self.semi_axes
        return math.pi * a * b

    @property
    def peak_pressure(self) -> float:
        """p0 = 3 P / (2 pi a b) in kPa."""
        return 1.5 * self.force / self.area

    def pressure(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Contact pressure in kPa at x, y (...,) mm, zero outside the ellipse."""
        a, b = self.semi_axes
        x, y = elastic.numbers("Elliptic", "x", x), elastic.numbers("Elliptic", "y", y)
        inside = 1 - (x / a) ** 2 - (y / b) ** 2
        return self.peak_pressure * np.sqrt(np.maximum(inside, 0.0))

    @property
    def _complete(self) -> float:
        """Complete elliptic integral K(1 - k²)."""
        return float(ellipkm1(self.axis_ratio**2))

    @property
    def _mean(self) -> float:
        """The factor sqrt((E/k² - K)(K - E)) / (1 - k²) of the semi-axes; pi/4 for a circle."""
        square = self.axis_ratio**2
        return math.sqrt(elliprd(0.0, 1.0, square) * elliprd(0.0, square, 1.0)) / 3
