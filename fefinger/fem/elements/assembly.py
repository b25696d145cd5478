"""Assembly of sparse matrices of small-strain isotropic elasticity: stiffness and mass.

The pattern follows from the numbering alone: assembly needs little memory beyond the matrix.

The stiffness is in displacement and mean stress (Herrmann). For every v and q: integral of 2 mu dev
eps(u) : dev eps(v) + p div v equals the load on v, and integral of q div u - q p / K = 0; the mean
stress p = K div u, and 1 / K = 0 at nu = 0.5.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis, ElementTetP2, MeshTet

from fefinger.fem.elements.spaces import Space
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


@dataclass(frozen=True)
class Elastic:
    """Isotropic elasticity: Young's modulus in kPa and Poisson's ratio, 0 <= poisson <= 0.5."""

    modulus: float
    poisson: float

    @property
    def shear(self) -> float:
        """Shear modulus mu in kPa."""
        return self.modulus / (2 * (1 + self.poisson))

    @property
    def compressibility(self) -> float:
        """1 / K in 1/kPa, K the bulk modulus: 0 at nu = 0.5."""
        return 3 * (1 - 2 * self.poisson) / self.modulus


def stiffness(space: Space, tissues: Mapping[int, Elastic]) -> sparse.csr_matrix:
    """Return the symmetric matrix [[A, B'], [B, -M / K]] of the space, mN/mm and mm².

    Its shape is (n_unknowns, n_unknowns). `tissues` gives the elasticity of every label in
    `space.tissue`. A pressure is measured in units of the shear modulus of its own tissue, so that
    moduli 1e9 apart stay within rounding.
    """
    count, numbers = space.n_unknowns, space.unknowns
    starts, columns = pattern(numbers, count)
    data = np.zeros(len(columns))
    small_strain(
        space.points[space.vertices],
        numbers,
        np.array([tissues[int(k)].shear for k in space.tissue]),
        np.array([tissues[int(k)].compressibility for k in space.tissue]),
        starts,
        columns,
        data,
    )
    return sparse.csr_matrix((data, columns, starts), shape=(count, count))


def mass(space: Space, densities: Mapping[int, float]) -> sparse.csr_matrix:
    """Return the consistent mass matrix (n_displacements, n_displacements) of a space.

    `densities` gives the density of every label in `space.tissue`, in kg/mm³ for a matrix in kg: a
    force in mN is one in kg mm/s².
    """
    corners = space.points[space.vertices]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    heavy = volumes * np.array([densities[int(k)] for k in space.tissue])
    reference = Basis(MeshTet.init_refdom(), ElementTetP2(), intorder=4)
    shapes = np.array([np.asarray(f[0])[0] for f in reference.basis])
    products = (shapes * (6 * reference.dx[0])) @ shapes.T  # of a cell of volume 1
    nodes, shape = space.nodes, (space.n_nodes, space.n_nodes)
    values = heavy[:, None, None] * products
    scalar = scattered(values, nodes[:, :, None], nodes[:, None, :], shape)
    return sparse.kron(scalar.tocsr(), sparse.eye(3), format="csr")
