"""A multifrontal factor of the symmetric quasi-definite matrices of mixed elasticity.

Each part of a nested dissection of the cells gathers the equations of its own unknowns in a dense
front and passes the Schur complement of the rest to its parent (Duff and Reid, ACM Trans. Math.
Softw. 9:302, 1983).
A pivot block [[A, B'], [B, -C]] with positive definite A and C needs no pivoting (Vanderbei, SIAM
J. Optim. 5:100, 1995): F = L D L' with D = 1 on displacements and -1 on pressures, by two Cholesky
factors, so that nearly all the work is done by dense matrix products.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import LinAlgError, cholesky
from scipy.linalg.blas import dsyrk, dtrsm

from fefinger.fem.linalg.dissection import Dissection, Front
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError
from fefinger.support.compiled import njit
from fefinger.support.tolerances import SINGULAR_PIVOT


Floats = NDArray[np.floating]

SINGULAR = (
    "held facets: expected a body that cannot move freely and cells of positive volume, received "
    "a stiffness matrix that is singular; hold more facets or repair the mesh"
)


@dataclass(frozen=True)
class Eliminated:
    """A factored front: lower (n, n) of its pivots, below (m, n) of its rest, signs (n, 1) of D."""

    front: Front
    lower: Array
    below: Array
    signs: Array


@dataclass(frozen=True)
class Factor:
    """The factor L D L' of a matrix, front by front."""

    order: Integers
    fronts: tuple[Eliminated, ...]

    def solve(self, right: Array) -> Array:
        """Return the solution (n,) or (n, k) for right hand sides of the same shape."""
        work = right[self.order].reshape(len(right), -1)
        self.forward(work)
        self.backward(work)
        answer = np.empty_like(work)
        answer[self.order] = work
        return answer.reshape(right.shape)

    def forward(self, work: Array) -> None:
        """Forward substitution with L, in place, in the order of elimination (n, k)."""
        for f in self.fronts:
            pivots = slice(f.front.start, f.front.stop)
            work[pivots] = dtrsm(1.0, f.lower, work[pivots], lower=1)
            work[f.front.rest] -= f.below @ work[pivots]

    def backward(self, work: Array) -> None:
        """Backward substitution with D L', in place, in the order of elimination (n, k)."""
        for f in reversed(self.fronts):
            pivots = slice(f.front.start, f.front.stop)
            right = f.signs * work[pivots] - f.below.T @ work[f.front.rest]
            work[pivots] = dtrsm(1.0, f.lower, right, lower=1, trans_a=1)


class Assembly:
    """Fronts of a matrix, filled one after the other.

    updates: Schur complements (m, m) of eliminated fronts, by number, until they are added to the
    front that has them as a part; their lower triangles count. Several assemblies may share them.
    """

    def __init__(
        self,
        arranged: sparse.csr_matrix,
        fronts: Sequence[Front],
        updates: dict[int, Floats] | None = None,
    ) -> None:
        self.updates: dict[int, Floats] = {} if updates is None else updates
        self._arranged, self._fronts = arranged, fronts
        self._place = np.full(arranged.shape[0], -1, dtype=np.int64)

    @property
    def dtype(self) -> "np.dtype[np.floating]":
        """Precision of the entries."""
        return self._arranged.dtype

    def front(self, index: int) -> tuple[Floats, Floats]:
        """Return the pivots' columns (n + m, n) and the lower triangle of the rest (m, m)."""
        front, place = self._fronts[index], self._place
        n, m = front.stop - front.start, len(front.rest)
        place[front.start : front.stop] = np.arange(n)
        place[front.rest] = n + np.arange(m)
        columns = np.zeros((n + m, n), dtype=self._arranged.dtype, order="F")
        rest = np.zeros((m, m), dtype=self._arranged.dtype, order="F")
        self._gather(columns, front)
        # By columns: arrays of one column count as of either layout, and compile it twice.
        flat = columns.T.reshape(-1), n + m, rest.T.reshape(-1), m
        for part in front.parts:
            where = place[self._fronts[part].rest]
            _add_lower(*flat, self.updates.pop(part), where, int(np.searchsorted(where, n)))
        place[front.start : front.stop] = -1
        place[front.rest] = -1
        return columns, rest

    def _gather(self, columns: Floats, front: Front) -> None:
        """Put the matrix entries of the pivots' rows into the columns of the front."""
        matrix = self._arranged
        block = slice(matrix.indptr[front.start], matrix.indptr[front.stop])
        lengths = np.diff(matrix.indptr[front.start : front.stop + 1])
        row = np.repeat(np.arange(front.stop - front.start), lengths)
        member = self._place[matrix.indices[block]]
        inside = member >= 0
        columns[member[inside], row[inside]] = matrix.data[block][inside]


def factor(matrix: sparse.csr_matrix, dissection: Dissection) -> Factor:
    """Factor a symmetric quasi-definite matrix (n, n), given in the order of its unknowns.

    Raises InputError if a pivot block is not definite: part of the body is not held, or a cell is
    degenerate.
    """
    order = dissection.order
    arranged = matrix[order][:, order].tocsr()
    diagonal = np.abs(arranged.diagonal())
    assembly = Assembly(arranged, dissection.fronts)
    done: list[Eliminated] = []
    for index, front in enumerate(dissection.fronts):
        columns, rest = assembly.front(index)
        split = front.pressure - front.start
        lower, below, signs = _eliminate(columns, split)
        pivots = np.diagonal(lower) ** 2
        if (pivots < SINGULAR_PIVOT * diagonal[front.start : front.stop]).any():
            raise InputError(SINGULAR)
        eliminated = Eliminated(front, lower, below, signs)
        assembly.updates[index] = _schur(rest, eliminated.below, split)
        done.append(eliminated)
    return Factor(order, tuple(done))


@njit(cache=True, nogil=True)
def _add_lower(
    columns: Floats,
    height: int,
    rest: Floats,
    m: int,
    update: Floats,
    where: Integers,
    n_pivots: int,
) -> None:
    """Add a child's Schur complement (lower triangle); its first `n_pivots` rows are pivots.

    columns and rest, `height` and m rows high: of a front, column after column.
    """
    n = height - m
    for j in range(n_pivots):
        for i in range(j, len(where)):
            columns[where[j] * height + where[i]] += update[i, j]
    for j in range(n_pivots, len(where)):
        for i in range(j, len(where)):
            rest[(where[j] - n) * m + where[i] - n] += update[i, j]


def _eliminate(columns: Floats, split: int) -> tuple[Array, Array, Array]:
    """Factor the pivot block: L (n, n), the rows below it, and the signs of D.

    Only the lower triangle is read.
    """
    n = columns.shape[1]
    lower = np.zeros((n, n), order="F")
    a, b = slice(0, split), slice(split, n)
    try:
        lower[a, a] = _cholesky(columns[a, a])
        left = _divided(lower[a, a], columns[split:, a])
        lower[b, a] = left[: n - split]
        right = columns[split:, b]
        if split < n:
            # The pressures have the block -C: minus its Schur complement is positive definite.
            right = left @ lower[b, a].T - right
            lower[b, b] = _cholesky(right[: n - split])
    except LinAlgError as error:
        raise InputError(SINGULAR) from error
    below = np.empty((len(columns) - n, n), order="F")
    below[:, a] = left[n - split :]
    below[:, b] = _divided(lower[b, b], right[n - split :])
    signs = np.ones((n, 1))
    signs[b] = -1.0
    return lower, below, signs


def _schur(rest: Floats, below: Array, split: int) -> Floats:
    """Schur complement rest - L D L' of the rows below the pivots; the lower triangle is set."""
    if len(rest) == 0:
        return rest
    if split > 0:
        rest = dsyrk(-1.0, below[:, :split], beta=1.0, c=rest, lower=1, overwrite_c=1)
    if split < below.shape[1]:
        # D is -1 on the pressures, so that their part is added.
        rest = dsyrk(1.0, below[:, split:], beta=1.0, c=rest, lower=1, overwrite_c=1)
    return rest


def _cholesky(block: Floats) -> Floats:
    return np.asarray(cholesky(block, lower=True, check_finite=False)) if block.size else block


def _divided(lower: Floats, rows: Floats) -> Floats:
    """Return rows @ inv(lower).T."""
    if rows.size == 0:
        return rows
    return np.asarray(dtrsm(1.0, lower, rows, side=1, lower=1, trans_a=1))
