"""Suite `fem`: the finite elements and their contact against exact solutions.

Everything is solved by the code that answers scenes (`fefinger.fem`), on meshes that are made here.
"""

from collections.abc import Iterator
from typing import Any

from fefinger.validation.case import Case
from fefinger.validation.fem import drawings, elements, exact, hertz, history, solid


PARTS = (hertz, elements, exact, history, solid)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the cases of all parts."""
    for part in PARTS:
        yield from part.cases(quick=quick)


def finding() -> dict[str, Any]:
    """Return the table of fefinger beside other programs."""
    return drawings.finding()


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and matplotlib Figure."""
    yield from drawings.figures()
