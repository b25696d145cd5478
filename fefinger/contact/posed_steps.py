"""Steps of many worlds in which objects at any pose press one pad, with friction or without.

The problem of a step is set and read by `posed`. Without friction objects may be elastic: F + g t C
of vertices that touch the same object then takes the place of F. The skin is less deep in such an
object than at the pose of a rigid one; the factor t and what is read as the depth are those of the
skin alone, so that t is found with the pressure.
"""

from fefinger.contact import active_set
from fefinger.contact.active_set import DONE, ENDLESS, K, LcpState
from fefinger.contact.pad_gaps import project, stiffening
from fefinger.contact.pad_worlds import UNSOLVED, Moves, Pad, Readings, Softness, Work, Worlds
from fefinger.contact.posed import accept, load, prepare
from fefinger.contact.posed_coulomb import PosedCoulomb
from fefinger.support.arrays import Array, Flags, Floats, Integers
from fefinger.support.compiled import njit
from fefinger.support.tolerances import COMPLEMENTARITY


NEAR, NEAR_RUBBED = 0.15, 1.0
"""Gap in mm within which skin may come into contact in a step, without and with friction.

Without friction skin that is not within the object is pushed away from it: contact ends .04 mm or
more within it in presses to 1.8 mm. Friction heaps skin up before an object, by .4 mm before a ball
of 8 mm that is dragged by 3 mm at a coefficient of .8.
"""

ROUNDS, SETTLED = 30, 1e-7
"""Times that the factor t is corrected, and its relative change that ends them."""


@njit(cache=True)
def _give_way(
    flexibility: Array, soft: Softness, touched: Integers, m: Work, stiffness: float
) -> None:
    """Add `stiffness` times C to F between near vertices that touch the same soft object."""
    for p in range(m.found[0]):
        i = m.listed[p]
        body = soft.body[touched[i]]
        if body < 0:
            continue
        for q in range(m.found[0]):
            j = m.listed[q]
            if touched[j] == touched[i]:
                flexibility[i, j] += stiffness * soft.matrix[body, i, j]


@njit(cache=True)
def _recede(
    soft: Softness, touched: Integers, x: Array, areas: Array, ahead: Array, m: Work
) -> None:
    """Set the gaps ahead of the skin to those at a pose, `ahead`, and how far objects give way."""
    for p in range(m.found[0]):
        i = m.listed[p]
        body, moved = soft.body[touched[i]], 0.0
        if body >= 0:
            for q in range(m.found[0]):
                j = m.listed[q]
                if touched[j] == touched[i]:
                    moved += soft.matrix[body, i, j] * x[j]
        m.ahead[i] = ahead[i] + moved / areas[i]


@njit(cache=True)
def _solve(
    solver: LcpState,
    pad: Pad,
    soft: Softness,
    move: Moves,
    s: Worlds,
    out: Readings,
    m: Work,
    w: int,
    g: float,
    t: float,
) -> tuple[int, float]:
    """Solve the problem of a world, whose F is set; return the outcome, and its factor t."""
    touched, ahead, added = out.touched[w], m.ahead.copy(), 0.0
    for _ in range(ROUNDS):
        if len(soft.matrix):
            _give_way(solver.flexibility, soft, touched, m, g * t - added)
            added = g * t
        load(
            *(pad, move.rotation[w], move.place[w], s.rotation[w], s.place[w]),
            *(touched, out.frame[w], m, g * t),
        )
        outcome = active_set.solve(solver, m.offset, COMPLEMENTARITY)
        if outcome != DONE or not len(soft.matrix):
            return outcome, t
        _recede(soft, touched, solver.x, pad.areas, ahead, m)
        found = stiffening(move.factors, pad, out.frame[w, 0], m)
        if abs(found - t) <= SETTLED * t:
            return DONE, t
        t = found
    return ENDLESS, t


@njit(cache=True, nogil=True)
def step_without_friction(
    solver: LcpState,
    compliance: Floats,
    pad: Pad,
    soft: Softness,
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
        project(solver.flexibility, compliance, out.frame[w, 0], m)
        if kept:
            deactivate(solver, m.near)
        else:
            activate(solver, s.x[w], s.active[w], m.near)
        outcome, t = _solve(solver, pad, soft, move, s, out, m, w, g, t)
        if outcome != DONE:
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
    x: Array,
    where: Integers,
    compliance: Floats,
    pad: Pad,
    move: Moves,
    s: Worlds,
    out: Readings,
    m: Work,
    w: int,
) -> tuple[float, float, int]:
    """Set up the problem with friction of a world: its right side, and the last x.

    Returns g, t and the number of vertices in contact, which are listed in `where`.
    """
    n, k = len(m.gap), 0
    g, t = prepare(compliance, pad, move, s, out, m, w, NEAR_RUBBED)
    load(
        *(pad, move.rotation[w], move.place[w], s.rotation[w], s.place[w]),
        *(out.touched[w], out.frame[w], m, g * t),
    )
    for j in range(n):
        on = s.active[w, j] and m.near[j]
        for a in range(3):
            x[a * n + j] = s.x[w, a * n + j] if on else 0.0
        if on:
            where[k] = j
            k += 1
    return g, t, k


def step_with_friction(
    solver: PosedCoulomb,
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
        known = solver.x, solver.where, compliance, pad
        g, t, count = _open(*known, move, s, out, m, w)
        solver.begin(out.frame[w], m, count)
        if solver.solve(m.offset, COMPLEMENTARITY) != DONE:
            out.verdict[w] = UNSOLVED
            continue
        accept(solver.x, solver.moved, pad, move, s, out, m, w, g, t, mu)
