"""Numbers of units and end organs that a scene asks for, which its cost grows with."""

import math
from collections.abc import Sequence

from fefinger.scene.ask import Ask
from fefinger.scene.innervation import innervation
from fefinger.scene.population import Disc, Grid, Layout, Line, Places


FINER = {"FAII": 2.0}
"""Steps of a membrane of a type over those of the other types."""


def units(ask: Ask) -> dict[str, float]:
    """Return the number of units of each type that `ask` describes; some may lie beside the pad."""
    return units_of(ask.population, ask.spikes)


def units_of(layout: Layout | None, types: Sequence[str]) -> dict[str, float]:
    """Return the number of units of each of `types` in a layout, before rounding."""
    if isinstance(layout, Disc):
        rows, area = innervation(), 0.01 * math.pi * layout.radius**2
        return {kind: area * layout.densities.get(kind, rows[kind].density) for kind in types}
    each = 1.0
    if isinstance(layout, Grid):
        # Imported here, because costs are also read for scenes without spikes.
        from fefinger.neural.populations import squares

        each = float(len(squares(layout.spacing, layout.radius)))
    elif isinstance(layout, Line):
        each = float(layout.count)
    elif isinstance(layout, Places):
        each = float(len(layout.places))
    return dict.fromkeys(types, each)


def organs(ask: Ask) -> float:
    """Return the expected number of end organs: one of each unit, or the mean of the published."""
    branched = ask.population is not None and ask.population.branched
    rows = innervation()
    return sum(
        count * (sum(rows[kind].organs) / 2 if branched else 1.0)
        for kind, count in units(ask).items()
    )


def blocks(ask: Ask) -> float:
    """Return the number of blocks of units that advance together; finer steps count more."""
    by_step: dict[float, float] = {}
    for kind, count in units(ask).items():
        finer = FINER.get(kind, 1.0)
        by_step[finer] = by_step.get(finer, 0.0) + count
    abreast = 16  # units of a family of the package that are advanced together
    return sum(finer * math.ceil(count / abreast) for finer, count in by_step.items())
