"""Contact of a pad with rigid objects at any pose: one step of many worlds that share the pad.

The pad is known by its compliance A for tractions along x, y and z at every vertex. From each place
of the skin a ray along its normal finds the nearest object: the gap counts along the object's
normal at the hit, and so does the pressure. Rows and columns of A in these directions are the
flexibility F of the contact problem, of the vertices that are near an object alone. The history
(`prony_history`) is of the traction as a vector, so that it holds while directions turn.

With a factor t on the elastic traction, y = t q (Pawluk's t(u), here by how objects penetrate the
undeformed skin), the displacement is A q, and the contact problem is in x = g y + h:
g t gap + F x - A h >= 0.
"""

import numpy as np

from fefinger.contact import active_set
from fefinger.contact.active_set import DONE, K, LcpState
from fefinger.contact.coulomb import CoulombSolver
from fefinger.contact.pad_gaps import frames, gaps, jumped, moved, nearest, project
from fefinger.contact.pad_worlds import (
    AREA,
    BORDER,
    DEEP,
    DEPTH,
    PASSED,
    STICK,
    UNSOLVED,
    VALID,
    Factors,
    Moves,
    Pad,
    Readings,
    Work,
    Worlds,
)
from fefinger.contact.prony_history import gain
from fefinger.support.arrays import Array, Flags, Floats, Integers
from fefinger.support.compiled import njit
from fefinger.support.tolerances import COMPLEMENTARITY


NEAR, NEAR_RUBBED = 0.15, 1.0
"""Gap in mm within which skin may come into contact in a step, without and with friction.

Without friction skin that is not within the object is pushed away from it: contact ends .04 mm or
more within it in presses to 1.8 mm. Friction heaps skin up before an object, by .4 mm before a ball
of 8 mm that is dragged by 3 mm at a coefficient of .8.
"""

WIDER, FULLER = 0.13, 1.8
"""Slopes of the exponent of t, by which it departs from a plate's: with the logarithm of the patch
over that under the plate, and with the difference in fullness (see `penetration`).

Least squares over 28 presses of a.h. (`validation/evidence/tactile.py`, those without `at`) at .5
to 1.5 mm: a ball on the proximal pad stiffens less than a plate there, a pin more.
"""

STUCK = 1e-6
"""Part of mu times the pressure by which the traction of a vertex that sticks falls short of it."""


@njit(cache=True)
def _history(pad: Pad, terms: Array, elastic: Array, dt: float, past: Array) -> float:
    """Compute what the past adds to the traction in a step of `dt` s, h (3n,); return g."""
    total = 0.0
    past[:] = 0.0
    for k in range(len(pad.rates)):
        total += gain(pad.weights[k], pad.rates[k], dt)
        decay = np.exp(-pad.rates[k] * dt)
        for j in range(len(past)):
            past[j] += decay * terms[k, j]
    for j in range(len(past)):
        past[j] -= total * elastic[j]
    return 1.0 + total


@njit(cache=True)
def _store(
    pad: Pad, s: Worlds, w: int, traction: Array, m: Work, g: float, t: float, dt: float
) -> None:
    """Update the internal variables of a world with the traction (3n,) at the end of a step."""
    terms, elastic = s.terms[w], s.elastic[w]
    for k in range(len(pad.rates)):
        part, decay = gain(pad.weights[k], pad.rates[k], dt), np.exp(-pad.rates[k] * dt)
        for j in range(len(traction)):
            rise = (traction[j] - m.past[j]) / g - elastic[j]
            terms[k, j] = decay * terms[k, j] + part * rise
    for j in range(len(traction)):
        elastic[j] = (traction[j] - m.past[j]) / g
        s.linear[w, j] = elastic[j] / t


@njit(cache=True)
def _put(s: Worlds, w: int, rotation: Array, place: Array) -> None:
    """Make poses of the objects, (b, 3, 3) and (b, 3), the last ones of a world."""
    for b in range(len(place)):
        for c in range(3):
            s.place[w, b, c] = place[b, c]
            for e in range(3):
                s.rotation[w, b, c, e] = rotation[b, c, e]


@njit(cache=True)
def load(
    pad: Pad,
    now: Array,
    place: Array,
    before: Array,
    was: Array,
    touched: Integers,
    frame: Array,
    m: Work,
    stiffness: float,
) -> None:
    """Set the right side of the contact problem; stiffness: g t.

    The objects' rotations (b, 3, 3) and places (b, 3) are those `now` and `before` the step, by
    which a material point of an object has moved along the skin.
    """
    n = len(m.gap)
    components = len(m.offset) // n
    m.offset[:] = 0.0
    travel, largest = np.zeros(3), 0.0
    for a in range(m.found[0]):
        j = m.listed[a]
        b = touched[j]
        if components == 3:
            for c in range(3):
                on = 0.0
                for e in range(3):  # the point of the object that is now at the vertex
                    local = 0.0
                    for f in range(3):
                        local += now[b, f, e] * (pad.points[j, f] - place[b, f])
                    on += before[b, c, e] * local
                travel[c] = pad.points[j, c] - on - was[b, c]
        for k in range(components):
            d = frame[k, j]
            value = 0.0
            for c in range(3):
                value -= d[c] * m.moved[3 * j + c]
                if k > 0:
                    value -= stiffness * d[c] * (m.held[3 * j + c] + pad.areas[j] * travel[c])
            value += stiffness * m.gap[j] if k == 0 else 0.0
            m.offset[k * n + j] = value
            largest = max(largest, abs(value) if k == 0 else 0.0)
    for j in range(n):
        if not m.near[j]:
            m.offset[j] = 1.0 + largest  # open, whatever happens elsewhere


@njit(cache=True)
def _read(pad: Pad, x: Array, out: Readings, w: int, mu: float, m: Work, deepest: float) -> None:
    """Read force, moment, area and depth of every object, and judge the contact."""
    n, bodies = len(m.gap), out.bodies[w]
    bodies[:] = 0.0
    for a in range(m.found[0]):
        j = m.listed[a]
        row = bodies[out.touched[w, j]]
        row[DEPTH] = max(row[DEPTH], -m.ahead[j])
        if not x[j] > 0.0:
            continue
        t, h = out.traction[w, j], out.hit[w, j]
        for c in range(3):
            row[c] += 1e-3 * pad.areas[j] * t[c]
        row[3] += 1e-3 * (h[1] * t[2] - h[2] * t[1])
        row[4] += 1e-3 * (h[2] * t[0] - h[0] * t[2])
        row[5] += 1e-3 * (h[0] * t[1] - h[1] * t[0])
        row[AREA] += pad.areas[j]
        if mu > 0.0 and np.hypot(x[n + j], x[2 * n + j]) < mu * x[j] * (1 - STUCK):
            row[STICK] += pad.areas[j]
        if pad.border[j]:
            out.verdict[w] = BORDER
    for row in bodies:
        if row[DEPTH] > deepest:
            out.verdict[w] = DEEP


@njit(cache=True)
def _finish(
    pad: Pad, x: Array, moved: Array, s: Worlds, out: Readings, w: int, m: Work, stiffness: float
) -> None:
    """Read traction and slip of the solution x, F x = `moved`, of a contact."""
    n, frame = len(m.gap), out.frame[w]
    components = len(x) // n
    out.traction[w] = 0.0
    out.slip[w] = 0.0
    out.pressure[w] = 0.0
    s.active[w] = False
    for a in range(m.found[0]):
        j = m.listed[a]
        if not x[j] > 0.0:
            continue
        s.active[w, j], out.pressure[w, j] = True, x[j]
        for k in range(components):
            at = k * n + j
            slid = (moved[at] + m.offset[at]) / (stiffness * pad.areas[j]) if k > 0 else 0.0
            for c in range(3):
                out.traction[w, j, c] += frame[k, j, c] * x[at]
                out.slip[w, j, c] += frame[k, j, c] * slid


@njit(cache=True)
def _between(value: float, grid: Array) -> tuple[int, float]:
    """Return the interval of a grid that holds a value, and where in it from 0 to 1.

    Beyond the grid they are its nearest end.
    """
    k = 0
    while k < len(grid) - 2 and value > grid[k + 1]:
        k += 1
    return k, min(max((value - grid[k]) / (grid[k + 1] - grid[k]), 0.0), 1.0)


@njit(cache=True)
def penetration(pad: Pad, direction: Array, m: Work) -> tuple[float, float, float, float]:
    """Describe how objects penetrate the undeformed skin, by numbers that are continuous.

    Returns the deepest penetration in mm, the mean angle of the objects' normals in degrees, the
    patch in mm² and the fullness: first moment squared over the second of the penetration over the
    skin, and second over first over the deepest one. A flat punch has a fullness of 1, a smooth
    object 2 / 3. Without penetration the patch is 0.
    """
    deepest = x = z = first = second = 0.0
    for a in range(m.found[0]):
        j = m.listed[a]
        into = max(-m.ahead[j], 0.0)
        part = into * pad.areas[j]
        deepest = max(deepest, into)
        first += part
        second += into * part
        x += part * direction[j, 0]
        z += part * direction[j, 2]
    if first == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    angle = np.degrees(np.arctan2(-x, z))
    return deepest, angle, first * first / second, second / (first * deepest)


@njit(cache=True)
def stiffening(f: Factors, pad: Pad, direction: Array, m: Work) -> float:
    """Return the factor t on the elastic traction, a power of that under a plate.

    The plate has the angle and the depth of what penetrates the skin.
    """
    deepest, angle, patch, fullness = penetration(pad, direction, m)
    if patch == 0.0:
        return 1.0
    k, part = _between(deepest, f.depths)
    i, share = _between(angle, f.angles)
    plate = np.zeros(3)
    for c in range(3):
        low = f.values[i, k, c] + part * (f.values[i, k + 1, c] - f.values[i, k, c])
        high = f.values[i + 1, k, c] + part * (f.values[i + 1, k + 1, c] - f.values[i + 1, k, c])
        plate[c] = low + share * (high - low)
    power = 1.0 + WIDER * (np.log(patch) - plate[1]) + FULLER * (fullness - plate[2])
    return np.exp(power * plate[0])


@njit(cache=True)
def prepare(
    compliance: Floats,
    pad: Pad,
    move: Moves,
    s: Worlds,
    out: Readings,
    m: Work,
    w: int,
    near: float,
) -> tuple[float, float]:
    """Find near skin, gaps, history and frames of a world; return g and t."""
    shapes, rotation, place = move.shapes, move.rotation[w], move.place[w]
    out.verdict[w] = VALID
    before = s.rotation[w], s.place[w]
    if s.stepped[w] and jumped(pad, shapes, rotation, place, *before, move.deepest):
        out.verdict[w] = PASSED
    nearest(pad, shapes, rotation, place, out.touched[w], out.frame[w, 0], m, near)
    gaps(pad, shapes, rotation, place, out.touched[w], out.hit[w], m, near)
    g = _history(pad, s.terms[w], s.elastic[w], move.dt, m.past)
    moved(compliance, m.past, m, m.moved)
    if len(m.offset) > len(m.gap):  # with friction
        if not s.stepped[w]:  # an object comes to be where it is without having slid there
            _put(s, w, rotation, place)
        frames(out.frame[w], m)
        moved(compliance, s.linear[w], m, m.held)
    return g, stiffening(move.factors, pad, out.frame[w, 0], m)


@njit(cache=True)
def set_up(
    flexibility: Array,
    compliance: Floats,
    pad: Pad,
    move: Moves,
    s: Worlds,
    out: Readings,
    m: Work,
    w: int,
    stiffness: float,
) -> None:
    """Set F and the right side of the contact problem of a world; stiffness: g t."""
    project(flexibility, compliance, out.frame[w], m)
    load(
        *(pad, move.rotation[w], move.place[w], s.rotation[w], s.place[w]),
        *(out.touched[w], out.frame[w], m, stiffness),
    )


@njit(cache=True, nogil=True)
def accept(
    x: Array,
    product: Array,
    pad: Pad,
    move: Moves,
    s: Worlds,
    out: Readings,
    m: Work,
    w: int,
    g: float,
    t: float,
    mu: float,
) -> None:
    """Read the solution x, F x = `product`, of a world, and make it its state."""
    _finish(pad, x, product, s, out, w, m, g * t)
    _read(pad, x, out, w, mu, m, move.deepest)
    for j in range(len(x)):
        s.x[w, j] = x[j]
    _store(pad, s, w, out.traction[w].reshape(-1), m, g, t, move.dt)
    _put(s, w, move.rotation[w], move.place[w])
    s.stepped[w] = True
    out.stiffness[w] = g * t


@njit(cache=True, nogil=True)
def step_without_friction(
    solver: LcpState,
    compliance: Floats,
    pad: Pad,
    move: Moves,
    s: Worlds,
    out: Readings,
    m: Work,
    first: int,
    last: int,
    kept: bool,
) -> None:
    """Advance the worlds from `first` to before `last`.

    kept: whether the solver holds the active set of this one world.
    """
    for w in range(first, last):
        g, t = prepare(compliance, pad, move, s, out, m, w, NEAR)
        set_up(solver.flexibility, compliance, pad, move, s, out, m, w, g * t)
        if kept:
            deactivate(solver, m.near)
        else:
            activate(solver, s.x[w], s.active[w], m.near)
        if active_set.solve(solver, m.offset, COMPLEMENTARITY) != DONE:
            out.verdict[w] = UNSOLVED
            m.near[:] = False
            activate(solver, s.x[w], s.active[w], m.near)
            continue
        accept(solver.x, solver.moved, pad, move, s, out, m, w, g, t, 0.0)


@njit(cache=True)
def deactivate(solver: LcpState, near: Flags) -> None:
    """Take the vertices that are no longer near out of the active set.

    The inverse of the others is a start for their new F.
    """
    i = 0
    while i < solver.counts[K]:
        vertex = solver.where[i]
        if near[vertex]:
            i += 1
        else:
            active_set.remove_vertex(solver, vertex)
            solver.x[vertex] = 0.0
    active_set.product(solver)


@njit(cache=True)
def activate(solver: LcpState, x: Array, active: Flags, near: Flags) -> None:
    """Give the solver the active vertices of a world that are near, and their pressures."""
    solver.place[:] = -1
    k = 0
    for j in range(len(active)):
        on = active[j] and near[j]
        solver.x[j] = x[j] if on else 0.0
        if on:
            solver.where[k] = j
            k += 1
    solver.counts[K] = k
    active_set.rebuild(solver)
    active_set.product(solver)


@njit(cache=True, nogil=True)
def _open(
    flexibility: Array,
    x: Array,
    product: Array,
    where: Integers,
    compliance: Floats,
    pad: Pad,
    move: Moves,
    s: Worlds,
    out: Readings,
    m: Work,
    w: int,
) -> tuple[float, float, int]:
    """Set up the problem with friction of a world: F, its right side, the last x and F x.

    Returns g, t and the number of vertices in contact, which are listed in `where`.
    """
    n, k = len(m.gap), 0
    g, t = prepare(compliance, pad, move, s, out, m, w, NEAR_RUBBED)
    set_up(flexibility, compliance, pad, move, s, out, m, w, g * t)
    for j in range(n):
        on = s.active[w, j] and m.near[j]
        for a in range(3):
            x[a * n + j] = s.x[w, a * n + j] if on else 0.0
        if on:
            where[k] = j
            k += 1
    active_set.combine(product, flexibility, x, np.empty(3 * n, dtype=np.int64), np.empty(3 * n))
    return g, t, k


def step_with_friction(
    solver: CoulombSolver,
    compliance: Floats,
    pad: Pad,
    move: Moves,
    s: Worlds,
    out: Readings,
    m: Work,
    first: int,
    last: int,
    mu: float,
) -> None:
    """Advance the worlds from `first` to before `last` with Coulomb friction.

    The solver runs in Python between compiled parts, so that threads wait for each other there.
    """
    for w in range(first, last):
        known = solver.flexibility, solver.x, solver.moved, solver.where, compliance, pad
        g, t, solver.counts[K] = _open(*known, move, s, out, m, w)
        solver.rebuild()
        if solver.solve(m.offset, COMPLEMENTARITY) != DONE:
            out.verdict[w] = UNSOLVED
            continue
        accept(solver.x, solver.moved, pad, move, s, out, m, w, g, t, mu)
