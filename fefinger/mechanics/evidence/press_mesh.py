"""Errors measured under many objects: of the mesh at finite strain, and of all that is cheaper.

`reports/press-mesh.json` holds presses of the calibrated fingers, and of published tissue under
objects that the trade-off does not have. Finite strain on each mesh is compared with a finer one,
every other mechanics with finite strain. A plate or ball has the error between those of the presses
on either side of it, any other object the largest of the presses that it lies between; at its depth
over the thickness of the finger.
"""

import math
from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.mechanics.evidence import carrying, reached_depth
from fefinger.mechanics.evidence.pressed_objects import (
    around,
    aside,
    between,
    objects,
    place,
    place_on,
    same,
)
from fefinger.mechanics.evidence.table import PRESS_MESH, Measured, table
from fefinger.mechanics.evidence.tradeoff import BEYOND, HELD
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.support.text import percent
from fefinger.theory.relaxation import hereditary_integral


MAIN = "a.h."
"""Subject whose finger was pressed by every object."""

LAW = Candidate("lumped")

QUANTILE = 0.95
"""Share of the depths of all presses that a margin covers."""


LOCAL = ("pressure", "area")

DEPTHS = 2.0
"""Factor of the depth within which presses tell a margin: errors fall steeply from first touch."""

ABOUT = 1.25
"""Factor of the depth over which local errors under edges are taken together: two to four of the
depths that were measured."""


class Known(NamedTuple):
    """An error and its source; not a number where it is not known, and the source says why."""

    error: float
    source: str


UNKNOWN = Known(math.nan, "not known: it was not measured")


def error(candidate: Candidate, case: Situation, quantity: str = "force") -> Known:
    """Return the measured error of a quantity: of finite strain that of its mesh."""
    names, reason = between(case.indenter)
    parts = _presses(candidate, case, quantity, names)
    if len(parts) < len(names) and aside(case.indenter):
        parts = []  # the missing press is the one that is like it
    if parts and not _deep_enough(parts):
        parts = _presses(candidate, case, quantity, around(case.indenter)) or parts
    if not parts:
        return Known(math.nan, f"not known: {reason or 'nothing like it was pressed'}")
    if not _deep_enough(parts):
        press, part = max(parts, key=lambda each: each[0].part[-1])
        return Known(
            math.nan,
            f"not known: it goes to {part:.2g} of the finger's thickness, and presses like it were "
            f"measured to {press.part[-1]:.2g}",
        )
    local = case.indenter.sharp and quantity != "force"
    read = _about if local else _at
    values = [_through(case, press, part, read(press, part), quantity) for press, part in parts]
    error, margins = max(values), [0.0]
    # Which vertices bear the pressure is by chance at any depth.
    depth = None if quantity in LOCAL else parts[0][1]
    where = place(case.indenter)
    share = _share(where, parts)
    if where is not None and share is not None:
        error = (1 - share) * values[0] + share * values[1]
        margins.append(_margin(_between(candidate, quantity, where[0]), depth))
    if local and _object_of(parts[0][0]) not in same(case.indenter):
        margins.append(_margin(_other_edges(candidate, quantity, case.indenter.kind), depth))
    if not _measured_finger(case, parts, quantity):
        margins.append(_margin(_other_fingers(_elsewhere(candidate, case), quantity), depth))
    carried = carrying.error(case, quantity) if _carried(candidate, case) else 0.0
    if case.measured_tissue:  # neither is the larger by far
        margin = math.hypot(*margins) + math.hypot(error, carried) - error
    else:
        margin = math.hypot(*margins, max(1 - error, 0.0) * carried)
    pressed = " and ".join(press.press for press, _ in parts)
    source = f"reports/{PRESS_MESH}, {pressed}: {percent(error)}"
    if margin:
        source += f", and {percent(margin)} of margin"
    return Known(error + margin, source)


def subject(finger: Finger) -> str:
    """Return the name of the calibrated finger in the report that has the tissue of a finger."""
    names = (*library.pawluk_bulk(), library.MEANS)
    fitted = {library.calibrated_name(name): name for name in names}
    return fitted.get(finger.tissue, "")


def stiffening(finger: Finger) -> bool:
    """Return whether the tissue of a finger is a calibrated one, with nothing changed."""
    tissues = library.tissue_set(finger.tissue)
    return (
        bool(subject(finger))
        and (finger.skin, finger.subcutaneous) == (tissues.skin, tissues.subcutaneous)
        and finger.surface is None
        and finger.relaxation == "whole"
        and (finger.bone, finger.nail, finger.cut) == HELD
    )


def _measured_finger(case: Situation, presses: list[tuple[Measured, float]], quantity: str) -> bool:
    """Return whether the presses of a scene are of its finger, and tell of what is between them.

    The margin between presses is of those of MAIN. Of another finger it is taken for the force
    alone, which is smooth; which vertices bear the pressure is by chance on every finger.
    """
    if case.measured_tissue:
        return case.finger.subject_name == MAIN
    own = reached_depth.calibrated(case.finger) and case.finger.subject_name
    whose = {press.press.partition("/")[0] for press, _ in presses}
    smooth = quantity == "force" or own == MAIN or len(presses) == 1
    return whose == {own} and smooth


def _elsewhere(candidate: Candidate, case: Situation) -> Candidate:
    """Return the candidate whose errors on other fingers tell the margin of one.

    On published tissue small strain was compared on one finger: there it is that of its mesh.
    """
    if case.measured_tissue and candidate.resolution is not None:
        return Candidate("solid", candidate.resolution)
    return candidate


def _carried(candidate: Candidate, case: Situation) -> bool:
    """Return whether an error is of small strain, and of a motion.

    Not that of a law of the force, whose relaxation is compared with measured presses.
    """
    small = candidate != LAW and not MECHANICS[candidate.mechanics].finite
    return small and case.motion.control == "depth"


def _presses(
    candidate: Candidate, case: Situation, quantity: str, names: Iterable[str]
) -> list[tuple[Measured, float]]:
    """Return the presses of some objects, and the depth over thickness that a scene is in each."""
    published = case.measured_tissue and not MECHANICS[candidate.mechanics].finite
    tissue = library.PUBLISHED if published else MAIN
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    found = []
    for name in names:
        own, label = f"{subject(case.finger)}/{name}", f"{tissue}/{name}"
        press = presses.get(own, presses.get(label)) if not published else presses.get(label)
        if press is not None:
            found.append((press, _reached(press, case) * _sooner(press, case.finger)))
    return found


def _sooner(press: Measured, finger: Finger) -> float:
    """Return by what a finger is less deep than a press where small strain errs as much.

    Tissue of Demiray's law stiffens by its exponent times I1 - 3, which grows as the square of the
    depth. 1 where the error is of a mesh, or on published tissue.
    """
    return _stiffer(press, finger.subcutaneous.exponent)


def _stiffer(press: Measured, exponent: float | None) -> float:
    """Return the root of an exponent over that of the tissue of a press."""
    there = _exponent(press)
    if MECHANICS[press.candidate.mechanics].finite or exponent is None or there is None:
        return 1.0
    return math.sqrt(exponent / there)


def _exponent(press: Measured) -> float | None:
    """Return the exponent of the tissue of a press; None of published tissue."""
    subject = press.press.partition("/")[0]
    if subject == library.PUBLISHED:
        return None
    return library.tissue_set(library.calibrated_name(subject)).subcutaneous.exponent


def _deep_enough(parts: list[tuple[Measured, float]]) -> bool:
    return any(part <= BEYOND * press.part[-1] for press, part in parts)


def _reached(press: Measured, case: Situation) -> float:
    """Return the depth of a scene over the thickness, by the force of presses of its tissue."""
    if case.among_neighbors is not None:
        return case.among_neighbors
    forces = table().presses(PRESS_MESH, "force", Candidate("solid"))
    force = forces[press.press]
    if case.measured_tissue:
        force = forces.get(f"{library.PUBLISHED}/{_object_of(press)}", force)
    return case.depth_over_thickness(force)


def _at(press: Measured, part: float) -> float:
    """Return the error of a press at a depth over thickness: constant beyond those measured."""
    return float(np.interp(part, press.part, press.values))


def _about(press: Measured, part: float) -> float:
    """Return the largest error of a press about a depth over thickness.

    Which vertices an edge or ridge touches changes with the depth and by chance.
    """
    around_it = part * np.linspace(1 / ABOUT, ABOUT, 9)
    return float(np.interp(around_it, press.part, press.values).max())


def _through(case: Situation, press: Measured, part: float, error: float, quantity: str) -> float:
    """Return the error through a motion of small strain.

    What of the force is wrong grows faster with the depth than the force, and relaxation weighs
    the latest growth most: both are carried by the hereditary integral, as the force is. Highest
    pressures follow the force. Where the force is prescribed it is the error at its depth.
    """
    if not _carried(press.candidate, case) or quantity not in ("force", "pressure"):
        return error
    force = table().presses(PRESS_MESH, "force", Candidate("solid"))[press.press]
    parts = np.concatenate([[0.0], press.part])
    forces = np.concatenate([[0.0], force.values])
    apart = np.concatenate([[0.0], press.values * force.values])
    time = case.times
    depth = (
        np.asarray(case.motion.value(time)) / case.finger.thickness * _sooner(press, case.finger)
    )
    whole, wrong = (
        np.abs(hereditary_integral(case.finger.prony, time, np.interp(depth, parts, values)))
        for values in (forces, apart)
    )
    return max(error, float(wrong.max() / whole.max()))


def _share(where: tuple[str, float] | None, parts: list[tuple[Measured, float]]) -> float | None:
    """Return where an object lies between two presses, from 0 at the first to 1 at the second.

    None for an object that is no plate or ball in the middle of the pad, or has no two neighbors;
    and on published tissue, where too few were pressed to tell the margin for it.
    """
    published = f"{library.PUBLISHED}/"
    if where is None or len(parts) != 2 or parts[0][0].press.startswith(published):
        return None
    axis, here = where
    low, high = (place_on(axis, _object_of(press)) for press, _ in parts)
    if low is None or high is None:
        return None
    return min(max((here - low) / (high - low), 0.0), 1.0)


def _object_of(press: Measured) -> str:
    return press.press.partition("/")[2]


Missed = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Depths over thickness (n,), and by what an error there exceeds what was told of it (n,)."""


def _margin(missed: Missed, part: float | None) -> float:
    """Quantile QUANTILE of the errors at the depths about a depth over thickness, or at all."""
    parts, values = missed
    near = values[[part is None or part / DEPTHS < each < part * DEPTHS for each in parts]]
    chosen = near if near.size else values
    return max(float(np.quantile(chosen, QUANTILE)), 0.0) if chosen.size else 0.0


@cache
def _between(candidate: Candidate, quantity: str, axis: str) -> Missed:
    """Return half of what the errors in presses of MAIN exceed those between their neighbors by.

    Half, as leaving a press out doubles the gap.
    """
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    row = {
        where: press
        for press in presses.values()
        if press.press.startswith(f"{MAIN}/")
        and (where := place_on(axis, _object_of(press))) is not None
    }
    places, missed = sorted(row), []
    for low, here, high in zip(places, places[1:], places[2:], strict=False):
        share = (here - low) / (high - low)
        deepest = min(row[low].part[-1], row[high].part[-1])
        for part, value in zip(row[here].part, row[here].values, strict=True):
            if part <= deepest:
                told = (1 - share) * _at(row[low], part) + share * _at(row[high], part)
                missed.append((part, (value - told) / 2))
    return _columns(missed)


@cache
def _other_edges(candidate: Candidate, quantity: str, kind: str) -> Missed:
    """Return half of what errors under edges of a kind exceed those under all others of it by."""
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    missed = []
    for tissue in (MAIN, library.PUBLISHED):
        row = [
            press
            for press in presses.values()
            if press.press.startswith(f"{tissue}/") and objects()[_object_of(press)].kind == kind
        ]
        for press in row:
            others = [other for other in row if other is not press]
            for part, value in zip(press.part, press.values, strict=True):
                told = [_about(other, part) for other in others if part <= other.part[-1]]
                if told:
                    missed.append((part, (value - max(told)) / 2))
    return _columns(missed)


@cache
def _other_fingers(candidate: Candidate, quantity: str) -> Missed:
    """Excess of the errors in presses of other fingers over those of MAIN, by depth."""
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    more = []
    for name, press in presses.items():
        subject, _, object_ = name.partition("/")
        main = presses.get(f"{MAIN}/{object_}")
        if main is not None and subject not in (MAIN, library.PUBLISHED):
            parts = press.part * _stiffer(main, _exponent(press))
            for part, value in zip(parts, press.values, strict=True):
                if part <= main.part[-1]:
                    more.append((part, value - _at(main, part)))
    return _columns(more)


def _columns(pairs: list[tuple[float, float]]) -> Missed:
    parts, values = np.array(pairs).reshape(-1, 2).T
    return parts, values
