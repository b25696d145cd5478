"""Surface displacement of bonded elastic layers around a point load, exact.

A load of 1 mN moves the surface at a distance r by K(r) mm: (1 - nu²) / (pi E r) on a half-space
(Boussinesq 1885), and on layers less the integral of (1 - L(xi)) J0(xi r) d xi in place of 1 / r,
with L of `stack`. What integrals of K over facets need is its first moment about the load, the
integral of K(s) s ds from 0 to r, which has no singularity.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.special import j0, j1

from fefinger.theory.contact.elastic import Array
from fefinger.theory.contact.stack import Stack


FAR = 30.0
"""Distance over the thickness from which on layers on a rigid base do not move: K r has fallen by
1e-9, where nothing of the layer is compressible, and by more where it is."""


DECAY = 20.0
"""Wavenumber times the thickness of the top layer from which on 1 - L is below 1e-14."""

PANELS, POINTS = 144, 16
"""Panels and points in each of the integrals over wavenumbers, whose phase is DECAY FAR at most."""


class Moment(NamedTuple):
    """Samples of the first moment of K, and of its derivative K(r) r, at equal steps from r = 0.

    step mm; value (n,) mm²/mN and slope (n,) mm/mN.
    """

    step: float
    value: Array
    slope: Array


@lru_cache(maxsize=16)
def moment(stack: Stack) -> Moment:
    """Return the first moment of the displacement around a point load of 1 mN.

    ValueError for layers on an elastic half-space: one layer on a rigid base, or a half-space.
    """
    modulus, poisson = stack.surface
    unit = (1 - poisson**2) / (math.pi * modulus)
    fine, thick = stack.scales
    if thick == math.inf:
        wide = 1e4  # distance in mm to which a half-space is tabulated, more than any finger has
        return Moment(wide, unit * np.array([0.0, wide]), unit * np.ones(2))
    if stack.thickness == math.inf:
        raise ValueError("point_load: expected a half-space or layers on a rigid base")
    # With 1920 intervals the moment is interpolated to 1e-9 of its largest.
    r = np.linspace(0.0, FAR * thick, 1921)
    xi, weights = _nodes(DECAY / fine)
    left = weights * (1 - stack.compliance(xi))
    value, slope = r.copy(), np.ones_like(r)
    for at in np.array_split(np.arange(len(r)), 32):
        phase = np.multiply.outer(r[at], xi)
        value[at] -= r[at] * (j1(phase) @ (left / xi))
        slope[at] -= r[at] * (j0(phase) @ left)
    slope[-1] = 0.0
    return Moment(float(r[1]), unit * value, unit * slope)


def _nodes(largest: float) -> tuple[Array, Array]:
    """Return nodes and weights (n,) of integrals from 0 to a wavenumber."""
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    edges = np.linspace(0.0, largest, PANELS + 1)
    half = np.diff(edges)[:, None] / 2
    return ((edges[:-1, None] + half) + half * nodes).ravel(), (half * weights).ravel()
