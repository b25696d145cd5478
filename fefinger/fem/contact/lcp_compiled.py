"""Exact contact of a condensed body, compiled: no array is made in a step.

The inverse H of the active block of F is kept, and follows the active set by bordering: a vertex
that joins or leaves costs two products with H, where a new Cholesky factor costs k / 6 of them.
Every solution starts from the last one and is refined by its own residual, so that H need not be
exact: rounding does not add up, and F may change a little from step to step. H is made anew where
the residual no longer falls fast.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fefinger.fem.elements.spaces import Array, Integers


Floats = NDArray[np.floating]

EXCHANGES = 500  # as in `contact`: PATIENCE block exchanges without progress, then single ones
PATIENCE = 12
CORRECTIONS = 60
RESIDUAL = 1e-13  # of the largest offset, above which a solution is refined
FALLING = 0.05  # what has to be left of a residual, or H is made anew
REFINED = 1e-10  # of the largest offset: a residual that no longer falls from there is a failure

DONE, ENDLESS, SINGULAR, MISSED, BEYOND, TURNED = 0, 1, 2, 3, 4, 5

K, SOLVED, ROUNDS, EXCHANGED, REBUILT = 0, 1, 2, 3, 4
"""Places in `Active.counts`: active vertices; solutions, rounds of exchange in them and vertices
exchanged; inverses made anew."""


class Active(NamedTuple):
    """The state of the complementarity problem: F x + b >= 0, x >= 0, x . (F x + b) = 0.

    flexibility (n, n); inverse (n, n), the leading block of which is H; where (n,) the active
    vertices in the order of H, place (n,) where in it a vertex stands or -1; x and moved = F x
    (n,); wrong (n,) marks; work (2, n); counts (5,); held and stood (2, n), x and moved, where and
    place as `hold` found them.
    """

    flexibility: Array
    inverse: Array
    where: Integers
    place: Integers
    x: Array
    moved: Array
    wrong: Integers
    work: Array
    counts: Integers
    held: Array
    stood: Integers


def active(flexibility: Array) -> Active:
    """Return the state without contact."""
    n = len(flexibility)
    return Active(
        flexibility=np.array(flexibility, order="C"),  # one that is read-only compiles anew
        inverse=np.zeros((n, n)),
        where=np.zeros(n, dtype=np.int64),
        place=np.full(n, -1, dtype=np.int64),
        x=np.zeros(n),
        moved=np.zeros(n),
        wrong=np.zeros(n, dtype=np.int64),
        work=np.zeros((2, n)),
        counts=np.zeros(5, dtype=np.int64),
        held=np.zeros((2, n)),
        stood=np.zeros((2, n), dtype=np.int64),
    )


@njit(cache=True)
def release(s: Active) -> None:
    """Return to the state without contact."""
    s.place[:] = -1
    s.x[:] = 0.0
    s.moved[:] = 0.0
    s.counts[:] = 0


@njit(cache=True, fastmath={"contract"})
def accumulate(out: Floats, rows: Floats, chosen: Integers, factor: Floats, k: int) -> None:
    """Add the sum over i < k of factor[i] rows[chosen[i]] to `out`, in either precision."""
    n = len(out)
    whole = k - k % 4
    for i in range(0, whole, 4):
        a, b, c, d = factor[i], factor[i + 1], factor[i + 2], factor[i + 3]
        p, q = rows[chosen[i]], rows[chosen[i + 1]]
        r, t = rows[chosen[i + 2]], rows[chosen[i + 3]]
        for j in range(n):
            out[j] += (a * p[j] + b * q[j]) + (c * r[j] + d * t[j])
    for i in range(whole, k):
        a, p = factor[i], rows[chosen[i]]
        for j in range(n):
            out[j] += a * p[j]


@njit(cache=True, fastmath={"contract"})
def _times_inverse(s: Active, right: Array, out: Array) -> None:
    """Put H right into `out`, both in the order of H."""
    k = s.counts[K]
    h = s.inverse
    for j in range(k):
        out[j] = 0.0
    whole = k - k % 4
    for i in range(0, whole, 4):
        a, b, c, d = right[i], right[i + 1], right[i + 2], right[i + 3]
        for j in range(k):
            out[j] += (a * h[i, j] + b * h[i + 1, j]) + (c * h[i + 2, j] + d * h[i + 3, j])
    for i in range(whole, k):
        for j in range(k):
            out[j] += right[i] * h[i, j]


@njit(cache=True, fastmath={"contract"})
def _join(s: Active, vertex: int) -> bool:
    """Add a vertex to the active set; False if F is not positive definite."""
    k, h = s.counts[K], s.inverse
    column, image = s.work[0], s.work[1]
    for i in range(k):
        column[i] = s.flexibility[vertex, s.where[i]]
    _times_inverse(s, column, image)
    own = s.flexibility[vertex, vertex]
    pivot = own
    for i in range(k):
        pivot -= column[i] * image[i]
    if not pivot > 1e-14 * own:
        return False
    for i in range(k):
        share = image[i] / pivot
        for j in range(k):
            h[i, j] += share * image[j]
        h[i, k] = -share
        h[k, i] = -share
    h[k, k] = 1.0 / pivot
    s.where[k] = vertex
    s.place[vertex] = k
    s.counts[K] = k + 1
    return True


@njit(cache=True, fastmath={"contract"})
def _leave(s: Active, vertex: int) -> None:
    """Remove a vertex from the active set."""
    h, last, at = s.inverse, s.counts[K] - 1, s.place[vertex]
    if at != last:
        for j in range(last + 1):
            h[at, j], h[last, j] = h[last, j], h[at, j]
        for i in range(last + 1):
            h[i, at], h[i, last] = h[i, last], h[i, at]
        s.where[at] = s.where[last]
        s.place[s.where[at]] = at
    s.place[vertex] = -1
    s.counts[K] = last
    pivot, row = h[last, last], h[last]
    for i in range(last):
        share = h[i, last] / pivot
        for j in range(last):
            h[i, j] -= share * row[j]


@njit(cache=True)
def _rebuild(s: Active) -> bool:
    """Make H anew; False if F is not positive definite."""
    k = s.counts[K]
    s.counts[K] = 0
    s.counts[REBUILT] += 1
    for i in range(k):
        if not _join(s, s.where[i]):
            return False
    return True


@njit(cache=True)
def hold(s: Active) -> int:
    """Note the present solution, and return how many vertices are active in it."""
    s.held[0], s.held[1] = s.x, s.moved
    s.stood[0], s.stood[1] = s.where, s.place
    return s.counts[K]


@njit(cache=True)
def restore(s: Active, active: int) -> None:
    """Return to the solution that `hold` noted; H is made anew, as it may have lost vertices."""
    s.where[:], s.place[:] = s.stood[0], s.stood[1]
    s.counts[K] = active
    _rebuild(s)
    s.x[:], s.moved[:] = s.held[0], s.held[1]


@njit(cache=True)
def product(s: Active) -> None:
    """Put F x into `moved`."""
    k = s.counts[K]
    for i in range(k):
        s.work[0, i] = s.x[s.where[i]]
    s.moved[:] = 0.0
    accumulate(s.moved, s.flexibility, s.where, s.work[0], k)


@njit(cache=True)
def _residual(s: Active, offset: Array) -> float:
    """Put -(F x + b) of the active set into `work`; return its largest entry."""
    largest = 0.0
    for i in range(s.counts[K]):
        j = s.where[i]
        s.work[0, i] = -(offset[j] + s.moved[j])
        largest = max(largest, abs(s.work[0, i]))
    return largest


@njit(cache=True)
def _balance(s: Active, offset: Array, scale: float) -> bool:
    """Make F x + b zero on the active set, from the present x; False if F is not definite."""
    last, fresh = np.inf, False
    largest = _residual(s, offset)
    while True:
        if not largest <= FALLING * last:
            if fresh:
                return largest <= REFINED * scale
            if not _rebuild(s):
                return False
            fresh = True
            _residual(s, offset)  # H was made in the same work space
        _times_inverse(s, s.work[0], s.work[1])
        for i in range(s.counts[K]):
            s.x[s.where[i]] += s.work[1, i]
        product(s)
        last, largest = largest, _residual(s, offset)
        if largest <= RESIDUAL * scale:
            return True


@njit(cache=True)
def _mark(s: Active, offset: Array, least: float) -> int:
    """Mark the vertices that pull or are pressed into the obstacle; return their number."""
    count = 0
    for j in range(len(offset)):
        if s.place[j] >= 0:
            wrong = s.x[j] < 0.0
        else:
            wrong = s.moved[j] + offset[j] < -least
        if wrong:
            s.wrong[count] = j
            count += 1
    return count


@njit(cache=True)
def solve(s: Active, offset: Array, tolerance: float) -> int:
    """Find x for b = `offset`, from the last x and active set; return DONE or what failed.

    Block principal pivoting (Júdice and Pires, Comput. Oper. Res. 21:587, 1994), as `contact`.
    """
    scale = 0.0
    for j in range(len(offset)):
        scale = max(scale, abs(offset[j]))
    fewest, patience = len(offset) + 1, PATIENCE
    s.counts[SOLVED] += 1
    for _ in range(EXCHANGES):
        if not _balance(s, offset, scale):
            return SINGULAR
        count = _mark(s, offset, tolerance * scale)
        if count == 0:
            return DONE
        first = 0
        if count < fewest:
            fewest, patience = count, PATIENCE
        elif patience > 0:
            patience -= 1
        else:
            first = count - 1
        s.counts[ROUNDS] += 1
        s.counts[EXCHANGED] += count - first
        for i in range(first, count):
            j = s.wrong[i]
            if s.place[j] < 0:
                if not _join(s, j) and not (_rebuild(s) and _join(s, j)):
                    return SINGULAR
            else:
                _leave(s, j)
                for k in range(len(s.moved)):
                    s.moved[k] -= s.x[j] * s.flexibility[j, k]
                s.x[j] = 0.0
    return ENDLESS


@njit(cache=True)
def slope(s: Active, right: Array) -> float:
    """Return right . z, with F z = `right` on the active set and z = 0 off it."""
    k = s.counts[K]
    for i in range(k):
        s.work[0, i] = right[s.where[i]]
    _times_inverse(s, s.work[0], s.work[1])
    total = 0.0
    for i in range(k):
        total += s.work[0, i] * s.work[1, i]
    return total
