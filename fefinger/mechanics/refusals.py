"""Reasons against a mechanics, each with the field of the scene that it is about."""

from collections.abc import Iterable
from typing import NamedTuple

from fefinger.results.records import Refusal


class Doubt(NamedTuple):
    """A reason against a mechanics, and the field or part of the scene to change, "" for none."""

    field: str
    reason: str


def refusals(mechanics: str, about: str, doubts: Iterable[Doubt]) -> tuple[Refusal, ...]:
    """Return the refusals of a mechanics for reasons `about` "ability", "accuracy" or "time"."""
    return tuple(Refusal(mechanics, about, doubt.reason, doubt.field) for doubt in doubts)
