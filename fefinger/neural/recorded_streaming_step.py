"""Compiled time step of the units of `recorded_streaming`."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fefinger.neural.recorded_compiled import Units, advance
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
    longest: Array,
    spikes: Array,
    counts: Integers,
) -> int:
    """Advance all units over a span (start, stop) in s; return the spikes, REFUSED or CROWDED.

    organs: index of the drive (n_units,), length (n_units,) mm, first end organ of each unit and
    their number (n_units + 1,), and vectors in the skin (n_organs, 2, 3).
    """
    drive, length, starts, across = organs
    for k in range(len(strain)):
        for c in range(6):
            if not abs(strain[k, c]) <= LARGEST_STRAIN:
                return REFUSED
    total = 0
    for i in range(len(counts)):
        largest = -np.inf
        for k in range(starts[i], starts[i + 1]):
            if drive[i] == 0:
                largest = max(largest, compressive_strain(strain[k]))
            else:
                largest = max(largest, tangent_strain(strain[k], across[k]))
        x = length[i] * largest
        counts[i] = advance(units, i, states[i], span, x, longest[i], spikes[i], 0)
        total += counts[i]
    return CROWDED if counts.max() > spikes.shape[1] else total
