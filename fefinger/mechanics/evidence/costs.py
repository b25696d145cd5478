"""Cost of every mechanics, and of meshes: expected CPU seconds, from the reports, and wall time."""

from collections.abc import Callable, Mapping
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fefinger.mechanics.evidence import vibration
from fefinger.mechanics.evidence.machine import slowness
from fefinger.mechanics.evidence.measured_tissue import PUBLISHED_LAW
from fefinger.mechanics.evidence.table import (
    SMALL_STRAIN_COST,
    SOLID_COST,
    TABULATION,
    Measured,
    read,
    table,
)
from fefinger.mechanics.press.discretization import needs_continuation
from fefinger.mechanics.press.load_steps import load_steps, tissue_relaxations
from fefinger.mechanics.press.notes import stiffens
from fefinger.mechanics.press.operator_cache import available, parities
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene.indenters import INDENTERS
from fefinger.scene.motion import Motion
from fefinger.support.checks import InputError
from fefinger.support.processes import threads
from fefinger.theory.relaxation import Prony


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

MESHES = ("coarse", "standard")
"""The measured meshes; the cost on the fine one is extrapolated in the number of unknowns."""

SIZE, LARGER = 140.0, 0.6
"""Width times thickness in mm² of the finger of most presses, and the exponent of cost over it:
unknowns on the coarse mesh grow as its root (12 560, 13 267 and 15 547 at 140, 161 and 221 mm²),
cost a little faster."""

TIMED = 0.16
"""Depth over the thickness of the press whose cost was measured."""

HARDER = 2.0
"""Exponent of the cost of deeper presses over the depth: 79 and 33 s at 0.28 of the
thickness under the plate at 30 degrees and the ball of 5 mm on the standard mesh."""

SHALLOW = 0.25
"""Cost of a press to first touch over that of one to TIMED: to 0.02, 0.04, 0.08 and 0.12 of the
thickness 0.3, 0.45, 0.65 and 0.85 under two balls, a bar and a cylinder on the coarse mesh, 0.36
and 0.7 to 0.02 and 0.08 under a ball on the standard one."""

SHARED = 0.64
"""Share of the CPU seconds of finite strain that threads divide among them: `flat-press` on the
standard mesh took 20.8 CPU s in two threads, of which the first took 14.2."""


def linear_seconds(case: Situation) -> float:
    """Return the expected CPU time of `linear` in s, from the times in the report."""
    return _spent("linear", case, 1.0 if case.half else WHOLE) + mesh_seconds(case)


def _seconds(candidate: Candidate, stage: str, report: str = SMALL_STRAIN_COST) -> float:
    """CPU seconds of a stage on this machine."""
    return table().value(report, f"{stage} seconds", candidate) * slowness(read(report))


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
        if store.available(finger, touch):
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
    longer = needs_continuation(case.finger, case.indenter, case.motion)
    if not available(case.finger, half=case.half, with_continuation=longer):
        spent += (1 if case.half else 2) * _seconds(Candidate("condensed", case.mesh), "build")
    return spent


def layered_seconds(case: Situation) -> float:
    """Return the expected CPU time of `layered` in s, from the times in the report."""
    seconds = partial(_seconds, Candidate("layered"))
    return seconds("setup") + len(case.times) * seconds("step")


class Cost(NamedTuple):
    """CPU seconds on half a finger: of setting up, of the press that scales spikes, of a step.

    `step` is that at first touch; its logarithm grows by `growth` times the relative depth, by
    `sharp` under an edge or ridge and by `stiffening` on tissue of another law; `deepest` is the
    largest relative depth that was timed.
    """

    setup: float
    reference: float
    step: float
    growth: float
    sharp: float
    stiffening: float
    deepest: float


@cache
def cost(mesh: str) -> Cost:
    """Return the cost on a mesh: medians of the presses, for steps a least-squares fit."""
    every = table().entries
    timed = [x for x in every if (x.report, x.quantity) == (SOLID_COST, "step seconds")]
    basis = [
        [
            *(each.candidate.resolution == name for name in MESHES),
            _part(each),
            INDENTERS[each.conditions["kind"]].sharp,
            each.conditions["law"] != PUBLISHED_LAW,
        ]
        for each in timed
    ]
    steps = np.log([each.value for each in timed])
    solution = np.linalg.lstsq(np.array(basis, dtype=float), steps, rcond=None)[0]
    growth, sharp, stiffening = solution[len(MESHES) :].tolist()
    rows = [
        [table().all(SOLID_COST, f"{stage} seconds", Candidate("solid", name)) for name in MESHES]
        for stage in ("setup", "reference")
    ]
    medians = [[np.median([each.value for each in there]) for there in row] for row in rows]
    costs = np.array([*medians, np.exp(solution[: len(MESHES)])])
    meshes = [Candidate("linear", name) for name in (*MESHES, mesh)]
    sizes = np.log([table().value(SMALL_STRAIN_COST, "unknowns", each) for each in meshes])
    power = np.diff(np.log(costs))[:, 0] / (sizes[1] - sizes[0])
    setup, reference, step = (costs[:, 1] * np.exp(power * (sizes[2] - sizes[1]))).tolist()
    deepest = max(map(_part, timed))
    return Cost(setup, reference, step, growth, sharp, stiffening, deepest)


def _part(timed: Measured) -> float:
    return float(timed.conditions["depth_mm"] / timed.conditions["thickness_mm"])


@lru_cache(maxsize=8)
def _steps(motion: Motion, relaxing: frozenset[Prony], friction: float, *, fast: bool) -> int:
    time = time_grid(motion, fast=fast)
    return len(load_steps(motion, time, relaxing, friction=friction).chosen)


def solid_seconds(case: Situation) -> float:
    """Return the expected CPU time of `solid` in s."""
    return _following(case) + mesh_seconds(case)


def _following(case: Situation) -> float:
    """CPU seconds of finite strain, without those of the mesh."""
    spent, finger = cost(case.mesh), case.finger
    relaxing, friction = tissue_relaxations(finger), case.indenter.kinetic
    steps = _steps(case.motion, relaxing, friction, fast="FAII" in case.ask.spikes)
    deep = min(case.depth_over_thickness, spent.deepest)
    harder = spent.growth * deep + spent.sharp * case.indenter.sharp
    layers = (finger.skin, finger.subcutaneous)
    harder += spent.stiffening * any(layer.law != PUBLISHED_LAW for layer in layers)
    whole = spent.setup + steps * spent.step * np.exp(harder)
    whole += spent.reference if case.ask.spikes else 0.0
    whole *= 1.0 if case.half else WHOLE
    whole *= (finger.width * finger.thickness / SIZE) ** LARGER
    return float(whole * slowness(read(SOLID_COST)))


def pressed_seconds(case: Situation) -> float:
    """Return the expected CPU time of `pressed` in s."""
    setup, step = (_of_table(case, stage) for stage in ("setup", "step"))
    return setup + len(case.times) * step + pressed_once(case)


def pressed_once(case: Situation) -> float:
    """Return the time in s of building mesh and press, which are kept; 0 where at hand."""
    return 0.0 if _press_at_hand(case) else building(case) + mesh_seconds(case)


def building(case: Situation) -> float:
    """Return the CPU time in s of solving the press of a scene; 0 where it is at hand."""
    if _press_at_hand(case):
        return 0.0
    deep = case.depth_over_thickness / TIMED
    if deep > 1.0:
        harder = deep**HARDER
    else:  # plates go on to that depth, so that other motions find their press
        harder = 1.0 if case.indenter.flat is not None else SHALLOW + (1 - SHALLOW) * deep
    return _of_table(case, "build") * harder


def _press_at_hand(case: Situation) -> bool:
    """Whether the press of a scene is shipped or cached, to its depth or force."""
    # Imported here, because costs are also read for scenes without a mesh.
    from fefinger.mechanics.press.depth_table import deepest_at_hand

    depth, force = deepest_at_hand(case.finger, case.indenter, case.motion)
    reached = case.motion.control.of(depth, force)
    return reached > 0 and reached >= case.motion.peak * (1 - 1e-9)


def _of_table(case: Situation, stage: str) -> float:
    """CPU seconds of a stage of `pressed` on the mesh of a scene."""
    mesh = "standard" if case.mesh == "fine" else case.mesh
    bodies = 1.0 if case.half or stage == "step" else WHOLE
    larger = FINE if case.mesh == "fine" and stage != "step" else 1.0
    return _seconds(Candidate("pressed", mesh), stage, TABULATION) * bodies * larger


def modal_seconds(case: Situation) -> float:
    """Return the expected CPU time of `modal` in s, besides that without inertia."""
    build, case = modal_once(case), vibration.of_inertia(case)
    bodies, steps = len(parities(half=case.half)), 2 * len(case.times)
    return bodies * _of_modes(case, "setup") + steps * _of_modes(case, "step") + build


def modal_once(case: Situation) -> float:
    """Return the time in s of building what inertia needs and is kept; 0 where at hand.

    Modes, and in tissue that stiffens an operator, which the mechanics without inertia lacks.
    """
    stiff, case = stiffens(case.finger), vibration.of_inertia(case)
    spent = condensed_once(case) if stiff else 0.0
    if available(case.finger, half=case.half, modes=True):
        return spent
    return spent + len(parities(half=case.half)) * _of_modes(case, "build")


def _of_modes(case: Situation, stage: str) -> float:
    """CPU seconds of a stage of `modal` for a body, on the mesh of a scene."""
    record, fine = read(vibration.REPORT), case.mesh == "fine"
    seconds: float = record["seconds"]["standard" if fine else case.mesh][stage]
    return seconds * (FINE if fine else 1.0) * slowness(record)


def _building_of_modal(case: Situation) -> float:
    """CPU seconds of the press that `modal` adds inertia to, on tissue that stiffens."""
    return building(case) if stiffens(case.finger) else 0.0


FINITE_STRAIN: Mapping[str, Callable[[Situation], float]] = {
    "solid": _following,
    "pressed": building,
    "modal": _building_of_modal,
}
"""Expected CPU seconds of finite strain within the cost of a mechanics."""


def wall(mechanics: str, case: Situation, seconds: float) -> float:
    """Convert expected CPU seconds of a mechanics to wall time in s on an idle machine.

    A share of the solution at finite strain uses as many cores as this process may use
    (`processes.threads`); everything else uses one.
    """
    if mechanics not in FINITE_STRAIN:
        return seconds
    return seconds - SHARED * (1 - 1 / threads()) * min(FINITE_STRAIN[mechanics](case), seconds)
