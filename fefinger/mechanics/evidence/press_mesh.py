"""Errors measured under many objects: of the mesh at finite strain, and of all that is cheaper.

`reports/press-mesh.json` holds presses of the calibrated fingers, and of published tissue under
objects that the trade-off does not have. Finite strain on each mesh is compared with a finer one,
every other mechanics with finite strain. A plate or ball has the error between those of the presses
on either side of it, any other object the largest of the presses that it lies between; at its depth
over the thickness of the finger.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from fefinger.mechanics.evidence import carrying, reached_depth
from fefinger.mechanics.evidence.press_margins import (
    LOCAL,
    MAIN,
    about,
    at,
    between_presses,
    margin,
    object_of,
    other_edges,
    other_fingers,
    stiffer,
    subject_of,
    unit,
)
from fefinger.mechanics.evidence.pressed_objects import (
    around,
    aside,
    between,
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
from fefinger.support.arrays import Array
from fefinger.support.text import percent
from fefinger.theory.relaxation import hereditary_integral


LAW = Candidate("lumped")


class Known(NamedTuple):
    """An error and its source; not a number where it is not known, and the source says why."""

    error: float
    source: str


UNKNOWN = Known(math.nan, "not known: it was not measured")


def error(candidate: Candidate, case: Situation, quantity: str = "force") -> Known:
    """Return the measured error of a quantity: of finite strain that of its mesh."""
    told = _told(candidate, case, quantity)
    if isinstance(told, str):
        return Known(math.nan, f"not known: {told}")
    margin, value = math.hypot(*_margins(told, candidate, case, quantity)), told.value
    carried = carrying.error(case, quantity) if _carried(candidate, case) else 0.0
    if case.measured_tissue:  # neither is the larger by far
        margin += math.hypot(value, carried) - value
    else:
        margin = math.hypot(margin, max(1 - value, 0.0) * carried)
    pressed = " and ".join(press.press for press in told.presses)
    source = f"reports/{PRESS_MESH}, {pressed}: {percent(value)}"
    if margin:
        source += f", and {percent(margin)} of margin"
    return Known(value + margin, source)


class _Told(NamedTuple):
    """What presses tell of an error.

    depth: over the thickness, in the first press; share: where the object lies between the presses,
    as `_share` has it; values (n,): of each press.
    """

    presses: list[Measured]
    depth: float
    values: Array
    share: float | None

    @property
    def value(self) -> float:
        """The error: between those of two presses, else the largest."""
        return float(self.values.max() if self.share is None else self.weighted.sum())

    @property
    def weighted(self) -> Array:
        """What of an error between two presses is of each (2,)."""
        assert self.share is not None
        return self.values * [1 - self.share, self.share]


def _told(candidate: Candidate, case: Situation, quantity: str) -> _Told | str:
    """Return what the presses next to a scene tell of an error, or why none does."""
    names, reason = between(case.indenter)
    parts = _presses(candidate, case, quantity, names)
    if len(parts) < len(names) and aside(case.indenter):
        parts = []  # the missing press is the one that is like it
    if parts and not _deep_enough(parts):
        parts = _presses(candidate, case, quantity, around(case.indenter)) or parts
    if not parts:
        return reason or "nothing like it was pressed"
    if not _deep_enough(parts):
        press, part = max(parts, key=lambda each: each[0].part[-1])
        return (
            f"it goes to {part:.2g} of the finger's thickness, and presses like it were measured "
            f"to {press.part[-1]:.2g}"
        )
    read = about if case.indenter.sharp and quantity != "force" else at
    values = [_through(case, press, part, read(press, part), quantity) for press, part in parts]
    share = _share(place(case.indenter), parts)
    return _Told([press for press, _ in parts], parts[0][1], np.array(values), share)


def _margins(told: _Told, candidate: Candidate, case: Situation, quantity: str) -> list[float]:
    """Return the margins of an error: between presses, of other edges, of other fingers."""
    # Which vertices bear the pressure is by chance at any depth.
    depth, margins = None if quantity in LOCAL else told.depth, []
    where, object_ = place(case.indenter), case.indenter
    if where is not None and told.share is not None:
        # Balls of nearly one curvature touch the same vertices; plates at an angle touch elsewhere.
        alike = where[0] == "curvature" and quantity not in LOCAL
        middle = 4 * told.share * (1 - told.share) if alike else 1.0
        missed = margin(between_presses(candidate, quantity, where[0]), depth)
        margins.append(middle * missed * unit(told.value, quantity))
    if object_.sharp and quantity != "force" and object_of(told.presses[0]) not in same(object_):
        margins.append(margin(other_edges(candidate, quantity, object_.kind), depth))
    elsewhere = _elsewhere(told, case, quantity)
    if elsewhere:
        other, value = _as_elsewhere(candidate, case, quantity, told.value)
        missed = margin(other_fingers(other, quantity), depth)
        margins.append(elsewhere * missed * unit(value, quantity))
    return margins


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
        and finger.tip_tissue is None
        and finger.relaxation == "whole"
        and (finger.bone, finger.nail, finger.cut) == HELD
    )


def _elsewhere(told: _Told, case: Situation, quantity: str) -> float:
    """Return the share of an error that was measured on another finger than that of the scene.

    All of it but for the force, which is smooth: which vertices bear the pressure is by chance on
    every finger, and the margin between presses is mostly of those of MAIN.
    """
    known = case.measured_tissue or reached_depth.calibrated(case.finger)
    own = case.finger.subject_name if known else None
    others = np.array([subject_of(press) != own for press in told.presses])
    if quantity != "force":
        return float(others.any() or (own != MAIN and len(others) > 1))
    if told.share is None:
        return float(others.any())
    return float(told.weighted[others].sum() / told.value)


def _as_elsewhere(
    candidate: Candidate, case: Situation, quantity: str, value: float
) -> tuple[Candidate, float]:
    """Return the candidate whose errors on other fingers tell the margin of one, and its error.

    On published tissue small strain was compared on one finger: there it is that of its mesh.
    """
    small = not MECHANICS[candidate.mechanics].finite
    if not (small and case.measured_tissue and candidate.resolution is not None):
        return candidate, value
    mesh = Candidate("solid", candidate.resolution)
    told = _told(mesh, case, quantity)
    return mesh, value if isinstance(told, str) else told.value


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
    finite = MECHANICS[candidate.mechanics].finite
    published = case.measured_tissue and not finite
    tissue = library.PUBLISHED if published else MAIN
    # What a mesh errs by is of the finger, whatever its tissue.
    whose = (finite and case.finger.subject_name) or subject(case.finger)
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    found = []
    for name in names:
        own, label = f"{whose}/{name}", f"{tissue}/{name}"
        press = presses.get(own, presses.get(label)) if not published else presses.get(label)
        if press is not None:
            found.append((press, _reached(press, case) * _sooner(press, case.finger)))
    return found


def _sooner(press: Measured, finger: Finger) -> float:
    """Return by what a finger is less deep than a press where small strain errs as much.

    Tissue of Demiray's law stiffens by its exponent times I1 - 3, which grows as the square of the
    depth. 1 where the error is of a mesh, or on published tissue.
    """
    return stiffer(press, finger.subcutaneous.exponent)


def _deep_enough(parts: list[tuple[Measured, float]]) -> bool:
    return any(part <= BEYOND * press.part[-1] for press, part in parts)


def _reached(press: Measured, case: Situation) -> float:
    """Return the depth of a scene over the thickness, by the force of presses of its tissue."""
    if case.among_neighbors is not None:
        return case.among_neighbors
    forces = table().presses(PRESS_MESH, "force", Candidate("solid"))
    force = forces[press.press]
    if case.measured_tissue:
        force = forces.get(f"{library.PUBLISHED}/{object_of(press)}", force)
    return case.depth_over_thickness(force)


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
    both = np.column_stack([np.interp(depth, parts, values) for values in (forces, apart)])
    whole, wrong = np.abs(hereditary_integral(case.finger.prony, time, both)).max(axis=0)
    return max(error, float(wrong / whole))


def _share(where: tuple[str, float] | None, parts: list[tuple[Measured, float]]) -> float | None:
    """Return where an object lies between two presses, from 0 at the first to 1 at the second.

    None for an object that is no plate or ball in the middle of the pad, or has no two neighbors.
    """
    if where is None or len(parts) != 2:
        return None
    axis, here = where
    low, high = (place_on(axis, object_of(press)) for press, _ in parts)
    if low is None or high is None:
        return None
    return min(max((here - low) / (high - low), 0.0), 1.0)
