"""Stated error of the force of a closed formula or of the lumped law.

`reports/formula-force.json` holds log ratios: of the formula's elastic force over that of finite
strain, by depth, for presses of a finger by a plate or a ball in the middle of the pad. The log
ratio is smooth in angle, curvature and depth, and changes sign, so it is interpolated with its
sign. For a scene it is read on the finger of MAIN under the same object, and corrected by the
difference between the two fingers under the objects that both were pressed by. Both forces are
then evolved through the motion; their largest difference over the peak force is the error.

The margin of the log ratio is the root of the sum of squares of independent causes: interpolation
between presses of MAIN, by their curvature; interpolation between fingers, by leaving presses out;
the mesh of the presses; and the error of finite strain through time (`carrying`).
"""

import math
from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

import numpy as np

from fefinger.mechanics.evidence import carrying, press_mesh
from fefinger.mechanics.evidence.press_margins import DEPTHS, MAIN, QUANTILE
from fefinger.mechanics.evidence.press_mesh import Known
from fefinger.mechanics.evidence.pressed_objects import place
from fefinger.mechanics.evidence.table import FORMULAS, Measured, table
from fefinger.mechanics.evidence.tradeoff import BEYOND
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene import library
from fefinger.scene.finger import STANDARD
from fefinger.support.arrays import Array
from fefinger.support.text import percent
from fefinger.theory.contact.ting import press_by_depth, radius_nodes
from fefinger.theory.relaxation import Prony, hereditary_integral


NAMES = ("hertz", "layered", "lumped")
"""Mechanics that are formulas or laws."""

CALIBRATED = "calibrated"
"""Tissue of the presses of fingers that were calibrated."""

NODES = 48
"""Depths at which the elastic forces are tabulated."""

MANY = 500
"""Half of the largest number of times at which forces are compared."""

CURVED = 2.0
"""Factor on the error bound of linear interpolation, for a curvature between two presses that is
larger than at them. Left out one at a time, all presses but that at 30 degrees are within it."""

HERTZIAN = 1.5
"""Exponent of force over depth at first touch."""


class Row(NamedTuple):
    """The presses of one finger on an axis, in their order, by angle in degrees or 1/mm."""

    places: Array
    presses: tuple[Measured, ...]


def error(candidate: Candidate, case: Situation, law: Prony | None = None) -> Known | None:
    """Return the error of the force of a formula, and its source; None without comparable presses.

    law: the relaxation of the lumped law, which answers by Eq. 2.3.
    """
    where = place(case.indenter)
    tissue = _tissue(case)
    if where is None or not tissue:
        return None
    axis, here = where
    main, own = row_of(candidate, tissue, MAIN, axis), _own(candidate, tissue, case, axis)
    if own is None and candidate.mechanics == "lumped":
        return None  # the law is of one finger
    if not (len(main.presses) and main.places[0] <= here <= main.places[-1]):
        return None
    low, high = _beside(main, here)
    part = _part(case, main.presses[low])
    if part > BEYOND * min(main.presses[at].part[-1] for at in (low, high)):
        return None
    curve = main.presses[low].part
    ratio = np.array([log_ratio(main, own, here, float(each)) for each in curve])
    margin = math.hypot(
        _between(main, here, part),
        0.0 if own is main else _fingers(candidate, tissue, axis, own, here, part),
        press_mesh.error(Candidate("solid", STANDARD), case).error,
    )
    moves = case.motion.control == "depth"
    carried = carrying.error(case, "force") if moves else 0.0
    back = moves and carrying.retreats(case.motion)
    if not back:  # on loading it is a share of the force that there is
        margin = math.hypot(margin, carried)
    if not math.isfinite(margin):
        return None
    ratios = (ratio, ratio - margin, ratio + margin)
    found, *bounds = _through(case, main.presses[low], ratios, part, law)
    more = max(*bounds, found) - found
    if back:  # on retreat one of the largest force: memory of what was deeper
        more = math.hypot(more, carried)
    names = " and ".join(main.presses[at].press for at in dict.fromkeys((low, high)))
    source = f"reports/{FORMULAS}, {names}: {percent(found)}, and {percent(more)} of margin"
    return Known(found + more, source)


def _tissue(case: Situation) -> str:
    """Name of the finger's tissue among those of the presses; empty for other tissue."""
    if case.measured_tissue:
        return library.PUBLISHED
    return CALIBRATED if press_mesh.stiffening(case.finger) else ""


@cache
def row_of(candidate: Candidate, tissue: str, subject: str, axis: str) -> Row:
    """Return the presses of a finger on an axis, "angle" or "curvature"."""
    found = {}
    for press in table().all(FORMULAS, "log ratio of force", candidate):
        row = press.conditions
        value = row[axis]
        if (row["tissue"], row["subject"]) == (tissue, subject) and value is not None:
            found[float(value)] = press
    places = sorted(found)
    return Row(np.array(places), tuple(found[each] for each in places))


def _own(candidate: Candidate, tissue: str, case: Situation, axis: str) -> Row | None:
    """Return the presses of the scene's own finger; None if it was not pressed along this axis."""
    finger = case.finger
    for subject in _subjects():
        row = row_of(candidate, tissue, subject, axis)
        if row.presses:
            size = tuple(row.presses[0].conditions["size_mm"])
            fitted = tissue == library.PUBLISHED or press_mesh.subject(finger) == subject
            if fitted and np.allclose(size, (finger.width, finger.thickness, finger.pad_radius)):
                return row
    return None


@cache
def _subjects() -> tuple[str, ...]:
    every = table().entries
    return tuple(dict.fromkeys(x.conditions["subject"] for x in every if x.report == FORMULAS))


def _beside(row: Row, here: float) -> tuple[int, int]:
    """Return the indices of the presses on either side of a place."""
    high = int(np.searchsorted(row.places, here - 1e-9))
    return max(high - (row.places[high] > here + 1e-9), 0), high


def log_ratio(main: Row, own: Row | None, here: float, part: float) -> float:
    """Return the log ratio at a place on the axis and a relative depth."""
    at_main = _values(main, part)
    found = float(np.interp(here, main.places, at_main))
    if own is None:
        return found
    more = _values(own, part) - np.interp(own.places, main.places, at_main)
    return found + float(np.interp(here, own.places, more))


def _values(row: Row, part: float) -> Array:
    """Return the log ratios (n,) of the presses of a row at a relative depth."""
    return np.array([np.interp(part, each.part, each.values) for each in row.presses])


def _between(row: Row, here: float, part: float) -> float:
    """Return the margin of a linear interpolation between two presses of a row, at a depth.

    CURVED f''/2 (x - a)(b - x), where f''/2 is the larger second divided difference at the two
    presses, of log ratios. Infinite where no press has one on either side.
    """
    low, high = _beside(row, here)
    if low == high:
        return 0.0
    slopes = np.diff(_values(row, part)) / np.diff(row.places)
    curved = np.abs(np.diff(slopes)) / (row.places[2:] - row.places[:-2])
    beside = [curved[at - 1] for at in (low, high) if 0 < at < len(row.places) - 1]
    distances = (here - row.places[low]) * (row.places[high] - here)
    return float(CURVED * max(beside, default=math.inf) * distances)


def _fingers(
    candidate: Candidate, tissue: str, axis: str, own: Row | None, here: float, part: float
) -> float:
    """Return the margin for the difference of a finger from that of MAIN.

    For a finger with presses of its own: half the deviation of a press of another finger from its
    interpolation without it, as leaving one out doubles the gap. For a finger without: the scatter
    between fingers of published tissue, which differ in size alone.
    """
    if own is None:
        return _quantile(_by_size(candidate, axis), part)
    if np.isclose(own.places, here).any():
        return 0.0
    return _quantile(_by_finger(candidate, tissue, axis), part) / 2


@cache
def _by_size(candidate: Candidate, axis: str) -> tuple[tuple[float, float], ...]:
    main, missed = row_of(candidate, library.PUBLISHED, MAIN, axis), list[tuple[float, float]]()
    for subject in _subjects():
        row = row_of(candidate, library.PUBLISHED, subject, axis)
        for at, press in zip(row.places, row.presses, strict=True):
            if subject != MAIN:
                missed += _missed(press, main, None, float(at))
    return tuple(missed)


@cache
def _by_finger(candidate: Candidate, tissue: str, axis: str) -> tuple[tuple[float, float], ...]:
    main, missed = row_of(candidate, tissue, MAIN, axis), list[tuple[float, float]]()
    for subject in _subjects():
        row = row_of(candidate, tissue, subject, axis)
        if subject == MAIN or len(row.presses) < 2:
            continue
        for at, press in enumerate(row.presses):
            others = Row(np.delete(row.places, at), _without(row.presses, at))
            missed += _missed(press, main, others, float(row.places[at]))
    return tuple(missed)


def _without(presses: tuple[Measured, ...], at: int) -> tuple[Measured, ...]:
    return (*presses[:at], *presses[at + 1 :])


def _missed(
    press: Measured, main: Row, own: Row | None, here: float
) -> Iterable[tuple[float, float]]:
    """Yield the relative depths of a press, and its deviations from the interpolation."""
    deepest = max(each.part[-1] for each in main.presses)
    for part, value in zip(press.part, press.values, strict=True):
        if part <= deepest:
            yield float(part), abs(float(value) - log_ratio(main, own, here, float(part)))


def _quantile(missed: tuple[tuple[float, float], ...], part: float) -> float:
    """Quantile QUANTILE of the deviations about a relative depth; infinite without any."""
    if not missed:
        return math.inf
    near = [value for at, value in missed if part / DEPTHS < at < part * DEPTHS]
    return float(np.quantile(near or [value for _, value in missed], QUANTILE))


def _part(case: Situation, press: Measured) -> float:
    """Return the largest relative depth of a scene; under force control by the force of a press."""
    forces = table().presses(FORMULAS, "force", Candidate("solid"))
    return case.depth_over_thickness(forces[press.press])


def _through(
    case: Situation, press: Measured, ratios: Iterable[Array], part: float, law: Prony | None
) -> list[float]:
    """Return the largest error of the force through time over its peak, for each curve of ratios.

    press: gives the force at finite strain over the depth; ratios: log ratios (n,) at its depths.
    Under force control the error is that at the depth reached.
    """
    if case.motion.control == "force":
        return [abs(math.expm1(float(np.interp(part, press.part, ratio)))) for ratio in ratios]
    true = table().presses(FORMULAS, "force", Candidate("solid"))[press.press].values
    prony = case.finger.prony
    time = _fewer(case.times)
    depth = np.asarray(case.motion.value(time)) / case.finger.thickness
    nodes = radius_nodes(part * (1 + 1e-9), NODES)
    curve = _forces(press.part, true, nodes)
    history = press_by_depth(prony, time, depth, nodes)
    right = history.stress(curve) / prony.long_time
    errors = []
    for ratio in ratios:
        formula = curve * np.exp(np.interp(nodes, press.part, ratio))
        if law is None:
            answered = history.stress(formula) / prony.long_time
        else:
            elastic = np.interp(depth, nodes, formula)
            answered = np.maximum(hereditary_integral(law, time, elastic), 0.0) / law.long_time
        errors.append(float(np.abs(answered - right).max() / right.max()))
    return errors


def _fewer(time: Array) -> Array:
    """Thin out the times to some 2 MANY: the first MANY, and equally many of the others.

    A motion of very many cycles or a very long one would take minutes. Both forces are evolved
    through the same thinned motion, so that their difference hardly changes.
    """
    rest = time[MANY:]
    if len(rest) <= MANY:
        return time
    return np.concatenate([time[:MANY], rest[:: -(-len(rest) // MANY)], time[-1:]])


def _forces(parts: Array, forces: Array, wanted: Array) -> Array:
    """Interpolate forces at depths, linear in force^(1 / HERTZIAN), extrapolated at the end."""
    roots = np.concatenate([[0.0], forces ** (1 / HERTZIAN)])
    known = np.concatenate([[0.0], parts])
    slope = (roots[-1] - roots[-2]) / (known[-1] - known[-2])
    beyond = np.maximum(wanted - known[-1], 0.0) * slope
    return np.asarray((np.interp(wanted, known, roots) + beyond) ** HERTZIAN)
