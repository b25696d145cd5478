"""Afferent units, from strain or displacement to spikes: drives, filters, generators, membranes.

A spike is made in `recorded_vectorized.py` (family `recorded`, called by `recorded_simulation.py`;
step by step in a loop, `recorded_compiled.py`) or `membranes/` (family `thesis`, called by
`units.py`).

The room takes arrays and is independent of mesh, finite elements and scene. The public names work
on the spikes of a run, `ff.run(scene).spikes` and its `times`:

    from fefinger.neural import locking, psth

Public names are imported at first use.
"""

import importlib
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from fefinger.neural.statistics import interval_variation as interval_variation
    from fefinger.neural.statistics import intervals as intervals
    from fefinger.neural.statistics import locking as locking
    from fefinger.neural.statistics import mean_rates as mean_rates
    from fefinger.neural.statistics import per_cycle as per_cycle
    from fefinger.neural.statistics import psth as psth
    from fefinger.neural.statistics import van_rossum as van_rossum
    from fefinger.neural.statistics import victor_purpura as victor_purpura

_HOMES = {
    "statistics": (
        *("interval_variation", "intervals", "locking", "mean_rates", "per_cycle", "psth"),
        *("van_rossum", "victor_purpura"),
    ),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(_HOME)
