"""Hertz contact of a sphere and an elastic half-space, and Huber's field below it: the formula.

`mechanics/hertz.py` will answer scenes with it; `validation/hertz.py` proves the finite elements
against it. Lengths in mm, moduli and stresses in kPa, forces in mN; z points into the body.
Sources: Hertz 1881, Huber 1904; Johnson, Contact Mechanics, 1985, chapters 3 and 4.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


Array = NDArray[np.float64]


@dataclass(frozen=True)
class Hertz:
    """A rigid paraboloid r² / 2R pressed by `depth` mm into a half-space.

    radius R in mm, modulus E in kPa, poisson nu. Valid for a small against R, without friction.
    """

    radius: float
    depth: float
    modulus: float
    poisson: float

    @property
    def contact_radius(self) -> float:
        """A = sqrt(R depth) in mm."""
        return float(np.sqrt(self.radius * self.depth))

    @property
    def plane_modulus(self) -> float:
        """E* = E / (1 - nu²) in kPa."""
        return self.modulus / (1 - self.poisson**2)

    @property
    def force(self) -> float:
        """P = 4/3 E* sqrt(R) depth^(3/2) in mN."""
        return 4 / 3 * self.plane_modulus * self.radius**0.5 * self.depth**1.5

    @property
    def peak_pressure(self) -> float:
        """p0 = 2 E* / pi sqrt(depth / R) in kPa."""
        return 2 * self.plane_modulus / np.pi * float(np.sqrt(self.depth / self.radius))

    def pressure(self, r: ArrayLike) -> Array:
        """Contact pressure in kPa at the distance r (...,) mm from the axis, zero outside."""
        inside = 1 - (np.asarray(r, dtype=np.float64) / self.contact_radius) ** 2
        return self.peak_pressure * np.sqrt(np.maximum(inside, 0.0))

    def stress(self, r: ArrayLike, z: ArrayLike) -> Array:
        """Return sigma_r, sigma_theta, sigma_z, tau_rz (4, ...) in kPa, tension positive; z > 0.

        Huber's field, in the variables of Johnson 3.4; on the axis by its limit.
        """
        r, z = np.broadcast_arrays(np.asarray(r, np.float64), np.asarray(z, np.float64))
        a, p0, nu = self.contact_radius, self.peak_pressure, self.poisson
        u = self._ellipsoid(r, z)
        root = np.sqrt(u)
        t = z / root
        phi = np.arctan(a / root)
        common = t**3 * a**2 * u / (u**2 + a**2 * z**2)
        far = r > 1e-6 * a
        with np.errstate(divide="ignore", invalid="ignore"):
            ring = (1 - 2 * nu) / 3 * (a / r) ** 2 * (1 - t**3)
        bulge = (1 - nu) * u / (a**2 + u)
        swell = (1 + nu) * root / a * phi
        sigma_z = -p0 * common
        sigma_r = p0 * (ring + common + t * (bulge + swell - 2))
        sigma_t = -p0 * (ring + t * (2 * nu + bulge - swell))
        axis = p0 * (0.5 / (1 + (z / a) ** 2) - (1 + nu) * (1 - z / a * np.arctan2(a, z)))
        shear = -p0 * r * z**2 * a**2 * root / ((u**2 + a**2 * z**2) * (a**2 + u))
        return np.array(
            [np.where(far, sigma_r, axis), np.where(far, sigma_t, axis), sigma_z, shear]
        )

    def displacement(self, r: ArrayLike, z: ArrayLike) -> Array:
        """Return u_r, u_z (2, ...) in mm under the contact pressure; z > 0, zero at infinity."""
        r, z = np.broadcast_arrays(np.asarray(r, np.float64), np.asarray(z, np.float64))
        a, p0 = self.contact_radius, self.peak_pressure
        sigma_r, sigma_t, sigma_z, _ = self.stress(r, z)
        outward = r * (sigma_t - self.poisson * (sigma_r + sigma_z)) / self.modulus
        root = np.sqrt(self._ellipsoid(r, z))
        phi = np.arctan(a / root)
        i0 = 2 * phi / a
        i1 = (phi - a * root / (a**2 + root**2)) / a**3
        i2 = 2 / (a**2 * root) - 2 * phi / a**3
        psi = np.pi * p0 * a**2 / 2 * (i0 - r**2 * i1 - z**2 * i2)
        slope = -np.pi * p0 * a**2 * z * i2
        shear = self.modulus / (2 * (1 + self.poisson))
        inward = (2 * (1 - self.poisson) * psi - z * slope) / (4 * np.pi * shear)
        return np.array([outward, inward])

    def _ellipsoid(self, r: Array, z: Array) -> Array:
        """Positive root u of r² / (a² + u) + z² / u = 1."""
        half = (r**2 + z**2 - self.contact_radius**2) / 2
        return half + np.sqrt(half**2 + (self.contact_radius * z) ** 2)
