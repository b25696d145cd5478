"""Case of a validation suite: one computed number, its expected value and the source of that."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Literal, NamedTuple, Self


Verdict = Literal["pass", "documented", "short", "fail"]


@dataclass(frozen=True)
class Noted:
    """A value with a sentence on it, which the page shows under the case."""

    value: float
    text: str

    def __float__(self) -> float:
        return self.value


@dataclass(frozen=True)
class Expected:
    """An expected value and its tolerance (absolute), both in `unit`."""

    value: float
    tolerance: float
    unit: str = "1"

    @classmethod
    def between(cls, low: float, high: float, unit: str = "1") -> Self:
        """Return the middle of two limits, with half of their distance as the tolerance."""
        return cls((low + high) / 2, (high - low) / 2, unit)


@dataclass(frozen=True)
class Case:
    """One comparison of a computed number with its expected value.

    measure: gives fefinger's value, or it with a note (`Noted`); source: the equation, table,
    program or second method behind `expected`; printed: a published value beside the right one;
    erratum: a sentence on why the two differ; wanted: what fefinger aims at where `expected` is
    only what is known of it; shortfall: a sentence on why it is missed; reason: why this tolerance.
    """

    name: str
    measure: Callable[[], float | Noted]
    expected: Expected
    source: str
    printed: float | None = None
    erratum: str = ""
    wanted: float | None = None
    shortfall: str = ""
    reason: str = ""


class Row(NamedTuple):
    """A Case in a table by names."""

    measure: Callable[[], float | Noted]
    expected: Expected
    source: str
    reason: str = ""


def tabled(rows: Mapping[str, Row]) -> Iterator[Case]:
    """Yield the cases of a table."""
    for name, row in rows.items():
        yield Case(name, row.measure, row.expected, row.source, reason=row.reason)


@dataclass(frozen=True)
class Outcome:
    """A Case that has been measured; where it could not be, `failure` says why, `value` is NaN.

    `note` is the sentence of the measure on its value.
    """

    case: Case
    value: float
    failure: str = ""
    note: str = ""

    @property
    def verdict(self) -> Verdict:
        """Pass, fail, documented (ours is right, the print is known to be outside), or short.

        Short is what is as known, and misses what is wanted.
        """
        case, tolerance = self.case, self.case.expected.tolerance
        if not abs(self.value - case.expected.value) <= tolerance:
            return "fail"
        if case.wanted is not None and abs(self.value - case.wanted) > tolerance:
            return "short"
        if case.printed is not None and abs(case.printed - case.expected.value) > tolerance:
            return "documented"
        return "pass"


def joined(*parts: ModuleType) -> Callable[..., Iterator[Case]]:
    """Return the function `cases` of a suite, which yields the cases of its parts in turn."""

    def cases(*, quick: bool) -> Iterator[Case]:
        for part in parts:
            yield from part.cases(quick=quick)

    return cases
