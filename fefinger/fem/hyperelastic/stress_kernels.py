"""Stress and moduli of the hyperelastic laws at one point, compiled.

Everything is written in the gradient of the displacement, so that stress and J - 1 keep their
digits at the smallest strains. Symmetric tensors have the components xx yy zz xy yz xz.
"""

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.compiled import njit


PAIRS = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]])
"""Row and column of the six components."""

Work = tuple[Array, Array, Array, Array, Array]
"""E, the inverse of C, the derivatives (6,) of the two invariants by C, and scratch (3, 3)."""

FAST = {"contract", "reassoc", "nsz", "arcp"}
"""LLVM fast-math flags without "nnan" and "ninf": a diverged iterate must stay inf or nan."""


@njit(cache=True, fastmath=FAST)
def _kinematics(gradient: Array, strain: Array, inverse: Array) -> float:
    """Fill the Green-Lagrange strain (3, 3) and the inverse of C (3, 3); return J - 1."""
    h = gradient
    for i in range(3):
        for j in range(3):
            total = h[i, j] + h[j, i]
            for k in range(3):
                total += h[k, i] * h[k, j]
            strain[i, j] = total / 2
    minors = (
        h[0, 0] * h[1, 1]
        - h[0, 1] * h[1, 0]
        + h[1, 1] * h[2, 2]
        - h[1, 2] * h[2, 1]
        + h[0, 0] * h[2, 2]
        - h[0, 2] * h[2, 0]
    )
    determinant = (
        h[0, 0] * (h[1, 1] * h[2, 2] - h[1, 2] * h[2, 1])
        - h[0, 1] * (h[1, 0] * h[2, 2] - h[1, 2] * h[2, 0])
        + h[0, 2] * (h[1, 0] * h[2, 1] - h[1, 1] * h[2, 0])
    )
    growth = h[0, 0] + h[1, 1] + h[2, 2] + minors + determinant
    a, b, c = 1 + 2 * strain[0, 0], 1 + 2 * strain[1, 1], 1 + 2 * strain[2, 2]
    d, e, f = 2 * strain[0, 1], 2 * strain[1, 2], 2 * strain[0, 2]
    square = (1 + growth) * (1 + growth)
    inverse[0, 0] = (b * c - e * e) / square
    inverse[1, 1] = (a * c - f * f) / square
    inverse[2, 2] = (a * b - d * d) / square
    inverse[0, 1] = inverse[1, 0] = (e * f - d * c) / square
    inverse[1, 2] = inverse[2, 1] = (d * f - a * e) / square
    inverse[0, 2] = inverse[2, 0] = (d * e - b * f) / square
    return growth


@njit(cache=True, fastmath=FAST)
def _product(inverse: Array, other: Array, factor: float, out: Array) -> None:
    """Fill the six components of factor * inverse @ dev(other), for tensors that commute."""
    mean = (other[0, 0] + other[1, 1] + other[2, 2]) / 3
    for row in range(6):
        i, j = PAIRS[row]
        total = -mean * inverse[i, j]
        for k in range(3):
            total += inverse[i, k] * other[k, j]
        out[row] = factor * total


@njit(cache=True, fastmath=FAST)
def _invariants(
    strain: Array, inverse: Array, volume: float, first: Array, second: Array, scratch: Array
) -> None:
    """Fill the derivatives (6,) of the isochoric I1 and I2 by C; volume is J^(-2/3)."""
    trace = strain[0, 0] + strain[1, 1] + strain[2, 2]
    _product(inverse, strain, 2 * volume, first)
    for i in range(3):
        for j in range(3):
            total = (2 + 4 * trace) * strain[i, j]
            for k in range(3):
                total -= 4 * strain[i, k] * strain[k, j]
            scratch[i, j] = total
    _product(inverse, scratch, volume * volume, second)


@njit(cache=True, fastmath=FAST)
def stresses(
    gradient: Array,
    pressure: float,
    law: Array,
    isochoric: Array,
    volumetric: Array,
    work: Work,
) -> tuple[float, float, float]:
    """Fill the elastic stresses (6,) of the displacement gradient.

    Return J - 1, J^(-2/3) and the rise exp(b (I1 - 3)) of the stiffness.
    """
    strain, inverse, first, second, scratch = work
    growth = _kinematics(gradient, strain, inverse)
    if growth <= -1.0:
        return growth, 1.0, 1.0
    logarithm = -2 / 3 * np.log1p(growth)
    volume = np.exp(logarithm)
    _invariants(strain, inverse, volume, first, second, scratch)
    rise = 1.0
    if law[3] > 0:
        trace = strain[0, 0] + strain[1, 1] + strain[2, 2]
        rise = np.exp(law[3] * (3 * np.expm1(logarithm) + 2 * trace * volume))
    one = law[0] * law[2] * rise
    two = law[0] * (1 - law[2])
    for row in range(6):
        i, j = PAIRS[row]
        isochoric[row] = one * first[row] + two * second[row]
        volumetric[row] = pressure * (1 + growth) * inverse[i, j]
    return growth, volume, rise


@njit(cache=True, fastmath=FAST)
def _right(strain: Array, c: Array) -> tuple[float, float]:
    """Fill C (3, 3) of the Green-Lagrange strain; return its first two invariants."""
    square = 0.0
    for i in range(3):
        for j in range(3):
            c[i, j] = 2 * strain[i, j] + (1.0 if i == j else 0.0)
            square += c[i, j] * c[i, j]
    trace = c[0, 0] + c[1, 1] + c[2, 2]
    return trace, (trace * trace - square) / 2


@njit(cache=True, fastmath=FAST)
def moduli_of(
    pressure: float,
    law: Array,
    gains: Array,
    state: tuple[float, float, float],
    work: Work,
    moduli: Array,
) -> None:
    """Fill dS / dE (6, 6) of gains[0] S_iso + gains[1] S_vol; shear strains count twice.

    `state` is what `stresses` returned, with what it left in `work`.
    """
    growth, volume, rise = state
    strain, inverse, first, _, c = work
    trace, minors = _right(strain, c)
    one = 2 * gains[0] * law[0] * law[2] * rise
    two = 2 * gains[0] * law[0] * (1 - law[2])
    p = gains[1] * pressure * (1 + growth)
    v1, v2 = one * volume, two * volume * volume
    for row in range(6):
        i, j = PAIRS[row]
        unit_r = 1.0 if i == j else 0.0
        for column in range(row, 6):
            k, m = PAIRS[column]
            unit_c = 1.0 if k == m else 0.0
            outer = inverse[i, j] * inverse[k, m]
            mixed = (inverse[i, k] * inverse[j, m] + inverse[i, m] * inverse[j, k]) / 2
            total = one * law[3] * first[row] * first[column] + p * (outer - 2 * mixed)
            total += v1 * (
                -(unit_r * inverse[k, m] + inverse[i, j] * unit_c) / 3
                + trace / 9 * outer
                + trace / 3 * mixed
            )
            if two != 0.0:
                identity = 0.0
                if row == column:
                    identity = 1.0 if i == j else 0.5
                b_r, b_c = trace * unit_r - c[i, j], trace * unit_c - c[k, m]
                total += v2 * (
                    unit_r * unit_c
                    - identity
                    - 2 / 3 * (b_r * inverse[k, m] + inverse[i, j] * b_c)
                    + 4 / 9 * minors * outer
                    + 2 / 3 * minors * mixed
                )
            moduli[row, column] = total
            moduli[column, row] = total


@njit(cache=True, fastmath=FAST)
def add_volumetric_stiffness(
    stiffness: float, growth: float, inverse: Array, moduli: Array
) -> None:
    """Add a volumetric stiffness, the second derivative of stiffness (dJ)² / 2, to the moduli.

    A stiffness of 2/3 mu turns 2 mu dev e : dev e into 2 mu e : e.
    """
    factor = stiffness * (1 + growth) * (1 + growth)
    for row in range(6):
        i, j = PAIRS[row]
        for column in range(6):
            k, m = PAIRS[column]
            moduli[row, column] += factor * inverse[i, j] * inverse[k, m]


@njit(cache=True)
def project_to_semidefinite(moduli: Array, stress: Array) -> None:
    """Replace the moduli (6, 6) and the stress (6,) by their positive parts."""
    values, vectors = np.linalg.eigh(moduli)
    if values[0] < 0:
        moduli[:] = (vectors * np.maximum(values, 0.0)) @ vectors.T
    full = np.empty((3, 3))
    for row in range(6):
        i, j = PAIRS[row]
        full[i, j] = full[j, i] = stress[row]
    values, vectors = np.linalg.eigh(full)
    if values[0] < 0:
        full = (vectors * np.maximum(values, 0.0)) @ vectors.T
        for row in range(6):
            i, j = PAIRS[row]
            stress[row] = full[i, j]
