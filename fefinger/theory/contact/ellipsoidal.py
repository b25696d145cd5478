"""Boussinesq potentials of Hertz's pressure on an elliptic contact, in closed form.

psi, the integral of p / rho, is that of a thin homogeneous ellipsoidal plate; psi1, the integral of
p ln(rho + z), is needed for Poisson's ratios below 1/2; its second derivatives are one smooth
integral over the depth. Lengths in mm, pressures in kPa; z points into the body. Source: Hertz
1881; Johnson, Contact Mechanics, 1985, 3.2 and 3.3; Carlson's elliptic integrals (DLMF 19.16).
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy.special import elliprd, elliprf

from fefinger.theory.contact.elastic import Array


NEWTON = 200
"""Largest number of Newton steps to the ellipsoid through a point."""

_NODES, _WEIGHTS = legendre.leggauss(120)


@dataclass(frozen=True)
class Potentials:
    """Potential psi at places (...,), its gradient (..., 3) and second derivatives (..., 3, 3)."""

    psi: Array
    gradient: Array
    hessian: Array


def potentials(place: Array, semi_axes: tuple[float, float], peak: float) -> Potentials:
    """Compute psi in kPa mm and its derivatives at `place` (..., 3) mm, z > 0.

    `semi_axes` a, b mm of the contact, `peak` p0 kPa.
    """
    squares = np.array([semi_axes[0] ** 2, semi_axes[1] ** 2, 0.0])
    level = _level(place, squares)
    wide = squares + level[..., None]
    a, b, c = np.moveaxis(wide, -1, 0)
    thick = 2 / 3 * np.stack([elliprd(b, c, a), elliprd(c, a, b), elliprd(a, b, c)], axis=-1)
    scale = np.pi / 2 * semi_axes[0] * semi_axes[1] * peak
    psi = scale * (2 * elliprf(a, b, c) - (place**2 * thick).sum(axis=-1))
    gradient = -2 * scale * place * thick
    # The level of the ellipsoid through the place rises by 2 unit / |unit|² per mm.
    unit = place / wide
    fall = 4 * scale / (np.sqrt(a * b * c) * (unit**2).sum(axis=-1))
    hessian = fall[..., None, None] * (unit[..., :, None] * unit[..., None, :])
    for i in range(3):
        hessian[..., i, i] -= 2 * scale * thick[..., i]
    return Potentials(psi, gradient, hessian)


def deeper(place: Array, semi_axes: tuple[float, float], peak: float) -> tuple[Array, Array]:
    """Gradient (..., 2) and second derivatives (..., 2, 2) of psi1 along x and y.

    psi = d psi1 / dz, so they are minus the integrals of those of psi from the place downward.
    """
    size = max(semi_axes)
    t = (_NODES + 1) / 2
    down = size * t**2 / (1 - t)
    weights = _WEIGHTS / 2 * size * t * (2 - t) / (1 - t) ** 2
    below = np.repeat(np.asarray(place, np.float64)[..., None, :], len(t), axis=-2)
    below[..., 2] += down
    potential = potentials(below, semi_axes, peak)
    gradient = np.einsum("...ni,n->...i", potential.gradient[..., :2], weights)
    hessian = np.einsum("...nij,n->...ij", potential.hessian[..., :2, :2], weights)
    return -gradient, -hessian


def _level(place: Array, squares: Array) -> Array:
    """Positive root w of x² / (a² + w) + y² / (b² + w) + z² / w = 1.

    The left side is decreasing and convex, so Newton's method converges monotonically from w = z²;
    steps double w until it is near, then the error is squared.
    """
    square = place**2
    level = square[..., 2].copy()
    for _ in range(NEWTON):
        parts = square / (squares + level[..., None])
        excess = parts.sum(axis=-1) - 1
        step = excess / (parts / (squares + level[..., None])).sum(axis=-1)
        level = level + np.maximum(step, 0.0)
        if np.all(step <= 1e-15 * level):
            return level
    raise ArithmeticError("ellipsoidal: expected places within 1e30 contact radii of each other")
