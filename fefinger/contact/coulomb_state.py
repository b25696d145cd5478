"""State of the compiled contact solver with friction, and its block of active vertices."""

from typing import NamedTuple

import numpy as np

from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


K, SOLVED, SWEPT, KEPT, INVERTED = 0, 1, 2, 3, 4
"""Indices of `CoulombState.counts`: vertices in the block; Newton steps, and sweeps; unknowns of
the last matrix, and whether its inverse is at hand."""


class CoulombState(NamedTuple):
    """State of the solver of contact with friction: pressures and tractions x, displacements F x.

    flexibility F (3n, 3n); mu (n,) of the vertices; x and moved = F x (3n,); block (3n, 3n): F
    of the active vertices `where` (n,), whose position in it is `place` (n,) or -1; compressed,
    constant and rest (3n,): x, b and F x + b of the block; before and start (3n,): ends of a Newton
    step; vertex and extra (3n,), column and row (3n, 3), code and kept (3n,): its unknowns, and
    the last matrix's, with its inverse (3n, 3n); counts (5,); residual (1,): of the last
    solution; chosen and factor (3n,): work.
    """

    flexibility: Array
    mu: Array
    x: Array
    moved: Array
    block: Array
    where: Integers
    place: Integers
    compressed: Array
    constant: Array
    rest: Array
    before: Array
    start: Array
    vertex: Integers
    extra: Array
    column: Array
    row: Array
    code: Integers
    kept: Integers
    inverse: Array
    counts: Integers
    residual: Array
    chosen: Integers
    factor: Array


def coulomb_state(flexibility: Array, mu: float) -> CoulombState:
    """Allocate the state of a flexibility (3n, 3n) and a coefficient, without contact."""
    n = len(flexibility) // 3
    return CoulombState(
        flexibility=np.array(flexibility, order="C"),
        mu=np.full(n, mu, dtype=np.float64),
        x=np.zeros(3 * n),
        moved=np.zeros(3 * n),
        block=np.zeros((3 * n, 3 * n)),
        where=np.zeros(n, dtype=np.int64),
        place=np.full(n, -1, dtype=np.int64),
        compressed=np.zeros(3 * n),
        constant=np.zeros(3 * n),
        rest=np.zeros(3 * n),
        before=np.zeros(3 * n),
        start=np.zeros(3 * n),
        vertex=np.zeros(3 * n, dtype=np.int64),
        extra=np.zeros(3 * n),
        column=np.zeros((3 * n, 3)),
        row=np.zeros((3 * n, 3)),
        code=np.zeros(3 * n, dtype=np.int64),
        kept=np.zeros(3 * n, dtype=np.int64),
        inverse=np.zeros((3 * n, 3 * n)),
        counts=np.zeros(5, dtype=np.int64),
        residual=np.zeros(1),
        chosen=np.zeros(3 * n, dtype=np.int64),
        factor=np.zeros(3 * n),
    )


@njit(cache=True)
def rebuild(s: CoulombState) -> None:
    """Compress the vertices in `where` into the block anew; the last matrix is forgotten."""
    count = s.counts[K]
    s.counts[K], s.counts[KEPT], s.counts[INVERTED] = 0, 0, 0
    s.place[:] = -1
    for i in range(count):
        join(s, s.where[i])


@njit(cache=True)
def join(s: CoulombState, vertex: int) -> None:
    """Add a vertex to the block."""
    n, k, f = len(s.where), s.counts[K], s.flexibility
    s.where[k], s.place[vertex] = vertex, k
    s.counts[K] = k + 1
    for a in range(3):
        row = f[a * n + vertex]
        for i in range(k + 1):
            for b in range(3):
                value = row[b * n + s.where[i]]
                s.block[3 * k + a, 3 * i + b] = value
                s.block[3 * i + b, 3 * k + a] = value


@njit(cache=True)
def leave(s: CoulombState, vertex: int) -> None:
    """Remove a vertex from the block: the last one takes its place."""
    last, at = s.counts[K] - 1, s.place[vertex]
    if at != last:
        for a in range(3):
            s.block[3 * at + a, : 3 * last + 3] = s.block[3 * last + a, : 3 * last + 3]
        for a in range(3):
            for j in range(3 * last + 3):
                s.block[j, 3 * at + a] = s.block[j, 3 * last + a]
        s.where[at] = s.where[last]
        s.place[s.where[at]] = at
    s.place[vertex] = -1
    s.counts[K] = last
