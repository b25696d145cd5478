"""Suite `thesis`: the tables, figures and numbers of Pawluk (1997) that the equations give."""

from collections.abc import Iterator
from typing import Any

from fefinger.validation import (
    thesis_array,
    thesis_ball,
    thesis_claims,
    thesis_drawings,
    thesis_energy,
    thesis_figures,
    thesis_fit,
    thesis_lumped,
    thesis_nerve,
    thesis_pressure,
    thesis_sensor,
    thesis_tables,
    thesis_unloading,
)
from fefinger.validation.case import Case


PARTS = (
    *(thesis_tables, thesis_lumped, thesis_claims, thesis_fit, thesis_energy, thesis_pressure),
    *(thesis_unloading, thesis_array, thesis_sensor, thesis_ball, thesis_nerve),
)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the cases of all parts."""
    for part in PARTS:
        yield from part.cases(quick=quick)


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and matplotlib Figure of the figures in the thesis's own axes."""
    yield from thesis_figures.figures()
    yield from thesis_drawings.figures()
