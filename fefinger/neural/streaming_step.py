"""Compiled time step of the units of `streaming`."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.neural.endorgans import LARGEST_CURRENT
from fefinger.neural.membranes.equations import Block, Stepping, eventful
from fefinger.neural.membranes.vectorized import LANES, interval
from fefinger.neural.recorded_compiled import Units, X, run
from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


class State(NamedTuple):
    """State of the units between two steps, without their membranes.

    drive (n,) index in STREAMED; across (n, 2, 3) unit vectors in the skin; length (n,) mm, gain
    (n,) µA/cm² per mm; at_rest (n,), share and pole (n, 2) of the end organs, poles in
    rad/s; modes (n, 2) and x (n,) mm, the last x_in; levels (substeps + 1, n) µA/cm², generator
    currents of the last step; spikes (n, ROOM) ms and counts (n,) of that step; clock (1,) ms.
    """

    drive: Integers
    across: Array
    length: Array
    gain: Array
    at_rest: Array
    share: Array
    pole: Array
    modes: Array
    x: Array
    levels: Array
    spikes: Array
    counts: Integers
    clock: Array


LARGEST_STRAIN = 1e6
"""Largest accepted strain: far beyond any skin, far below an overflow of the drives."""

REFUSED, CROWDED = -1, -2
"""Returned, instead of the number of spikes, for a strain that is not finite or too large, and for
more than ROOM spikes of one unit."""


@njit(cache=True)
def compressive_strain(e: NDArray[np.floating]) -> float:
    """Return max(0, -smallest eigenvalue) of xx yy zz xy yz xz, in trigonometric closed form."""
    xx, yy, zz = float(e[0]), float(e[1]), float(e[2])
    xy, yz, xz = float(e[3]), float(e[4]), float(e[5])
    mean = (xx + yy + zz) / 3.0
    a, b, c = xx - mean, yy - mean, zz - mean
    size = math.sqrt((a * a + b * b + c * c + 2.0 * (xy * xy + yz * yz + xz * xz)) / 6.0)
    if size == 0.0:
        return max(0.0, -mean)
    determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    # Rounding may take the cosine slightly beyond 1 where two principal values are equal.
    angle = math.acos(min(1.0, max(-1.0, determinant / (2.0 * size**3)))) / 3.0
    return max(0.0, -(mean + 2.0 * size * math.cos(angle + 2.0 * math.pi / 3.0)))


@njit(cache=True)
def _along(e: NDArray[np.floating], u: Array, v: Array) -> float:
    """Return u . e v."""
    return (
        u[0] * (e[0] * v[0] + e[3] * v[1] + e[5] * v[2])
        + u[1] * (e[3] * v[0] + e[1] * v[1] + e[4] * v[2])
        + u[2] * (e[5] * v[0] + e[4] * v[1] + e[2] * v[2])
    )


@njit(cache=True)
def tangent_strain(e: NDArray[np.floating], across: Array) -> float:
    """Largest normal strain in the plane of the skin (Mohr's circle)."""
    a, b = _along(e, across[0], across[0]), _along(e, across[0], across[1])
    c = _along(e, across[1], across[1])
    return 0.5 * (a + c) + math.hypot(0.5 * (a - c), b)


@njit(cache=True)
def _current(s: "State", i: int, x: float) -> float:
    """Return the current of the saturating generator in µA/cm² for unit i at x."""
    out = s.at_rest[i] * x + s.share[i, 0] * s.modes[i, 0] + s.share[i, 1] * s.modes[i, 1]
    return -LARGEST_CURRENT * math.expm1(-s.gain[i] * max(out, 0.0) / LARGEST_CURRENT)


@njit(cache=True)
def currents(s: "State", strain: NDArray[np.floating], dt: float, share: float) -> bool:
    """Advance x_in, end organs and generator currents by a step of dt ms.

    x_in moves by a share of the way to its value at this strain. Returns False, with the state
    unchanged, for a strain beyond LARGEST_STRAIN or not finite.
    """
    for i in range(len(s.x)):
        for k in range(6):
            if not abs(strain[i, k]) <= LARGEST_STRAIN:
                return False
    substeps = len(s.levels) - 1
    part = dt / substeps
    for i in range(len(s.x)):
        before = s.x[i]
        if s.drive[i] == 0:
            s.x[i] = s.length[i] * compressive_strain(strain[i])
        else:
            s.x[i] = s.length[i] * tangent_strain(strain[i], s.across[i])
        if share < 1.0:
            s.x[i] = before + share * (s.x[i] - before)
        change = s.x[i] - before
        if dt == 0.0:
            s.modes[i, 0] += change
            s.modes[i, 1] += change
            s.levels[:, i] = _current(s, i, s.x[i])
            continue
        s.levels[0, i] = s.levels[substeps, i]
        p, q = 1e-3 * s.pole[i, 0], 1e-3 * s.pole[i, 1]
        fade, wane = math.exp(-p * part), math.exp(-q * part)
        grow, rise = change / dt * (1.0 - fade) / p, change / dt * (1.0 - wane) / q
        for k in range(substeps):
            s.modes[i, 0] = fade * s.modes[i, 0] + grow
            s.modes[i, 1] = wane * s.modes[i, 1] + rise
            s.levels[k + 1, i] = _current(s, i, before + change * (k + 1) / substeps)
    return True


@njit(cache=True)
def integrate_and_fire(
    s: "State", units: Array, numbers: tuple[float, float, float], dt: float
) -> int:
    """Advance integrate-and-fire units by dt ms; return the number of spikes, or CROWDED.

    units (n, 3): potential, highest potential, ms when free. numbers: threshold in µA/cm², time
    constant and refractory time in ms.
    """
    threshold, tau, refractory = numbers
    substeps = len(s.levels) - 1
    part = dt / substeps
    s.counts[:] = 0
    for i in range(len(s.x)):
        for k in range(substeps if dt > 0.0 else 0):
            begin = s.clock[0] + k * part
            steep = (s.levels[k + 1, i] - s.levels[k, i]) / (threshold * part)
            span, line = (begin, begin + part), (s.levels[k, i] / threshold, steep)
            times = (tau, refractory)
            s.counts[i] = eventful(units[i], span, line, times, s.spikes[i], s.counts[i])
    return _advance_clock(s, dt)


@njit(cache=True)
def hodgkin_huxley(
    s: "State",
    units: Array,
    last: Array,
    how: Stepping,
    rest: Array,
    block: Block,
    dt: float,
) -> int:
    """Advance Hodgkin-Huxley units by dt ms; return the number of spikes, or CROWDED.

    units (n_blocks, :) and last (n_blocks,) of LANES units each; how, rest and block as in
    `membranes.vectorized`.
    """
    substeps = len(s.levels) - 1
    part = dt / substeps
    s.counts[:] = 0
    for b in range(len(units)):
        block_units = slice(b * LANES, min((b + 1) * LANES, len(s.x)))
        for k in range(substeps):
            last[b] = interval(
                units[b],
                s.levels[k, block_units],
                s.levels[k + 1, block_units],
                s.clock[0] + k * part,
                part,
                last[b],
                how,
                rest,
                block,
                s.spikes[block_units],
                s.counts[block_units],
            )
    return _advance_clock(s, dt)


@njit(cache=True)
def _advance_clock(s: "State", dt: float) -> int:
    """Advance the clock; return the number of spikes, or CROWDED."""
    s.clock[0] += dt
    return CROWDED if s.counts.max() > s.spikes.shape[1] else s.counts.sum()


@njit(cache=True)
def _report(
    queue: tuple[Array, Integers],
    u: int,
    new: Array,
    count: int,
    stop: float,
    spikes: Array,
    counts: Integers,
) -> None:
    """Report the impulses of unit u up to `stop` s: of those in its queue, and of `count` new ones.

    queue: impulses (n_units, :) s of units that are recorded later, and their numbers (n_units,).
    They ascend, and new ones are later than they.
    """
    late, held = queue
    total = held[u] + count
    for k in range(count):
        late[u, held[u] + k] = new[k]
    due = 0
    while due < total and late[u, due] <= stop:
        spikes[u, due] = late[u, due]
        due += 1
    for k in range(due, total):
        late[u, k - due] = late[u, k]
    held[u], counts[u] = total - due, due


@njit(cache=True)
def recorded(
    units: Units,
    states: Array,
    span: tuple[float, float],
    strain: NDArray[np.floating],
    share: float,
    organs: tuple[Integers, Array, Integers, Array],
    blocks: tuple[Integers, Integers, Array],
    queue: tuple[Array, Integers],
    spikes: Array,
    counts: Integers,
) -> int:
    """Advance all units over a span (start, stop) in s; return the spikes in it, or REFUSED.

    share: of the way to this strain; the span must have room for its spikes. organs: index of the
    drive (n_units,), length (n_units,) mm, first end organ of each unit and their number
    (n_units + 1,), and vectors in the skin (n_organs, 2, 3). blocks: units (n_units,) in the order
    of their blocks, first place of each block there and their number (n_blocks + 1,), and bound of
    its steps in s (n_blocks,). queue: as in `_report`.
    """
    drive, length, starts, across = organs
    for k in range(len(strain)):
        for c in range(6):
            if not abs(strain[k, c]) <= LARGEST_STRAIN:
                return REFUSED
    x, current = np.empty((2, len(counts))), np.empty((2, len(counts)))
    for i in range(len(counts)):
        largest = -np.inf
        for k in range(starts[i], starts[i + 1]):
            if drive[i] == 0:
                largest = max(largest, compressive_strain(strain[k]))
            else:
                largest = max(largest, tangent_strain(strain[k], across[k]))
        x[1, i] = length[i] * largest
        if share < 1.0:
            x[1, i] = states[i, X] + share * (x[1, i] - states[i, X])
    order, first, longest = blocks
    time = np.array(span)
    for b in range(len(longest)):
        block = order[first[b] : first[b + 1]]
        times, fired = np.empty((len(block), spikes.shape[1])), np.zeros(len(block), np.int64)
        run(units, block, states, time, x, longest[b], times, fired, current)
        for i in range(len(block)):
            if fired[i] == 0 and queue[1][block[i]] == 0:
                counts[block[i]] = 0
            else:
                _report(queue, block[i], times[i], fired[i], span[1], spikes, counts)
    return counts.sum()
