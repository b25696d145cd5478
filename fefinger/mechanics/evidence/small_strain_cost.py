"""Cost of the mechanics at small strain, and of meshes: CPU seconds, from the reports."""

from functools import partial
from pathlib import Path

from fefinger.mechanics.evidence.machine import slowness
from fefinger.mechanics.evidence.table import SMALL_STRAIN_COST, read, table
from fefinger.mechanics.press.discretization import continued
from fefinger.mechanics.press.operator_cache import at_hand
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.support.checks import InputError


SLIDING = 20.0
"""Time of a step along a path over one of a press: 15 to 25 over dots, letters and gratings."""

GRIPPING = 10.0
"""Time of a step with friction over one without, of the cases of the bench `sliding`."""

NARROW = 0.3
"""Time of reading the area of contact under other objects over that under a plate: 0.1 to 0.4."""

STEEPEST = 45.0
"""Angle of a plate in degrees beyond which contact leaves the part of the pad that `condensed` is
reduced to, at depths of a tenth of the thickness."""

MORPH_SECONDS = {"coarse": 0.7, "standard": 1.2, "fine": 1.5}
"""CPU seconds of morphing a shipped mesh to half a finger, on the machine of the reports."""

MESH_SECONDS = {"coarse": 8.0, "standard": 20.0, "fine": 50.0}
"""The same of meshing it anew: once where the first attempt passes, up to four times that; of the
fine one in proportion to its unknowns, it was not timed."""

SCAN_SECONDS, SCAN_SECONDS_PER_MEGABYTE = 3.5, 1.0
"""The same of the shape of a surface file, of few triangles and of many."""

FINE = 2.5
"""Cost on the fine mesh over that on the standard one, as their unknowns; not measured."""

WHOLE = 3.0
"""Cost of a whole finger against half of one: twice the unknowns and loads, a larger factor."""


def linear_seconds(case: Situation) -> float:
    """Return the expected CPU time of `linear` in s, from the times in the report."""
    return _spent("linear", case, 1.0 if case.half else WHOLE) + mesh_seconds(case)


def _seconds(candidate: Candidate, stage: str) -> float:
    """Return the CPU seconds of a stage on this machine."""
    seconds = table().value(SMALL_STRAIN_COST, f"{stage} seconds", candidate)
    return seconds * slowness(read(SMALL_STRAIN_COST))


def _spent(mechanics: str, case: Situation, bodies: float) -> float:
    """Return the expected time in s of a press of a body `bodies` times as large as half a finger.

    The area is read where contact changes.
    """
    seconds = partial(_seconds, Candidate(mechanics, case.mesh))
    setup, fields = seconds("setup"), seconds("fields")
    spent = bodies * (setup + fields if case.ask.fields else setup)
    factor = (SLIDING if case.motion.slides else 1.0) * (
        GRIPPING if case.indenter.friction else 1.0
    )
    spent += len(case.times) * seconds("step") * factor
    return spent + areas(case) * seconds("area") if case.ask.pressure else spent


def areas(case: Situation) -> float:
    """Count the contact areas that are read, each by its cost over that of one under a plate."""
    return case.changes * (1.0 if case.indenter.flat is not None else NARROW)


def mesh_seconds(case: Situation, *, follow: bool = True) -> float:
    """Return the expected time in s to build the mesh of a scene, none where it is at hand.

    `follow`: that is the mesh that follows the touch.
    """
    from fefinger.mesh import store

    finger, touch = case.finger, case.touch if follow else None
    try:
        if store.at_hand(finger, touch):
            return 0.0
        seconds = MORPH_SECONDS if store.morphed(finger, touch) else MESH_SECONDS
    except InputError:  # no mesh can be made for a finger of this size
        return 0.0
    spent = seconds[case.mesh]
    if finger.surface is not None:
        megabytes = Path(finger.surface).stat().st_size / 1e6
        spent += SCAN_SECONDS + SCAN_SECONDS_PER_MEGABYTE * megabytes
    return spent * slowness({})


def condensed_seconds(case: Situation) -> float:
    """Return the expected CPU time of `condensed` in s: more, if its operator is to be built.

    A whole finger is two halves. Under a steep plate the whole mesh is expected to be solved too.
    """
    whole = _spent("condensed", case, 1.0 if case.half else 2.0) + condensed_once(case)
    plate = case.indenter.plate
    steep = plate is not None and plate.angle > STEEPEST
    return whole + linear_seconds(case) if steep else whole


def condensed_once(case: Situation) -> float:
    """Return the time in s of building mesh and operator, which are kept; 0 where at hand."""
    spent = mesh_seconds(case, follow=False)
    longer = continued(case.finger, case.indenter, case.motion)
    if not at_hand(case.finger, half=case.half, continued=longer):
        spent += (1 if case.half else 2) * _seconds(Candidate("condensed", case.mesh), "build")
    return spent


def layered_seconds(case: Situation) -> float:
    """Return the expected CPU time of `layered` in s, from the times in the report."""
    seconds = partial(_seconds, Candidate("layered"))
    return seconds("setup") + len(case.times) * seconds("step")
