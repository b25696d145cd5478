"""Compiled time step of the units of `recorded_streaming`."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fefinger.neural.recorded_compiled import Units
from fefinger.neural.recorded_vectorized import run
from fefinger.neural.streaming_step import (
    CROWDED,
    LARGEST_STRAIN,
    REFUSED,
    compressive_strain,
    tangent_strain,
)
from fefinger.support.arrays import Array, Integers


@njit(cache=True)
def step(
    units: Units,
    states: Array,
    span: tuple[float, float],
    strain: NDArray[np.floating],
    organs: tuple[Integers, Array, Integers, Array],
    blocks: tuple[Integers, Integers, Array],
    spikes: Array,
    counts: Integers,
) -> int:
    """Advance all units over a span (start, stop) in s; return the spikes, REFUSED or CROWDED.

    organs: index of the drive (n_units,), length (n_units,) mm, first end organ of each unit and
    their number (n_units + 1,), and vectors in the skin (n_organs, 2, 3). blocks: units (n_units,)
    in the order of their blocks, first place of each block there and their number (n_blocks + 1,),
    and bound of its steps in s (n_blocks,).
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
    order, first, longest = blocks
    time = np.array(span)
    for b in range(len(longest)):
        block = order[first[b] : first[b + 1]]
        times, fired = np.empty((len(block), spikes.shape[1])), np.zeros(len(block), np.int64)
        run(units, block, states, time, x, longest[b], times, fired, current)
        for i in range(len(block)):
            spikes[block[i]], counts[block[i]] = times[i], fired[i]
    return CROWDED if counts.max() > spikes.shape[1] else counts.sum()
