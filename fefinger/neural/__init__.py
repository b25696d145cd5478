"""Afferent units, from strain or displacement to spikes: drives, filters, generators, membranes.

A spike is made in `recorded_compiled.py` (family `recorded`, called by `recorded.py` or, step by
step, by `streaming_step.py`) or `membranes/` (family `thesis`, called by `afferent_units.py`).

This package takes arrays and is independent of mesh, finite elements and scene. The public names
work on the spikes of a run, `ff.run(scene).spikes` and its `times`:

    from fefinger.neural import locking, psth
"""

from fefinger.neural.spectra import signal_spectrum, spike_spectrum
from fefinger.neural.statistics import (
    interval_variation,
    intervals,
    locking,
    mean_rates,
    per_cycle,
    psth,
    van_rossum,
    victor_purpura,
)


__all__ = [
    "interval_variation",
    "intervals",
    "locking",
    "mean_rates",
    "per_cycle",
    "psth",
    "signal_spectrum",
    "spike_spectrum",
    "van_rossum",
    "victor_purpura",
]
