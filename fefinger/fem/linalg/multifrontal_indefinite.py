"""A multifrontal factor of symmetric indefinite matrices, in single or double precision.

Like `multifrontal`, but the pivot block F of a front may be indefinite: it is inverted as a whole,
with row exchanges, and F^-1 and R F^-1 (R the rows below) are stored instead of triangles. That is
enough for the consistent tangent of a body under pressure, which no order of the unknowns makes
quasi-definite. Single precision suffices, because the caller refines by true residuals; double
precision is for matrices on which it fails.

The branches of the dissection are factored and solved in all threads, then the fronts above them.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import get_lapack_funcs

from fefinger.fem.linalg.dissection import Dissection
from fefinger.fem.linalg.multifrontal import SINGULAR, Assembly, Floats
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError
from fefinger.support.compiled import njit
from fefinger.support.processes import together


Precision = type[np.float32] | type[np.float64]

LARGE = "solve: expected numbers within the range of {} precision, received larger ones"

STRIP = 512  # rows or columns of a product that are formed at once


@dataclass(frozen=True)
class Branch:
    """Eliminated fronts of a branch of the dissection: F^-1 and R F^-1 of each.

    unknowns (n_own + n_border,): first the ones eliminated here, in order, then those in fronts
    above that they act on; own: n_own. table (n_fronts, 3): start, stop and number of rest; rest:
    all of these, as places among `unknowns`; values: F^-1 and R F^-1, front by front and row by
    row; negative: how many eigenvalues of the fronts are.
    """

    unknowns: Integers
    own: int
    table: Integers
    rest: Integers
    values: Floats
    negative: int

    def forward(self, work: Floats) -> Floats:
        """Eliminate: own unknowns (n_own, ...), then what is added to the border."""
        part = work[self.unknowns]
        part[self.own :] = 0.0
        _forward(self.table, self.rest, self.values, part)
        return part

    def backward(self, work: Floats) -> None:
        """Substitute the border's solution, in place."""
        part = work[self.unknowns]
        _backward(self.table, self.rest, self.values, part)
        work[self.unknowns[: self.own]] = part[: self.own]


@dataclass(frozen=True)
class ApproximateFactor:
    """Approximate factor: branches that depend on no other, and the fronts above them at last."""

    branches: tuple[Branch, ...]

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues of the matrix, by Sylvester's law of inertia."""
        return sum(branch.negative for branch in self.branches)

    def solve(self, right: Array) -> Array:
        """Return the solution (n,) or (n, k) for right hand sides of the same shape."""
        # One column is a matrix too: the substitutions are compiled once.
        work = right.reshape(len(right), -1).astype(self.branches[0].values.dtype)
        *branches, above = self.branches
        parts = together(lambda branch: branch.forward(work), branches)
        for branch, part in zip(branches, parts, strict=True):
            work[branch.unknowns[: branch.own]] = part[: branch.own]
            work[branch.unknowns[branch.own :]] += part[branch.own :]
        work[above.unknowns] = above.forward(work)
        above.backward(work)
        together(lambda branch: branch.backward(work), branches)
        return work.reshape(right.shape).astype(np.float64)


def factor(
    matrix: sparse.csr_matrix,
    dissection: Dissection,
    precision: Precision = np.float32,
) -> ApproximateFactor:
    """Factor a symmetric matrix (n, n), given in the order of its unknowns.

    Raises InputError if a pivot block is singular, or a number beyond the precision.
    """
    order = dissection.order
    arranged = matrix[order][:, order].tocsr()
    with np.errstate(over="ignore"):  # checked on the next line
        arranged.data = arranged.data.astype(precision)
    if not np.isfinite(arranged.data).all():
        raise InputError(LARGE.format("single" if precision is np.float32 else "double"))
    updates: dict[int, Floats] = {}
    *branches, above = dissection.branches

    def eliminated(numbers: Integers) -> Branch:
        return _eliminated(numbers, dissection, Assembly(arranged, dissection.fronts, updates))

    return ApproximateFactor((*together(eliminated, branches), eliminated(above)))


def _eliminated(numbers: Integers, dissection: Dissection, assembly: Assembly) -> Branch:
    """Eliminate the fronts of a branch."""
    fronts = [dissection.fronts[number] for number in numbers]
    pivots = np.concatenate([np.arange(front.start, front.stop) for front in fronts])
    members = np.concatenate([pivots, fronts[-1].rest])
    counts = np.array([(front.stop - front.start, len(front.rest)) for front in fronts])
    starts = np.searchsorted(pivots, [front.start for front in fronts])
    values = np.empty((counts[:, 0] * counts.sum(axis=1)).sum(), dtype=assembly.dtype)
    negative = place = 0
    for number, (n, m) in zip(numbers.tolist(), counts.tolist(), strict=True):
        block = values[place : place + n * (n + m)].reshape(n + m, n)
        columns, rest = assembly.front(number)
        negative += _inverse(columns[:n], block[:n])
        assembly.updates[number] = _schur(columns[n:], block, rest)
        place += block.size
    return Branch(
        unknowns=dissection.order[members],
        own=len(pivots),
        table=np.column_stack([starts, starts + counts[:, 0], counts[:, 1]]),
        rest=np.searchsorted(members, np.concatenate([front.rest for front in fronts])),
        values=values,
        negative=negative,
    )


def _schur(rows: Floats, block: Floats, rest: Floats) -> Floats:
    """Fill R F^-1 below F^-1 in `block`; return the Schur complement, whose lower triangle counts.

    Strips of it are formed in all threads.
    """
    inverse, below = np.vsplit(block, [block.shape[1]])

    # Each thread has an error state of its own; `_inverse` refuses what is not finite.
    def fill(first: int) -> None:
        with np.errstate(over="ignore", invalid="ignore"):
            np.matmul(rows[first : first + STRIP], inverse, out=below[first : first + STRIP])

    def subtract(first: int) -> None:
        strip = slice(first, first + STRIP)
        with np.errstate(over="ignore", invalid="ignore"):
            rest[first:, strip] -= below[first:] @ rows[strip].T

    strips = range(0, len(rest), STRIP)
    together(fill, strips)
    together(subtract, strips)
    return rest


def _inverse(block: Floats, out: Floats) -> int:
    """Fill `out` with the inverse of a symmetric matrix (n, n); count its negative eigenvalues.

    Its lower triangle is read. Raises InputError if it is singular.
    """
    if not len(block):
        return 0
    sytrf, sytrf_lwork, sytri = get_lapack_funcs(("sytrf", "sytrf_lwork", "sytri"), (block,))
    # Without a workspace of the optimal size, LAPACK uses its unblocked, slow algorithm.
    size = int(sytrf_lwork(len(block), lower=1)[0])
    factored, exchanges, singular = sytrf(block, lower=1, lwork=size)
    inverse, _ = sytri(factored, exchanges, lower=1)
    if singular or not _mirrored(inverse, out):
        raise InputError(SINGULAR)
    # A 2 x 2 pivot block of Bunch and Kaufman has one eigenvalue of either sign.
    alone = exchanges > 0
    return int((np.diagonal(factored)[alone] < 0).sum()) + int((~alone).sum()) // 2


@njit(cache=True, nogil=True)
def _mirrored(lower: Floats, out: Floats) -> bool:
    """Fill a symmetric matrix from its lower triangle; return whether it is finite."""
    finite = True
    for j in range(len(lower)):
        for i in range(j, len(lower)):
            out[i, j] = out[j, i] = lower[i, j]
            finite &= np.isfinite(lower[i, j])
    return finite


@njit(cache=True, nogil=True)
def _forward(table: Integers, rest: Integers, values: Floats, work: Floats) -> None:
    """Forward substitution in place, for (n, k) in the order of elimination.

    Rows are subtracted in loops: as expressions of arrays they take seconds to compile.
    """
    place = first = 0
    columns = work.shape[1]
    for f in range(len(table)):
        start, stop, m = table[f]
        n = stop - start
        below = values[place + n * n : place + n * (n + m)].reshape(m, n)
        part = np.dot(below, work[start:stop])
        for i in range(m):
            row = rest[first + i]
            for c in range(columns):
                work[row, c] -= part[i, c]
        place, first = place + n * (n + m), first + m


@njit(cache=True, nogil=True)
def _backward(table: Integers, rest: Integers, values: Floats, work: Floats) -> None:
    """Backward substitution in place, for (n, k) in the order of elimination."""
    place, first = len(values), len(rest)
    columns, solved = work.shape[1], np.empty_like(work)
    for f in range(len(table) - 1, -1, -1):
        start, stop, m = table[f]
        n = stop - start
        place, first = place - n * (n + m), first - m
        inverse = values[place : place + n * n].reshape(n, n)
        below = values[place + n * n : place + n * (n + m)].reshape(m, n)
        for i in range(m):
            row = rest[first + i]
            for c in range(columns):
                solved[i, c] = work[row, c]
        own = np.dot(inverse, work[start:stop])
        other = np.dot(below.T, solved[:m])
        for i in range(n):
            for c in range(columns):
                work[start + i, c] = own[i, c] - other[i, c]
