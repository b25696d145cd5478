"""Suite `thesis`: the tables, figures and numbers of Pawluk (1997) that the equations give."""

from collections.abc import Iterator
from typing import Any

from fefinger.validation.case import joined
from fefinger.validation.thesis import (
    array,
    ball,
    claims,
    drawings,
    energy,
    fit,
    lumped,
    nerve,
    pressure,
    sensor,
    tables,
    unloading,
)
from fefinger.validation.thesis import figures as thesis_figures


cases = joined(
    *(tables, lumped, claims, fit, energy, pressure),
    *(unloading, array, sensor, ball, nerve),
)


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and matplotlib Figure of the figures in the thesis's own axes."""
    yield from thesis_figures.figures()
    yield from drawings.figures()
