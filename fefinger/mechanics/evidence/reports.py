"""What the reports have measured of each mechanics: the source of its stated cost and error."""

import json
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from fefinger.mechanics.evidence.machine import slowness
from fefinger.mechanics.press.operator_cache import at_hand
from fefinger.mechanics.situation import Situation
from fefinger.scene.finger import RESOLUTIONS
from fefinger.scene.indenter import (
    Indenter,
)
from fefinger.support.checks import InputError
from fefinger.support.package_data import report
from fefinger.support.text import percent


LINEAR_RADIUS = 2.0
"""Radius of an indenter in mm below which the mesh error of `linear` has not been measured."""

LINEAR_EDGE = 1.0
"""Radius of an edge, ridge or crest in mm below which the mesh error has not been measured."""

FACETS = {"coarse": 0.8, "standard": 0.42, "fine": 0.3}
"""Length in mm of the facets of the pad where it is touched, by resolution."""

FEWEST = 1.0
"""Facets per contact radius, below which the force is off by 10 % and more: on the coarse mesh,
against the standard one, -65 % at 0.3 facets, 10 % at 0.5, -1 to -3 % at 0.8 to 0.9."""

LINEAR_REPORT = "linear-mesh.json"

LAYERED_REPORT = "layered-force.json"

SOLID_REPORT = "solid-force.json"

SOLID_SUBJECT = "a.h."
"""The subject on whose finger the errors of `solid` and `linear` are measured."""

LAYERED_PRESSES = {"sphere-2": 2.0, "sphere-5": 5.0, "flat-30": float("inf")}
"""Objects under which `layered` was measured against `linear`, and their radii in mm."""

CONDENSED_REPORT = "condensed-cost.json"

STEEPEST = 45.0
"""Angle of a plate in degrees beyond which contact leaves the part of the pad that `condensed` is
reduced to, at depths of a tenth of the thickness."""

MESH_SECONDS = {"coarse": 4.5, "standard": 11.0, "fine": 27.0}
"""CPU seconds of building the mesh of half a finger on the machine of the reports; of the fine one
in proportion to its unknowns, it was not timed."""

WHOLE = 3.0
"""Cost of a whole finger against half of one: twice the unknowns and loads, a larger factor."""


@cache
def read(name: str) -> dict[str, Any]:
    """Return a report."""
    measured: dict[str, Any] = json.loads(report(name))
    return measured


def linear() -> dict[str, Any]:
    """Return the mesh convergence and timing of `linear`, by resolution."""
    resolutions: dict[str, Any] = read(LINEAR_REPORT)["resolutions"]
    return resolutions


def linear_seconds(case: Situation) -> float:
    """Return the expected wall time of `linear` in s, from the times in the report."""
    whole = _spent(linear()[case.mesh], case, 1.0 if case.half else WHOLE)
    return whole * slowness(read(LINEAR_REPORT)) + mesh_seconds(case)


def _spent(row: Mapping[str, Any], case: Situation, bodies: float) -> float:
    """Return the expected time in s of a press as that of a row, on so many times its body.

    The area is that of the whole pad, and read where contact changes.
    """
    setup, fields = float(row["setup_seconds"]), float(row["fields_seconds"])
    spent = bodies * (setup + fields if case.ask.fields else setup)
    spent += len(case.times) * float(row["step_seconds"])
    areas = case.changes * float(row["area_seconds"])
    return spent + areas if case.ask.pressure else spent


def mesh_seconds(case: Situation, *, follow: bool = True) -> float:
    """Return the expected time in s to build the mesh of a scene, none where it is at hand.

    `follow`: that is the mesh that follows the touch.
    """
    from fefinger.mesh.store import at_hand as built

    try:
        if built(case.finger, case.touch if follow else None):
            return 0.0
    except InputError:  # no mesh can be made for a finger of this size
        return 0.0
    return MESH_SECONDS[case.mesh] * slowness({})


def condensed() -> dict[str, Any]:
    """Return the cost of the operator of `condensed` and of its use, by resolution."""
    resolutions: dict[str, Any] = read(CONDENSED_REPORT)["resolutions"]
    return resolutions


def condensed_seconds(case: Situation) -> float:
    """Return the expected wall time of `condensed` in s: more, if its operator is to be built.

    A whole finger is two halves. Under a steep plate the whole mesh is expected to be solved too.
    """
    whole = _spent(condensed()[case.mesh], case, 1.0 if case.half else 2.0)
    whole = whole * slowness(read(CONDENSED_REPORT)) + condensed_once(case)
    plate = case.indenter.plate
    steep = plate is not None and plate.angle > STEEPEST
    return whole + linear_seconds(case) if steep else whole


def condensed_once(case: Situation) -> float:
    """Return the time in s of building mesh and operator, which are kept; 0 where at hand."""
    spent = mesh_seconds(case, follow=False)
    if not at_hand(case.finger, half=case.half):
        build = float(condensed()[case.mesh]["build_seconds"])
        spent += (1 if case.half else 2) * build * slowness(read(CONDENSED_REPORT))
    return spent


def linear_error(case: Situation) -> tuple[float, str]:
    """Return the measured error of the force of `linear`, and its source.

    It is the sum of the errors of the mesh and of small strain, which do not know of each other.
    """
    mesh, press = linear_mesh_error(case)
    return _with_small_strain(case, mesh, f"reports/{LINEAR_REPORT}, {press}")


def condensed_error(case: Situation) -> tuple[float, str]:
    """Return the measured error of the force of `condensed`, and its source, as `linear_error`.

    Its mesh is that of the 30 degree plate and does not follow the touch.
    """
    measured: dict[str, dict[str, float | None]] = read(CONDENSED_REPORT)["force_error"]["presses"]
    press = linear_press(case.indenter, tuple(measured[case.mesh]))
    mesh = _of_mesh({name: row[press] for name, row in measured.items()}, case.mesh)
    return _with_small_strain(case, mesh, f"reports/{CONDENSED_REPORT}, {press}")


def _of_mesh(errors: Mapping[str, float | None], resolution: str) -> float:
    """Return the error of a mesh, at least that of the finer ones: a small one may be by chance."""
    if errors[resolution] is None:
        return float("inf")
    finer = RESOLUTIONS[RESOLUTIONS.index(resolution) :]
    return max(errors.get(name) or 0.0 for name in finer)


def _with_small_strain(case: Situation, mesh: float, source: str) -> tuple[float, str]:
    strain = small_strain_error(case)
    if np.isinf(mesh):
        return mesh, f"{source}: the mesh is too coarse for it"
    both = (
        f"{source}: {percent(mesh)} of the mesh; reports/{SOLID_REPORT}, {solid_press(case)}: "
        f"{percent(strain)} of small strain"
    )
    return mesh + strain, both


def linear_mesh_error(case: Situation) -> tuple[float, str]:
    """Return the measured error of the force against the extrapolated mesh, and on which press.

    The press is the one next to the scene's: by angle for a plate, by the smallest radius for a
    round indenter.
    """
    press = linear_press(case.indenter, tuple(linear()[case.mesh]["force_error"]))
    errors = {name: row["force_error"][press] for name, row in linear().items()}
    return _of_mesh(errors, case.mesh), press


def linear_radius(case: Situation) -> float:
    """Return the smallest radius in mm for which the mesh error of `linear` is measured."""
    return LINEAR_EDGE if case.indenter.sharp else LINEAR_RADIUS


def linear_press(indenter: Indenter, presses: tuple[str, ...]) -> str:
    """Return which of the measured presses is next to that of an indenter."""
    flat = indenter.flat
    if flat is not None:
        angles = {press: float(press[5:]) for press in presses if press.startswith("flat-")}
        return min(angles, key=lambda press: abs(angles[press] - flat.angle))
    if indenter.sharp:
        return "edge" if indenter.plate is None else "grating"
    return "sphere-5" if indenter.least_radius >= 5 else "sphere-2"


def layered() -> dict[str, Any]:
    """Return the force of `layered` against `linear`, by press and depth, and its timing."""
    return read(LAYERED_REPORT)


def layered_seconds(case: Situation) -> float:
    """Return the expected wall time of `layered` in s, from the times in the report."""
    steps = len(case.times)
    whole = float(layered()["setup_seconds"]) + steps * float(layered()["step_seconds"])
    return whole * slowness(layered())


def layered_error(indenter: Indenter, depth: float) -> tuple[float, str]:
    """Return the measured error of the force of `layered` at `depth` mm, and its source.

    It is that of the subject whose finger is worst; linear between the measured depths, and
    constant beyond their ends.
    """
    press = layered_press(indenter)
    row = layered()["presses"][press]
    depths, errors = row["depth_mm"], row["force_error"]
    source = f"reports/{LAYERED_REPORT}, {press}: against linear, the worst of four fingers"
    return float(np.interp(depth, depths, errors)), source


def layered_depth(indenter: Indenter) -> float:
    """Return the largest depth in mm at which `layered` was measured under such an indenter."""
    return float(layered()["presses"][layered_press(indenter)]["depth_mm"][-1])


def layered_press(indenter: Indenter) -> str:
    """Return the measured press whose object is next blunter, because the error grows with it."""
    radius = max(indenter.hertzian or (indenter.least_radius,))
    blunter = [press for press, measured in LAYERED_PRESSES.items() if measured >= radius]
    return min(blunter, key=LAYERED_PRESSES.__getitem__)


def solid() -> dict[str, Any]:
    """Return the forces of `solid` and of everything cheaper, by press, of one subject."""
    rows: dict[str, Any] = read(SOLID_REPORT)["rows"]
    own = {press: f"{SOLID_SUBJECT}/{press}" for press in LAYERED_PRESSES}
    return {press: rows[name] for press, name in own.items() if name in rows}


def solid_press(case: Situation) -> str:
    """Return the measured press whose object is next blunter and that was measured so deep.

    Small strain errs more under a blunter object; an edge or ridge is none of these.
    """
    if case.indenter.sharp:
        return "flat-30"
    radius = case.indenter.least_radius
    for press in sorted(solid(), key=LAYERED_PRESSES.__getitem__):
        if LAYERED_PRESSES[press] >= radius and _part(case, press) <= solid_reach(press):
            return press
    return "flat-30"


def solid_reach(press: str) -> float:
    """Return the largest depth over the finger's thickness at which a press was measured."""
    row = solid()[press]
    return float(row["depth_mm"][-1] / row["thickness_mm"])


def small_strain_part(case: Situation) -> float:
    """Return the depth of the scene over the finger's thickness, which small strain errs by."""
    return _part(case, solid_press(case))


def small_strain_error(case: Situation) -> float:
    """Return the measured difference of the forces of `linear` and `solid` to the scene's depth.

    It is the largest on the way, of the force there; linear between the measured depths, constant
    beyond them, and none at first touch; of tissue that relaxes, where that was measured.
    """
    press = solid_press(case)
    row = solid()[press]
    parts = np.array([0.0, *row["depth_mm"]]) / row["thickness_mm"]
    told = (row["relaxing_N"], row["force_N"])
    forces = next(each for each in told if each and None not in each["solid"])
    small, finite = (np.array(forces[name]) for name in ("linear", "solid"))
    apart = np.maximum.accumulate(np.abs(small - finite)) / finite
    return float(np.interp(_part(case, press), parts, [0.0, *apart]))


def _part(case: Situation, press: str) -> float:
    row = solid()[press]
    return case.depth_over_thickness(row, row["force_N"]["solid"])


def solid_error(case: Situation) -> tuple[float, str]:
    """Return the measured error of the force against the extrapolated mesh, and its source.

    It is that of `linear` under the object most like the scene's, or that of `solid` where that is
    larger: measured under fewer objects and, for the fine mesh, on the standard one.
    """
    error, press = linear_mesh_error(case)
    source = f"reports/{LINEAR_REPORT}, {press}"
    own = linear_press(case.indenter, tuple(solid()))
    errors = solid().get(own, {"mesh_error": None})["mesh_error"]
    resolution = case.mesh
    if errors is not None:
        measured = errors["standard" if resolution == "fine" else resolution]
        if measured > error:
            error, source = measured, f"reports/{SOLID_REPORT}, {own}"
    return error, f"{source}: of the mesh, not of the model"
