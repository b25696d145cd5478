"""Compiled time step of the units of `recorded_streaming`."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fefinger.neural.recorded_compiled import Units, X
from fefinger.neural.recorded_vectorized import run
from fefinger.neural.streaming_step import (
    LARGEST_STRAIN,
    REFUSED,
    compressive_strain,
    tangent_strain,
)
from fefinger.support.arrays import Array, Integers


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
def step(
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
