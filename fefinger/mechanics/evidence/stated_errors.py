"""The measured trade-off between speed and accuracy: stated errors and costs of every candidate.

A scene is placed between the presses of `reports/tradeoff.json`: a plate by its angle, a ball by
its curvature, of which that of the 30 degree plate is 0; and by its depth over the thickness of
the finger. The stated error lies between those of its neighbors, numerical and model error added,
with margins for what lies between presses, for motions, for other fingers and for the draw of the
mesh. So it is for the force and for what else is STATED.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import NamedTuple

from fefinger.mechanics.evidence import formulas, press_mesh, tradeoff
from fefinger.mechanics.evidence.mesh_scatter import DRAWN, scatter
from fefinger.mechanics.evidence.press_mesh import Known
from fefinger.mechanics.evidence.table import table
from fefinger.mechanics.evidence.tradeoff import REPORT
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.scene import library
from fefinger.scene.finger import RESOLUTIONS, Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import Ramp
from fefinger.support.text import percent


FARTHEST = 1.25
"""Depth over that of the deepest press beyond which errors of other reports are not used either.

At 30 degrees the forces of `solid` on the coarse and the standard mesh are 0.7 % apart there, 1 %
above it and 1.3 % at 1.58."""

PRESSED = "a.h."
"""Subject on whose finger the presses are."""


class Stated(NamedTuple):
    """A stated error with its margins, its two parts, and the source."""

    error: float
    numerical: float
    model: float
    source: str


def difference(case: Situation) -> str:
    """Name the feature of a scene without a stated error that no measured press has."""
    other = tradeoff.other_object(case.indenter)
    if other:
        return other
    if case.place is None:
        flat = case.indenter.flat
        plate = f"a plate at {flat.angle:g} degrees" if flat is not None else ""
        return plate or f"a ball of {case.indenter.ball_radius:g} mm"
    if not case.measured_tissue:
        surface = case.finger.surface is not None
        return f"a finger {'from a surface' if surface else 'of other tissue, bone or nail'}"
    return "a press so deep, or its object on this mesh"


def stated(candidate: Candidate, case: Situation, quantity: str = "force") -> Stated | None:
    """Return the stated error of a quantity.

    None where the scene is not like a measured press, or the candidate does not give it.
    """
    if case.place is None or not case.measured_tissue:
        return None
    mechanics, names = Candidate(candidate.mechanics), list(case.neighbors)
    deepest = max(case.deepest(name) for name in names)
    same_size = tradeoff.measured_size(case.finger, tradeoff.forces()[names[0]])
    read = tradeoff.interpolated if same_size or quantity == "force" else tradeoff.largest
    errors = read(table(), candidate, case.place, deepest, quantity)
    if errors is None:
        return None
    numerical = errors[0] + _rule(f"error of time steps, {quantity}", mechanics)
    model = errors[1] * _rule(f"factor of direct runs, {quantity}", mechanics)
    if quantity == "force" and not same_size:
        model *= _rule("factor of other fingers", mechanics)
    margins = [moving(motion_shares(candidate, quantity), names) * sum(errors)]
    if not same_size or len(names) > 1:
        margins.append(_rule(f"margin between presses, {quantity}", candidate))
    margins.append(DRAWN * scatter(candidate, deepest, quantity))
    margin = math.hypot(*margins)  # of causes that do not know of each other
    source = (
        f"reports/{REPORT}, {' and '.join(names)}: {percent(numerical)} of mesh and steps, "
        f"{percent(model)} of the model, {percent(margin)} of margin"
    )
    return Stated(numerical + model + margin, numerical, model, source)


def is_measured(candidate: Candidate, case: Situation) -> bool:
    """Return whether the error of the force was measured in a press like the scene."""
    found = measured(candidate, case)
    return found is not None and math.isfinite(found.error)


def _rule(quantity: str, candidate: Candidate) -> float:
    """Return a margin, a factor or an error of the trade-off."""
    return table().value(REPORT, quantity, candidate)


def motion_shares(candidate: Candidate, quantity: str) -> dict[str, float]:
    """Return the share by which the error through a motion exceeds that of the press, by press."""
    return table().values(REPORT, f"share of motion, {quantity}", candidate)


def moving(shares: Mapping[str, float], names: Collection[str]) -> float:
    """Return the largest share of some presses, see `motion_shares`; of all, if one is unknown."""
    known = names if all(name in shares for name in names) else shares
    return max((shares[name] for name in known), default=0.0)


def measured(candidate: Candidate, case: Situation, quantity: str = "force") -> Known | None:
    """Return the measured error of a quantity and its source.

    Where nothing comparable was measured: None for small strain; for finite strain the error is not
    a number, and the source states the reason.
    """
    if candidate.mechanics in formulas.NAMES and quantity == "force":
        formula = formulas.error(candidate, case)
        if formula is not None:
            return formula
    finite = MECHANICS[candidate.mechanics].finite
    own = None if finite else stated(candidate, case, quantity)
    if own is not None:
        return _on_its_mesh(own, candidate, case, quantity)
    if not finite and not _pressed(case):
        return None
    found = press_mesh.error(candidate, case, quantity)
    if not finite and math.isnan(found.error) and not case.measured_tissue:
        return None
    mesh = _of_mesh(candidate, case, quantity)
    if mesh is not None and mesh.error > found.error:
        found = mesh
    steps = _rule(f"error of time steps, {quantity}", Candidate(candidate.mechanics))
    return Known(math.hypot(found.error, steps), found.source)  # independent of the mesh


def _of_mesh(candidate: Candidate, case: Situation, quantity: str) -> Known | None:
    """Return the mesh error of a quantity other than the force, in presses under the same object.

    The mesh decides which points bear the pressure, whatever the tissue and the strain, so the
    comparison of meshes at finite strain applies. The force has evidence of its own.
    """
    if quantity == "force" or candidate.resolution is None:
        return None
    return press_mesh.error(Candidate("solid", candidate.resolution), case, quantity)


def _on_its_mesh(own: Stated, candidate: Candidate, case: Situation, quantity: str) -> Known:
    """Return a stated error with at least the mesh error of comparable presses."""
    mesh = _of_mesh(candidate, case, quantity)
    if mesh is None or not mesh.error > own.numerical:
        return Known(own.error, own.source)
    more = mesh.error - own.numerical
    return Known(own.error + more, f"{own.source}; of the mesh {mesh.source}")


def _pressed(case: Situation) -> bool:
    """Whether small strain was compared with finite strain on such a finger and object."""
    if case.indenter.raised:  # measured while they slide, by `reports.RAISED`
        return False
    published = case.measured_tissue and case.place is None
    return published or press_mesh.stiffening(case.finger)


def spikes(candidate: Candidate, case: Situation) -> dict[str, float]:
    """Return the largest errors of spike counts and first spikes in the base scenes, over types.

    "spike count": missing or extra spikes over all; "first spike": in s. Empty for a scene without
    a comparable press.
    """
    if case.place is None or not case.measured_tissue:
        return {}
    counts, firsts = (
        table().values(REPORT, f"spikes, {what}", candidate.measured).values()
        for what in ("count", "first_ms")
    )
    if not counts:
        return {}
    first = max(each for each in firsts if not math.isnan(each))
    return {"spike count": max(counts), "first spike": 1e-3 * first}


def without_press(
    candidate: Candidate, case: Situation, error: float, source: str
) -> tuple[float, str]:
    """Return the error of another report, with those of steps and motions added; and its source.

    It was measured under another object or on another finger, for which no margin is known. It is
    at least the stated error of the nearest plate or ball that was pressed, and not a number for
    scenes much deeper than the presses.
    """
    nearest = case.under(tradeoff.nearest(case.indenter))
    deep, deepest = _depths(case, nearest)
    if deep > FARTHEST * deepest and math.isfinite(error):
        return float("nan"), (
            f"not known: it goes to {deep:.2g} of the finger's thickness, and presses like it were "
            f"measured to {deepest:.2g}"
        )
    error *= 1 + _largest_share(candidate.mechanics)
    error += _rule("error of time steps, force", Candidate(candidate.mechanics))
    for bound in (stated(candidate, nearest), _least(candidate, case, nearest)):
        if bound is not None and bound.error > error:
            error, source = bound.error, bound.source
    return error, f"{source} (reports/{REPORT} has none for {difference(case)})"


def _largest_share(mechanics: str) -> float:
    """Return the largest share of any press and mesh, see `motion_shares`."""
    meshes = (None, *RESOLUTIONS)
    shares = [motion_shares(Candidate(mechanics, mesh), "force") for mesh in meshes]
    return max((share for each in shares for share in each.values()), default=0.0)


def _least(candidate: Candidate, case: Situation, nearest: Situation) -> Stated | None:
    """Return the stated error of the measured press nearest to a scene, at or near its depth.

    A lower bound for scenes of which less is known.
    """
    object_ = nearest.indenter
    plate_or_ball = object_.flat is not None or object_.ball_radius is not None
    indenter = object_ if plate_or_ball else Flat(30)
    pressed = replace(
        nearest, finger=Finger.subject(PRESSED, tissue=library.PUBLISHED), indenter=indenter
    )
    if pressed.place is None:
        return None
    presses = tradeoff.forces()
    deep = min(
        *(case.deepest(name) for name in pressed.neighbors),
        *(tradeoff.reach(presses[name]) for name in pressed.neighbors),
    )
    motion = Ramp(60.0, deep * pressed.finger.thickness, corner=0.0)
    return stated(candidate, replace(pressed, motion=motion))


def _depths(case: Situation, nearest: Situation) -> tuple[float, float]:
    """Return the relative depth of a scene, and that of its deepest neighboring press.

    For an object unlike all plates and balls: of all presses.
    """
    presses = tradeoff.forces()
    press = max(nearest.neighbors or presses, key=lambda name: tradeoff.reach(presses[name]))
    return case.deepest(press), tradeoff.reach(presses[press])
