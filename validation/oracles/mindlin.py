"""Sphere sheared on a half-space under a constant normal force, and forces at a point of one.

Lengths in mm, moduli in kPa, forces in mN. a is the contact radius of Hertz, P its force. Sources:
Mindlin, J. Appl. Mech. 16:259, 1949; Mindlin and Deresiewicz, J. Appl. Mech. 20:327, 1953; Johnson,
Contact Mechanics, 1985, 7.2 and 7.4; the forces of Boussinesq and Cerruti, Johnson 3.2
and 3.6; z points into the body.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


@dataclass(frozen=True)
class Mindlin:
    """A sphere that is pressed with `force` mN on a circle of `radius` mm, and sheared.

    The half-space has the shear modulus `shear` kPa; the sphere is rigid.
    """

    radius: float
    force: float
    shear: float
    poisson: float
    friction: float

    @property
    def most(self) -> float:
        """Largest tangential force in mN."""
        return self.friction * self.force

    @property
    def stiffness(self) -> float:
        """Tangential force over displacement in mN/mm before any slip: 8 G a / (2 - nu)."""
        return 8 * self.shear * self.radius / (2 - self.poisson)

    def stick_radius(self, tangential: ArrayLike) -> Array:
        """Return the radius c in mm of the circle that sticks under a first tangential force."""
        return self.radius * np.cbrt(1 - np.asarray(tangential) / self.most)

    def displacement(self, tangential: ArrayLike) -> Array:
        """Return the displacement in mm of a tangential force in mN that rises from 0."""
        part = np.asarray(tangential) / self.most
        return 1.5 * self.most / self.stiffness * (1 - np.cbrt(1 - part) ** 2)

    def force_at(self, displacement: ArrayLike) -> Array:
        """Return the tangential force in mN at a displacement in mm that rises from 0."""
        limit = 1.5 * self.most / self.stiffness
        part = np.clip(1 - np.asarray(displacement) / limit, 0.0, None)
        return self.most * (1 - part**1.5)

    def back(self, tangential: ArrayLike, peak: float) -> Array:
        """Return the displacement in mm on the way back from a force `peak` mN: Masing's rule."""
        return self.displacement(peak) - 2 * self.displacement((peak - np.asarray(tangential)) / 2)

    def loop(self, peak: float) -> float:
        """Return the work in µJ lost in a cycle between the forces -peak and peak mN.

        Mindlin and Deresiewicz (1953), here as the area between both ways of the cycle.
        """
        force = np.linspace(-peak, peak, 200_001)
        gap = -self.back(-force, peak) - self.back(force, peak)
        return float(abs(np.trapezoid(gap, force)))

    def traction(self, r: ArrayLike, tangential: float) -> Array:
        """Return the traction in kPa at distances r mm from the axis, of a first loading."""
        r, c = np.asarray(r, float), float(self.stick_radius(tangential))
        top = 1.5 * self.most / (np.pi * self.radius**3)
        outer = np.sqrt(np.maximum(self.radius**2 - r**2, 0.0))
        return np.asarray(top * (outer - np.sqrt(np.maximum(c**2 - r**2, 0.0))))


def cerruti(x: ArrayLike, y: ArrayLike, z: ArrayLike, *, shear: float, poisson: float) -> Array:
    """Displacement (3, ...) in mm under a tangential force of 1 mN along x at the origin."""
    x, y, z = np.broadcast_arrays(*(np.asarray(each, float) for each in (x, y, z)))
    rho = np.sqrt(x**2 + y**2 + z**2)
    free = 1 - 2 * poisson
    along = 1 / rho + x**2 / rho**3
    along = along + free * (1 / (rho + z) - x**2 / (rho * (rho + z) ** 2))
    across = x * y / rho**3 - free * x * y / (rho * (rho + z) ** 2)
    down = x * z / rho**3 + free * x / (rho * (rho + z))
    return np.asarray(np.array([along, across, down]) / (4 * np.pi * shear))


def point_displacement(
    r: ArrayLike, z: ArrayLike, *, force: float, modulus: float, poisson: float
) -> Array:
    """Displacement u_r, u_z (2, ...) in mm under a normal point force in mN, zero at infinity."""
    r, z = np.broadcast_arrays(np.asarray(r, np.float64), np.asarray(z, np.float64))
    rho = np.hypot(r, z)
    scale = force / (4 * np.pi * elastic.shear_modulus(modulus, poisson))
    outward = r * z / rho**3 - (1 - 2 * poisson) * r / (rho * (rho + z))
    return scale * np.array([outward, z**2 / rho**3 + 2 * (1 - poisson) / rho])
