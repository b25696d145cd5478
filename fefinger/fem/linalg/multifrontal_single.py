"""A multifrontal factor of symmetric indefinite matrices, in single or double precision.

Like `multifrontal`, but the pivot block F of a front may be indefinite: it is inverted as a whole,
with row exchanges, and F^-1 and R F^-1 (R the rows below) are stored instead of triangles. That is
enough for the consistent tangent of a body under pressure, which no order of the unknowns makes
quasi-definite. Single precision suffices, because the caller refines by true residuals; double
precision is for matrices on which it fails.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy import sparse
from scipy.linalg.lapack import get_lapack_funcs

from fefinger.fem.linalg.dissection import Dissection, Front
from fefinger.fem.linalg.multifrontal import SINGULAR, Assembly, Floats
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError


Precision = type[np.float32] | type[np.float64]

LARGE = "solve: expected numbers within the range of {} precision, received larger ones"

STRIP = 512  # columns of a symmetric product that are formed at once


@dataclass(frozen=True)
class ApproximateFactor:
    """Approximate factor: F^-1 and R F^-1 of all fronts.

    order (n,) of elimination; table (n_fronts, 3): start, stop and number of rest; rest: all of
    these; values: F^-1 and R F^-1, front by front and row by row; negative: how many eigenvalues
    of the matrix are, by Sylvester's law of inertia.
    """

    order: Integers
    table: Integers
    rest: Integers
    values: Floats
    negative: int

    @property
    def entries(self) -> int:
        """Number of entries stored."""
        return len(self.values)

    @property
    def double(self) -> bool:
        """Whether it is in double precision."""
        return bool(self.values.dtype == np.float64)

    def solve(self, right: Array) -> Array:
        """Return the solution (n,) or (n, k) for right hand sides of the same shape."""
        work = right[self.order].astype(self.values.dtype)
        _solve(self.table, self.rest, self.values, work)
        answer = np.empty(right.shape)
        answer[self.order] = work
        return answer


def factor(
    matrix: sparse.csr_matrix,
    dissection: Dissection,
    precision: Precision = np.float32,
) -> ApproximateFactor:
    """Factor a symmetric matrix (n, n), given in the order of its unknowns.

    Raises
    ------
    InputError
        If a pivot block is singular, or a number beyond the precision.
    """
    order = dissection.order
    arranged = matrix[order][:, order].tocsr()
    with np.errstate(over="ignore"):  # checked on the next line
        arranged.data = arranged.data.astype(precision)
    if not np.isfinite(arranged.data).all():
        raise InputError(LARGE.format("single" if precision is np.float32 else "double"))
    table, values, places = _empty(dissection.fronts, precision)
    negative = 0
    assembly = Assembly(arranged, dissection.fronts)
    for index, (inverse, below) in enumerate(places):
        columns, rest = assembly.front(index)
        n = columns.shape[1]
        inverse[:], below_zero = _inverse(columns[:n])
        negative += below_zero
        np.matmul(columns[n:], inverse, out=below)
        for first in range(0, len(rest), STRIP):
            strip = slice(first, first + STRIP)
            rest[first:, strip] -= below[first:] @ columns[n:][strip].T
        assembly.updates[index] = rest
    rests = np.concatenate([front.rest for front in dissection.fronts])
    return ApproximateFactor(order, table, rests, values, negative)


def _empty(
    fronts: Sequence[Front], precision: Precision
) -> tuple[Integers, Floats, list[tuple[Floats, Floats]]]:
    """Allocate the table and values of a factor, with views of the values of each front."""
    table = np.array([(f.start, f.stop, len(f.rest)) for f in fronts])
    counts = table[:, 1] - table[:, 0]
    starts = np.concatenate([[0], np.cumsum(counts * (counts + table[:, 2]))])
    values = np.empty(starts[-1], dtype=precision)
    places = []
    for n, m, start, stop in zip(counts, table[:, 2], starts[:-1], starts[1:], strict=True):
        block = values[start:stop].reshape(n + m, n)
        places.append((block[:n], block[n:]))
    return table, values, places


def _inverse(block: Floats) -> tuple[Floats, int]:
    """Invert a symmetric matrix (n, n); also count its negative eigenvalues.

    Its lower triangle is read.

    Raises
    ------
    InputError
        If it is singular.
    """
    if not len(block):
        return block, 0
    sytrf, sytrf_lwork, sytri = get_lapack_funcs(("sytrf", "sytrf_lwork", "sytri"), (block,))
    # Without a workspace of the optimal size, LAPACK uses its unblocked, slow algorithm.
    size = int(sytrf_lwork(len(block), lower=1)[0])
    factored, exchanges, singular = sytrf(block, lower=1, lwork=size)
    inverse, _ = sytri(factored, exchanges, lower=1)
    if singular or not np.isfinite(inverse).all():
        raise InputError(SINGULAR)
    return np.asarray(np.tril(inverse) + np.tril(inverse, -1).T), _negative(factored, exchanges)


def _negative(factored: Floats, exchanges: Integers) -> int:
    """Count the negative eigenvalues of D in L D L' of Bunch and Kaufman.

    A 2 x 2 pivot block of this factorization has one eigenvalue of either sign.
    """
    alone = exchanges > 0
    return int((np.diagonal(factored)[alone] < 0).sum()) + int((~alone).sum()) // 2


@njit(cache=True)
def _solve(table: Integers, rest: Integers, values: Floats, work: Floats) -> None:
    """Solve in place for right hand sides (n,) or (n, k) in the order of elimination."""
    place = first = 0
    for f in range(len(table)):
        start, stop, m = table[f]
        n = stop - start
        below = values[place + n * n : place + n * (n + m)].reshape(m, n)
        part = np.dot(below, work[start:stop])
        for i in range(m):
            work[rest[first + i]] -= part[i]
        place, first = place + n * (n + m), first + m
    for f in range(len(table) - 1, -1, -1):
        start, stop, m = table[f]
        n = stop - start
        place, first = place - n * (n + m), first - m
        inverse = values[place : place + n * n].reshape(n, n)
        below = values[place + n * n : place + n * (n + m)].reshape(m, n)
        solved = work[rest[first : first + m]]
        work[start:stop] = np.dot(inverse, work[start:stop]) - np.dot(below.T, solved)
