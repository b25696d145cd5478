"""Rates of the fitted units over frequency and amplitude, far beyond the recorded points.

A vibration that grows does not fire recorded units less, and fast ones fire them once per cycle at
most. Neither is fitted where nothing was recorded.
"""

from functools import cache

import numpy as np
from fefinger.validation.afferents.vibration import Probed

from fefinger.support.arrays import Array


FREQUENCIES = (1, 2, 5, 10, 20, 40, 60, 100, 150, 200, 250, 300, 400, 600, 800)
"""Hz."""

AMPLITUDES = np.geomspace(5e-4, 1.0, 20)
"""mm, peak."""

BEFORE = 0.2
"""Least time in s of a vibration before its rate counts, over a second."""


@cache
def rates(probed: Probed) -> Array:
    """Mean rates (n_frequencies, n_amplitudes) in Hz of a population."""
    factors, rows = probed.gains(), []
    for frequency in FREQUENCIES:
        since = np.ceil(BEFORE * frequency) / frequency
        times = probed.times(float(frequency), AMPLITUDES, factors, since + 1.0)
        counts = np.array([np.count_nonzero(each >= since) for each in times])
        rows.append(counts.reshape(len(AMPLITUDES), -1).mean(axis=1))
    return np.array(rows)


def largest_fall(probed: Probed) -> float:
    """Largest fall of the rate as the amplitude grows, over the highest rate at the frequency."""
    table = rates(probed)
    falls = (np.maximum.accumulate(table, axis=1) - table).max(axis=1)
    return float(np.max(falls / np.maximum(table.max(axis=1), 1.0)))


FAST = 150.0
"""Frequency in Hz from which a second impulse per cycle is refused."""


def most_per_cycle(probed: Probed) -> float:
    """Most impulses per cycle from FAST on."""
    fast = np.array(FREQUENCIES) >= FAST
    return float(np.max(rates(probed)[fast].max(axis=1) / np.array(FREQUENCIES)[fast]))
