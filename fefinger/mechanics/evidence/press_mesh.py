"""Errors read from presses that were measured under many objects, next to that of a scene.

`reports/press-mesh.json` holds presses of the calibrated fingers and of published tissue. Finite
strain on each mesh is compared with a finer mesh, every other mechanics with finite strain. The
error of a plate or ball is interpolated between the presses on either side of it; that of any other
object is the largest of its neighboring presses. Errors are read at the relative depth of the
scene: indentation over the thickness of the finger.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from fefinger.mechanics.evidence import measured_tissue, pressed_objects, tabulation_error
from fefinger.mechanics.evidence.press_margins import (
    LOCAL,
    between_presses,
    error_at,
    largest_error_near,
    margin,
    margin_unit,
    other_edges,
    other_fingers,
    stiffer,
)
from fefinger.mechanics.evidence.pressed_objects import (
    axis_and_value,
    neighbor_presses,
    neighbors_without_itself,
    presses_of_same_object,
    tilted_or_off_center,
    value_on_axis,
)
from fefinger.mechanics.evidence.table import MAIN, PRESS_MESH, Measured, table
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.scene import library
from fefinger.support.arrays import Array
from fefinger.support.text import percent
from fefinger.theory.relaxation import hereditary_integral


LUMPED_LAW = Candidate("lumped")

BEYOND = 1.06
"""Depth over that of the deepest press up to which the errors there count."""


class StatedError(NamedTuple):
    """A relative error and its source; nan where it is not known, and the source says why."""

    error: float
    source: str


UNKNOWN = StatedError(math.nan, "not known: it was not measured")


def error(candidate: Candidate, case: Situation, quantity: str = "force") -> StatedError:
    """Return the measured error of a quantity; at finite strain, that of the mesh.

    Small strain is wrong by more than the fine mesh differs from the standard one, as which it
    counts.
    """
    if not MECHANICS[candidate.mechanics].finite:
        candidate = candidate.measured
    estimate = _estimate(candidate, case, quantity)
    if isinstance(estimate, str):
        return StatedError(math.nan, estimate)
    margin, value = math.hypot(*_margins(estimate, candidate, case, quantity)), estimate.value
    grows = _grows_through_motion(candidate, case)
    tabulation = tabulation_error.error(case, quantity, table=False) if grows else 0.0
    if case.published_tissue:  # neither is the larger by far
        margin += math.hypot(value, tabulation) - value
    else:
        margin = math.hypot(margin, max(1 - value, 0.0) * tabulation)
    pressed = " and ".join(press.press for press in estimate.presses)
    source = f"reports/{PRESS_MESH}, {pressed}: {percent(value)}"
    if margin:
        source += f", and {percent(margin)} of margin"
    return StatedError(value + margin, source)


class _Estimate(NamedTuple):
    """Error of a quantity by the neighboring presses, without margins.

    depth: relative depth in the first press; share: position of the object between the presses, see
    `_share`; values (n,): error in each press.
    """

    presses: list[Measured]
    depth: float
    values: Array
    share: float | None

    @property
    def value(self) -> float:
        """The error, interpolated between two presses if possible, else the largest."""
        return float(self.values.max() if self.share is None else self.weighted.sum())

    @property
    def weighted(self) -> Array:
        """Contributions (2,) of the two presses to an interpolated error."""
        assert self.share is not None
        return self.values * [1 - self.share, self.share]


def _estimate(candidate: Candidate, case: Situation, quantity: str) -> _Estimate | str:
    """Estimate an error by the presses next to a scene; a sentence where none is comparable."""
    names, reason = neighbor_presses(case.indenter)
    parts = _presses(candidate, case, quantity, names)
    if len(parts) < len(names) and tilted_or_off_center(case.indenter):
        parts = []  # the missing press is the one that is like it
    if parts and not _deep_enough(parts):
        others = neighbors_without_itself(case.indenter)
        parts = _presses(candidate, case, quantity, others) or parts
    if not parts:
        return f"not known: {reason or 'no comparable press was measured'}"
    if not _deep_enough(parts):
        press, part = max(parts, key=lambda each: each[0].part[-1])
        return (
            f"not known: it goes to {part:.2g} of the finger's thickness, and presses like it were "
            f"measured to {press.part[-1]:.2g}"
        )
    read = largest_error_near if case.indenter.sharp and quantity != "force" else error_at
    values = [_through(case, press, read(press, part), quantity) for press, part in parts]
    share = _share(axis_and_value(case.indenter), parts)
    return _Estimate([press for press, _ in parts], parts[0][1], np.array(values), share)


def _margins(
    estimate: _Estimate, candidate: Candidate, case: Situation, quantity: str
) -> list[float]:
    """Return the margins of an estimate: interpolation, other edges, other fingers."""
    # Which vertices bear the pressure is by chance at any depth.
    depth, margins = None if quantity in LOCAL else estimate.depth, []
    where, object_ = axis_and_value(case.indenter), case.indenter
    if where is not None and estimate.share is not None:
        # Balls of nearly one curvature touch the same vertices; plates at an angle touch elsewhere.
        alike = where[0] == "curvature" and quantity not in LOCAL
        middle = 4 * estimate.share * (1 - estimate.share) if alike else 1.0
        excess = margin(between_presses(candidate, quantity, where[0]), depth)
        margins.append(middle * excess * margin_unit(estimate.value, quantity))
    same_object = presses_of_same_object(object_)
    if object_.sharp and quantity != "force" and estimate.presses[0].object not in same_object:
        margins.append(margin(other_edges(candidate, quantity, object_.kind), depth))
    elsewhere = _measured_elsewhere(estimate, case, quantity)
    if elsewhere:
        other, value = _scatter_of(candidate, case, quantity, estimate.value)
        excess = margin(other_fingers(other, quantity), depth)
        margins.append(elsewhere * excess * margin_unit(value, quantity))
    return margins


def _measured_elsewhere(estimate: _Estimate, case: Situation, quantity: str) -> float:
    """Return the share of an estimate that was measured on another finger than the scene's.

    The force varies smoothly, so its share is that of the presses of other fingers. Other
    quantities depend by chance on which vertices bear the pressure, so one such press counts fully.
    """
    known = case.published_tissue or measured_tissue.subject(case.finger)
    subject = case.finger.subject_name if known else None
    # Published tissue was pressed on the finger of MAIN.
    fingers = [MAIN if x.finger == library.PUBLISHED else x.finger for x in estimate.presses]
    others = np.array([finger != subject for finger in fingers])
    if quantity != "force":
        return float(others.any() or (subject != MAIN and len(others) > 1))
    if estimate.share is None:
        return float(others.any())
    return float(estimate.weighted[others].sum() / estimate.value)


def _scatter_of(
    candidate: Candidate, case: Situation, quantity: str, value: float
) -> tuple[Candidate, float]:
    """Return the candidate whose scatter between fingers gives the margin, and its error.

    On published tissue, small strain was compared on one finger only; the scatter there is that of
    finite strain on the same mesh.
    """
    finite = MECHANICS[candidate.mechanics].finite
    if finite or not case.published_tissue or candidate.resolution is None:
        return candidate, value
    mesh = Candidate("solid", candidate.resolution)
    estimate = _estimate(mesh, case, quantity)
    return mesh, value if isinstance(estimate, str) else estimate.value


def _grows_through_motion(candidate: Candidate, case: Situation) -> bool:
    """Whether the error of a candidate grows through the motion: small strain at a given depth.

    Not that of the lumped law, whose relaxation is compared with measured presses.
    """
    small = candidate != LUMPED_LAW and not MECHANICS[candidate.mechanics].finite
    return small and case.motion.control == "depth"


def _presses(
    candidate: Candidate, case: Situation, quantity: str, names: Iterable[str]
) -> list[tuple[Measured, float]]:
    """Return the presses by some objects, each with the relative depth at which it is read."""
    finite = MECHANICS[candidate.mechanics].finite
    if case.published_tissue and not finite:
        fingers = [library.PUBLISHED]
    else:  # The error of a mesh depends on the finger, hardly on its tissue.
        subject = (finite and case.finger.subject_name) or library.fitted_to(case.finger.tissue)
        fingers = [subject or MAIN, MAIN]
    presses = table().presses(PRESS_MESH, f"error of {quantity}", candidate)
    parts, exponent = [], case.finger.subcutaneous.exponent
    for name in names:
        press = next((presses[x] for f in fingers if (x := f"{f}/{name}") in presses), None)
        if press is not None:
            parts.append((press, _reached(press, case) * stiffer(press, exponent)))
    return parts


def _reached(press: Measured, case: Situation) -> float:
    """Return the relative depth of a scene; under force control by a press with the same object."""
    if case.motion.control == "depth":
        return case.depth_over_thickness
    same_object = [x for x in case.force_curves if x.object == press.object]
    return pressed_objects.under_force(case.finger, case.peak, same_object or case.force_curves)


def _deep_enough(parts: list[tuple[Measured, float]]) -> bool:
    return any(part <= BEYOND * press.part[-1] for press, part in parts)


def _through(case: Situation, press: Measured, error: float, quantity: str) -> float:
    """Return the error of small strain through a motion, from that in a press at a depth.

    The difference of the forces grows faster with the depth than the force, and relaxation weights
    the latest growth most, so the hereditary integral is taken of both. Highest pressures follow
    the force. Under force control it is the error at the depth reached.
    """
    if not _grows_through_motion(press.candidate, case) or quantity not in ("force", "pressure"):
        return error
    force = table().presses(PRESS_MESH, "force", Candidate("solid"))[press.press]
    parts = np.concatenate([[0.0], press.part])
    forces = np.concatenate([[0.0], force.values])
    apart = np.concatenate([[0.0], press.values * force.values])
    time = case.times
    part = np.asarray(case.motion.value(time)) / case.finger.thickness
    depth = part * stiffer(press, case.finger.subcutaneous.exponent)
    both = np.column_stack([np.interp(depth, parts, values) for values in (forces, apart)])
    whole, wrong = np.abs(hereditary_integral(case.finger.prony, time, both)).max(axis=0)
    return max(error, float(wrong / whole))


def _share(where: tuple[str, float] | None, parts: list[tuple[Measured, float]]) -> float | None:
    """Position of an object between two presses, from 0 at the first to 1 at the second.

    None for an object that is no plate or ball in the middle of the pad, or has one neighbor.
    """
    if where is None or len(parts) != 2:
        return None
    axis, here = where
    low, high = (value_on_axis(axis, press.object) for press, _ in parts)
    if low is None or high is None:
        return None
    return min(max((here - low) / (high - low), 0.0), 1.0)
