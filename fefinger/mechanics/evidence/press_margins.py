"""Margins of the errors between measured presses: by what a press differs from those around it.

Of `reports/press-mesh.json`: from one press to the next on a finger, to other edges, and to other
fingers. Margins are shares of an error, as errors fall with the depth, but for LOCAL quantities.
"""

import math
from collections.abc import Iterator, Mapping
from functools import cache

import numpy as np

from fefinger.mechanics.evidence.pressed_objects import objects, place_on
from fefinger.mechanics.evidence.table import PRESS_MESH, Measured, table
from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.scene import library
from fefinger.support.arrays import Array


MAIN = "a.h."
"""Subject whose finger was pressed by every object."""

QUANTILE = 0.95
"""Share of the depths of all presses that a margin covers."""


LOCAL = ("pressure", "area")

DEPTHS = 2.0
"""Factor of the depth within which presses tell a margin: errors fall steeply from first touch."""

ABOUT = 1.25
"""Factor of the depth over which local errors under edges are taken together: two to four of the
depths that were measured."""

Missed = tuple[Array, Array]
"""Depths over thickness (n,), and by what an error there exceeds what was told of it (n,)."""


def margin(missed: Missed, part: float | None) -> float:
    """Quantile QUANTILE of the errors at the depths about a depth over thickness, or at all."""
    parts, values = missed
    near = values[[part is None or part / DEPTHS < each < part * DEPTHS for each in parts]]
    chosen = near if near.size else values
    return max(float(np.quantile(chosen, QUANTILE)), 0.0) if chosen.size else 0.0


def unit(error: float, quantity: str) -> float:
    """Return what margins are multiples of: an error itself, as errors fall with the depth.

    1 for LOCAL quantities: which vertices bear the pressure is by chance at any depth.
    """
    return 1.0 if quantity in LOCAL else error


@cache
def between_presses(candidate: Candidate, quantity: str, axis: str) -> Missed:
    """Return half of what the errors in presses exceed those between their neighbors by.

    The presses of one finger at a time. Half, as leaving a press out doubles the gap.
    """
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    rows: dict[str, dict[float, Measured]] = {}
    for name, press in presses.items():
        finger, where = name.partition("/")[0], place_on(axis, object_of(press))
        if where is not None:
            rows.setdefault(finger, {})[where] = press
    return _columns([each for row in rows.values() for each in _left_out(row, quantity)])


def _left_out(row: Mapping[float, Measured], quantity: str) -> Iterator[tuple[float, float]]:
    """Yield depths over thickness of every press with two neighbors, and half of what they miss."""
    places = sorted(row)
    for low, here, high in zip(places, places[1:], places[2:], strict=False):
        share = (here - low) / (high - low)
        deepest = min(row[low].part[-1], row[high].part[-1])
        for part, value in zip(row[here].part, row[here].values, strict=True):
            if part <= deepest:
                told = (1 - share) * at(row[low], part) + share * at(row[high], part)
                yield part, (value - told) / unit(told, quantity) / 2


@cache
def other_edges(candidate: Candidate, quantity: str, kind: str) -> Missed:
    """Return half of what errors under edges of a kind exceed those under all others of it by."""
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    missed = []
    for tissue in (MAIN, library.PUBLISHED):
        row = [
            press
            for press in presses.values()
            if press.press.startswith(f"{tissue}/") and objects()[object_of(press)].kind == kind
        ]
        for press in row:
            others = [other for other in row if other is not press]
            for part, value in zip(press.part, press.values, strict=True):
                told = [about(other, part) for other in others if part <= other.part[-1]]
                if told:
                    missed.append((part, (value - max(told)) / 2))
    return _columns(missed)


@cache
def other_fingers(candidate: Candidate, quantity: str) -> Missed:
    """Excess of the errors in presses of other fingers over those of MAIN, by depth."""
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    more = []
    for name, press in presses.items():
        subject, _, object_ = name.partition("/")
        main = presses.get(f"{MAIN}/{object_}")
        if main is not None and subject not in (MAIN, library.PUBLISHED):
            parts = press.part * stiffer(main, exponent_of(press))
            for part, value in zip(parts, press.values, strict=True):
                if part <= main.part[-1]:
                    told = at(main, part)
                    more.append((part, (value - told) / unit(told, quantity)))
    return _columns(more)


def _columns(pairs: list[tuple[float, float]]) -> Missed:
    parts, values = np.array(pairs).reshape(-1, 2).T
    return parts, values


def at(press: Measured, part: float) -> float:
    """Return the error of a press at a depth over thickness: constant beyond those measured."""
    return float(np.interp(part, press.part, press.values))


def about(press: Measured, part: float) -> float:
    """Return the largest error of a press about a depth over thickness.

    Which vertices an edge or ridge touches changes with the depth and by chance.
    """
    around_it = part * np.linspace(1 / ABOUT, ABOUT, 9)
    return float(np.interp(around_it, press.part, press.values).max())


def stiffer(press: Measured, exponent: float | None) -> float:
    """Return the root of an exponent over that of the tissue of a press."""
    there = exponent_of(press)
    if MECHANICS[press.candidate.mechanics].finite or exponent is None or there is None:
        return 1.0
    return math.sqrt(exponent / there)


def exponent_of(press: Measured) -> float | None:
    """Return the exponent of the tissue of a press; None of published tissue."""
    subject = press.press.partition("/")[0]
    if subject == library.PUBLISHED:
        return None
    return library.tissue_set(library.calibrated_name(subject)).subcutaneous.exponent


def object_of(press: Measured) -> str:
    """Return the name of the object of a press."""
    return press.press.partition("/")[2]


def subject_of(press: Measured) -> str:
    """Return the subject of a press; on published tissue, that was MAIN."""
    subject = press.press.partition("/")[0]
    return MAIN if subject == library.PUBLISHED else subject
