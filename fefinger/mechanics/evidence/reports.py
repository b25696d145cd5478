"""Measured cost and error of the mechanics at small strain, and cost of meshes, by the reports."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fefinger.mechanics.evidence import table
from fefinger.mechanics.evidence.machine import slowness
from fefinger.mechanics.evidence.table import Measured, read
from fefinger.mechanics.press.continuation import continued
from fefinger.mechanics.press.operator_cache import at_hand
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene.finger import RESOLUTIONS
from fefinger.scene.indenter import Indenter
from fefinger.support.checks import InputError
from fefinger.support.text import percent


LINEAR_RADIUS = 2.0
"""Radius of an indenter in mm below which the mesh error of `linear` was not measured."""

LINEAR_EDGE = 1.0
"""Radius of an edge, ridge or crest in mm below which the mesh error has not been measured."""

PIN_EDGE = 0.2
"""Radius of the edge of the pin in mm for which the mesh error is measured; a pin is 1 mm wide."""

FACETS = {"coarse": 0.8, "standard": 0.42, "fine": 0.3}
"""Length in mm of the facets of the pad where it is touched, by resolution."""

FEWEST = 1.0
"""Facets per contact radius, below which the force is off by 10 % and more: on the coarse mesh,
against the standard one, -65 % at 0.3 facets, 10 % at 0.5, -1 to -3 % at 0.8 to 0.9."""

SOLID_SUBJECT = "a.h."
"""The subject on whose finger the errors of `solid` and `linear` are measured."""

RAISED = {"coarse": 0.30, "standard": 0.13, "fine": 0.08}
"""Error of the mean force on raised dots 0.7 mm wide that are scanned, by the mesh: against that
extrapolated from all three; letters and Braille have wider parts and err less (validation/friction,
`mesh.py`)."""

GRIPPING = 10.0
"""Time of a step with friction over one without, of the cases of the bench `sliding`."""

LAYERED_PRESSES = {"sphere-2": 2.0, "sphere-5": 5.0, "flat-30": float("inf")}
"""Objects under which `layered` was measured against `linear`, and their radii in mm."""

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

WHOLE = 3.0
"""Cost of a whole finger against half of one: twice the unknowns and loads, a larger factor."""


LINEAR, CONDENSED, LAYERED, SOLID = map(Candidate, ("linear", "condensed", "layered", "solid"))

MESH_ERROR = "numerical error of force"
"""Error of the force against the extrapolated mesh."""


def linear_seconds(case: Situation) -> float:
    """Return the expected CPU time of `linear` in s, from the times in the report."""
    whole = _spent(table.LINEAR, LINEAR, case, 1.0 if case.half else WHOLE)
    return whole * slowness(read(table.LINEAR)) + mesh_seconds(case)


def _seconds(report: str, candidate: Candidate, stage: str) -> float:
    """Return the measured CPU seconds of a stage."""
    return table.table().value(report, f"{stage} seconds", candidate)


def _spent(report: str, mechanics: Candidate, case: Situation, bodies: float) -> float:
    """Return the expected time in s of a press as in a report, of a body `bodies` times as large.

    The area is that of the whole pad, and read where contact changes.
    """
    seconds = partial(_seconds, report, replace(mechanics, resolution=case.mesh))
    setup, fields = seconds("setup"), seconds("fields")
    spent = bodies * (setup + fields if case.ask.fields else setup)
    spent += len(case.times) * seconds("step") * (GRIPPING if case.indenter.friction else 1.0)
    return spent + case.changes * seconds("area") if case.ask.pressure else spent


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
    whole = _spent(table.CONDENSED, CONDENSED, case, 1.0 if case.half else 2.0)
    whole = whole * slowness(read(table.CONDENSED)) + condensed_once(case)
    plate = case.indenter.plate
    steep = plate is not None and plate.angle > STEEPEST
    return whole + linear_seconds(case) if steep else whole


def condensed_once(case: Situation) -> float:
    """Return the time in s of building mesh and operator, which are kept; 0 where at hand."""
    spent = mesh_seconds(case, follow=False)
    longer = continued(case.finger, case.indenter, case.motion)
    if not at_hand(case.finger, half=case.half, continued=longer):
        build = _seconds(table.CONDENSED, replace(CONDENSED, resolution=case.mesh), "build")
        spent += (1 if case.half else 2) * build * slowness(read(table.CONDENSED))
    return spent


def linear_error(case: Situation) -> tuple[float, str]:
    """Return the measured error of the force of `linear`, and its source.

    The sum of the errors of the mesh and of small strain.
    """
    mesh, press = linear_mesh_error(case)
    return _with_small_strain(case, mesh, f"reports/{table.LINEAR}, {press}")


def condensed_error(case: Situation) -> tuple[float, str]:
    """Return the measured error of the force of `condensed`, and its source, as `linear_error`.

    Its mesh is that of the 30 degree plate and does not follow the touch.
    """
    mesh, press = _mesh_error(table.CONDENSED, CONDENSED, case)
    return _with_small_strain(case, mesh, f"reports/{table.CONDENSED}, {press}")


def linear_mesh_error(case: Situation) -> tuple[float, str]:
    """Return the measured error of the force against the extrapolated mesh, and on which press."""
    return _mesh_error(table.LINEAR, LINEAR, case)


def _mesh_error(report: str, mechanics: Candidate, case: Situation) -> tuple[float, str]:
    """Return the error of a mesh, at least that of the finer ones (it may be small by chance).

    The press is the nearest to the scene: by angle for a plate, by the smallest radius for a round
    indenter. Infinite where the mesh is too coarse.
    """
    if case.indenter.raised:
        return RAISED[case.mesh], "raised parts as of reports/friction.json"
    finer = RESOLUTIONS[RESOLUTIONS.index(case.mesh) :]
    candidates = [replace(mechanics, resolution=name) for name in finer]
    rows = [table.table().presses(report, MESH_ERROR, candidate) for candidate in candidates]
    press = linear_press(case.indenter, tuple(rows[0]))
    errors = [row[press].value for row in rows if press in row]
    if np.isnan(errors[0]):
        return float("inf"), press
    return max(0.0 if np.isnan(error) else error for error in errors), press


def _with_small_strain(case: Situation, mesh: float, source: str) -> tuple[float, str]:
    strain = small_strain_error(case)
    if np.isinf(mesh):
        return mesh, f"{source}: the mesh is too coarse for it"
    both = (
        f"{source}: {percent(mesh)} of the mesh; reports/{table.SOLID}, {solid_press(case)}: "
        f"{percent(strain)} of small strain"
    )
    return mesh + strain, both


def linear_radius(case: Situation) -> float:
    """Return the smallest radius in mm for which the mesh error of `linear` is measured."""
    if case.indenter.kind == "pin":
        return PIN_EDGE
    return LINEAR_EDGE if case.indenter.sharp else LINEAR_RADIUS


def linear_press(indenter: Indenter, presses: tuple[str, ...]) -> str:
    """Return the name of the measured press nearest to that of an indenter."""
    flat = indenter.flat
    if flat is not None:
        angles = {press: float(press[5:]) for press in presses if press.startswith("flat-")}
        return min(angles, key=lambda press: abs(angles[press] - flat.angle))
    if indenter.kind == "pin" and "pin" in presses:
        return "pin"
    if indenter.sharp:
        return "edge" if indenter.plate is None else "grating"
    return "sphere-5" if indenter.least_radius >= 5 else "sphere-2"


def layered_seconds(case: Situation) -> float:
    """Return the expected CPU time of `layered` in s, from the times in the report."""
    seconds = partial(_seconds, table.LAYERED, LAYERED)
    return (seconds("setup") + len(case.times) * seconds("step")) * slowness(read(table.LAYERED))


def layered_error(indenter: Indenter, depth: float) -> tuple[float, str]:
    """Return the measured error of the force of `layered` at `depth` mm, and its source.

    The largest of four fingers; linear between the measured depths, constant beyond them.
    """
    measured = _layered_curve(indenter)
    source = f"reports/{table.LAYERED}, {measured.press}: against linear, the worst of four fingers"
    return measured.at(depth), source


def layered_depth(indenter: Indenter) -> float:
    """Return the largest depth in mm at which `layered` was measured under such an indenter."""
    return _layered_curve(indenter).deepest


def layered_tissue() -> Mapping[str, Any]:
    """Return the tissue of the fingers on which `layered` was measured."""
    return table.table().all(table.LAYERED, "error of force", LAYERED)[0].conditions


def _layered_curve(indenter: Indenter) -> Measured:
    """Return the error of `layered` over the depth under an indenter."""
    curves = table.table().presses(table.LAYERED, "error of force", LAYERED)
    return curves[layered_press(indenter)]


def layered_press(indenter: Indenter) -> str:
    """Return the press with the next blunter object: the error grows with bluntness."""
    radius = max(indenter.hertzian or (indenter.least_radius,))
    blunter = [press for press, measured in LAYERED_PRESSES.items() if measured >= radius]
    return min(blunter, key=LAYERED_PRESSES.__getitem__)


def _forces(mechanics: Candidate, quantity: str = "force") -> dict[str, Measured]:
    """Return the forces of a mechanics on the finger of SOLID_SUBJECT, by object."""
    curves = table.table().presses(table.SOLID, quantity, mechanics)
    own = {press: f"{SOLID_SUBJECT}/{press}" for press in LAYERED_PRESSES}
    return {press: curves[name] for press, name in own.items() if name in curves}


def solid_press(case: Situation) -> str:
    """Return the press with the next blunter object that was measured to the depth of the scene.

    The error of small strain grows with bluntness; edges and ridges count as a plate.
    """
    if case.indenter.sharp:
        return "flat-30"
    radius, forces = case.indenter.least_radius, _forces(SOLID)
    for press in sorted(forces, key=LAYERED_PRESSES.__getitem__):
        deep_enough = case.depth_over_thickness(forces[press]) <= solid_reach(press)
        if LAYERED_PRESSES[press] >= radius and deep_enough:
            return press
    return "flat-30"


def solid_reach(press: str) -> float:
    """Return the largest depth over the finger's thickness at which a press was measured."""
    return float(_forces(SOLID)[press].part[-1])


def small_strain_part(case: Situation) -> float:
    """Return the relative depth of a scene, which determines the error of small strain."""
    return case.depth_over_thickness(_forces(SOLID)[solid_press(case)])


def small_strain_error(case: Situation) -> float:
    """Return the measured difference of the forces of `linear` and `solid` to the scene's depth.

    The largest difference up to a depth over the force there; linear between the measured depths,
    constant beyond them, 0 at first touch; of relaxing tissue where that was measured.
    """
    press = solid_press(case)
    relaxing = _forces(SOLID, "relaxing force").get(press)
    complete = relaxing is not None and not np.isnan(relaxing.values).any()
    quantity = "relaxing force" if complete else "force"
    small, finite = (_forces(mechanics, quantity)[press] for mechanics in (LINEAR, SOLID))
    differences = np.abs(small.values - finite.values)
    errors = np.maximum.accumulate(differences) / finite.values
    return float(np.interp(small_strain_part(case), [0.0, *finite.part], [0.0, *errors]))
