"""Assembly of sparse matrices: compiled element loop of mixed elasticity into a fixed pattern.

The pattern follows from the numbering alone: assembly needs little memory beyond the matrix.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


Places = NDArray[np.int32]

EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
"""Corners of the edges of a cell, in scikit-fem's order of the quadratics after the corners."""

_INNER, _OUTER = (5 + 3 * np.sqrt(5)) / 20, (5 - np.sqrt(5)) / 20
RULE = np.full((4, 4), _OUTER) + (_INNER - _OUTER) * np.eye(4)
"""Barycentric coordinates of four points of equal weight, exact for polynomials of degree 2."""


def numbering(chosen: Integers, count: int) -> Integers:
    """Return the place in `chosen` of every number below `count`, -1 for those that are not."""
    number = np.full(count, -1, dtype=np.int64)
    number[chosen] = np.arange(len(chosen))
    return number


def scattered(
    block: Array, rows: Integers, columns: Integers, shape: tuple[int, int]
) -> sparse.coo_matrix:
    """Return the sum of entries at rows and columns, which are broadcast against the block.

    Entries with a negative row or column are left out.
    """
    rows, columns = (np.broadcast_to(each, block.shape).ravel() for each in (rows, columns))
    kept = (rows >= 0) & (columns >= 0)
    return sparse.coo_matrix((block.ravel()[kept], (rows[kept], columns[kept])), shape=shape)


def pattern(unknowns: Integers, count: int) -> tuple[Places, Places]:
    """Return row starts (count + 1,) and ascending columns of all pairs that share a cell.

    unknowns (n_cells, n_local) are the numbers of each cell's unknowns, below `count`.
    """
    n_cells, n_local = unknowns.shape
    ones, starts = np.ones(unknowns.size, np.int32), n_local * np.arange(n_cells + 1)
    members = sparse.csr_matrix((ones, unknowns.ravel(), starts), shape=(n_cells, count))
    pairs = members.T.tocsr() @ members
    pairs.sort_indices()
    return pairs.indptr, pairs.indices


@njit(cache=True)
def small_strain(
    corners: Array,
    unknowns: Integers,
    shear: Array,
    compressibility: Array,
    starts: Places,
    columns: Places,
    data: Array,
) -> None:
    """Add the element matrices [[A, B'], [B, -M / K]] of all cells into `data`.

    corners (n_cells, 4, 3) mm; unknowns (n_cells, 34), displacements first, three to a node;
    shear (n_cells,) kPa, the unit of the pressures of a cell; compressibility (n_cells,) 1/kPa.
    """
    slopes, derivative = np.empty((4, 3)), np.empty((10, 3))
    block = np.empty((34, 34))
    for e in range(len(corners)):
        volume = _slopes(corners[e], slopes)
        block[:] = 0.0
        for q in range(4):
            _quadratic(RULE[q], slopes, derivative)
            _displacements(derivative, volume / 4 * shear[e], block)
            for k in range(4):
                factor = volume / 4 * shear[e] * RULE[q, k]
                for i in range(10):
                    for a in range(3):
                        block[30 + k, 3 * i + a] += factor * derivative[i, a]
        lump = -(shear[e] ** 2) * compressibility[e] * volume / 20
        for k in range(4):
            for m in range(4):
                block[30 + k, 30 + m] = 2 * lump if k == m else lump
        for i in range(30):
            for j in range(i + 1, 34):
                block[i, j] = block[j, i]
        _scatter(block, unknowns[e], starts, columns, data)


@njit(cache=True)
def _slopes(corners: Array, slopes: Array) -> float:
    """Fill the gradients (4, 3) of the barycentric coordinates; return the volume."""
    volume = 0.0
    for k in range(4):
        a, b, c = (k + 1) % 4, (k + 2) % 4, (k + 3) % 4
        height = 0.0
        for d in range(3):
            e, f = (d + 1) % 3, (d + 2) % 3
            slopes[k, d] = (corners[b, e] - corners[a, e]) * (corners[c, f] - corners[a, f])
            slopes[k, d] -= (corners[b, f] - corners[a, f]) * (corners[c, e] - corners[a, e])
            height += slopes[k, d] * (corners[k, d] - corners[a, d])
        for d in range(3):
            slopes[k, d] /= height
        volume = abs(height) / 6
    return volume


@njit(cache=True)
def _quadratic(point: Array, slopes: Array, derivative: Array) -> None:
    """Fill the gradients (10, 3) of the quadratic shapes at barycentric coordinates (4,)."""
    for d in range(3):
        for k in range(4):
            derivative[k, d] = (4 * point[k] - 1) * slopes[k, d]
        for k in range(6):
            a, b = EDGES[k]
            derivative[4 + k, d] = 4 * (point[b] * slopes[a, d] + point[a] * slopes[b, d])


@njit(cache=True)
def _displacements(derivative: Array, weight: float, block: Array) -> None:
    """Add mu (grad u : grad v + grad u : grad v' - 2/3 div u div v) to the lower triangle."""
    for i in range(10):
        for j in range(i + 1):
            dot = 0.0
            for c in range(3):
                dot += derivative[i, c] * derivative[j, c]
            for a in range(3):
                for b in range(3):
                    value = derivative[i, b] * derivative[j, a]
                    value -= 2 / 3 * derivative[i, a] * derivative[j, b]
                    if a == b:
                        value += dot
                    block[3 * i + a, 3 * j + b] += weight * value


@njit(cache=True)
def _scatter(block: Array, members: Integers, starts: Places, columns: Places, data: Array) -> None:
    """Add a block (34, 34) to its rows.

    The three unknowns of a node stand side by side in every row, and have the same columns.
    """
    for k in range(34):
        if k < 30 and k % 3:
            continue
        rows = 3 if k < 30 else 1
        start = starts[members[k]]
        width = starts[members[k] + 1] - start
        row_columns = columns[start : start + width]
        for j in range(14):
            first = 3 * j if j < 10 else 20 + j
            at = start + np.searchsorted(row_columns, members[first])
            for r in range(rows):
                for c in range(3 if j < 10 else 1):
                    data[at + r * width + c] += block[k + r, first + c]
