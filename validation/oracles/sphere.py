"""Contact of a rigid sphere and an elastic half-space, beyond the paraboloid of Hertz.

Lengths in mm, moduli and stresses in kPa, forces in mN. Source: Sneddon, Int. J. Eng. Sci. 3,
1965, 47; the pressure is the Abel integral of his solution.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


WIDEST = 0.9
"""Largest a/R: the displacement diverges at 1, and linear strain ends long before."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)


def _force(x: float) -> float:
    """Force function (1 + x²) artanh x - x, by its series where that cancels."""
    if x > 0.1:
        return (1 + x * x) * math.atanh(x) - x
    odd = range(1, 21, 2)
    return sum(x ** (n + 2) * (1 / (n + 2) + 1 / n) for n in odd)


@dataclass(frozen=True)
class Sphere:
    """A rigid frictionless sphere that touches a half-space on a circle of `contact_radius` a.

    radius R and a in mm, modulus E in kPa, poisson nu in 0 to 0.5. Small strain and small slope in
    the body: a of at most 0.9 R.
    """

    radius: float
    contact_radius: float
    modulus: float
    poisson: float

    @classmethod
    def at_depth(cls, radius: float, depth: float, *, modulus: float, poisson: float) -> "Sphere":
        """Return the contact at an approach of `depth` mm: depth = a artanh(a / R)."""
        ratio = depth / radius
        if ratio > WIDEST * math.atanh(WIDEST):
            msg = (
                f"Sphere: expected a depth of at most {WIDEST * math.atanh(WIDEST):.3g} R, where "
                f"a = {WIDEST} R, received {ratio:.3g} R"
            )
            raise ValueError(msg)
        ratio_of_radii = brentq(
            lambda x: x * math.atanh(x) - ratio, 0.0, WIDEST, xtol=1e-300, rtol=1e-14
        )
        return cls(radius, ratio_of_radii * radius, modulus=modulus, poisson=poisson)

    @property
    def depth(self) -> float:
        """Approach a/2 ln((R + a) / (R - a)) in mm."""
        return self.contact_radius * math.atanh(self.contact_radius / self.radius)

    @property
    def force(self) -> float:
        """P = E*/2 [(a² + R²) ln((R + a) / (R - a)) - 2 a R] in mN."""
        a, big = self.contact_radius, self.radius
        stiff = elastic.plane_modulus(self.modulus, self.poisson)
        return stiff * big**2 * _force(a / big)

    def pressure(self, r: ArrayLike) -> Array:
        """Contact pressure in kPa at the distance r (...,) mm from the axis, zero outside."""
        r, a, big = np.asarray(r, np.float64), self.contact_radius, self.radius
        reach = np.sqrt(np.maximum(a**2 - r**2, 0.0))[..., None]
        t = np.sqrt(r[..., None] ** 2 + (reach * (_NODES + 1) / 2) ** 2)
        t = np.maximum(t, 1e-9 * a)
        slope = np.arctanh(np.minimum(t, a) / big) / t + big / (big**2 - np.minimum(t, a) ** 2)
        stiff = elastic.plane_modulus(self.modulus, self.poisson)
        return stiff / np.pi * (slope * reach / 2) @ _WEIGHTS

    def displacement(self, r: ArrayLike) -> Array:
        """Displacement u_z of the surface in mm at r (...,) mm, the sphere itself inside."""
        r, a, big = np.asarray(r, np.float64), self.contact_radius, self.radius
        inside = self.depth - big + np.sqrt(np.maximum(big**2 - np.minimum(r, a) ** 2, 0.0))
        far = np.maximum(r, a)[..., None]
        # t = far sin(s) removes the square root at the edge.
        top = np.arcsin(a / far)
        s = top * (_NODES + 1) / 2
        t = far * np.sin(s)
        free = (self.depth - t * np.arctanh(np.minimum(t, a) / big)) * top / 2 @ _WEIGHTS
        return np.where(r <= a, inside, 2 / np.pi * free)
