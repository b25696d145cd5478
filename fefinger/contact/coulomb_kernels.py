"""Compiled parts of contact with Coulomb friction: sweeps, residual, and Newton's method."""

from typing import NamedTuple

import numpy as np

from fefinger.contact.active_set import ENDLESS
from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


CONE = 1e-10  # residual that counts as none, over the largest pressure
ITERATIONS = 200  # most steps of Newton's method and sweeps of a solution
SMOOTHING = 10  # sweeps where no part of a Newton step comes closer
SHORTEST = 1 / 16  # part of a Newton step
FALLING = 0.2  # part of the residual that a step with an inverse leaves, or it is dropped

KINDS = 5  # of unknowns

SETTLED, SOLVE, INVERT = 0, -1, -2
"""Outcomes of an iteration besides ENDLESS: solved; a matrix to solve with, or to invert, as its
unknowns are the last ones."""

K, SOLVED, TRIED, UNKNOWNS = 0, 1, 2, 3
"""Indices of `CoulombSolver.counts`: vertices in the block; Newton steps; iterations of the present
solution; unknowns of the matrix that it needs."""


class Block(NamedTuple):
    """The iterate on the vertices in question, and room for all.

    matrix (3n, 3n): F; mu (n,); x, constant and rest (3n,): x, b and F x + b.
    """

    matrix: Array
    mu: Array
    x: Array
    constant: Array
    rest: Array


class Unknowns(NamedTuple):
    """The unknowns of a Newton step, and room for all.

    vertex, code (3n,): the vertex in the block, and which vertex and kind it is; column, row
    (3n, 3) and extra (3n,): entries of the matrix.
    """

    vertex: Integers
    code: Integers
    column: Array
    row: Array
    extra: Array


@njit(cache=True, fastmath={"contract"})
def _add(rest: Array, row: Array, factor: float, m: int) -> None:
    for j in range(m):
        rest[j] += factor * row[j]


@njit(cache=True, fastmath={"contract"})
def _add_two(rest: Array, first: Array, a: float, second: Array, b: float, m: int) -> None:
    for j in range(m):
        rest[j] += a * first[j] + b * second[j]


@njit(cache=True, inline="always")
def _target(s: Block, i: int) -> tuple[float, float, float, float]:
    """Return pressure and traction before their projection, and the stiffness along the plane.

    A vertex that cannot move along a direction, as across a plane of symmetry, bears none there.
    """
    j = 3 * i
    a, b, c = s.matrix[j + 1, j + 1], s.matrix[j + 2, j + 2], s.matrix[j + 1, j + 2]
    # The largest eigenvalue of the block in the plane; 0 where the vertex cannot move.
    stiff = (a + b) / 2 + np.sqrt((a - b) ** 2 / 4 + c * c)
    u = s.x[j + 1] - s.rest[j + 1] / stiff if a > 0.0 else 0.0
    v = s.x[j + 2] - s.rest[j + 2] / stiff if b > 0.0 else 0.0
    return s.x[j] - s.rest[j] / s.matrix[j, j], u, v, stiff


@njit(cache=True, inline="always")
def _on_disc(u: float, v: float, bound: float) -> tuple[float, float]:
    """Project a traction on the disc of a radius `bound`."""
    size = np.hypot(u, v)
    return (u * bound / size, v * bound / size) if size > bound else (u, v)


@njit(cache=True)
def _sweep(s: Block, k: int) -> None:
    """Visit all vertices: project pressure and traction, and update the gaps and slips of all."""
    x, rest, m = s.x, s.rest, 3 * k
    for i in range(k):
        j = 3 * i
        step = max(0.0, x[j] - rest[j] / s.matrix[j, j]) - x[j]
        if step != 0.0:
            x[j] += step
            _add(rest, s.matrix[j], step, m)
        _, u, v, _ = _target(s, i)
        u, v = _on_disc(u, v, s.mu[i] * x[j])
        first, second = u - x[j + 1], v - x[j + 2]
        if first != 0.0 or second != 0.0:
            x[j + 1], x[j + 2] = u, v
            _add_two(rest, s.matrix[j + 1], first, s.matrix[j + 2], second, m)


@njit(cache=True)
def _residual(s: Block, k: int) -> float:
    """Largest distance of pressures and tractions from their projections, over the pressure."""
    x, largest, top = s.x, 0.0, 0.0
    for i in range(k):
        j = 3 * i
        p, u, v, _ = _target(s, i)
        u, v = _on_disc(u, v, s.mu[i] * x[j])
        top = max(top, x[j])
        largest = max(largest, abs(x[j] - max(p, 0.0)), np.hypot(x[j + 1] - u, x[j + 2] - v))
    return largest / top if top > 0.0 else largest


@njit(cache=True)
def load(s: Block, k: int) -> None:
    """Compute the rest F x + b of the block."""
    m = 3 * k
    for j in range(m):  # where slices are copied, numba compiles the messages of errors, for 3 s
        s.rest[j] = s.constant[j]
    for j in range(m):
        if s.x[j] != 0.0:
            _add(s.rest, s.matrix[j], s.x[j], m)


@njit(cache=True)
def _move(s: Block, before: Array, start: Array, part: float) -> float:
    """Move by a part of the way from `before` to `start`, back into the cone; the residual there.

    before, start (3k,).
    """
    x, k = s.x, len(before) // 3
    for i in range(k):
        j = 3 * i
        for a in range(3):
            x[j + a] = before[j + a] + part * (start[j + a] - before[j + a])
        x[j] = max(0.0, x[j])
        x[j + 1], x[j + 2] = _on_disc(x[j + 1], x[j + 2], s.mu[i] * x[j])
    load(s, k)
    return _residual(s, k)


@njit(cache=True, inline="always")
def _set(rows: Array, q: int, a: float, b: float, c: float) -> None:
    rows[q, 0], rows[q, 1], rows[q, 2] = a, b, c


@njit(cache=True)
def _unknowns(s: Block, where: Integers, k: int, out: Unknowns) -> int:
    """List the unknowns of a Newton step: their number.

    Pressures in contact, both tractions of what sticks, and of what slips the one across the slip,
    whose projection turns with it. Each is a column of up to three entries of a vertex, and a row
    of up to two; `code` tells of which vertex and kind it is.
    """
    x, q = s.x, 0
    vertex, code, column, row, extra = out
    for i in range(k):
        p, u, v, stiff = _target(s, i)
        if p <= 0.0:
            continue
        bound, size = s.mu[i] * x[3 * i], np.hypot(u, v)
        slips = size > bound
        vertex[q], extra[q], code[q] = i, 0.0, KINDS * where[i] + (1 if slips else 0)
        _set(column, q, 1.0, 0.0, 0.0)
        _set(row, q, 1.0, 0.0, 0.0)
        q += 1
        if slips:
            a, b = u / size, v / size
            _set(column, q - 1, 1.0, s.mu[i] * a, s.mu[i] * b)
            free = min(s.matrix[3 * i + 1, 3 * i + 1], s.matrix[3 * i + 2, 3 * i + 2]) > 0.0
            if free and bound > 0.0:
                vertex[q], extra[q] = i, (size / bound - 1.0) * stiff
                _set(column, q, 0.0, -b, a)
                _set(row, q, 0.0, -b, a)
                code[q] = KINDS * where[i] + 2
                q += 1
            continue
        for c in (1, 2):
            if s.matrix[3 * i + c, 3 * i + c] > 0.0:
                vertex[q], extra[q], code[q] = i, 0.0, KINDS * where[i] + 2 + c
                _set(column, q, 0.0, 2.0 - c, c - 1.0)
                _set(row, q, 0.0, 2.0 - c, c - 1.0)
                q += 1
    return q


@njit(cache=True, fastmath={"contract"})
def assemble(s: Block, k: int, unknowns: Unknowns, q: int) -> tuple[Array, Array]:
    """Return the matrix (q, q) and the right side (q,) of a Newton step."""
    m, line, matrix, right = 3 * k, np.empty(3 * k), np.empty((q, q)), np.zeros(q)
    vertex, _, columns, row, extra = unknowns
    for a in range(q):
        line[:] = 0.0
        for c in range(3):
            right[a] -= row[a, c] * s.constant[3 * vertex[a] + c]
            if row[a, c] != 0.0:
                _add(line, s.matrix[3 * vertex[a] + c], row[a, c], m)
        for b in range(q):
            j, column = 3 * vertex[b], columns[b]
            matrix[a, b] = column[0] * line[j] + column[1] * line[j + 1] + column[2] * line[j + 2]
        matrix[a, a] += extra[a]
    return matrix, right


@njit(cache=True, fastmath={"contract", "reassoc"})
def _correct(s: Block, unknowns: Unknowns, inverse: Array) -> Array:
    """Return the unknowns (q,), corrected by the inverse (q, q) times their residual."""
    q = len(inverse)
    values, right = np.empty(q), np.empty(q)
    vertex, _, _, row, extra = unknowns
    for a in range(q):
        i = 3 * vertex[a]
        now = rest = 0.0
        for c in range(3):
            now += row[a, c] * s.x[i + c]
            rest += row[a, c] * s.rest[i + c]
        values[a], right[a] = now, -rest - extra[a] * now
    for a in range(q):
        line, total = inverse[a], 0.0
        for b in range(q):
            total += line[b] * right[b]
        values[a] += total
    return values


@njit(cache=True)
def _step(s: Block, before: Array, start: Array, now: float) -> float:
    """Go as far to `start` (3k,) as reduces the residual, or stay; return the residual there."""
    k, part, after = len(start) // 3, 1.0, np.inf
    for j in range(3 * k):
        before[j] = s.x[j]
    while part >= SHORTEST and not after < now:
        after = _move(s, before, start, part)
        part /= 2.0
    if not after < now:
        _move(s, before, before, 0.0)
    return after


@njit(cache=True)
def _scatter(unknowns: Unknowns, values: Array, start: Array) -> None:
    """Set the iterate (3k,) of the values (q,) of the unknowns."""
    start[:] = 0.0
    for a in range(len(values)):
        for c in range(3):
            start[3 * unknowns.vertex[a] + c] += unknowns.column[a, c] * values[a]


@njit(cache=True)
def iterate(
    s: Block,
    where: Integers,
    k: int,
    unknowns: Unknowns,
    kept: Integers,
    inverse: Array,
    values: Array,
    counts: Integers,
) -> tuple[int, float]:
    """Iterate until the solution, or until a matrix is needed; return the outcome and the residual.

    kept (q,): codes of the unknowns of the last matrix; inverse (q, q), or (0, 0) for none; values:
    the unknowns of the Newton step to begin with, or none.
    """
    before, start = np.empty(3 * k), np.empty(3 * k)
    now = 0.0
    if len(values):
        now = _residual(s, k)
        _scatter(unknowns, values, start)
        counts[SOLVED] += 1
        if not _step(s, before, start, now) < now:
            for _ in range(SMOOTHING):
                _sweep(s, k)
    fresh = len(inverse) > 0
    while counts[TRIED] < ITERATIONS:
        if not fresh:
            _sweep(s, k)
        now = _residual(s, k)
        if now <= CONE:
            load(s, k)
            now = _residual(s, k)
            if now <= CONE:
                return SETTLED, now
        if not np.isfinite(now):
            return ENDLESS, now
        q = _unknowns(s, where, k, unknowns)
        same = q == len(kept)
        for a in range(q):
            same = same and unknowns.code[a] == kept[a]
        if q > 0 and not (same and fresh):
            counts[UNKNOWNS] = q
            return INVERT if same else SOLVE, now
        counts[TRIED] += 1
        if q == 0:  # nothing is in contact: sweeps go on
            fresh = False
            continue
        counts[SOLVED] += 1
        _scatter(unknowns, _correct(s, unknowns, inverse), start)
        if not _step(s, before, start, now) <= FALLING * now:
            fresh, kept = False, kept[:0]
    return ENDLESS, now
