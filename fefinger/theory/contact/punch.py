"""Rigid cone, flat punch and cylinder on an elastic half-space, without friction.

Lengths in mm, moduli and stresses in kPa, forces in mN (mN/mm for the cylinder). Sources: Sneddon,
Int. J. Eng. Sci. 3, 1965, 47 (cone, punch); Johnson, Contact Mechanics, 1985, 4.2 (cylinder).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


STEEPEST = 45.0
"""Smallest half angle of a cone in degrees: linear theory assumes small slopes."""


@dataclass(frozen=True)
class Cone:
    """A rigid cone pressed by `depth` mm; `half_angle` in degrees from the axis, 45 to below 90.

    modulus E in kPa, poisson nu in 0 to 0.5; ValueError for a value outside its range.
    """

    half_angle: float
    depth: float
    modulus: float
    poisson: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        elastic.require_positive("Cone", depth=self.depth)
        elastic.require_elastic("Cone", self.modulus, self.poisson)
        if not STEEPEST <= self.half_angle < 90:
            msg = (
                f"Cone: expected a half angle in {STEEPEST:g} to below 90 degrees (small slope), "
                f"received {self.half_angle!r}"
            )
            raise ValueError(msg)

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
                np.maximum(self.contact_radius / elastic.distances("Cone", r), 1.0)
            )

    def displacement(self, r: ArrayLike) -> Array:
        """Displacement u_z of the surface in mm at r (...,) mm, the cone itself inside."""
        x = elastic.distances("Cone", r) / self.contact_radius
        slope = self.depth * 2 / math.pi
        far = np.maximum(x, 1.0)
        free = np.arcsin(1 / far) - (far - np.sqrt(far**2 - 1))
        return np.where(x <= 1, self.depth - slope * x, slope * free)


@dataclass(frozen=True)
class FlatPunch:
    """A rigid cylinder of radius a with a flat end, pressed by `depth` mm.

    contact_radius a in mm, modulus E in kPa, poisson nu in 0 to 0.5; depth at most a (small
    strain); ValueError for a value outside its range.
    """

    contact_radius: float
    depth: float
    modulus: float
    poisson: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        elastic.require_positive("FlatPunch", contact_radius=self.contact_radius, depth=self.depth)
        elastic.require_elastic("FlatPunch", self.modulus, self.poisson)
        elastic.require_small(
            "FlatPunch", "a depth", self.depth, limit=self.contact_radius, of="the contact radius"
        )

    @property
    def force(self) -> float:
        """P = 2 E* a depth in mN."""
        stiff = elastic.plane_modulus(self.modulus, self.poisson)
        return 2 * stiff * self.contact_radius * self.depth

    def pressure(self, r: ArrayLike) -> Array:
        """Contact pressure in kPa at r (...,) mm, infinite at the edge, zero outside."""
        r, a = elastic.distances("FlatPunch", r), self.contact_radius
        inside = np.maximum(1 - (r / a) ** 2, 0.0)
        with np.errstate(divide="ignore"):
            shape = inside**-0.5
        return np.where(r <= a, self.force / (2 * np.pi * a**2) * shape, 0.0)

    def displacement(self, r: ArrayLike) -> Array:
        """Displacement u_z of the surface in mm at r (...,): 2 depth / pi asin(a / r) outside."""
        far = np.maximum(elastic.distances("FlatPunch", r), self.contact_radius)
        ratio = self.contact_radius / far
        return 2 * self.depth / np.pi * np.arcsin(ratio)


@dataclass(frozen=True)
class Cylinder:
    """A rigid cylinder of `radius` R mm on its side, pressed by `line_force` mN per mm of length.

    Plane strain; modulus E in kPa, poisson nu in 0 to 0.5. The approach has no value in plane
    strain (it grows as the logarithm of the size of the body). ValueError for a value outside its
    range or a half width above R.
    """

    radius: float
    line_force: float
    modulus: float
    poisson: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        elastic.require_positive("Cylinder", radius=self.radius, line_force=self.line_force)
        elastic.require_elastic("Cylinder", self.modulus, self.poisson)
        elastic.require_small(
            "Cylinder", "a half width", self.half_width, limit=self.radius, of="the radius"
        )

    @property
    def half_width(self) -> float:
        """Half width b = sqrt(4 P' R / (pi E*)) of the contact in mm."""
        stiff = elastic.plane_modulus(self.modulus, self.poisson)
        return math.sqrt(4 * self.line_force * self.radius / (math.pi * stiff))

    @property
    def peak_pressure(self) -> float:
        """p0 = sqrt(P' E* / (pi R)) in kPa."""
        stiff = elastic.plane_modulus(self.modulus, self.poisson)
        return math.sqrt(self.line_force * stiff / (math.pi * self.radius))

    def pressure(self, x: ArrayLike) -> Array:
        """Contact pressure in kPa at x (...,) mm from the middle line, zero outside."""
        inside = 1 - (elastic.numbers("Cylinder", "x", x) / self.half_width) ** 2
        return self.peak_pressure * np.sqrt(np.maximum(inside, 0.0))

    def stress(self, x: ArrayLike, z: ArrayLike) -> Array:
        """Stress sigma_x, sigma_z, tau_xz (3, ...) in kPa at z >= 0 (McEwen; Johnson 4.49)."""
        _, z = elastic.points("Cylinder.stress", np.abs(x), z)
        x, b = np.broadcast_to(np.asarray(x, np.float64), z.shape), self.half_width
        # The complex root of (x + iz)² - b² is n + im in McEwen's notation, up to its sign.
        root = np.sqrt((x + 1j * z - b) + 0j) * np.sqrt((x + 1j * z + b) + 0j)
        n, m = root.real, root.imag
        size = np.where(np.abs(root) > 0, np.abs(root) ** 2, 1.0)
        spread = (z**2 + n**2) / size
        scale = -self.peak_pressure / b
        return scale * np.array(
            [
                m * (1 + spread) - 2 * z,
                m * (1 - spread),
                n * (m**2 - z**2) / size,
            ]
        )
