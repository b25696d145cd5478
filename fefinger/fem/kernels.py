"""Compiled element loops of finite-strain mixed elasticity, in the reference configuration.

The potential of one step is the integral of g_d W_iso + g_v (p (J - 1) - p² / 2K) + H : E, with E
the Green-Lagrange strain, g_d and g_v what a step of relaxation makes of the elastic stress, and H
the stress that the past leaves (second Piola-Kirchhoff). Everything is written in the gradient of
the displacement, so that stress and J - 1 keep their digits at the smallest strains.

Symmetric tensors have the components xx yy zz xy yz xz.
"""

import numpy as np
from numba import njit

from fefinger.fem.spaces import Array, Integers


PAIRS = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]])
"""Row and column of the six components."""

FAST = {"contract", "reassoc", "nsz", "arcp"}
"""Freedoms of arithmetic that leave inf and nan what they are."""


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
def _invariants(strain: Array, inverse: Array, growth: float, first: Array, second: Array) -> float:
    """Fill the derivatives (6,) of the isochoric I1 and I2 by C; return I1 - 3."""
    volume = np.exp(-2 / 3 * np.log1p(growth))
    trace = strain[0, 0] + strain[1, 1] + strain[2, 2]
    _product(inverse, strain, 2 * volume, first)
    other = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            total = (2 + 4 * trace) * strain[i, j]
            for k in range(3):
                total -= 4 * strain[i, k] * strain[k, j]
            other[i, j] = total
    _product(inverse, other, volume * volume, second)
    return float(3 * np.expm1(-2 / 3 * np.log1p(growth)) + 2 * trace * volume)


@njit(cache=True, fastmath=FAST)
def _stresses(
    gradient: Array,
    pressure: float,
    law: Array,
    isochoric: Array,
    volumetric: Array,
    work: tuple[Array, Array, Array, Array],
) -> tuple[float, float]:
    """Fill the elastic stresses (6,) of the displacement gradient; return J - 1 and I1 - 3."""
    strain, inverse, first, second = work
    growth = _kinematics(gradient, strain, inverse)
    if growth <= -1.0:
        return growth, 0.0
    stretch = _invariants(strain, inverse, growth, first, second)
    one = law[0] * law[2] * np.exp(law[3] * stretch)
    two = law[0] * (1 - law[2])
    for row in range(6):
        i, j = PAIRS[row]
        isochoric[row] = one * first[row] + two * second[row]
        volumetric[row] = pressure * (1 + growth) * inverse[i, j]
    return growth, stretch


@njit(cache=True, fastmath=FAST)
def _moduli(
    pressure: float,
    law: Array,
    gains: Array,
    growth: float,
    stretch: float,
    work: tuple[Array, Array, Array, Array],
    moduli: Array,
) -> None:
    """Fill dS / dE (6, 6) of gains[0] S_iso + gains[1] S_vol; shear strains count twice."""
    strain, inverse, first, second = work
    volume = np.exp(-2 / 3 * np.log1p(growth))
    c = 2 * strain + np.eye(3)
    trace = c[0, 0] + c[1, 1] + c[2, 2]
    square = 0.0
    for i in range(3):
        for j in range(3):
            square += c[i, j] * c[i, j]
    minors = (trace * trace - square) / 2
    exponential = law[0] * law[2] * np.exp(law[3] * stretch) / 2
    one, one_one = 4 * gains[0] * exponential, 4 * gains[0] * exponential * law[3]
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
            total = one_one * first[row] * first[column] + p * (outer - 2 * mixed)
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
def _spread(nodal: Array, strain_rows: Array, deformation: Array, node: int) -> None:
    """Fill the rows (6, 3) that take a displacement of the node to dE, shears doubled."""
    for row in range(3):
        for a in range(3):
            strain_rows[row, a] = deformation[a, row] * nodal[node, row]
    for row in range(3, 6):
        i, j = PAIRS[row]
        for a in range(3):
            strain_rows[row, a] = (
                deformation[a, i] * nodal[node, j] + deformation[a, j] * nodal[node, i]
            )


@njit(cache=True, fastmath=FAST)
def _local(
    values: Array,
    members: Integers,
    inverse_jacobian: Array,
    reference: Array,
    shapes: Array,
    nodal: Array,
    gradient: Array,
) -> float:
    """Fill the gradients (10, 3) of the shapes and of the displacement (3, 3); return p."""
    gradient[:] = 0.0
    for node in range(10):
        for j in range(3):
            nodal[node, j] = (
                reference[node, 0] * inverse_jacobian[0, j]
                + reference[node, 1] * inverse_jacobian[1, j]
                + reference[node, 2] * inverse_jacobian[2, j]
            )
        for i in range(3):
            u = values[members[3 * node + i]]
            for j in range(3):
                gradient[i, j] += u * nodal[node, j]
    pressure = 0.0
    for a in range(4):
        pressure += shapes[a] * values[members[30 + a]]
    return pressure


@njit(cache=True, fastmath=FAST)
def stress(
    values: Array,
    unknowns: Integers,
    jacobians: Array,
    reference: Array,
    shapes: Array,
    laws: Array,
    isochoric: Array,
    volumetric: Array,
) -> float:
    """Fill the elastic stresses (n_cells, n_q, 6) in kPa; return the smallest J."""
    nodal, gradient = np.empty((10, 3)), np.empty((3, 3))
    work = (np.empty((3, 3)), np.empty((3, 3)), np.empty(6), np.empty(6))
    least = np.inf
    for e in range(len(unknowns)):
        for q in range(len(reference)):
            p = _local(values, unknowns[e], jacobians[e], reference[q], shapes[q], nodal, gradient)
            growth, _ = _stresses(gradient, p, laws[e], isochoric[e, q], volumetric[e, q], work)
            least = min(least, 1 + growth)
    return least


@njit(cache=True, fastmath=FAST)
def residual(
    values: Array,
    unknowns: Integers,
    jacobians: Array,
    weights: Array,
    reference: Array,
    shapes: Array,
    laws: Array,
    gains: Array,
    past: Array,
    out: Array,
) -> float:
    """Add the derivative of the potential to `out` (n_unknowns,); return the smallest J.

    The cells after the first inverted one are left out: the sum is then of no use.
    """
    nodal, gradient = np.empty((10, 3)), np.empty((3, 3))
    isochoric, volumetric, total = np.empty(6), np.empty(6), np.empty(6)
    work = (np.empty((3, 3)), np.empty((3, 3)), np.empty(6), np.empty(6))
    local = np.empty(34)
    rows = np.empty((6, 3))
    least = np.inf
    for e in range(len(unknowns)):
        members = unknowns[e]
        local[:] = 0.0
        for q in range(len(reference)):
            p = _local(values, members, jacobians[e], reference[q], shapes[q], nodal, gradient)
            growth, _ = _stresses(gradient, p, laws[e], isochoric, volumetric, work)
            least = min(least, 1 + growth)
            if growth <= -1.0:
                return least
            for row in range(6):
                total[row] = weights[e, q] * (
                    gains[e, 0] * isochoric[row] + gains[e, 1] * volumetric[row] + past[e, q, row]
                )
            for i in range(3):
                gradient[i, i] += 1.0
            for node in range(10):
                _spread(nodal, rows, gradient, node)
                for a in range(3):
                    for row in range(6):
                        local[3 * node + a] += rows[row, a] * total[row]
            share = weights[e, q] * gains[e, 1] * (growth - p * laws[e, 1])
            for a in range(4):
                local[30 + a] += share * shapes[q, a]
        for k in range(34):
            out[members[k]] += local[k]
    return least


@njit(cache=True, fastmath=FAST)
def tangent(
    values: Array,
    unknowns: Integers,
    jacobians: Array,
    weights: Array,
    reference: Array,
    shapes: Array,
    laws: Array,
    gains: Array,
    past: Array,
    slots: Integers,
    whole: bool,
    data: Array,
) -> float:
    """Add the second derivative of the potential to `data` (nnz,); return the smallest J.

    slots (n_cells, 34, 34) are the places of the cell's entries in `data`. Unless `whole`, what
    the pressure and the past add to the displacement block is left out.
    """
    nodal, gradient = np.empty((10, 3)), np.empty((3, 3))
    isochoric, volumetric, total = np.empty(6), np.empty(6), np.empty(6)
    work = (np.empty((3, 3)), np.empty((3, 3)), np.empty(6), np.empty(6))
    moduli = np.empty((6, 6))
    rows, stiff = np.empty((10, 6, 3)), np.empty((6, 3))
    local = np.empty((34, 34))
    least = np.inf
    for e in range(len(unknowns)):
        members = unknowns[e]
        local[:] = 0.0
        for q in range(len(reference)):
            p = _local(values, members, jacobians[e], reference[q], shapes[q], nodal, gradient)
            growth, stretch = _stresses(gradient, p, laws[e], isochoric, volumetric, work)
            least = min(least, 1 + growth)
            if growth <= -1.0:
                return least
            _moduli(p if whole else 0.0, laws[e], gains[e], growth, stretch, work, moduli)
            weight = weights[e, q]
            for row in range(6):
                total[row] = weight * gains[e, 0] * isochoric[row]
                if whole:
                    total[row] += weight * (gains[e, 1] * volumetric[row] + past[e, q, row])
            for i in range(3):
                gradient[i, i] += 1.0
            for node in range(10):
                _spread(nodal, rows[node], gradient, node)
            _fill(local, weight, moduli, total, nodal, rows, stiff)
            _couple(local, weight * gains[e, 1], laws[e, 1], shapes[q], work[1], growth, rows)
        for k in range(34):
            for m in range(k, 34):
                data[slots[e, k, m]] += local[k, m]
                if m > k:
                    data[slots[e, m, k]] += local[k, m]
    return least


@njit(cache=True, fastmath=FAST)
def _fill(
    local: Array,
    weight: float,
    moduli: Array,
    total: Array,
    nodal: Array,
    rows: Array,
    stiff: Array,
) -> None:
    """Add the displacement block of one point to the upper triangle of `local`."""
    for m in range(10):
        for row in range(6):
            for b in range(3):
                entry = 0.0
                for column in range(6):
                    entry += moduli[row, column] * rows[m, column, b]
                stiff[row, b] = weight * entry
        x = total[0] * nodal[m, 0] + total[3] * nodal[m, 1] + total[5] * nodal[m, 2]
        y = total[3] * nodal[m, 0] + total[1] * nodal[m, 1] + total[4] * nodal[m, 2]
        z = total[5] * nodal[m, 0] + total[4] * nodal[m, 1] + total[2] * nodal[m, 2]
        for k in range(m + 1):
            geometric = nodal[k, 0] * x + nodal[k, 1] * y + nodal[k, 2] * z
            for a in range(3):
                for b in range(3):
                    entry = 0.0
                    for row in range(6):
                        entry += rows[k, row, a] * stiff[row, b]
                    local[3 * k + a, 3 * m + b] += entry
                local[3 * k + a, 3 * m + a] += geometric


@njit(cache=True, fastmath=FAST)
def _couple(
    local: Array,
    weight: float,
    compressibility: float,
    shapes: Array,
    inverse: Array,
    growth: float,
    rows: Array,
) -> None:
    """Add the pressure rows of one point to the upper triangle of `local`."""
    for node in range(10):
        for a in range(3):
            change = 0.0
            for row in range(6):
                i, j = PAIRS[row]
                change += inverse[i, j] * rows[node, row, a]
            for b in range(4):
                local[3 * node + a, 30 + b] += weight * (1 + growth) * change * shapes[b]
    for a in range(4):
        for b in range(a, 4):
            local[30 + a, 30 + b] -= weight * compressibility * shapes[a] * shapes[b]


@njit(cache=True)
def energy(
    values: Array,
    unknowns: Integers,
    jacobians: Array,
    weights: Array,
    reference: Array,
    shapes: Array,
    laws: Array,
    gains: Array,
    past: Array,
) -> float:
    """Return the potential in mN mm, written apart from its derivatives so that it checks them."""
    nodal, gradient = np.empty((10, 3)), np.empty((3, 3))
    total = 0.0
    for e in range(len(unknowns)):
        mu, compressibility, share, exponent = laws[e]
        for q in range(len(reference)):
            p = _local(
                values, unknowns[e], jacobians[e], reference[q], shapes[q], nodal, gradient
            )
            deformation = gradient + np.eye(3)
            c = deformation.T @ deformation
            volume = np.linalg.det(deformation)
            one = np.trace(c) * volume ** (-2 / 3) - 3
            two = (np.trace(c) ** 2 - np.trace(c @ c)) / 2 * volume ** (-4 / 3) - 3
            rising = np.expm1(exponent * one) / exponent if exponent > 0 else one
            work = gains[e, 0] * mu / 2 * (share * rising + (1 - share) * two)
            work += gains[e, 1] * (p * (volume - 1) - p * p * compressibility / 2)
            for row in range(6):
                i, j = PAIRS[row]
                twice = 1.0 if i == j else 2.0
                work += twice * past[e, q, row] * (c[i, j] - (1.0 if i == j else 0.0)) / 2
            total += weights[e, q] * work
    return total


@njit(cache=True)
def slots(members: Integers, starts: Integers, columns: Integers) -> Integers:
    """Return where the entries (n_cells, 34, 34) of each cell stand in a sorted CSR matrix."""
    found = np.empty((len(members), members.shape[1], members.shape[1]), dtype=np.int32)
    for e in range(len(members)):
        for k in range(members.shape[1]):
            row = members[e, k]
            low, high = starts[row], starts[row + 1]
            for m in range(members.shape[1]):
                found[e, k, m] = low + np.searchsorted(columns[low:high], members[e, m])
    return found
