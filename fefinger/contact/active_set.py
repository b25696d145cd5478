"""Compiled complementarity solver of a condensed body; a solution allocates no array.

The inverse H of the active block of F is updated by bordering: a vertex that is added or removed
costs two products with H, a new Cholesky factor of k vertices k / 6 of them. Every solution starts
from the last one and is refined by its residual, so that H need not be exact: rounding errors do
not accumulate, and F may change slightly from step to step. H is rebuilt where the residual no
longer falls fast.
"""

from typing import NamedTuple

import numpy as np

from fefinger.contact.complementarity import EXCHANGES, PATIENCE
from fefinger.support.arrays import Array, Floats, Integers
from fefinger.support.compiled import njit


RESIDUAL = 1e-13  # over the largest offset: a solution with a larger residual is refined
FALLING = 0.05  # a refinement that leaves a larger share of the residual rebuilds H
REFINED = 1e-10  # over the largest offset: accepted where a new H does not reduce the residual

DONE, ENDLESS, SINGULAR, MISSED, BEYOND, TURNED = 0, 1, 2, 3, 4, 5
"""Outcomes of a step of contact: `Stepper.failures` and `march.failure` say what they mean."""

K, SOLVED, ROUNDS, EXCHANGED, REBUILT = 0, 1, 2, 3, 4
"""Indices of `LcpState.counts`: active vertices; solutions, rounds of exchange and vertices
exchanged in them; inverses rebuilt."""


class LcpState(NamedTuple):
    """The state of the complementarity problem: F x + b >= 0, x >= 0, x . (F x + b) = 0.

    flexibility F (n, n); inverse (n, n), the leading block of which is H; where (n,): the active
    vertices in the order of H; place (n,): the position of a vertex in that order, or -1; x and
    moved = F x (n,); wrong (n,): vertices to exchange; work (2, n); counts (5,).
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

    @property
    def volatile(self) -> tuple[Array | Integers, ...]:
        """Arrays that a failed solution leaves changed."""
        return self.x, self.moved, self.where, self.place, self.counts


def lcp_state(flexibility: Array) -> LcpState:
    """Allocate the solver state of a flexibility (n, n), without contact."""
    n = len(flexibility)
    return LcpState(
        # A copy: numba compiles read-only arrays as another type, which takes seconds.
        flexibility=np.array(flexibility, order="C"),
        inverse=np.zeros((n, n)),
        where=np.zeros(n, dtype=np.int64),
        place=np.full(n, -1, dtype=np.int64),
        x=np.zeros(n),
        moved=np.zeros(n),
        wrong=np.zeros(n, dtype=np.int64),
        work=np.zeros((2, n)),
        counts=np.zeros(5, dtype=np.int64),
    )


@njit(cache=True, fastmath={"contract"})
def accumulate(out: Floats, rows: Floats, chosen: Integers, factor: Floats) -> None:
    """Add the sum over i of factor[i] rows[chosen[i]] to `out`, in either precision."""
    n, k = len(out), len(factor)
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


@njit(cache=True)
def combine(out: Floats, rows: Floats, values: Array, chosen: Integers, factor: Floats) -> int:
    """Set `out` to the sum of values[i] rows[i]; return how many of the values are not zero.

    Their indices and they themselves are then in `chosen` and `factor`.
    """
    k = 0
    for i in range(len(values)):
        if values[i] != 0.0:
            chosen[k], factor[k] = i, values[i]
            k += 1
    out[:] = 0.0
    accumulate(out, rows, chosen, factor[:k])
    return k


@njit(cache=True, fastmath={"contract"})
def _times_inverse(s: LcpState, right: Array, out: Array) -> None:
    """Compute out = H right, both in the order of H."""
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
def _add_vertex(s: LcpState, vertex: int) -> bool:
    """Add a vertex to the active set; False if F is not positive definite."""
    k, h = s.counts[K], s.inverse
    column, image = s.work[0], s.work[1]
    for i in range(k):
        column[i] = s.flexibility[vertex, s.where[i]]
    _times_inverse(s, column, image)
    diagonal = s.flexibility[vertex, vertex]
    pivot = diagonal
    for i in range(k):
        pivot -= column[i] * image[i]
    if not pivot > 1e-14 * diagonal:  # rounding of the sum above; "not >" also catches nan
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
def remove_vertex(s: LcpState, vertex: int) -> None:
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
def rebuild(s: LcpState) -> bool:
    """Rebuild H vertex by vertex; False if F is not positive definite."""
    k = s.counts[K]
    s.counts[K] = 0
    s.counts[REBUILT] += 1
    for i in range(k):
        if not _add_vertex(s, s.where[i]):
            return False
    return True


@njit(cache=True)
def product(s: LcpState) -> None:
    """Compute moved = F x."""
    k = s.counts[K]
    for i in range(k):
        s.work[0, i] = s.x[s.where[i]]
    s.moved[:] = 0.0
    accumulate(s.moved, s.flexibility, s.where, s.work[0, :k])


@njit(cache=True, inline="always")
def _residual(s: LcpState, offset: Array) -> float:
    """Compute the residual -(F x + b) of the active set into `work`; return its largest entry."""
    largest = 0.0
    for i in range(s.counts[K]):
        j = s.where[i]
        s.work[0, i] = -(offset[j] + s.moved[j])
        largest = max(largest, abs(s.work[0, i]))
    return largest


@njit(cache=True, inline="always")
def _solve_active(s: LcpState, offset: Array, scale: float) -> bool:
    """Solve F x + b = 0 on the active set by iterative refinement; False if F is not definite."""
    last, fresh = np.inf, False
    largest = _residual(s, offset)
    while True:
        # "not <=" also catches nan. The first time `last` is infinite, and H is used as it is.
        if not largest <= FALLING * last:
            if fresh:
                return largest <= REFINED * scale
            if not rebuild(s):
                return False
            fresh = True
            _residual(s, offset)  # `rebuild` has overwritten `work`
        _times_inverse(s, s.work[0], s.work[1])
        for i in range(s.counts[K]):
            s.x[s.where[i]] += s.work[1, i]
        product(s)
        last, largest = largest, _residual(s, offset)
        if largest <= RESIDUAL * scale:
            return True


@njit(cache=True, inline="always")
def _mark_violations(s: LcpState, offset: Array, least: float) -> int:
    """List the vertices with tension or penetration in `wrong`; return their number."""
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
def solve(s: LcpState, offset: Array, tolerance: float) -> int:
    """Solve for x with b = `offset`, from the last x and active set; return DONE or a failure.

    Block principal pivoting (Júdice and Pires, Comput. Oper. Res. 21:587, 1994), as in
    `complementarity`.
    """
    scale = 0.0
    for j in range(len(offset)):
        scale = max(scale, abs(offset[j]))
    fewest, patience = len(offset) + 1, PATIENCE
    s.counts[SOLVED] += 1
    for _ in range(EXCHANGES):
        if not _solve_active(s, offset, scale):
            return SINGULAR
        count = _mark_violations(s, offset, tolerance * scale)
        if count == 0:
            return DONE
        first = 0
        if count < fewest:
            fewest, patience = count, PATIENCE
        elif patience > 0:
            patience -= 1
        else:
            # The last violation alone (Murty's rule): slow, but it cannot cycle.
            first = count - 1
        s.counts[ROUNDS] += 1
        s.counts[EXCHANGED] += count - first
        for i in range(first, count):
            j = s.wrong[i]
            if s.place[j] < 0:
                if not _add_vertex(s, j) and not (rebuild(s) and _add_vertex(s, j)):
                    return SINGULAR
            else:
                remove_vertex(s, j)
                for k in range(len(s.moved)):
                    s.moved[k] -= s.x[j] * s.flexibility[j, k]
                s.x[j] = 0.0
    return ENDLESS


@njit(cache=True, inline="always")
def slope(s: LcpState, right: Array) -> float:
    """Compute right . z, with F z = `right` on the active set and z = 0 off it."""
    k = s.counts[K]
    for i in range(k):
        s.work[0, i] = right[s.where[i]]
    _times_inverse(s, s.work[0], s.work[1])
    total = 0.0
    for i in range(k):
        total += s.work[0, i] * s.work[1, i]
    return total
