"""Contact problem of a pad with objects at any pose: set before a step, and read after it.

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

from fefinger.contact.pad_gaps import frames, gaps, jumped, moved, nearest, stiffening
from fefinger.contact.pad_worlds import (
    AREA,
    BORDER,
    DEEP,
    DEPTH,
    PASSED,
    STICK,
    VALID,
    Moves,
    Pad,
    Readings,
    Work,
    Worlds,
)
from fefinger.contact.prony_history import gain
from fefinger.support.arrays import Array, Floats, Integers
from fefinger.support.compiled import njit


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
    skin = m.listed[: m.found[0]]
    moved(compliance, m.past, skin, m.moved)
    if len(m.offset) > len(m.gap):  # with friction
        if not s.stepped[w]:  # an object comes to be where it is without having slid there
            _put(s, w, rotation, place)
        frames(out.frame[w], m)
        moved(compliance, s.linear[w], skin, m.held)
    return g, stiffening(move.factors, pad, out.frame[w, 0], m)


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
