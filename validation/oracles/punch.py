"""Rigid cone and flat punch on an elastic half-space, without friction.

Lengths in mm, moduli and stresses in kPa, forces in mN. Source: Sneddon, Int. J. Eng. Sci. 3,
1965, 47.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


@dataclass(frozen=True)
class Cone:
    """A rigid cone pressed by `depth` mm; `half_angle` in degrees from the axis.

    modulus E in kPa, poisson nu in 0 to 0.5. Small slopes: half angles of 45 degrees or more.
    """

    half_angle: float
    depth: float
    modulus: float
    poisson: float

    @property
    def contact_radius(self) -> float:
        """Contact radius a = 2/pi depth tan(half angle) in mm."""
        return 2 / math.pi * self.depth * math.tan(math.radians(self.half_angle))

    @property
    def force(self) -> float:
        """P = E* a depth = 2/pi E* depth² tan(half angle) in mN."""
        return elastic.plane_modulus(self.modulus, self.poisson) * self.contact_radius * self.depth

    def pressure(self, r: ArrayLike) -> Array:
        """Contact pressure in kPa at r (...,) mm, infinite at the tip, zero outside."""
        scale = elastic.plane_modulus(self.modulus, self.poisson) / 2
        scale /= math.tan(math.radians(self.half_angle))
        with np.errstate(divide="ignore"):
            return scale * np.arccosh(
                np.maximum(self.contact_radius / np.asarray(r, np.float64), 1.0)
            )

    def displacement(self, r: ArrayLike) -> Array:
        """Displacement u_z of the surface in mm at r (...,) mm, the cone itself inside."""
        x = np.asarray(r, np.float64) / self.contact_radius
        slope = self.depth * 2 / math.pi
        far = np.maximum(x, 1.0)
        free = np.arcsin(1 / far) - (far - np.sqrt(far**2 - 1))
        return np.where(x <= 1, self.depth - slope * x, slope * free)


@dataclass(frozen=True)
class FlatPunch:
    """A rigid cylinder of radius a with a flat end, pressed by `depth` mm.

    contact_radius a in mm, modulus E in kPa, poisson nu in 0 to 0.5. Small strain: depths below a.
    """

    contact_radius: float
    depth: float
    modulus: float
    poisson: float

    @property
    def force(self) -> float:
        """P = 2 E* a depth in mN."""
        stiff = elastic.plane_modulus(self.modulus, self.poisson)
        return 2 * stiff * self.contact_radius * self.depth

    def pressure(self, r: ArrayLike) -> Array:
        """Contact pressure in kPa at r (...,) mm, infinite at the edge, zero outside."""
        r, a = np.asarray(r, np.float64), self.contact_radius
        inside = np.maximum(1 - (r / a) ** 2, 0.0)
        with np.errstate(divide="ignore"):
            shape = inside**-0.5
        return np.where(r <= a, self.force / (2 * np.pi * a**2) * shape, 0.0)

    def displacement(self, r: ArrayLike) -> Array:
        """Displacement u_z of the surface in mm at r (...,): 2 depth / pi asin(a / r) outside."""
        far = np.maximum(np.asarray(r, np.float64), self.contact_radius)
        ratio = self.contact_radius / far
        return 2 * self.depth / np.pi * np.arcsin(ratio)
