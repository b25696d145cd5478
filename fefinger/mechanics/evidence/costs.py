"""Cost of every mechanics, and of meshes: expected CPU seconds and wall time.

`reports/evidence.json` holds the seconds of each stage of a mechanics on a mesh, on the machine of
the reports, and how those of finite strain grow with the depth, by a regression
(`validation/evidence/cost_table.py`). What a scene adds are counts of steps, of bodies, of units
and of end organs that it asks for.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from fefinger.mechanics.evidence import vibration
from fefinger.mechanics.evidence.presses import EVIDENCE, read
from fefinger.mechanics.press.load_steps import load_steps, stride_of, tissue_relaxations
from fefinger.mechanics.press.mesh_limits import needs_continuation
from fefinger.mechanics.press.notes import stiffens
from fefinger.mechanics.press.operator_cache import available, parities
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS
from fefinger.scene.ask import Ask, Disc, Grid, Layout, Line, Places, innervation
from fefinger.scene.motion import Motion
from fefinger.support.checks import InputError
from fefinger.support.machine import slowness
from fefinger.support.processes import threads
from fefinger.support.vocabulary import FAMILIES
from fefinger.theory.relaxation import Prony


FINER = {"FAII": 2.0}
"""Steps of a membrane of a type over those of the other types."""


def units(ask: Ask) -> dict[str, float]:
    """Return the number of units of each type that `ask` describes; some may lie beside the pad."""
    return units_of(ask.population, ask.spikes)


def units_of(layout: Layout | None, types: Sequence[str]) -> dict[str, float]:
    """Return the number of units of each of `types` in a layout, before rounding."""
    if isinstance(layout, Disc):
        rows, area = innervation(), 0.01 * math.pi * layout.radius**2
        return {kind: area * layout.densities.get(kind, rows[kind].density) for kind in types}
    each = 1.0
    if isinstance(layout, Grid):
        # Imported here, because costs are also read for scenes without spikes.
        from fefinger.neural.populations import squares

        each = float(len(squares(layout.spacing, layout.radius)))
    elif isinstance(layout, Line):
        each = float(layout.count)
    elif isinstance(layout, Places):
        each = float(len(layout.places))
    return dict.fromkeys(types, each)


def organs(ask: Ask) -> float:
    """Return the expected number of end organs: one of each unit, or the mean of the published."""
    branched = ask.population is not None and ask.population.branched
    rows = innervation()
    return sum(
        count * (sum(rows[kind].organs) / 2 if branched else 1.0)
        for kind, count in units(ask).items()
    )


def blocks(ask: Ask) -> float:
    """Return the number of blocks of units that advance together; finer steps count more."""
    by_step: dict[float, float] = {}
    for kind, count in units(ask).items():
        finer = FINER.get(kind, 1.0)
        by_step[finer] = by_step.get(finer, 0.0) + count
    abreast = 16  # units of a family of the package that are advanced together
    return sum(finer * math.ceil(count / abreast) for finer, count in by_step.items())


STEEPEST = 45.0
"""Angle of a plate in degrees beyond which contact leaves the part of the pad that `condensed` is
reduced to, at depths of a tenth of the thickness."""

BESIDE = 8.0
"""Expected seconds of an answer from which on its spikes are checked beside it, in a process of
their own."""


def coefficients() -> Mapping[str, Any]:
    """Return the coefficients of cost of the report; see `validation/evidence/cost_table.py`."""
    return dict(read(EVIDENCE)["costs"])


def seconds(mechanics: str, stage: str, mesh: str = "") -> float:
    """Return the CPU seconds of a stage of a mechanics on half a finger, on this machine."""
    stages = coefficients()["seconds"][f"{mechanics} {mesh}".rstrip()]
    return float(stages[stage]) * slowness({})


def _whole() -> float:
    """Return the cost on a whole finger over that on half of one, which has half the unknowns."""
    return float(2 ** coefficients()["power"])


def linear_seconds(case: Situation) -> float:
    """Return the expected CPU time of `linear` in s."""
    return _spent("linear", case, 1.0 if case.half else _whole()) + mesh_seconds(case)


def _spent(mechanics: str, case: Situation, bodies: float) -> float:
    """Return the expected time in s of a press of a body `bodies` times as large as half a finger.

    The area is read where contact changes.
    """
    spent = bodies * seconds(mechanics, "setup", case.mesh)
    if case.ask.fields:
        spent += bodies * seconds(mechanics, "fields", case.mesh)
    grows = coefficients()
    factor = grows["sliding"] if case.motion.slides else 1.0
    if case.indenter.friction:
        factor *= grows["gripping"]
        if not case.motion.slides:  # the matrix of twice the candidates has four times the entries
            factor *= (grows["forced"] if case.motion.by_force else 1.0) * (1 if case.half else 4)
    spent += len(case.times) * seconds(mechanics, "step", case.mesh) * factor + _slip(case)
    areas = case.changes if case.ask.pressure else 0
    return spent + areas * seconds(mechanics, "area", case.mesh) + _organs(mechanics, case)


def _slip(case: Situation) -> float:
    """Return the expected time in s of contact in which vertices begin to slip, in a press."""
    sticks = 1.0  # coefficient of friction from which skin sticks to what presses it, a convention
    if case.motion.slides or not 0 < case.indenter.friction < sticks:
        return 0.0
    slipped = 0.15  # depth over the thickness at which the slip of a press was timed
    part = min(case.depth_over_thickness, coefficients()["deepest"]) / slipped
    return float(coefficients()["slip"][case.mesh]) * part**2 * slowness({})


def _organs(mechanics: str, case: Situation) -> float:
    """Return the expected time in s of strain at the end organs of a population."""
    if case.ask.population is None:
        return 0.0
    mesh = case.mesh if MECHANICS[mechanics].meshed else ""
    once, step = (seconds(mechanics, stage, mesh) for stage in ("organ", "organ_step"))
    return organs(case.ask) * (once + len(case.times) * step)


def spike_seconds(case: Situation) -> float:
    """Return the expected CPU time in s of the spikes of a scene, of the family that it names.

    One of a user's own counts as the default one.
    """
    ask = case.ask
    if not ask.spikes:
        return 0.0
    family = ask.afferents if ask.afferents in FAMILIES else FAMILIES[0]
    once, block, sample = (
        seconds("spikes", stage, family) for stage in ("setup", "block_second", "sample")
    )
    spent = once + block * blocks(ask) * case.motion.duration
    return spent + sample * organs(ask) * len(case.times)


def mesh_seconds(case: Situation, *, follow: bool = True) -> float:
    """Return the expected time in s to build the mesh of a scene, none where it is at hand.

    `follow`: that is the mesh that follows the touch.
    """
    from fefinger.mesh import store

    finger, touch = case.finger, case.touch if follow else None
    try:
        if store.available(finger, touch):
            return 0.0
        stage = "morph" if store.morphed(finger, touch) else "mesh"
    except InputError:  # no mesh can be made for a finger of this size
        return 0.0
    spent = seconds("mesh", stage, case.mesh)
    if finger.surface is not None:
        megabytes = Path(finger.surface).stat().st_size / 1e6
        spent += seconds("scan", "setup") + seconds("scan", "megabyte") * megabytes
    return spent


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
        spent += (1 if case.half else 2) * seconds("condensed", "build", case.mesh)
    return spent


def formula_seconds(mechanics: str, case: Situation) -> float:
    """Return the expected CPU time in s of a mechanics without a mesh."""
    spent = seconds(mechanics, "setup") + _stepping(mechanics, case)
    return spent + _organs(mechanics, case)


def _stepping(mechanics: str, case: Situation, mesh: str = "") -> float:
    """Return the time in s of the steps: longer ones where the depth under a force is sought."""
    longer = coefficients()["sought"].get(mechanics, 1.0) if case.motion.by_force else 1.0
    return float(longer * len(case.times) * seconds(mechanics, "step", mesh))


@lru_cache(maxsize=8)
def _steps(motion: Motion, relaxing: frozenset[Prony], *, fast: bool, **sliding: float) -> int:
    time = time_grid(motion, fast=fast)
    return len(load_steps(motion, time, relaxing, refine=1, **sliding).chosen)


def solid_seconds(case: Situation) -> float:
    """Return the expected CPU time of `solid` in s."""
    return _following(case) + mesh_seconds(case)


def _following(case: Situation) -> float:
    """CPU seconds of finite strain, the making of the mesh left out.

    The logarithm of the seconds of a step grows with the relative depth, and under edges.
    """
    grows, finger = coefficients(), case.finger
    steps = _steps(
        case.motion,
        tissue_relaxations(finger),
        fast="FAII" in case.ask.spikes,
        friction=case.indenter.friction,
        depth=case.depth_over_thickness * finger.thickness,
        stride=stride_of(case.indenter),
    )
    harder = grows["growth"] * min(case.depth_over_thickness, grows["deepest"])
    harder += grows["sharp"] * case.indenter.sharp + grows["stiffening"] * stiffens(finger)
    spent = seconds("solid", "setup", case.mesh)
    # With friction over without, in slides at 0.5 and 2 N on two tissues, coarse mesh: 1.3 to 1.5.
    frictional = 1.4 if case.indenter.friction else 1.0
    # Skin under a bar, ridges or dots that slide takes new factors: 1.5 to 5.3 times, nine slides.
    sharp_slide = 2.7 if case.motion.slides and case.indenter.sharp else 1.0
    step = frictional * sharp_slide * seconds("solid", "step", case.mesh)
    spent += steps * step * float(np.exp(harder))
    spent += seconds("solid", "reference", case.mesh) if case.ask.spikes else 0.0
    spent += _organs("solid", case)
    larger = finger.width * finger.thickness / grows["size"]  # unknowns grow as its root
    return spent * (1.0 if case.half else _whole()) * float(larger ** (grows["power"] / 2))


def pressed_seconds(case: Situation) -> float:
    """Return the expected CPU time of `pressed` in s."""
    stages = ("setup", "fields") if case.ask.fields else ("setup",)
    spent = sum(seconds("pressed", stage, case.mesh) for stage in stages)
    spent *= 1.0 if case.half else _whole()
    spent += _stepping("pressed", case, case.mesh) + _organs("pressed", case)
    return spent + pressed_once(case)


def pressed_once(case: Situation) -> float:
    """Return the time in s of building mesh and press, which are kept; 0 where at hand."""
    return 0.0 if _press_at_hand(case) else building(case) + mesh_seconds(case)


def building(case: Situation) -> float:
    """Return the CPU time in s of solving the press of a scene; 0 where it is at hand."""
    if _press_at_hand(case):
        return 0.0
    grows = coefficients()
    deep = case.depth_over_thickness / grows["timed"]
    if case.indenter.flat is not None:  # plates go on to that depth, for other motions
        deep = max(deep, 1.0)
    harder = deep**2 if deep > 1 else grows["shallow"] + (1 - grows["shallow"]) * deep
    whole = 1.0 if case.half else _whole()
    return seconds("pressed", "build", case.mesh) * harder * whole


def _press_at_hand(case: Situation) -> bool:
    """Whether the press of a scene is shipped or cached, to its depth or force."""
    # Imported here, because costs are also read for scenes without a mesh.
    from fefinger.mechanics.press.depth_table import deepest_at_hand

    depth, force = deepest_at_hand(case.finger, case.indenter, case.motion)
    reached = case.motion.control.of(depth, force)
    return reached > 0 and reached >= case.motion.peak * (1 - 1e-9)


def modal_seconds(case: Situation) -> float:
    """Return the expected CPU time of `modal` in s, besides that without inertia."""
    build, case = modal_once(case), vibration.of_inertia(case)
    bodies, steps = len(parities(half=case.half)), 2 * len(case.times)
    spent = bodies * seconds("modal", "setup", case.mesh)
    return spent + steps * seconds("modal", "step", case.mesh) + build


def modal_once(case: Situation) -> float:
    """Return the time in s of building what inertia needs and is kept; 0 where at hand.

    Modes, and in tissue that stiffens an operator, which the mechanics without inertia lacks.
    """
    stiff, case = stiffens(case.finger), vibration.of_inertia(case)
    spent = condensed_once(case) if stiff else 0.0
    if available(case.finger, half=case.half, modes=True):
        return spent
    return spent + len(parities(half=case.half)) * seconds("modal", "build", case.mesh)


def _building_of_modal(case: Situation) -> float:
    """CPU seconds of the press that `modal` adds inertia to, on tissue that stiffens."""
    return building(case) if stiffens(case.finger) else 0.0


FINITE_STRAIN: Mapping[str, Callable[[Situation], float]] = {
    "solid": _following,
    "pressed": building,
    "modal": _building_of_modal,
}
"""Expected CPU seconds of finite strain within the cost of a mechanics."""


def beside(seconds: float) -> bool:
    """Whether the spikes of an answer expected to take `seconds` are checked beside it."""
    return seconds >= BESIDE and threads() > 1


def wall(mechanics: str, case: Situation, seconds: float) -> float:
    """Convert expected CPU seconds of a mechanics to wall time in s on an idle machine.

    A share of the solution at finite strain uses as many cores as this process may use
    (`processes.threads`); everything else uses one.
    """
    if mechanics not in FINITE_STRAIN:
        return seconds
    finite = min(FINITE_STRAIN[mechanics](case), seconds)
    return seconds - coefficients()["shared"] * (1 - 1 / threads()) * finite
