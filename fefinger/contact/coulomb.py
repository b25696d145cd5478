"""Compiled contact with Coulomb friction: pressure and traction that fit a flexibility.

Of every vertex the pressure is p >= 0 with the gap w >= 0, p w = 0, and the traction t in the plane
of contact has |t| <= mu p, with t = -mu p s / |s| wherever the vertex slips by s. Both are
projections, p = max(0, p - w / a) and t = P(t - s / b) on the disc of radius mu p (Alart and
Curnier, Comput. Methods Appl. Mech. Eng. 92:353, 1991). A semi-smooth Newton method solves for the
iterate that they do not change; sweeps over the vertices that apply one after the other (block
Gauss-Seidel) come before each step, and take over where no part of it comes closer. The distance
from both projections is the residual.

Vectors of 3n have the pressures first, then the tractions along x, then those along y. The vertices
in question are compressed into a block with three rows for each of them.
"""

import numpy as np

from fefinger.contact.active_set import DONE, ENDLESS, SINGULAR, combine
from fefinger.contact.coulomb_state import (
    INVERTED,
    KEPT,
    SOLVED,
    SWEPT,
    CoulombState,
    K,
    join,
    leave,
)
from fefinger.support.arrays import Array
from fefinger.support.compiled import njit


CONE = 1e-10  # residual that counts as none, over the largest pressure
ITERATIONS = 200
SMOOTHING = 10  # sweeps where no part of a Newton step comes closer
SHORTEST = 1 / 16  # part of a Newton step
FALLING = 0.2  # part of the residual that a step with an inverse leaves, or it is dropped
REFRESHED = 8  # steps with an inverse after which it is computed anew, the next time
ROUNDS = 60  # of vertices that join

KINDS = 5  # of unknowns


@njit(cache=True, fastmath={"contract"})
def _add(rest: Array, row: Array, factor: float, m: int) -> None:
    for j in range(m):
        rest[j] += factor * row[j]


@njit(cache=True, fastmath={"contract"})
def _add_two(rest: Array, first: Array, a: float, second: Array, b: float, m: int) -> None:
    for j in range(m):
        rest[j] += a * first[j] + b * second[j]


@njit(cache=True)
def _target(s: CoulombState, i: int) -> tuple[float, float, float, float]:
    """Return pressure and traction before their projection, and the stiffness along the plane.

    A vertex that cannot move along a direction, as across a plane of symmetry, bears none there.
    """
    x, rest, j = s.compressed, s.rest, 3 * i
    a, b, c = s.block[j + 1, j + 1], s.block[j + 2, j + 2], s.block[j + 1, j + 2]
    # The largest eigenvalue of the block in the plane; 0 where the vertex cannot move.
    stiff = (a + b) / 2 + np.sqrt((a - b) ** 2 / 4 + c * c)
    u = x[j + 1] - rest[j + 1] / stiff if a > 0.0 else 0.0
    v = x[j + 2] - rest[j + 2] / stiff if b > 0.0 else 0.0
    return x[j] - rest[j] / s.block[j, j], u, v, stiff


@njit(cache=True)
def _on_disc(u: float, v: float, bound: float) -> tuple[float, float]:
    """Project a traction on the disc of a radius `bound`."""
    size = np.hypot(u, v)
    return (u * bound / size, v * bound / size) if size > bound else (u, v)


@njit(cache=True)
def _visit(s: CoulombState, i: int, m: int) -> None:
    """Project pressure and traction of a vertex, and update the gaps and slips of all."""
    x, j = s.compressed, 3 * i
    step = max(0.0, x[j] - s.rest[j] / s.block[j, j]) - x[j]
    if step != 0.0:
        x[j] += step
        _add(s.rest, s.block[j], step, m)
    _, u, v, _ = _target(s, i)
    u, v = _on_disc(u, v, s.mu[s.where[i]] * x[j])
    first, second = u - x[j + 1], v - x[j + 2]
    if first != 0.0 or second != 0.0:
        x[j + 1], x[j + 2] = u, v
        _add_two(s.rest, s.block[j + 1], first, s.block[j + 2], second, m)


@njit(cache=True)
def _sweep(s: CoulombState) -> None:
    """Visit all vertices of the block."""
    k = s.counts[K]
    s.counts[SWEPT] += 1
    for i in range(k):
        _visit(s, i, 3 * k)


@njit(cache=True)
def _residual(s: CoulombState) -> float:
    """Largest distance of pressures and tractions from their projections, over the pressure."""
    x, largest, top = s.compressed, 0.0, 0.0
    for i in range(s.counts[K]):
        j = 3 * i
        p, u, v, _ = _target(s, i)
        u, v = _on_disc(u, v, s.mu[s.where[i]] * x[j])
        top = max(top, x[j])
        largest = max(largest, abs(x[j] - max(p, 0.0)), np.hypot(x[j + 1] - u, x[j + 2] - v))
    return largest / top if top > 0.0 else largest


@njit(cache=True)
def _unknowns(s: CoulombState) -> int:
    """List the unknowns of a Newton step: their number.

    Pressures in contact, both tractions of what sticks, and of what slips the one across the slip,
    whose projection turns with it. Each is a column of up to three entries of a vertex, and a row
    of up to two; `code` tells of which vertex and kind it is.
    """
    x, q = s.compressed, 0
    for i in range(s.counts[K]):
        p, u, v, stiff = _target(s, i)
        if p <= 0.0:
            continue
        bound, size = s.mu[s.where[i]] * x[3 * i], np.hypot(u, v)
        slips = size > bound
        s.vertex[q], s.extra[q], s.code[q] = i, 0.0, KINDS * s.where[i] + (1 if slips else 0)
        s.column[q], s.row[q] = (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)
        q += 1
        if slips:
            a, b = u / size, v / size
            s.column[q - 1] = (1.0, s.mu[s.where[i]] * a, s.mu[s.where[i]] * b)
            free = min(s.block[3 * i + 1, 3 * i + 1], s.block[3 * i + 2, 3 * i + 2]) > 0.0
            if free and bound > 0.0:
                s.vertex[q], s.extra[q] = i, (size / bound - 1.0) * stiff
                s.column[q], s.row[q] = (0.0, -b, a), (0.0, -b, a)
                s.code[q] = KINDS * s.where[i] + 2
                q += 1
            continue
        for c in (1, 2):
            if s.block[3 * i + c, 3 * i + c] > 0.0:
                s.vertex[q], s.extra[q], s.code[q] = i, 0.0, KINDS * s.where[i] + 2 + c
                s.column[q], s.row[q] = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
                s.column[q, c] = s.row[q, c] = 1.0
                q += 1
    return q


@njit(cache=True, fastmath={"contract"})
def _matrix(s: CoulombState, q: int) -> Array:
    """Assemble the matrix (q, q) of a Newton step."""
    matrix, m, line = np.empty((q, q)), 3 * s.counts[K], np.empty(3 * s.counts[K])
    for a in range(q):
        line[:] = 0.0
        for c in range(3):
            if s.row[a, c] != 0.0:
                _add(line, s.block[3 * s.vertex[a] + c], s.row[a, c], m)
        for b in range(q):
            j, column = 3 * s.vertex[b], s.column[b]
            matrix[a, b] = column[0] * line[j] + column[1] * line[j + 1] + column[2] * line[j + 2]
        matrix[a, a] += s.extra[a]
    return matrix


@njit(cache=True)
def _solved(matrix: Array, right: Array, values: Array) -> bool:
    """Solve a linear system; False if it is singular."""
    try:
        values[:] = np.linalg.solve(matrix, right)
    except Exception:  # numba compiles no narrower clause; a singular matrix is the only error
        return False
    return True


@njit(cache=True)
def _inverted(matrix: Array, inverse: Array) -> bool:
    """Invert a matrix; False if it is singular."""
    try:
        inverse[:] = np.linalg.inv(matrix)
    except Exception:  # as in `_solved`
        return False
    return True


@njit(cache=True)
def _newton(s: CoulombState) -> int:
    """Solve for the iterate at which all projections are as at this one, into `start`.

    Return how many unknowns there are, 0 where they cannot be solved for. Where they are the same
    as the last time, the inverse of that matrix is used again, which is out of date by the turn of
    the slip.
    """
    q = _unknowns(s)
    if q == 0:
        return 0
    same = q == s.counts[KEPT]
    for a in range(q):
        same = same and s.code[a] == s.kept[a]
    values = np.empty(q)
    if same:
        if s.counts[INVERTED] == 0:
            if not _inverted(_matrix(s, q), s.inverse[:q, :q]):
                s.counts[KEPT] = 0
                return 0
            s.counts[INVERTED] = 1
        _correct(s, values)
    else:
        s.counts[KEPT], s.counts[INVERTED] = q, 0
        s.kept[:q] = s.code[:q]
        right = np.empty(q)
        for a in range(q):
            i = 3 * s.vertex[a]
            right[a] = -(
                s.row[a, 0] * s.constant[i]
                + s.row[a, 1] * s.constant[i + 1]
                + s.row[a, 2] * s.constant[i + 2]
            )
        if not _solved(_matrix(s, q), right, values):
            s.counts[KEPT] = 0
            return 0
    s.start[: 3 * s.counts[K]] = 0.0
    for a in range(q):
        for c in range(3):
            s.start[3 * s.vertex[a] + c] += s.column[a, c] * values[a]
    return q


@njit(cache=True, fastmath={"contract", "reassoc"})
def _correct(s: CoulombState, values: Array) -> None:
    """Set `values` (q,) to the unknowns, corrected by the inverse times their residual."""
    q = len(values)
    right = np.empty(q)
    for a in range(q):
        i = 3 * s.vertex[a]
        now = rest = 0.0
        for c in range(3):
            now += s.row[a, c] * s.compressed[i + c]
            rest += s.row[a, c] * s.rest[i + c]
        values[a], right[a] = now, -rest - s.extra[a] * now
    for a in range(q):
        line, total = s.inverse[a], 0.0
        for b in range(q):
            total += line[b] * right[b]
        values[a] += total


@njit(cache=True)
def _go(s: CoulombState, part: float) -> None:
    """Move by a part of the way from `before` to `start`, and back into the cone."""
    for i in range(s.counts[K]):
        j = 3 * i
        for a in range(3):
            s.compressed[j + a] = s.before[j + a] + part * (s.start[j + a] - s.before[j + a])
        s.compressed[j] = max(0.0, s.compressed[j])
        s.compressed[j + 1], s.compressed[j + 2] = _on_disc(
            s.compressed[j + 1], s.compressed[j + 2], s.mu[s.where[i]] * s.compressed[j]
        )
    _load(s)


@njit(cache=True)
def _settle(s: CoulombState, offset: Array) -> bool:
    """Find the iterate that no projection changes; False if that does not happen."""
    n, k = len(s.where), s.counts[K]
    for i in range(k):
        for a in range(3):
            s.constant[3 * i + a] = offset[a * n + s.where[i]]
    _load(s)
    inverse = s.counts[INVERTED] == 1
    for number in range(ITERATIONS):
        if not inverse:
            _sweep(s)
        now = _residual(s)
        if now <= CONE:
            _load(s)
            if _residual(s) <= CONE:
                if number > REFRESHED:
                    s.counts[INVERTED] = 0
                return True
        s.before[: 3 * k] = s.compressed[: 3 * k]
        if not np.isfinite(now):
            return False
        if _newton(s) == 0:  # nothing is in contact, or the matrix is singular: sweeps go on
            inverse = False
            continue
        s.counts[SOLVED] += 1
        inverse = s.counts[INVERTED] == 1
        part, closer = 1.0, False
        while part >= SHORTEST and not closer:
            _go(s, part)
            after = _residual(s)
            closer = after < now
            part /= 2.0
        if inverse and not after <= FALLING * now:
            s.counts[KEPT], s.counts[INVERTED] = 0, 0
            inverse = False
            if not closer:
                _go(s, 0.0)
        elif not closer:
            _go(s, 0.0)
            for _ in range(SMOOTHING):
                _sweep(s)
    return False


@njit(cache=True)
def _load(s: CoulombState) -> None:
    """Compute the rest F x + b of the block."""
    m = 3 * s.counts[K]
    s.rest[:m] = s.constant[:m]
    for j in range(m):
        if s.compressed[j] != 0.0:
            _add(s.rest, s.block[j], s.compressed[j], m)


@njit(cache=True)
def product(s: CoulombState) -> None:
    """Compute moved = F x."""
    combine(s.moved, s.flexibility, s.x, s.chosen, s.factor)


@njit(cache=True)
def solve(s: CoulombState, offset: Array, tolerance: float) -> int:
    """Solve for x with b = `offset` (3n,), from the last x; return DONE or a failure."""
    n = len(s.where)
    scale = 0.0
    for j in range(n):
        scale = max(scale, abs(offset[j]))
    for number in range(ROUNDS):
        joined = 0
        for j in range(n):
            if s.place[j] < 0 and s.moved[j] + offset[j] < -tolerance * scale:
                if not s.flexibility[j, j] > 0.0:
                    return SINGULAR
                join(s, j)
                joined += 1
        if joined == 0 and (number > 0 or s.counts[K] == 0):
            return DONE
        for i in range(s.counts[K]):
            for a in range(3):
                s.compressed[3 * i + a] = s.x[a * n + s.where[i]]
        if not _settle(s, offset):
            return ENDLESS
        s.residual[0] = _residual(s)
        _unload(s)
    return ENDLESS


@njit(cache=True)
def _unload(s: CoulombState) -> None:
    """Write the block into x; vertices without pressure leave it."""
    n = len(s.where)
    s.x[:] = 0.0
    for i in range(s.counts[K]):
        for a in range(3):
            s.x[a * n + s.where[i]] = s.compressed[3 * i + a]
    i = 0
    while i < s.counts[K]:
        if s.x[s.where[i]] > 0.0:
            i += 1
        else:
            leave(s, s.where[i])
    product(s)
