"""Hertz contact of a sphere or of two curvatures, with Huber's stress field below a sphere.

`mechanics/hertz.py` answers scenes with it; `validation/fem/hertz.py` checks the finite elements
against it. Lengths in mm, moduli and stresses in kPa, forces in mN; z points into the body.
Sources: Hertz 1881, Huber 1904; Johnson, Contact Mechanics, 1985, chapters 3 and 4.
The elliptic integrals are Carlson's (DLMF 19.25.1), which do not cancel as the ellipse becomes a
circle.
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
