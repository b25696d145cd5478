"""Compiled element loops of finite-strain mixed elasticity, in the reference configuration.

The potential of one step is the integral of g_d W_iso + g_v (p (J - 1) - p² / 2K) + H : E, with E
the Green-Lagrange strain, g_d and g_v the relaxation factors of the step, and H the history stress
(second Piola-Kirchhoff).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.fem.hyperelastic.material import (
    FAST,
    PAIRS,
    CompiledLaw,
    add_volumetric_stiffness,
    moduli_of,
    project_to_semidefinite,
    stresses,
)
from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


class Elements(NamedTuple):
    """Elements of a body or of a part of it.

    unknowns (n_cells, 34); jacobians (n_cells, 3, 3): gradients of the reference coordinates;
    weights (n_cells, n_q) mm³; reference (n_q, 10, 3) and shapes (n_q, 4): gradients of the
    quadratics and values of the linears (times the scale of the pressures in kPa);
    materials (n_cells, 2 + n_parameters): `Material.row` of each cell.
    """

    unknowns: Integers
    jacobians: Array
    weights: Array
    reference: Array
    shapes: Array
    materials: Array


@njit(cache=True, fastmath=FAST)
def _spread(nodal: Array, strain_rows: Array, deformation: Array, node: int) -> None:
    """Fill the strain-displacement matrix (6, 3) of a node: dE = B du, shears doubled."""
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


@njit(cache=True, nogil=True, fastmath=FAST)
def stress(
    values: Array,
    elements: Elements,
    cells: Integers,
    law: CompiledLaw,
    isochoric: Array,
    volumetric: Array,
) -> float:
    """Fill the elastic stresses (n_cells, n_q, 6) of `cells` in kPa; return the smallest J.

    cells (n,): numbers of cells that have the law; so in the other loops.
    """
    unknowns, jacobians, _, reference, shapes, materials = elements
    moved, pressures, gradient = np.empty((10, 3)), np.empty(4), np.empty((3, 3))
    work = (np.empty((3, 3)), np.empty((3, 3)), np.empty(6), np.empty(6), np.empty((3, 3)))
    least = np.inf
    for e in cells:
        _gather(values, unknowns[e], moved, pressures)
        for q in range(len(reference)):
            _gradient(moved, reference[q], jacobians[e], gradient)
            p = _mean(shapes[q], pressures)
            state = stresses(
                gradient, p, law, materials[e], isochoric[e, q], volumetric[e, q], work
            )
            least = min(least, 1 + state[0])
    return least


@njit(cache=True, nogil=True, fastmath=FAST)
def residual(
    values: Array,
    elements: Elements,
    cells: Integers,
    law: CompiledLaw,
    gains: Array,
    past: Array,
    out: Array,
) -> float:
    """Add the derivative of the potential to `out` (n_unknowns,); return the smallest J.

    The cells after the first inverted one are left out: the sum is then of no use.
    """
    unknowns, jacobians, weights, reference, shapes, materials = elements
    moved, pressures, gradient = np.empty((10, 3)), np.empty(4), np.empty((3, 3))
    isochoric, volumetric = np.empty(6), np.empty(6)
    work = (np.empty((3, 3)), np.empty((3, 3)), np.empty(6), np.empty(6), np.empty((3, 3)))
    total, nominal, pulled = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    local = np.empty(34)
    least = np.inf
    for e in cells:
        _gather(values, unknowns[e], moved, pressures)
        local[:] = 0.0
        for q in range(len(reference)):
            _gradient(moved, reference[q], jacobians[e], gradient)
            p = _mean(shapes[q], pressures)
            growth = stresses(gradient, p, law, materials[e], isochoric, volumetric, work)[0]
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
            share = weights[e, q] * gains[e, 1] * (growth - p * materials[e, 1])
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
    elements: Elements,
    cells: Integers,
    law: CompiledLaw,
    gains: Array,
    past: Array,
    slots: NDArray[np.int32],
    consistent: bool,
    data: Array,
) -> float:
    """Add the second derivative of the potential to `data` (nnz,); return the smallest J.

    slots (n_cells, 34, 34) are the places of the cell's entries in `data`. Unless `consistent`, the
    displacement block is made definite: without what pressure and past add to it, with a stiffness
    against changes of volume, and with the positive parts of the moduli and the stress only. Such a
    matrix is good to iterate with, and no derivative.
    """
    unknowns, jacobians, weights, reference, shapes, materials = elements
    moved, pressures, gradient = np.empty((10, 3)), np.empty(4), np.empty((3, 3))
    isochoric, volumetric, total = np.empty(6), np.empty(6), np.empty(6)
    work = (np.empty((3, 3)), np.empty((3, 3)), np.empty(6), np.empty(6), np.empty((3, 3)))
    moduli, nodal = np.empty((6, 6)), np.empty((10, 3))
    rows, stiff = np.empty((10, 6, 3)), np.empty((6, 3))
    local = np.empty((34, 34))
    least = np.inf
    for e in cells:
        _gather(values, unknowns[e], moved, pressures)
        local[:] = 0.0
        for q in range(len(reference)):
            _gradient(moved, reference[q], jacobians[e], gradient)
            p = _mean(shapes[q], pressures)
            state = stresses(gradient, p, law, materials[e], isochoric, volumetric, work)
            least = min(least, 1 + state[0])
            if state[0] <= -1.0:
                return least
            moduli_of(p if consistent else 0.0, gains[e], state, work, moduli)
            weight = weights[e, q]
            for row in range(6):
                total[row] = weight * gains[e, 0] * isochoric[row]
                if consistent:
                    total[row] += weight * (gains[e, 1] * volumetric[row] + past[e, q, row])
            if not consistent:
                add_volumetric_stiffness(
                    2 / 3 * gains[e, 0] * materials[e, 0], state[0], work[1], moduli
                )
                project_to_semidefinite(moduli, total)
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
            _couple(local, coupling, materials[e, 1], shapes[q], work[1], state[0], rows)
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
def slots(
    members: Integers, starts: NDArray[np.int32], columns: NDArray[np.int32]
) -> NDArray[np.int32]:
    """Positions of the entries (n_cells, 34, 34) of each cell in a sorted CSR matrix."""
    positions = np.empty((len(members), members.shape[1], members.shape[1]), dtype=np.int32)
    for e in range(len(members)):
        for k in range(members.shape[1]):
            row = members[e, k]
            low, high = starts[row], starts[row + 1]
            for m in range(members.shape[1]):
                positions[e, k, m] = low + np.searchsorted(columns[low:high], members[e, m])
    return positions
