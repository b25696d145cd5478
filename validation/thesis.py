"""Suite `thesis`: the tables, figures and numbers of Pawluk (1997) that the equations give."""

from collections.abc import Iterator

from fefinger.validation import (
    thesis_energy,
    thesis_fit,
    thesis_lumped,
    thesis_pressure,
    thesis_tables,
)
from fefinger.validation.case import Case


PARTS = (thesis_tables, thesis_lumped, thesis_energy, thesis_pressure, thesis_fit)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the cases of all parts."""
    for part in PARTS:
        yield from part.cases(quick=quick)
