"""Reasons against a mechanics, each with the field of the scene that it is about."""

from collections.abc import Iterable
from typing import NamedTuple

from fefinger.results.records import Refusal


class Reason(NamedTuple):
    """A reason against a mechanics, and the field or part of the scene to change, "" for none."""

    field: str
    text: str


def refusals(mechanics: str, about: str, reasons: Iterable[Reason]) -> tuple[Refusal, ...]:
    """Return the refusals of a mechanics for reasons `about` "ability", "accuracy" or "time"."""
    return tuple(Refusal(mechanics, about, reason.text, reason.field) for reason in reasons)
