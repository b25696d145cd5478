"""Stress below a uniform pressure on a circle by Lipschitz-Hankel integrals.

I(m, n; l) is the integral of J_m(a t) J_n(r t) exp(-z t) t^l dt. They are complete elliptic
integrals; near the axis, where these cancel, they are integrated over the circle by the trapezoidal
rule, which converges there as m^n. Lengths in mm, stresses in kPa; z points into the body. Sources:
Love 1929; Eason, Noble and Sneddon, Phil. Trans. A 247, 1955, 529 (integrals).
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, ellipkm1, elliprj

from fefinger.theory.contact.elastic import Array


NEAR = 0.2
"""Largest parameter m = 4 a r / ((a + r)² + z²) of points near the axis."""

_TURN = (np.arange(24) + 0.5) * np.pi / 24
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)


def circle_stress(
    r: ArrayLike, z: ArrayLike, *, radius: float, pressure: float, poisson: float
) -> Array:
    """Stress sigma_r, sigma_theta, sigma_z, tau_rz (4, ...) in kPa below a uniform pressure.

    r >= 0, z > 0 in mm; positive in tension. On the axis it is `loads.circle_axis_stress`.
    """
    r, z = np.broadcast_arrays(np.asarray(r, np.float64), np.asarray(z, np.float64))
    r, z, shape = (r / radius).ravel(), (z / radius).ravel(), r.shape
    integrals, near = np.empty((5, len(r))), 4 * r <= NEAR * ((1 + r) ** 2 + z**2)
    integrals[:, near] = _by_turns(r[near], z[near])
    integrals[:, ~near] = _by_ellipses(r[~near], z[~near])
    # I(1,0;0), I(0,1;0), I(1,1;0), I(1,0;1), I(1,1;1)
    i100, i010, i110, i101, i111 = integrals
    away = r > 0
    safe = np.where(away, r, 1.0)
    half = np.where(away, (i010 + r * i100 - z * i110) / (2 * safe), i100 / 2)
    bent = np.where(away, z * i110 / safe, z * i101 / 2)
    loose = (1 - 2 * poisson) * half
    parts = [
        -(i100 - z * i101 - loose + bent),
        -(2 * poisson * i100 + loose - bent),
        -(i100 + z * i101),
        -z * i111,
    ]
    return pressure * np.array(parts).reshape(4, *shape)


def _by_ellipses(r: Array, z: Array) -> Array:
    """Return I(1,0;0), I(0,1;0), I(1,1;0), I(1,0;1), I(1,1;1) of a circle of radius 1."""
    square = (1 + r) ** 2 + z**2
    m, rest = 4 * r / square, ((1 - r) ** 2 + z**2) / square
    first, second = ellipkm1(rest), ellipe(m)
    root = np.sqrt(square)
    ring = ((1 - m / 2) * first - second) * root / (np.pi * r)
    steep = (first + (1 - r**2 - z**2) / ((1 - r) ** 2 + z**2) * second) / (np.pi * root)
    slanted = z * ((1 - m / 2) / rest * second - first) / (np.pi * r * root)
    i100 = _solid_angle(1.0, r, z) / (2 * np.pi)
    i010 = _solid_angle(r, 1.0, z) / (2 * np.pi * r)
    return np.array([i100, i010, ring, steep, slanted])


def _solid_angle(a: float | Array, r: float | Array, z: Array) -> Array:
    """Solid angle of a disk of radius a, seen from the distance r off its axis (Maxwell)."""
    a, r = np.broadcast_arrays(np.asarray(a, np.float64), np.asarray(r, np.float64))
    square = (a + r) ** 2 + z**2
    rest = ((a - r) ** 2 + z**2) / square
    side = (a - r) / (a + r)
    first = ellipkm1(rest)
    # side times the complete integral of the third kind; 0 on the rim, where it only jumps.
    safe = np.where(side == 0, 1.0, side)
    third = first + 4 * a * r / (3 * (a + r) ** 2) * elliprj(0.0, rest, 1.0, safe**2)
    whole = np.pi * (1 + np.sign(side))
    return whole - 2 * z / np.sqrt(square) * (first + side * third)


def _by_turns(r: Array, z: Array) -> Array:
    """Return the integrals of `_by_ellipses` as means over the angle, for points near the axis."""
    cosine = np.cos(_TURN)

    def rho(r: Array) -> Array:
        return np.sqrt(1 + r[..., None] ** 2 - 2 * r[..., None] * cosine + z[..., None] ** 2)

    apart = rho(r)
    ring = (cosine / apart).mean(axis=-1)
    steep = ((1 - r[:, None] * cosine) / apart**3).mean(axis=-1)
    slanted = z * (cosine / apart**3).mean(axis=-1)
    i100 = _solid_angle(1.0, r, z) / (2 * np.pi)
    within = np.zeros_like(r)
    for node, weight in zip((_NODES + 1) / 2, _WEIGHTS / 2, strict=True):
        within += weight * node * r * z * (rho(node * r) ** -3).mean(axis=-1)
    return np.array([i100, within, ring, steep, slanted])
