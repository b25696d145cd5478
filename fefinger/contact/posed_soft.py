"""Contact of a pad with elastic objects at any pose, without friction: one step of many worlds.

As `posed`, with F + g t C of vertices that touch the same object in place of F. The skin is then
less deep in the object than at the pose of a rigid one; the factor t and what is read as the depth
are those of the skin alone, so that t is found with the pressure.
"""

from fefinger.contact import active_set
from fefinger.contact.active_set import DONE, ENDLESS, LcpState
from fefinger.contact.pad_worlds import UNSOLVED, Moves, Pad, Readings, Softness, Work, Worlds
from fefinger.contact.posed import (
    NEAR,
    accept,
    activate,
    deactivate,
    load,
    prepare,
    set_up,
    stiffening,
)
from fefinger.support.arrays import Array, Floats, Integers
from fefinger.support.compiled import njit
from fefinger.support.tolerances import COMPLEMENTARITY


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
    """Solve the problem of a world, set up with the factor t; return the outcome, and its t."""
    touched, ahead, added = out.touched[w], m.ahead.copy(), 0.0
    for _ in range(ROUNDS):
        _give_way(solver.flexibility, soft, touched, m, g * t - added)
        added = g * t
        load(
            *(pad, move.rotation[w], move.place[w], s.rotation[w], s.place[w]),
            *(touched, out.frame[w], m, g * t),
        )
        outcome = active_set.solve(solver, m.offset, COMPLEMENTARITY)
        if outcome != DONE:
            return outcome, t
        _recede(soft, touched, solver.x, pad.areas, ahead, m)
        found = stiffening(move.factors, pad, out.frame[w, 0], m)
        if abs(found - t) <= SETTLED * t:
            return DONE, t
        t = found
    return ENDLESS, t


@njit(cache=True, nogil=True)
def step_with_soft_objects(
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
    """Advance the worlds from `first` to before `last`; `kept` as of `posed`."""
    for w in range(first, last):
        g, t = prepare(compliance, pad, move, s, out, m, w, NEAR)
        set_up(solver.flexibility, compliance, pad, move, s, out, m, w, g * t)
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
