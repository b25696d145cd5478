"""Errors read from presses that were measured under many objects, next to that of a scene.

`reports/press-mesh.json` holds presses of the calibrated fingers and of published tissue. Finite
strain on each mesh is compared with a finer mesh, every other mechanics with finite strain. The
error of a plate or ball is interpolated between the presses on either side of it; that of any other
object is the largest of its neighboring presses. Errors are read at the relative depth of the
scene: indentation over the thickness of the finger.

Margins are those of the scatter of the presses: for the interpolation between two presses of a
finger, for other edges, and for other fingers. They are relative to the error, because errors
decrease with the depth; for LOCAL quantities they are absolute.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import NamedTuple

import numpy as np

from fefinger.mechanics.evidence import measured_tissue, pressed_objects, tabulation_error
from fefinger.mechanics.evidence.table import MAIN, PRESS_MESH, Measured, table
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.scene import library
from fefinger.support.arrays import Array
from fefinger.support.text import percent
from fefinger.theory.relaxation import hereditary_integral


QUANTILE = 0.95
"""Quantile of the deviations, over all presses at depths like that, that is taken as margin."""

LOCAL = ("pressure", "area")
"""Quantities that depend by chance on which vertices bear the pressure."""

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

LUMPED_LAW = Candidate("lumped")

BEYOND = 1.06
"""Depth over that of the deepest press up to which the errors there count."""


def margin(excess: Excess, part: float) -> float:
    """95 % quantile of the excess at depths within a factor DEPTHS of `part`, else of all."""
    parts, values = excess
    near = values[(part / DEPTHS < parts) & (parts < part * DEPTHS)]
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
        where = pressed_objects.value_on_axis(axis, press.object)
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
        row = [each for each in of_tissue if pressed_objects.objects()[each.object].kind == kind]
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
    names, reason = pressed_objects.neighbor_presses(case.indenter)
    parts = _presses(candidate, case, quantity, names)
    if len(parts) < len(names) and pressed_objects.tilted_or_off_center(case.indenter):
        parts = []  # the missing press is the one that is like it
    if parts and not _deep_enough(parts):
        others = pressed_objects.neighbors_without_itself(case.indenter)
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
    share = _share(pressed_objects.axis_and_value(case.indenter), parts)
    return _Estimate([press for press, _ in parts], parts[0][1], np.array(values), share)


def _margins(
    estimate: _Estimate, candidate: Candidate, case: Situation, quantity: str
) -> list[float]:
    depth, margins = estimate.depth, []
    where, object_ = pressed_objects.axis_and_value(case.indenter), case.indenter
    if where is not None and estimate.share is not None:
        # Balls of nearly one curvature touch the same vertices; plates at an angle touch elsewhere.
        alike = where[0] == "curvature" and quantity not in LOCAL
        middle = 4 * estimate.share * (1 - estimate.share) if alike else 1.0
        excess = margin(between_presses(candidate, quantity, where[0]), depth)
        margins.append(middle * excess * margin_unit(estimate.value, quantity))
    same_object = pressed_objects.presses_of_same_object(object_)
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
    return small and not case.motion.by_force


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
    if not case.motion.by_force:
        return case.depth_over_thickness
    same_object = [x for x in case.force_curves if x.object == press.object]
    curves = same_object or case.force_curves
    return pressed_objects.under_force(case.finger, case.motion.peak, curves)


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
    low, high = (pressed_objects.value_on_axis(axis, press.object) for press, _ in parts)
    if low is None or high is None:
        return None
    return min(max((here - low) / (high - low), 0.0), 1.0)
