"""Contact of a condensed viscoelastic body, one step after the other, in real time.

The same mathematics as `march`, which is the oracle: p = g y + h with y the elastic pressure, and h
and F h from one recursion per Prony term, so that no product with F is spent on the past. A factor
t on the elastic pressure (the thesis's modulus t(u) over a constant one) enters as y = t q.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit

from fefinger.fem.contact import lcp_compiled as contact
from fefinger.fem.contact.lcp_compiled import (
    BEYOND,
    CORRECTIONS,
    DONE,
    ENDLESS,
    MISSED,
    SINGULAR,
    Active,
    Floats,
)
from fefinger.fem.contact.viscoelastic import History, Prescribed, Relaxation
from fefinger.fem.elements.spaces import Array, Integers
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.tolerances import COMPLEMENTARITY, FORCE_MATCH, SMALL_FORCE


class Memory(NamedTuple):
    """The past of the pad and what the obstacle means to it.

    gap (n,) mm³ and travel (n,) mm² of the patch; weights and rates (m,) of the Prony terms; terms
    and moved_terms (m, n) their recursions for the pressure and for F times it; elastic and
    moved_elastic (n,) y and F y; past, moved_past and offset (n,) work; depth (1,) mm; tolerance
    (1,) of the penetration, over the largest offset; peak (1,) mN the largest force of the path, as
    far as it is known, which decides what is small.
    """

    gap: Array
    travel: Array
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


def memory(
    gap: Array,
    travel: Array,
    weights: Array,
    rates: Array,
    tolerance: float = COMPLEMENTARITY,
) -> Memory:
    """Return a pad at rest; `weights` (m,) are those of the terms over the long-time one."""
    n, m = len(gap), len(rates)
    return Memory(
        gap=np.array(gap),
        travel=np.array(travel),
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
"""Places in `Output.summary`: mN, mm² of pressed vertices, center of pressure in mm."""


class Output(NamedTuple):
    """What is read off the pad after a step.

    areas (n,) mm² and moments (2, n) mm³ of the pad that each vertex stands for, limits (n,) what
    contact there comes to: DONE, or BEYOND or TURNED on the rim of the patch or of the indenter;
    elastic (n,) kPa the pressure q of the linear body; rows (n, n_strains) the strains under unit
    pressures, of either precision, chosen (n,) and factor (n,) those that count; strain
    (n_strains,); summary (4,).
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
def read(s: Active, m: Memory, out: Output, stiffening: float) -> None:
    """Bring the output up to date."""
    force = area = weight = x = y = 0.0
    k = 0
    for j in range(len(s.x)):
        pressure = s.x[j]
        if pressure > 0.0:
            force += m.travel[j] * pressure
            area += out.areas[j]
            weight += out.areas[j] * pressure
            x += out.moments[0, j] * pressure
            y += out.moments[1, j] * pressure
        out.elastic[j] = m.elastic[j] / stiffening
        if m.elastic[j] != 0.0:
            out.chosen[k] = j
            out.factor[k] = out.elastic[j]
            k += 1
    out.strain[:] = 0.0
    contact.accumulate(out.strain, out.rows, out.chosen, out.factor, k)
    summary = out.summary
    summary[FORCE], summary[AREA] = force, area
    summary[X] = x / weight if weight > 0.0 else np.nan
    summary[Y] = y / weight if weight > 0.0 else np.nan


@njit(cache=True)
def advance(
    s: Active, m: Memory, out: Output, dt: float, target: float, by_force: bool, stiffening: float
) -> int:
    """Step, and read; return DONE or what failed, with all as it was before the step."""
    active, depth, peak = contact.hold(s), m.depth[0], m.peak[0]
    g = recall(m, dt)
    failed = _find(s, m, g, target, by_force, stiffening)
    for j in range(len(s.x)):
        if failed == DONE and s.x[j] > 0.0:
            failed = out.limits[j]
    if failed != DONE:
        contact.restore(s, active)
        m.depth[0], m.peak[0] = depth, peak
        return failed
    remember(m, s.x, s.moved, dt, g)
    read(s, m, out, stiffening)
    return DONE


@njit(cache=True)
def reset(s: Active, m: Memory) -> None:
    """Let go of the body, and wait until it has forgotten."""
    contact.release(s)
    for array in (m.terms, m.moved_terms):
        array[:] = 0.0
    for row in (m.elastic, m.moved_elastic, m.depth, m.peak):
        row[:] = 0.0


@njit(cache=True)
def step(s: Active, m: Memory, dt: float, target: float, by_force: bool, stiffening: float) -> int:
    """Move on by `dt` s to a depth in mm or a force in mN; return DONE or what failed.

    `stiffening` is t at the end of the step; the contact pressure is then in s.x, t q in m.elastic.
    """
    g = recall(m, dt)
    failed = _find(s, m, g, target, by_force, stiffening)
    if failed == DONE:
        remember(m, s.x, s.moved, dt, g)
    return failed


@njit(cache=True)
def _find(s: Active, m: Memory, g: float, target: float, by_force: bool, stiffening: float) -> int:
    """Find the pressure at a depth or a force, once the past is recalled."""
    if by_force:
        return _reach(s, m, g, target)
    m.depth[0] = target
    return _press(s, m, g * stiffening, target)


@njit(cache=True)
def _gain(m: Memory, k: int, dt: float) -> float:
    exponent = m.rates[k] * dt
    return m.weights[k] * (-np.expm1(-exponent) / exponent if exponent > 0.0 else 1.0)


@njit(cache=True)
def recall(m: Memory, dt: float) -> float:
    """Put h and F h into `past` and `moved_past`; return g."""
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
def remember(m: Memory, pressure: Array, moved: Array, dt: float, g: float) -> None:
    """Accept p and F p at the end of the step."""
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
def _press(s: Active, m: Memory, stiffness: float, depth: float) -> int:
    """Find the pressure at a depth; `stiffness` is g t."""
    for j in range(len(m.gap)):
        m.offset[j] = (m.gap[j] - depth * m.travel[j]) * stiffness - m.moved_past[j]
    return contact.solve(s, m.offset, m.tolerance[0])


@njit(cache=True)
def _reach(s: Active, m: Memory, g: float, force: float) -> int:
    """Find pressure and depth for a force in mN, as `march` does."""
    touch = np.inf
    for j in range(len(m.gap)):
        touch = min(touch, (m.gap[j] - m.moved_past[j] / g) / m.travel[j])
    if force <= 0.0:
        m.depth[0] = touch
        s.x[:] = 0.0
        s.moved[:] = 0.0
        return DONE
    m.peak[0] = max(m.peak[0], force)
    close = FORCE_MATCH * max(force, SMALL_FORCE * m.peak[0])
    low, high = touch, np.inf
    depth = max(m.depth[0], touch + 1e-6 * (1.0 + abs(touch)))
    for _ in range(CORRECTIONS):
        failed = _press(s, m, g, depth)
        if failed != DONE:
            return failed
        excess = -force
        for j in range(len(m.travel)):
            excess += m.travel[j] * s.x[j]
        if abs(excess) <= close:
            m.depth[0] = depth
            return DONE
        if excess < 0.0:
            low = depth
        else:
            high = depth
        rise = g * contact.slope(s, m.travel)
        depth = depth - excess / rise if rise > 0.0 else 2.0 * depth - touch
        if not (low < depth and depth < high):
            depth = (low + high) / 2.0 if np.isfinite(high) else low + 2.0 * (low - touch)
    return MISSED


def check(outcome: int, deepest: float = np.inf) -> None:
    """Raise the error for what failed in a step of a pad that answers `deepest` mm."""
    messages = {
        ENDLESS: f"contact: no consistent contact set after {contact.EXCHANGES} exchanges; refine "
        "the step",
        SINGULAR: "contact: the flexibility of the pad is not positive definite",
        MISSED: f"force control: asked for a force that was not reached after {CORRECTIONS} "
        "corrections; take shorter steps",
    }
    if outcome == BEYOND:
        message = (
            f"step: expected contact inside the candidates for a depth of {deepest:g} mm, but it "
            "reaches their rim; make the finger with a larger `deepest`, or press less where the "
            "pad ends"
        )
        raise InputError(message)
    if outcome != DONE:
        raise ConvergenceError(messages[outcome])


def march(
    flexibility: Array,
    gap: Array,
    travel: Array,
    relaxation: Relaxation,
    prescribed: Prescribed,
    progress: Callable[[float], None] = lambda fraction: None,
) -> History:
    """Return the contact history of a body at rest, as `march.march` does.

    Raises
    ------
    ConvergenceError
        If the contact or the depth under force control is not found.
    """
    s = contact.active(flexibility)
    m = memory(gap, travel, relaxation.weights, relaxation.rates)
    time, by_force = prescribed.time, prescribed.control == "force"
    m.peak[0] = prescribed.value.max(initial=0.0)
    shape = (len(time), len(gap))
    depth, pressure, elastic = np.empty(len(time)), np.empty(shape), np.empty(shape)
    for k, target in enumerate(prescribed.value):
        dt = float(time[k] - time[k - 1]) if k else 0.0
        check(step(s, m, dt, float(target), by_force, 1.0))
        depth[k], pressure[k], elastic[k] = m.depth[0], s.x, m.elastic
        progress((k + 1) / len(time))
    return History(depth, pressure, elastic, int(s.counts[contact.SOLVED]))
