"""Margins of errors read between measured presses, from the scatter of those presses.

The presses are those of `reports/press-mesh.json`. There are margins for the interpolation between
two presses of a finger, for other edges, and for other fingers. They are relative to the error,
because errors decrease with the depth; for LOCAL quantities they are absolute.
"""

import math
from collections.abc import Iterator, Mapping
from functools import cache

import numpy as np

from fefinger.mechanics.evidence.pressed_objects import objects, value_on_axis
from fefinger.mechanics.evidence.table import MAIN, PRESS_MESH, Measured, table
from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.scene import library
from fefinger.support.arrays import Array


QUANTILE = 0.95
"""Quantile of the deviations, over all presses and depths, that is taken as margin."""

LOCAL = ("pressure", "area")
"""Quantities that depend by chance on which vertices bear the pressure, at any depth."""

DEPTHS = 2.0
"""Factor on the depth within which deviations count: errors fall steeply from first touch on."""

ABOUT = 1.25
"""Factor of the depth over which local errors under edges are taken together: two to four of the
depths that were measured."""

SHALLOW = 1.25
"""Power of the depth by which errors of a mesh fall. From the first measured depth to the second,
that of 70 presses on each mesh is 1.2 for the force and 0.9 to 1.0 for strain in the median, 1.3
and 1.2 in three quarters of them."""

Excess = tuple[Array, Array]
"""Relative depths (n,), and the excess (n,) of an error there over its estimate without it."""


def margin(excess: Excess, part: float | None) -> float:
    """95 % quantile of the excess at depths within a factor 2 of `part` (of all depths if None)."""
    parts, values = excess
    near = values[[part is None or part / DEPTHS < each < part * DEPTHS for each in parts]]
    chosen = near if near.size else values
    return max(float(np.quantile(chosen, QUANTILE)), 0.0) if chosen.size else 0.0


def margin_unit(error: float, quantity: str) -> float:
    """Return the unit of a margin: the error itself, or 1 for LOCAL quantities."""
    return 1.0 if quantity in LOCAL else error


@cache
def between_presses(candidate: Candidate, quantity: str, axis: str) -> Excess:
    """Leave-one-out excess of the errors over their interpolation between two neighbors.

    The presses of one finger at a time. Leaving one out doubles the gap; halved for that, the
    excess held in fewer of the scenes of development (91 % of the choices; 93 % as it is).
    """
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    rows: dict[str, dict[float, Measured]] = {}
    for press in presses.values():
        where = value_on_axis(axis, press.object)
        if where is not None:
            rows.setdefault(press.finger, {})[where] = press
    return _columns([each for row in rows.values() for each in _left_out(row, quantity)])


def _left_out(row: Mapping[float, Measured], quantity: str) -> Iterator[tuple[float, float]]:
    """Yield the relative depth and the excess of every press that has two neighbors."""
    places = sorted(row)
    for low, here, high in zip(places, places[1:], places[2:], strict=False):
        share = (here - low) / (high - low)
        deepest = min(row[low].part[-1], row[high].part[-1])
        for part, value in zip(row[here].part, row[here].values, strict=True):
            if part <= deepest:
                below, above = (_expected(row[each], part, quantity) for each in (low, high))
                estimate = (1 - share) * below + share * above
                yield part, (value - estimate) / margin_unit(estimate, quantity)


@cache
def other_edges(candidate: Candidate, quantity: str, kind: str) -> Excess:
    """Half the excess of the error under each edge of a kind over the largest under the others."""
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    excess = []
    for tissue in (MAIN, library.PUBLISHED):
        of_tissue = [each for each in presses.values() if each.finger == tissue]
        row = [each for each in of_tissue if objects()[each.object].kind == kind]
        for press in row:
            others = [other for other in row if other is not press]
            for part, value in zip(press.part, press.values, strict=True):
                estimate = [
                    largest_error_near(other, part) for other in others if part <= other.part[-1]
                ]
                if estimate:
                    excess.append((part, (value - max(estimate)) / 2))
    return _columns(excess)


@cache
def other_fingers(candidate: Candidate, quantity: str) -> Excess:
    """Excess of the errors in presses of other fingers over those of MAIN, by depth."""
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    more = []
    for press in presses.values():
        main = presses.get(f"{MAIN}/{press.object}")
        if main is not None and press.finger not in (MAIN, library.PUBLISHED):
            parts = press.part * stiffer(main, exponent_of(press))
            for part, value in zip(parts, press.values, strict=True):
                if part <= main.part[-1]:
                    estimate = _expected(main, part, quantity)
                    more.append((part, (value - estimate) / margin_unit(estimate, quantity)))
    return _columns(more)


def _expected(press: Measured, part: float, quantity: str) -> float:
    """Return the error that a press lets expect; LOCAL ones, by chance, are taken as constant."""
    if quantity in LOCAL:
        return float(np.interp(part, press.part, press.values))
    return error_at(press, part)


def _columns(pairs: list[tuple[float, float]]) -> Excess:
    parts, values = np.array(pairs).reshape(-1, 2).T
    return parts, values


def error_at(press: Measured, part: float) -> float:
    """Return the error of a press at a relative depth, constant beyond the deepest measured one.

    Above the shallowest one that of a mesh grows, since the mesh resolves ever less of the contact.
    """
    return float(_errors(press, np.array([part]))[0])


def largest_error_near(press: Measured, part: float) -> float:
    """Return the largest error of a press within ABOUT of a relative depth.

    The vertices that an edge or ridge touches change with the depth, by chance.
    """
    return float(_errors(press, part * np.linspace(1 / ABOUT, ABOUT, 9)).max())


def _errors(press: Measured, part: Array) -> Array:
    """Return the errors (n,) of a press at relative depths (n,)."""
    errors = np.asarray(np.interp(part, press.part, press.values))
    if press.candidate.resolution is None:
        return errors
    first = float(press.part[0])
    return errors * np.maximum(first / np.maximum(part, 1e-9 * first), 1.0) ** SHALLOW


def stiffer(press: Measured, exponent: float | None) -> float:
    """Factor on the relative depth for which small strain has the same error as in a press.

    Tissue of Demiray's law stiffens by its exponent times I1 - 3, which grows as the square of the
    depth. 1 for the error of a mesh, and on published tissue.
    """
    there = exponent_of(press)
    if MECHANICS[press.candidate.mechanics].finite or exponent is None or there is None:
        return 1.0
    return math.sqrt(exponent / there)


def exponent_of(press: Measured) -> float | None:
    """Return the exponent of stiffening of the tissue of a press; None for published tissue."""
    if press.finger == library.PUBLISHED:
        return None
    return library.tissue_set(library.calibrated_name(press.finger)).subcutaneous.exponent
