"""Compiled contact step of a linear viscoelastic body, for whole motions and for real time.

p = g y + h as in `viscoelastic.py`, with y the elastic pressure, and h and F h from one recursion
per Prony term, so that the history needs no product with F. A factor t on the elastic pressure (the
thesis's modulus t(u) over a constant one) enters as y = t q.
"""

from typing import NamedTuple

import numpy as np

from fefinger.fem.contact import complementarity
from fefinger.fem.contact import lcp_compiled as contact
from fefinger.fem.contact.friction_state import FrictionState
from fefinger.fem.contact.lcp_compiled import (
    BEYOND,
    DONE,
    ENDLESS,
    MISSED,
    SINGULAR,
    Floats,
    LcpState,
)
from fefinger.fem.contact.viscoelastic import CORRECTIONS, corrected
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.compiled import njit
from fefinger.support.tolerances import COMPLEMENTARITY, FORCE_MATCH, LEAST_FORCE, SMALL_FORCE


class PadState(NamedTuple):
    """Viscoelastic state of the pad (Prony internal variables), initial gaps and load vector.

    p (n,) kPa: the contact pressure; q: that of the relaxed elastic body at the same displacement;
    y = t q, with the factor t of the thesis (else 1); p = g y + h at the end of a step, h being
    what the past leaves; F mm/kPa/mm²: the flexibility of the pad, whose displacement is F q.

    gap (n,) mm³ and projected (n,) mm² of the patch; weights and rates (m,) of the Prony terms;
    terms and moved_terms (m, n): the internal variables of the pressure and F times them; elastic
    and moved_elastic (n,): y and F y; past, moved_past and offset (n,): work; depth (1,) mm;
    tolerance (1,) of the penetration, over the largest offset; peak (1,) mN: the largest force so
    far, which scales the tolerance of small forces. With several components of traction per
    vertex, terms to offset have one after the other.
    """

    gap: Array
    projected: Array
    weights: Array
    rates: Array
    terms: Array
    moved_terms: Array
    elastic: Array
    moved_elastic: Array
    past: Array
    moved_past: Array
    offset: Array
    depth: Array
    tolerance: Array
    peak: Array


def pad_state(
    gap: Array,
    projected: Array,
    weights: Array,
    rates: Array,
    tolerance: float = COMPLEMENTARITY,
    components: int = 1,
) -> PadState:
    """Allocate the state of a pad at rest; `weights` (m,): Prony weights over the long-time one."""
    n, m = components * len(gap), len(rates)
    return PadState(
        gap=np.array(gap),
        projected=np.array(projected),
        weights=np.array(weights, dtype=np.float64),
        rates=np.array(rates, dtype=np.float64),
        terms=np.zeros((m, n)),
        moved_terms=np.zeros((m, n)),
        elastic=np.zeros(n),
        moved_elastic=np.zeros(n),
        past=np.zeros(n),
        moved_past=np.zeros(n),
        offset=np.zeros(n),
        depth=np.zeros(1),
        tolerance=np.array([tolerance]),
        peak=np.zeros(1),
    )


FORCE, AREA, X, Y = 0, 1, 2, 3
"""Indices of `Output.summary`: mN, mm² of pressed vertices, center of pressure in mm."""


class Output(NamedTuple):
    """Output of a step: strains at the sites, force, area and center of pressure.

    areas (n,) mm² and moments (2, n) mm³: integrals of the hat of each vertex; limits (n,): outcome
    of a step with contact at the vertex: DONE, or BEYOND or TURNED on the rim of the patch or of
    the indenter; elastic (n,) kPa: the pressure q of the linear body; rows (n, n_strains): strains
    under unit pressures, in single or double precision; chosen and factor (n,): work, the loaded
    vertices and their pressures; strain (n_strains,); summary (4,).
    """

    areas: Array
    moments: Array
    limits: Integers
    elastic: Array
    rows: Floats
    chosen: Integers
    factor: Floats
    strain: Floats
    summary: Array


@njit(cache=True)
def read(s: LcpState, m: PadState, out: Output, stiffening: float) -> None:
    """Update strains, force, area and center of pressure after a step."""
    force = area = weight = x = y = 0.0
    for j in range(len(s.x)):
        pressure = s.x[j]
        if pressure > 0.0:
            force += m.projected[j] * pressure
            area += out.areas[j]
            weight += out.areas[j] * pressure
            x += out.moments[0, j] * pressure
            y += out.moments[1, j] * pressure
        out.elastic[j] = m.elastic[j] / stiffening
    contact.combine(out.strain, out.rows, out.elastic, out.chosen, out.factor)
    summary = out.summary
    summary[FORCE], summary[AREA] = force, area
    summary[X] = x / weight if weight > 0.0 else np.nan
    summary[Y] = y / weight if weight > 0.0 else np.nan


@njit(cache=True)
def real_time_step(
    s: LcpState,
    m: PadState,
    out: Output,
    dt: float,
    target: float,
    by_force: bool,
    stiffening: float,
) -> int:
    """Step with output, for real time: DONE, or a failure with the state rolled back.

    `stiffening` is t at the end of the step, 1 under force control.
    """
    active, depth, peak = contact.save(s), m.depth[0], m.peak[0]
    g = load_history(m, dt)
    failed = solve_target(s, m, m.gap, m.moved_past, g * stiffening, target, by_force)
    for j in range(len(s.x)):
        if failed == DONE and s.x[j] > 0.0:
            failed = out.limits[j]
    if failed != DONE:
        contact.restore(s, active)
        m.depth[0], m.peak[0] = depth, peak
        return failed
    store_history(m, s.x, s.moved, dt, g)
    read(s, m, out, stiffening)
    return DONE


@njit(cache=True)
def reset(s: LcpState | FrictionState, m: PadState) -> None:
    """Reset the pad to rest: no contact and no history."""
    contact.release(s)
    for array in (m.terms, m.moved_terms):
        array[:] = 0.0
    for row in (m.elastic, m.moved_elastic, m.depth, m.peak):
        row[:] = 0.0


@njit(cache=True)
def step(s: LcpState, m: PadState, dt: float, target: float, by_force: bool) -> int:
    """Step without output, for whole motions; return DONE or a failure.

    It lasts `dt` s and ends at a depth in mm or a force in mN. The contact pressure is then in
    s.x, the elastic one in m.elastic.
    """
    g = load_history(m, dt)
    failed = solve_target(s, m, m.gap, m.moved_past, g, target, by_force)
    if failed == DONE:
        store_history(m, s.x, s.moved, dt, g)
    return failed


@njit(cache=True)
def _gain(m: PadState, k: int, dt: float) -> float:
    exponent = m.rates[k] * dt
    return m.weights[k] * (-np.expm1(-exponent) / exponent if exponent > 0.0 else 1.0)


@njit(cache=True)
def load_history(m: PadState, dt: float) -> float:
    """Compute the history terms h and F h of a step into `past` and `moved_past`; return g."""
    total = 0.0
    m.past[:] = 0.0
    m.moved_past[:] = 0.0
    for k in range(len(m.rates)):
        gain, decay = _gain(m, k, dt), np.exp(-m.rates[k] * dt)
        total += gain
        for j in range(len(m.past)):
            m.past[j] += decay * m.terms[k, j]
            m.moved_past[j] += decay * m.moved_terms[k, j]
    for j in range(len(m.past)):
        m.past[j] -= total * m.elastic[j]
        m.moved_past[j] -= total * m.moved_elastic[j]
    return 1.0 + total


@njit(cache=True)
def store_history(m: PadState, pressure: Array, moved: Array, dt: float, g: float) -> None:
    """Update the internal variables with p and F p at the end of a step."""
    for k in range(len(m.rates)):
        gain, decay = _gain(m, k, dt), np.exp(-m.rates[k] * dt)
        for j in range(len(m.past)):
            y, z = (pressure[j] - m.past[j]) / g, (moved[j] - m.moved_past[j]) / g
            m.terms[k, j] = decay * m.terms[k, j] + gain * (y - m.elastic[j])
            m.moved_terms[k, j] = decay * m.moved_terms[k, j] + gain * (z - m.moved_elastic[j])
    for j in range(len(m.past)):
        m.elastic[j] = (pressure[j] - m.past[j]) / g
        m.moved_elastic[j] = (moved[j] - m.moved_past[j]) / g


@njit(cache=True)
def excess_force(projected: Array, pressure: Array, force: float) -> float:
    """Force in mN of a pressure (n,) kPa on areas (n,) mm² beyond a prescribed one."""
    excess = -force
    for j in range(len(projected)):
        excess += projected[j] * pressure[j]
    return excess


@njit(cache=True)
def first_touch(m: PadState, gap: Array, past: Array, stiffness: float) -> float:
    """Compute the depth in mm at which the first of the gaps closes; as in `solve_target`."""
    depth = np.inf
    for j in range(len(gap)):
        depth = min(depth, (gap[j] - past[j] / stiffness) / m.projected[j])
    return depth


@njit(cache=True)
def _at_depth(
    s: LcpState, m: PadState, gap: Array, past: Array, stiffness: float, depth: float
) -> int:
    for j in range(len(gap)):
        m.offset[j] = (gap[j] - depth * m.projected[j]) * stiffness - past[j]
    return contact.solve(s, m.offset, m.tolerance[0])


@njit(cache=True)
def solve_target(
    s: LcpState,
    m: PadState,
    gap: Array,
    past: Array,
    stiffness: float,
    target: float,
    by_force: bool,
) -> int:
    """Solve for the pressure at a depth in mm or, as `viscoelastic.depth_at`, a force in mN.

    gap (n,) mm³ is that of a pad without pressure or past, at a depth of 0; past (n,): what the
    past moves it, times the `stiffness` (g t, see above). Without force the obstacle stays where it
    is, as at a depth of 0 before it is pressed, or goes back as far as skin that creeps back
    pushes it. It is then out of contact: weighted gaps close some um beyond first touch.
    """
    if not by_force:
        m.depth[0] = target
        return _at_depth(s, m, gap, past, stiffness, target)
    touch, force = first_touch(m, gap, past, stiffness), target
    if force <= 0.0:
        m.depth[0] = min(m.depth[0], touch)
        s.x[:] = 0.0
        s.moved[:] = 0.0
        return DONE
    m.peak[0] = max(m.peak[0], force)
    close = FORCE_MATCH * max(force, SMALL_FORCE * m.peak[0], LEAST_FORCE)
    low, high = touch, np.inf
    depth = max(m.depth[0], touch + 1e-6 * (1.0 + abs(touch)))
    for _ in range(CORRECTIONS):
        failed = _at_depth(s, m, gap, past, stiffness, depth)
        if failed != DONE:
            return failed
        excess = excess_force(m.projected, s.x, force)
        if abs(excess) <= close:
            m.depth[0] = depth
            return DONE
        rise = stiffness * contact.slope(s, m.projected)
        depth, low, high = corrected(depth, excess, rise, low, high, touch)
    return MISSED


def check(outcome: int, deepest: float = np.inf, *, advice: str = "take shorter steps") -> None:
    """Raise the error of a failed step, with what to do; none for DONE.

    deepest: the largest depth in mm of the finger.
    """
    messages = {
        ENDLESS: f"{complementarity.ENDLESS}; {advice}",
        SINGULAR: complementarity.INDEFINITE,
        MISSED: f"force control: expected to reach the force within {CORRECTIONS} corrections, "
        f"did not; {advice}",
    }
    if outcome == BEYOND:
        message = (
            f"step: expected contact inside the candidates for a depth of {deepest:g} mm, received "
            "contact at their rim; make the finger with a larger `deepest`, or press less where "
            "the pad ends"
        )
        raise InputError(message)
    if outcome != DONE:
        raise ConvergenceError(messages[outcome])
