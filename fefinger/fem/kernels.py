"""Compiled element loops of finite-strain mixed elasticity, in the reference configuration.

The potential of one step is the integral of g_d W_iso + g_v (p (J - 1) - p² / 2K) + H : E, with E
the Green-Lagrange strain, g_d and g_v what a step of relaxation makes of the elastic stress, and H
the stress that the past leaves (second Piola-Kirchhoff). Everything is written in the gradient of
the displacement, so that stress and J - 1 keep their digits at the smallest strains.

Symmetric tensors have the components xx yy zz xy yz xz.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fefinger.fem.spaces import Array, Integers


PAIRS = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]])
"""Row and column of the six components."""

Work = tuple[Array, Array, Array, Array, Array]
"""E, the inverse of C, the derivatives (6,) of the two invariants by C, and scratch (3, 3)."""

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
def _stresses(
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
def _moduli(
    pressure: float,
    law: Array,
    gains: Array,
    state: tuple[float, float, float],
    work: Work,
    moduli: Array,
) -> None:
    """Fill dS / dE (6, 6) of gains[0] S_iso + gains[1] S_vol; shear strains count twice.

    `state` is what `_stresses` returned, with what it left in `work`.
    """
    growth, volume, rise = state
    strain, inverse, first, _, c = work
    for i in range(3):
        for j in range(3):
            c[i, j] = 2 * strain[i, j]
        c[i, i] += 1.0
    trace = c[0, 0] + c[1, 1] + c[2, 2]
    square = 0.0
    for i in range(3):
        for j in range(3):
            square += c[i, j] * c[i, j]
    minors = (trace * trace - square) / 2
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
def _brace(stiffness: float, growth: float, inverse: Array, moduli: Array) -> None:
    """Add stiffness (dJ)² / 2 to the moduli; 2/3 of mu makes 2 mu dev e : dev e into 2 mu e : e."""
    factor = stiffness * (1 + growth) * (1 + growth)
    for row in range(6):
        i, j = PAIRS[row]
        for column in range(6):
            k, m = PAIRS[column]
            moduli[row, column] += factor * inverse[i, j] * inverse[k, m]


@njit(cache=True)
def _convex(moduli: Array, stress: Array) -> None:
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
def _gather(values: Array, members: Integers, moved: Array, pressures: Array) -> None:
    """Fill the displacements (10, 3) and pressures (4,) of a cell."""
    for node in range(10):
        for i in range(3):
            moved[node, i] = values[members[3 * node + i]]
    for a in range(4):
        pressures[a] = values[members[30 + a]]


@njit(cache=True, fastmath=FAST)
def _gradient(moved: Array, reference: Array, jacobian: Array, gradient: Array) -> None:
    """Fill the displacement gradient (3, 3) at a point."""
    for i in range(3):
        x = y = z = 0.0
        for node in range(10):
            u = moved[node, i]
            x += u * reference[node, 0]
            y += u * reference[node, 1]
            z += u * reference[node, 2]
        for j in range(3):
            gradient[i, j] = x * jacobian[0, j] + y * jacobian[1, j] + z * jacobian[2, j]


@njit(cache=True, fastmath=FAST)
def _mean(shapes: Array, pressures: Array) -> float:
    return float(
        shapes[0] * pressures[0]
        + shapes[1] * pressures[1]
        + shapes[2] * pressures[2]
        + shapes[3] * pressures[3]
    )


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
    moved, pressures, gradient = np.empty((10, 3)), np.empty(4), np.empty((3, 3))
    work = (np.empty((3, 3)), np.empty((3, 3)), np.empty(6), np.empty(6), np.empty((3, 3)))
    least = np.inf
    for e in range(len(unknowns)):
        _gather(values, unknowns[e], moved, pressures)
        for q in range(len(reference)):
            _gradient(moved, reference[q], jacobians[e], gradient)
            p = _mean(shapes[q], pressures)
            state = _stresses(gradient, p, laws[e], isochoric[e, q], volumetric[e, q], work)
            least = min(least, 1 + state[0])
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
    moved, pressures, gradient = np.empty((10, 3)), np.empty(4), np.empty((3, 3))
    isochoric, volumetric = np.empty(6), np.empty(6)
    work = (np.empty((3, 3)), np.empty((3, 3)), np.empty(6), np.empty(6), np.empty((3, 3)))
    total, nominal, pulled = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    local = np.empty(34)
    least = np.inf
    for e in range(len(unknowns)):
        _gather(values, unknowns[e], moved, pressures)
        local[:] = 0.0
        for q in range(len(reference)):
            _gradient(moved, reference[q], jacobians[e], gradient)
            p = _mean(shapes[q], pressures)
            growth, _, _ = _stresses(gradient, p, laws[e], isochoric, volumetric, work)
            least = min(least, 1 + growth)
            if growth <= -1.0:
                return least
            for row in range(6):
                i, j = PAIRS[row]
                total[i, j] = weights[e, q] * (
                    gains[e, 0] * isochoric[row] + gains[e, 1] * volumetric[row] + past[e, q, row]
                )
                total[j, i] = total[i, j]
            for i in range(3):
                gradient[i, i] += 1.0
            _multiplied(gradient, total, nominal)
            _multiplied_by_transpose(nominal, jacobians[e], pulled)
            for node in range(10):
                for i in range(3):
                    local[3 * node + i] += (
                        pulled[i, 0] * reference[q, node, 0]
                        + pulled[i, 1] * reference[q, node, 1]
                        + pulled[i, 2] * reference[q, node, 2]
                    )
            share = weights[e, q] * gains[e, 1] * (growth - p * laws[e, 1])
            for a in range(4):
                local[30 + a] += share * shapes[q, a]
        for k in range(34):
            out[unknowns[e, k]] += local[k]
    return least


@njit(cache=True, fastmath=FAST)
def _multiplied(a: Array, b: Array, out: Array) -> None:
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@njit(cache=True, fastmath=FAST)
def _multiplied_by_transpose(a: Array, b: Array, out: Array) -> None:
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[j, 0] + a[i, 1] * b[j, 1] + a[i, 2] * b[j, 2]


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
    slots: NDArray[np.int32],
    whole: bool,
    data: Array,
) -> float:
    """Add the second derivative of the potential to `data` (nnz,); return the smallest J.

    slots (n_cells, 34, 34) are the places of the cell's entries in `data`. Unless `whole`, the
    displacement block is made definite: without what pressure and past add to it, with a stiffness
    against changes of volume, and with the positive parts of the moduli and the stress only. Such a
    matrix is good to iterate with, and no derivative.
    """
    moved, pressures, gradient = np.empty((10, 3)), np.empty(4), np.empty((3, 3))
    isochoric, volumetric, total = np.empty(6), np.empty(6), np.empty(6)
    work = (np.empty((3, 3)), np.empty((3, 3)), np.empty(6), np.empty(6), np.empty((3, 3)))
    moduli, nodal = np.empty((6, 6)), np.empty((10, 3))
    rows, stiff = np.empty((10, 6, 3)), np.empty((6, 3))
    local = np.empty((34, 34))
    least = np.inf
    for e in range(len(unknowns)):
        _gather(values, unknowns[e], moved, pressures)
        local[:] = 0.0
        for q in range(len(reference)):
            _gradient(moved, reference[q], jacobians[e], gradient)
            p = _mean(shapes[q], pressures)
            state = _stresses(gradient, p, laws[e], isochoric, volumetric, work)
            least = min(least, 1 + state[0])
            if state[0] <= -1.0:
                return least
            _moduli(p if whole else 0.0, laws[e], gains[e], state, work, moduli)
            weight = weights[e, q]
            for row in range(6):
                total[row] = weight * gains[e, 0] * isochoric[row]
                if whole:
                    total[row] += weight * (gains[e, 1] * volumetric[row] + past[e, q, row])
            if not whole:
                _brace(2 / 3 * gains[e, 0] * laws[e, 0], state[0], work[1], moduli)
                _convex(moduli, total)
            for i in range(3):
                gradient[i, i] += 1.0
            for node in range(10):
                for j in range(3):
                    nodal[node, j] = (
                        reference[q, node, 0] * jacobians[e, 0, j]
                        + reference[q, node, 1] * jacobians[e, 1, j]
                        + reference[q, node, 2] * jacobians[e, 2, j]
                    )
                _spread(nodal, rows[node], gradient, node)
            _fill(local, weight, moduli, total, nodal, rows, stiff)
            coupling = weight * gains[e, 1]
            _couple(local, coupling, laws[e, 1], shapes[q], work[1], state[0], rows)
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
    moved, pressures, gradient = np.empty((10, 3)), np.empty(4), np.empty((3, 3))
    total = 0.0
    for e in range(len(unknowns)):
        mu, compressibility, share, exponent = laws[e]
        _gather(values, unknowns[e], moved, pressures)
        for q in range(len(reference)):
            _gradient(moved, reference[q], jacobians[e], gradient)
            p = _mean(shapes[q], pressures)
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
def slots(members: Integers, starts: Integers, columns: Integers) -> NDArray[np.int32]:
    """Return where the entries (n_cells, 34, 34) of each cell stand in a sorted CSR matrix."""
    found = np.empty((len(members), members.shape[1], members.shape[1]), dtype=np.int32)
    for e in range(len(members)):
        for k in range(members.shape[1]):
            row = members[e, k]
            low, high = starts[row], starts[row + 1]
            for m in range(members.shape[1]):
                found[e, k, m] = low + np.searchsorted(columns[low:high], members[e, m])
    return found
