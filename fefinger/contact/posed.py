"""Contact of a pad with rigid objects at any pose: one step of many worlds that share the pad.

The pad is known by its compliance A for tractions along x, y and z at every vertex. From each place
of the skin a ray along its normal finds the nearest object: the gap counts along the object's
normal at the hit, and so does the pressure. Rows and columns of A in these directions are the
flexibility F of the contact problem, of the vertices that are near an object alone. The history
(`prony_history`) is of the traction as a vector, so that it holds while directions turn.

With a factor t on the elastic traction, y = t q (Pawluk's t(u), here by the deepest penetration),
the displacement is A q, and the contact problem is in x = g y + h: g t gap + F x - A h >= 0.
"""

from typing import NamedTuple

import numpy as np

from fefinger.contact import active_set
from fefinger.contact.active_set import DONE, K, LcpState
from fefinger.contact.coulomb import CoulombSolver
from fefinger.contact.signed_distance import Shapes, distance, ray
from fefinger.support.arrays import Array, Flags, Floats, Integers
from fefinger.support.compiled import njit
from fefinger.support.tolerances import COMPLEMENTARITY


NEAR, NEAR_RUBBED = 0.15, 1.0
"""Gap in mm within which skin may come into contact in a step, without and with friction.

Without friction skin that is not within the object is pushed away from it: contact ends .04 mm or
more within it in presses to 1.8 mm. Friction heaps skin up before an object, by .4 mm before a ball
of 8 mm that is dragged by 3 mm at a coefficient of .8.
"""

STUCK = 1e-6
"""Traction short of mu times the pressure, over that, from which a vertex counts as sticking."""

VALID, DEEP, BORDER, PASSED, UNSOLVED = 0, 1, 2, 3, 4
"""Verdicts on a step: penetration beyond `deepest`; contact at the border of the pad; an object
that moved through the skin within the step; no contact found, so that the state is as before."""

FORCE, AREA, STICK, DEPTH = 0, 6, 7, 8
"""Columns of the readings of an object: force and moment (6), area, area that sticks, depth."""


class Pad(NamedTuple):
    """Compliance and skin of a pad, shared by all worlds.

    compliance A (3n, 3n) mm³/kPa of the relaxed body, for the components x, y, z of each vertex in
    turn; points and normals (n, 3) of the vertices, outward; owner (k, 3): vertex at each corner of
    a triangle, or -1; places and skin (k, q, 3): quadrature points and outward normals there; hats
    (k, 3, q) mm²: weights times the hats of the corners; areas (n,) mm²; border (n,): where contact
    could spread beyond the pad; weights and rates (m,) of the Prony terms over the long-time one.
    """

    compliance: Floats
    points: Array
    normals: Array
    owner: Integers
    places: Array
    skin: Array
    hats: Array
    areas: Array
    border: Flags
    weights: Array
    rates: Array


class Factors(NamedTuple):
    """t (k, i) of Pawluk's modulus by angles (k,) in degrees and penetrations (i,) in mm.

    The angle is that of a plate, about y: 0 below the pad, positive toward the tip.
    """

    angles: Array
    depths: Array
    values: Array


class Worlds(NamedTuple):
    """State of all worlds.

    terms (w, m, 3n) kPa: internal variables of the Prony series; elastic (w, 3n) kPa: y; linear (w,
    3n) kPa: q, of which displacement and strain are linear; x (w, c n): pressures, with friction
    then both tractions in the frames of the vertices; active (w, n): in contact; rotation (w, b, 3,
    3) and place (w, b, 3) mm: last poses; stepped (w,): whether there are any.
    """

    terms: Array
    elastic: Array
    linear: Array
    x: Array
    active: Flags
    rotation: Array
    place: Array
    stepped: Flags


class Readings(NamedTuple):
    """What a step gives.

    traction (w, n, 3) kPa on the skin; pressure (w, n) kPa; slip (w, n, 3) mm of the skin over the
    object in the step; touched (w, n): number of the object, or -1; bodies (w, b, 9): see FORCE,
    in N, N mm about the origin, mm² and mm; hit (w, n, 3) mm³: first moments of the places of
    contact; frame (w, 3, n, 3): direction of the pressure and both of the traction; stiffness (w,):
    g t of the step; verdict (w,).
    """

    traction: Array
    pressure: Array
    slip: Array
    touched: Integers
    bodies: Array
    hit: Array
    frame: Array
    stiffness: Array
    verdict: Integers


class Work(NamedTuple):
    """What a thread needs for a step of one world.

    gap, ahead (n,): weighted gaps mm³, gaps at the vertices mm; near (n,) and listed (n,): flags
    and numbers of the near vertices, as many as found[0]; past (3n,) h, moved and held (3n,): A h
    and A q; offset (c n,): right side of the contact problem.
    """

    gap: Array
    ahead: Array
    near: Flags
    listed: Integers
    found: Integers
    past: Array
    moved: Array
    held: Array
    offset: Array


def worlds(count: int, pad: Pad, bodies: int, components: int) -> Worlds:
    """Allocate the state of some worlds at rest; components: 1, or 3 with friction."""
    n, terms = len(pad.areas), len(pad.rates)
    return Worlds(
        terms=np.zeros((count, terms, 3 * n)),
        elastic=np.zeros((count, 3 * n)),
        linear=np.zeros((count, 3 * n)),
        x=np.zeros((count, components * n)),
        active=np.zeros((count, n), dtype=np.bool_),
        rotation=np.zeros((count, bodies, 3, 3)),
        place=np.zeros((count, bodies, 3)),
        stepped=np.zeros(count, dtype=np.bool_),
    )


def readings(count: int, pad: Pad, bodies: int) -> Readings:
    """Allocate the readings of some worlds."""
    n = len(pad.areas)
    return Readings(
        traction=np.zeros((count, n, 3)),
        pressure=np.zeros((count, n)),
        slip=np.zeros((count, n, 3)),
        touched=np.full((count, n), -1, dtype=np.int64),
        bodies=np.zeros((count, bodies, 9)),
        hit=np.zeros((count, n, 3)),
        frame=np.zeros((count, 3, n, 3)),
        stiffness=np.ones(count),
        verdict=np.zeros(count, dtype=np.int64),
    )


def work(pad: Pad, components: int) -> Work:
    """Allocate the work arrays of a thread."""
    n = len(pad.areas)
    return Work(
        gap=np.zeros(n),
        ahead=np.zeros(n),
        near=np.zeros(n, dtype=np.bool_),
        listed=np.zeros(n, dtype=np.int64),
        found=np.zeros(1, dtype=np.int64),
        past=np.zeros(3 * n),
        moved=np.zeros(3 * n),
        held=np.zeros(3 * n),
        offset=np.zeros(components * n),
    )


@njit(cache=True)
def _nearest(
    pad: Pad,
    shapes: Shapes,
    rotation: Array,
    place: Array,
    touched: Integers,
    d: Array,
    m: Work,
    near: float,
) -> None:
    """Find the nearest object of every vertex.

    d (n, 3): the object's outward normal, which is the direction of the pressure.
    """
    m.found[0] = 0
    for j in range(len(m.gap)):
        m.ahead[j], touched[j] = near, -1
        point = pad.points[j, 0], pad.points[j, 1], pad.points[j, 2]
        normal = pad.normals[j, 0], pad.normals[j, 1], pad.normals[j, 2]
        for b in range(len(shapes.kind)):
            hit, far, x, y, z = ray(shapes, b, rotation, place, point, normal, near)
            if hit and far < m.ahead[j]:
                m.ahead[j], touched[j] = far, b
                d[j, 0], d[j, 1], d[j, 2] = x, y, z
        m.near[j] = touched[j] >= 0
        if m.near[j]:
            m.listed[m.found[0]] = j
            m.found[0] += 1


@njit(cache=True)
def _gaps(
    pad: Pad,
    shapes: Shapes,
    rotation: Array,
    place: Array,
    touched: Integers,
    hit: Array,
    m: Work,
    near: float,
) -> None:
    """Weight the gaps (n,) along the objects' normals, and the places of contact, by the hats."""
    m.gap[:] = 0.0
    hit[:] = 0.0
    for k in range(len(pad.owner)):
        for c in range(3):
            j = pad.owner[k, c]
            if j < 0 or touched[j] < 0:
                continue
            b = touched[j]
            for other in range(c):  # of the same object: done with that corner
                i = pad.owner[k, other]
                if i >= 0 and touched[i] == b:
                    b = -1
                    break
            if b >= 0:
                _triangle(pad, shapes, rotation, place, touched, hit, m, near, k, c, b)


@njit(cache=True)
def _triangle(
    pad: Pad,
    shapes: Shapes,
    rotation: Array,
    place: Array,
    touched: Integers,
    hit: Array,
    m: Work,
    near: float,
    k: int,
    first: int,
    b: int,
) -> None:
    """Add the gaps of triangle `k` to object `b`, which its corners from `first` on touch."""
    for q in range(pad.places.shape[1]):
        point = pad.places[k, q, 0], pad.places[k, q, 1], pad.places[k, q, 2]
        normal = pad.skin[k, q, 0], pad.skin[k, q, 1], pad.skin[k, q, 2]
        found, far, x, y, z = ray(shapes, b, rotation, place, point, normal, near)
        gap = -far * (x * normal[0] + y * normal[1] + z * normal[2]) if found else near
        far = far if found else 0.0
        for c in range(first, 3):
            j = pad.owner[k, c]
            if j >= 0 and touched[j] == b:
                weight = pad.hats[k, c, q]
                m.gap[j] += weight * gap
                hit[j, 0] += weight * (point[0] + far * normal[0])
                hit[j, 1] += weight * (point[1] + far * normal[1])
                hit[j, 2] += weight * (point[2] + far * normal[2])


@njit(cache=True)
def _history(pad: Pad, terms: Array, elastic: Array, dt: float, past: Array) -> float:
    """Compute h (3n,) of a step of `dt` s; return g."""
    total = 0.0
    past[:] = 0.0
    for k in range(len(pad.rates)):
        exponent = pad.rates[k] * dt
        total += pad.weights[k] * (-np.expm1(-exponent) / exponent if exponent > 0.0 else 1.0)
        decay = np.exp(-exponent)
        for j in range(len(past)):
            past[j] += decay * terms[k, j]
    for j in range(len(past)):
        past[j] -= total * elastic[j]
    return 1.0 + total


@njit(cache=True)
def _store(pad: Pad, terms: Array, elastic: Array, new: Array, dt: float) -> None:
    """Update the internal variables with the elastic traction (3n,) at the end of a step."""
    for k in range(len(pad.rates)):
        exponent = pad.rates[k] * dt
        gain = pad.weights[k] * (-np.expm1(-exponent) / exponent if exponent > 0.0 else 1.0)
        decay = np.exp(-exponent)
        for j in range(len(new)):
            terms[k, j] = decay * terms[k, j] + gain * (new[j] - elastic[j])
    elastic[:] = new


@njit(cache=True, fastmath={"contract", "reassoc"})
def _moved(pad: Pad, traction: Array, m: Work, out: Array) -> None:
    """Compute A t at the near vertices; t (3n,) is zero at most others."""
    n = len(m.gap)
    loaded, k = np.empty(n, dtype=np.int64), 0
    for j in range(n):
        if traction[3 * j] != 0.0 or traction[3 * j + 1] != 0.0 or traction[3 * j + 2] != 0.0:
            loaded[k] = j
            k += 1
    for a in range(m.found[0]):
        for c in range(3):
            row, total = pad.compliance[3 * m.listed[a] + c], 0.0
            for b in range(k):
                j = 3 * loaded[b]
                total += (
                    row[j] * traction[j]
                    + row[j + 1] * traction[j + 1]
                    + row[j + 2] * traction[j + 2]
                )
            out[3 * m.listed[a] + c] = total


@njit(cache=True)
def _frames(frame: Array, m: Work) -> None:
    """Complete the directions of pressure to frames.

    Duff et al., J. Comput. Graph. Tech. 6:1, 2017.
    """
    for a in range(m.found[0]):
        j = m.listed[a]
        x, y, z = frame[0, j, 0], frame[0, j, 1], frame[0, j, 2]
        sign = np.copysign(1.0, z)
        p = -1.0 / (sign + z)
        q = x * y * p
        frame[1, j, 0], frame[1, j, 1], frame[1, j, 2] = 1.0 + sign * x * x * p, sign * q, -sign * x
        frame[2, j, 0], frame[2, j, 1], frame[2, j, 2] = q, sign + y * y * p, -y


@njit(cache=True, fastmath={"contract"})
def _project(flexibility: Array, pad: Pad, frame: Array, m: Work, components: int) -> None:
    """Set the rows and columns of near vertices to F = d . A . d, in each of their directions."""
    n, turned = len(m.gap), np.empty((3, 3))
    for j in range(n):  # what is near no more takes no part
        if not m.near[j] and flexibility[j, j] != 0.0:
            for a in range(components):
                flexibility[a * n + j] = 0.0
                flexibility[:, a * n + j] = 0.0
    for p in range(m.found[0]):
        i = m.listed[p]
        r0, r1, r2 = pad.compliance[3 * i], pad.compliance[3 * i + 1], pad.compliance[3 * i + 2]
        for q in range(p + 1):
            j = m.listed[q]
            k = 3 * j
            for a in range(components):
                x, y, z = frame[a, i, 0], frame[a, i, 1], frame[a, i, 2]
                turned[a, 0] = x * r0[k] + y * r1[k] + z * r2[k]
                turned[a, 1] = x * r0[k + 1] + y * r1[k + 1] + z * r2[k + 1]
                turned[a, 2] = x * r0[k + 2] + y * r1[k + 2] + z * r2[k + 2]
            for a in range(components):
                for b in range(components):
                    value = (
                        turned[a, 0] * frame[b, j, 0]
                        + turned[a, 1] * frame[b, j, 1]
                        + turned[a, 2] * frame[b, j, 2]
                    )
                    flexibility[a * n + i, b * n + j] = value
                    flexibility[b * n + j, a * n + i] = value


@njit(cache=True)
def _load(
    pad: Pad,
    now: Array,
    place: Array,
    before: Array,
    was: Array,
    touched: Integers,
    frame: Array,
    m: Work,
    stiffness: float,
    components: int,
) -> None:
    """Set the right side of the contact problem; stiffness: g t.

    The objects' rotations (b, 3, 3) and places (b, 3) are those `now` and `before` the step, by
    which a material point of an object has moved along the skin.
    """
    n = len(m.gap)
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
def _jumped(
    pad: Pad, shapes: Shapes, rotation: Array, place: Array, was: Array, deepest: float
) -> bool:
    """Whether an object was deeper than `deepest` mm in the skin on its way here."""
    for b in range(len(shapes.kind)):
        path = place[b] - was[b]
        parts = int(2.0 * np.sqrt((path * path).sum()) / deepest)
        for k in range(1, parts):
            at = was[b] + k / parts * path
            for j in range(len(pad.areas)):
                x = rotation[b].T @ (pad.points[j] - at)
                if distance(shapes, b, x[0], x[1], x[2])[0] < -deepest:
                    return True
    return False


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
def _prepare(
    pad: Pad,
    shapes: Shapes,
    rotation: Array,
    place: Array,
    s: Worlds,
    out: Readings,
    w: int,
    m: Work,
    dt: float,
    deepest: float,
    near: float,
) -> float:
    """Find near skin, gaps and history of a world; return g."""
    out.verdict[w] = VALID
    if s.stepped[w] and _jumped(pad, shapes, rotation, place, s.place[w], deepest):
        out.verdict[w] = PASSED
    _nearest(pad, shapes, rotation, place, out.touched[w], out.frame[w, 0], m, near)
    _gaps(pad, shapes, rotation, place, out.touched[w], out.hit[w], m, near)
    g = _history(pad, s.terms[w], s.elastic[w], dt, m.past)
    _moved(pad, m.past, m, m.moved)
    return g


@njit(cache=True)
def _accept(
    pad: Pad,
    rotation: Array,
    place: Array,
    s: Worlds,
    out: Readings,
    w: int,
    m: Work,
    dt: float,
    g: float,
    t: float,
) -> None:
    """Make the traction of a step, and its poses, the state of a world."""
    new = (out.traction[w].reshape(-1) - m.past) / g
    _store(pad, s.terms[w], s.elastic[w], new, dt)
    s.linear[w] = new / t
    s.rotation[w], s.place[w] = rotation, place
    s.stepped[w] = True
    out.stiffness[w] = g * t


@njit(cache=True)
def _between(value: float, grid: Array) -> tuple[int, float]:
    """Return the interval of a grid that holds a value, and its part; at the ends the nearest."""
    k = 0
    while k < len(grid) - 2 and value > grid[k + 1]:
        k += 1
    return k, min(max((value - grid[k]) / (grid[k + 1] - grid[k]), 0.0), 1.0)


@njit(cache=True)
def _stiffening(f: Factors, pad: Pad, direction: Array, m: Work) -> float:
    """Return t at the deepest penetration and the mean angle of the skin that objects penetrate."""
    deepest = x = z = 0.0
    for a in range(m.found[0]):
        j = m.listed[a]
        into = max(-m.ahead[j], 0.0)
        deepest = max(deepest, into)
        x += into * pad.areas[j] * direction[j, 0]
        z += into * pad.areas[j] * direction[j, 2]
    angle = np.degrees(np.arctan2(-x, z)) if x != 0.0 or z != 0.0 else 0.0
    k, part = _between(deepest, f.depths)
    i, share = _between(angle, f.angles)
    low = f.values[i, k] + part * (f.values[i, k + 1] - f.values[i, k])
    high = f.values[i + 1, k] + part * (f.values[i + 1, k + 1] - f.values[i + 1, k])
    return low + share * (high - low)


@njit(cache=True, nogil=True)
def step_without_friction(
    solver: LcpState,
    pad: Pad,
    shapes: Shapes,
    rotation: Array,
    place: Array,
    s: Worlds,
    out: Readings,
    m: Work,
    first: int,
    last: int,
    dt: float,
    factors: Factors,
    deepest: float,
    kept: bool,
) -> None:
    """Advance the worlds from `first` to before `last` by `dt` s to poses (w, b, 3, 3), (w, b, 3).

    deepest mm: penetration beyond which a step is not valid. kept: whether the solver holds the
    active set of this one world.
    """
    for w in range(first, last):
        g = _prepare(pad, shapes, rotation[w], place[w], s, out, w, m, dt, deepest, NEAR)
        t = _stiffening(factors, pad, out.frame[w, 0], m)
        _project(solver.flexibility, pad, out.frame[w], m, 1)
        _load(
            *(pad, rotation[w], place[w], s.rotation[w], s.place[w]),
            *(out.touched[w], out.frame[w], m, g * t, 1),
        )
        # What is no longer near leaves; the inverse of the others is a start for their new F.
        if kept:
            i = 0
            while i < solver.counts[K]:
                v = solver.where[i]
                if m.near[v]:
                    i += 1
                else:
                    active_set.remove_vertex(solver, v)
                    solver.x[v] = 0.0
            active_set.product(solver)
        else:
            _activate(solver, s.x[w], s.active[w], m.near)
        if active_set.solve(solver, m.offset, COMPLEMENTARITY) != DONE:
            out.verdict[w] = UNSOLVED
            solver.x[:] = 0.0
            _activate(solver, solver.x, s.active[w], np.zeros_like(m.near))
            continue
        _finish(pad, solver.x, solver.moved, s, out, w, m, g * t)
        _read(pad, solver.x, out, w, 0.0, m, deepest)
        s.x[w] = solver.x
        _accept(pad, rotation[w], place[w], s, out, w, m, dt, g, t)


@njit(cache=True)
def _activate(solver: LcpState, x: Array, active: Flags, near: Flags) -> None:
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
    pad: Pad,
    shapes: Shapes,
    rotation: Array,
    place: Array,
    s: Worlds,
    out: Readings,
    m: Work,
    w: int,
    dt: float,
    factors: Factors,
    deepest: float,
) -> tuple[float, float, int]:
    """Set up the problem with friction of a world: F, its right side, the last x and F x.

    Returns g, t and the number of vertices in contact, which are listed in `where`.
    """
    n = len(m.gap)
    if not s.stepped[w]:  # an object comes to be where it is without having slid there
        s.rotation[w], s.place[w] = rotation, place
    g = _prepare(pad, shapes, rotation, place, s, out, w, m, dt, deepest, NEAR_RUBBED)
    t = _stiffening(factors, pad, out.frame[w, 0], m)
    _frames(out.frame[w], m)
    _moved(pad, s.linear[w], m, m.held)
    _project(flexibility, pad, out.frame[w], m, 3)
    _load(
        *(pad, rotation, place, s.rotation[w], s.place[w]),
        *(out.touched[w], out.frame[w], m, g * t, 3),
    )
    k = 0
    for j in range(n):
        on = s.active[w, j] and m.near[j]
        for a in range(3):
            x[a * n + j] = s.x[w, a * n + j] if on else 0.0
        if on:
            where[k] = j
            k += 1
    active_set.combine(product, flexibility, x, np.empty(3 * n, dtype=np.int64), np.empty(3 * n))
    return g, t, k


@njit(cache=True, nogil=True)
def _close(
    x: Array,
    product: Array,
    pad: Pad,
    rotation: Array,
    place: Array,
    s: Worlds,
    out: Readings,
    m: Work,
    w: int,
    dt: float,
    g: float,
    t: float,
    mu: float,
    deepest: float,
) -> None:
    """Read the solution of a world with friction, and make it its state."""
    _finish(pad, x, product, s, out, w, m, g * t)
    _read(pad, x, out, w, mu, m, deepest)
    s.x[w] = x
    _accept(pad, rotation, place, s, out, w, m, dt, g, t)


def step_with_friction(
    solver: CoulombSolver,
    pad: Pad,
    shapes: Shapes,
    rotation: Array,
    place: Array,
    s: Worlds,
    out: Readings,
    m: Work,
    first: int,
    last: int,
    dt: float,
    factors: Factors,
    deepest: float,
    mu: float,
) -> None:
    """Advance worlds with Coulomb friction; arguments as of `step_without_friction`."""
    for w in range(first, last):
        pose = rotation[w], place[w]
        g, t, solver.counts[K] = _open(
            *(solver.flexibility, solver.x, solver.moved, solver.where, pad, shapes, *pose),
            *(s, out, m, w, dt, factors, deepest),
        )
        solver.rebuild()
        if solver.solve(m.offset, COMPLEMENTARITY) != DONE:
            out.verdict[w] = UNSOLVED
            continue
        solved = solver.x, solver.moved
        _close(*solved, pad, *pose, s, out, m, w, dt, g, t, mu, deepest)
