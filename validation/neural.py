"""Suite `neural`: membranes, end organs, gains and populations, and the claims of chapters 4 and 5.

A claim is a number between two limits, which fail where it is not reproduced; its name begins with
the section, figure or equation of Pawluk (1997) that makes it.
"""

from collections.abc import Iterator
from typing import Any

from fefinger.validation import (
    neural_drawings,
    neural_filters,
    neural_gains,
    neural_membrane,
    neural_phases,
    neural_ramps,
    neural_sinusoids,
    neural_skin,
)
from fefinger.validation.case import Case


PARTS = (
    *(neural_membrane, neural_sinusoids, neural_phases, neural_filters, neural_ramps),
    *(neural_gains, neural_skin),
)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the cases of all parts."""
    for part in PARTS:
        yield from part.cases(quick=quick)


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and matplotlib Figure of the figures in the thesis's own axes."""
    yield from neural_drawings.figures()
