"""Hertz contact of a sphere and an elastic half-space, with Huber's stress field below it.

`mechanics/hertz.py` answers scenes with it; `validation/fem/hertz.py` checks the finite elements
against it. Lengths in mm, moduli and stresses in kPa, forces in mN; z points into the body.
Sources: Hertz 1881, Huber 1904; Johnson, Contact Mechanics, 1985, chapters 3 and 4.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


@dataclass(frozen=True)
class Hertz:
    """A rigid paraboloid r² / 2R pressed by `depth` mm into a half-space, without friction.

    Parameters
    ----------
    radius
        R in mm.
    depth
        Approach in mm, 0 (touch, no field) to R, where the contact is as wide as the sphere.
        The force on a true sphere differs by 0.4 % at a/R = 0.2 (Sneddon 1965).
    modulus, poisson
        E in kPa and nu in 0 to 0.5.

    Raises
    ------
    ValueError
        A value outside its range.
    """

    radius: float
    depth: float
    modulus: float
    poisson: float

    def __post_init__(self) -> None:
        elastic.require_positive("Hertz", radius=self.radius)
        elastic.require_not_negative("Hertz", depth=self.depth)
        elastic.require_elastic("Hertz", self.modulus, self.poisson)
        elastic.require_small("Hertz", "a depth", self.depth, limit=self.radius, of="the radius")

    @property
    def contact_radius(self) -> float:
        """Contact radius a = sqrt(R depth) in mm."""
        return float(np.sqrt(self.radius * self.depth))

    @property
    def plane_modulus(self) -> float:
        """E* = E / (1 - nu²) in kPa."""
        return elastic.plane_modulus(self.modulus, self.poisson)

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
        inside = 1 - (elastic.numbers("Hertz", "r", r, least=0.0) / self._size) ** 2
        return self.peak_pressure * np.sqrt(np.maximum(inside, 0.0))

    def stress(self, r: ArrayLike, z: ArrayLike) -> Array:
        """Return sigma_r, sigma_theta, sigma_z, tau_rz (4, ...) in kPa, tension positive.

        Huber's field in the variables of Johnson 3.4, with 1 - t² = r² / (a² + u) substituted,
        which makes it regular on the axis and on the surface. ValueError for r < 0 or z < 0.
        """
        r, z = elastic.points("Hertz.stress", r, z)
        a, nu = self._size, self.poisson
        u, t = self._ellipsoid(r, z)
        root = np.sqrt(u)
        wide = a**2 + u
        narrow = u + (a * t) ** 2
        # Zero only at the edge on the surface, where both quotients vanish.
        narrow = np.where(narrow > 0, narrow, 1.0)
        common = t**3 * a**2 / narrow
        ring = (1 - 2 * nu) / 3 * a**2 / wide * (1 + t + t**2) / (1 + t)
        bulge = (1 - nu) * u / wide
        swell = (1 + nu) * root / a * np.arctan2(a, root)
        radial = ring + common + t * (bulge + swell - 2)
        hoop = -(ring + t * (2 * nu + bulge - swell))
        shear = -r * (a * t) ** 2 * root / (narrow * wide)
        return self.peak_pressure * np.array([radial, hoop, -common, shear])

    def strain(self, r: ArrayLike, z: ArrayLike) -> Array:
        """Return the strains r, theta, z and rz (4, ...), rz the tensor component."""
        return elastic.strain(self.stress(r, z), self.modulus, self.poisson)

    def displacement(self, r: ArrayLike, z: ArrayLike) -> Array:
        """Return u_r, u_z (2, ...) in mm under the contact pressure, zero at infinity."""
        r, z = elastic.points("Hertz.displacement", r, z)
        a = self._size
        hoop = elastic.strain(self.stress(r, z), self.modulus, self.poisson)[1]
        u, t = self._ellipsoid(r, z)
        root = np.sqrt(u)
        phi = np.arctan2(a, root)
        bend = (phi - a * root / (a**2 + u)) / a
        lift = 2 * t**2 * root * (1 - root * phi / a)
        scale = np.pi * self.peak_pressure / 2
        psi = scale * (2 * a * phi - r**2 * bend - lift)
        slope = -2 * scale * lift
        shear = elastic.shear_modulus(self.modulus, self.poisson)
        inward = (2 * (1 - self.poisson) * psi - slope) / (4 * np.pi * shear)
        return np.array([r * hoop, inward])

    @property
    def _size(self) -> float:
        """Length scale of the fields; at first touch, where they are zero, any value serves."""
        return self.contact_radius or 1.0

    def _ellipsoid(self, r: Array, z: Array) -> tuple[Array, Array]:
        """Positive root u of r² / (a² + u) + z² / u = 1, and t = z / sqrt(u), also at z = 0."""
        a = self._size
        half = (r**2 + z**2 - a**2) / 2
        root = np.hypot(half, a * z)
        inside = half < 0
        # Of the two algebraic forms of the root, the one that does not cancel.
        far = np.where(inside, 1.0, half + root)
        near = np.where(inside, root - half, 1.0)
        u = np.where(inside, (a * z) ** 2 / near, far)
        t = np.where(inside, np.sqrt(near) / a, z / np.sqrt(np.where(u > 0, u, 1.0)))
        return u, np.minimum(t, 1.0)


def relative_radius(*radii: float) -> float:
    """Relative radius R in mm with 1/R = sum of 1/Ri (Eq. 3.9 and 3.19).

    A flat surface has an infinite Ri, a hollow one a negative Ri. Pawluk (1997), section 3.5.

    Raises ValueError for a radius of 0, or conforming surfaces, which do not touch first in a
    point.
    """
    if not radii or any(radius == 0 or math.isnan(radius) for radius in radii):
        raise ValueError(f"radii: expected radii in mm other than 0, received {list(radii)}")
    curvature = math.fsum(1 / radius for radius in radii)
    if curvature <= 0:
        msg = f"radii: expected surfaces that touch in a point, received {list(radii)} mm"
        raise ValueError(msg)
    return 1 / curvature


def equivalent_radius(first: float, second: float) -> float:
    """Radius sqrt(R' R'') in mm of the circular contact equivalent to an elliptic one.

    For R'/R'' up to 5 the mean contact radius is then within 3.3 %, the depth within 3.4 % and the
    peak pressure within 7 % of the elliptic contact.
    """
    elastic.require_positive("equivalent_radius", first=first, second=second)
    return math.sqrt(first * second)
