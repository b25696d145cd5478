"""Suite `neural`: membranes, end organs, gains and populations, and the claims of chapters 4 and 5.

A claim is a number between two limits, which fail where it is not reproduced; its name begins with
the section, figure or equation of Pawluk (1997) that makes it.
"""

from collections.abc import Iterator
from typing import Any

from fefinger.validation.case import Case
from fefinger.validation.neural import (
    drawings,
    filters,
    gains,
    membrane,
    phases,
    ramps,
    sinusoids,
    skin,
)


PARTS = (
    *(membrane, sinusoids, phases, filters, ramps),
    *(gains, skin),
)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the cases of all parts."""
    for part in PARTS:
        yield from part.cases(quick=quick)


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and matplotlib Figure of the figures in the thesis's own axes."""
    yield from drawings.figures()
