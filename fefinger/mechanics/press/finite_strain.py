"""Contact of a hyperelastic, relaxing finger at finite strain, in load steps."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import sparse

from fefinger.fem.body import Solid
from fefinger.fem.contact.deformed_gap import ContactSurface, contact_surface
from fefinger.fem.contact.travel import envelope
from fefinger.fem.elements.probe import recovered_gradient_at
from fefinger.fem.hyperelastic import load_path
from fefinger.fem.hyperelastic.continuum import Continuum, continuum
from fefinger.fem.hyperelastic.load_path import FrictionHistory, SideLoad
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.hyperelastic.state import State
from fefinger.geometry.finger_mesh import REGIONS
from fefinger.mechanics.press import mesh_limits, placement, problem
from fefinger.mechanics.press.compliances import object_surface
from fefinger.mechanics.press.load_steps import (
    LoadSteps,
    load_steps,
    peak_steps,
    stride_of,
    tissue_relaxations,
)
from fefinger.mechanics.press.problem import (
    NAIL,
    FiniteStrainHistory,
    Press,
    frames_of,
    materials,
    relaxations,
)
from fefinger.mechanics.press.reference import reference_strain, reference_unknowns
from fefinger.mechanics.press.response import finite_strain_response
from fefinger.mechanics.press.small_strain import WHOLE_MESH, assembled
from fefinger.neural.drives import Reference
from fefinger.results.records import Response
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError, InputError, Stopped
from fefinger.support.progress import Progress, Stages
from fefinger.support.tensors import logarithmic
from fefinger.support.tolerances import PRESS_EQUILIBRIUM


WORTH = 4  # steps that are worth keeping when a run has to stop
# Factors that a press may take: of each step, and of all steps beyond that. Ordinary presses take
# less than ten in all; one against the bone can take a hundred for a single step.
BUDGET = load_path.FactorizationBudget(usual=8, spare=40)
# Sharp parts that slide over the skin take more in many steps.
SLIDING_BUDGET = replace(BUDGET, spare=400)
SPREAD = 2.0  # of the candidates at finite strain, beyond those at small: a pad flattens

RECORDED = ("depth", "pressure", "gap", "moved", "moment", "strain", "sideways")
"""Quantities of a `FiniteStrainHistory` that are recorded at every step."""


def most_compressed(elements: Continuum, values: Array) -> tuple[float, Array, str]:
    """Return the smallest principal stretch in a body, the place (3,) mm at rest, and the tissue.

    `values` (n_unknowns,): of the body.
    """
    space = elements.space
    moved = values[space.unknowns[:, :30]].reshape(-1, 10, 3)
    deformation = np.eye(3) + np.einsum(
        "eni,qnk,ekj->eqij", moved, elements.reference, elements.jacobians
    )
    stretch = np.linalg.svd(deformation, compute_uv=False)[..., -1].min(axis=1)
    cell = int(np.argmin(stretch))
    place = space.points[space.vertices[cell]].mean(axis=0)
    names = {number: name for name, number in REGIONS.items()} | {NAIL: "nail"}
    name = names[int(space.tissue[cell])]
    return float(stretch[cell]), place, "subcutaneous tissue" if name == "subcutaneous" else name


def failure_message(error: Exception, elements: Continuum, values: Array | None) -> str:
    """Return the message of a press that found no equilibrium after `values` (n,), if any."""
    if values is None:
        return str(error)
    stretch, (x, y, z), tissue = most_compressed(elements, values)
    return (
        f"{error}. At the last equilibrium the {tissue} at x = {x:.1f}, y = {y:.1f}, z = {z:.1f} "
        f"mm is pressed to {stretch:.2g} of its length"
    )


FINITE_STRAIN = replace(
    WHOLE_MESH, body=lambda finger, mesh, report: assembled(finger, mesh, factored=False)
)
"""How `solid` builds the body; its steps make factors of their own tangents."""


def respond(
    scene: Scene,
    progress: Progress | None = None,
    *,
    mechanics: str,
    notes: tuple[str, ...],
    refine: int = 1,
    allowance: load_path.FactorizationBudget | None = None,
) -> Response:
    """Solve the scene; `refine` divides every load step.

    allowance: limit on tangent factorizations, by default BUDGET, or SLIDING_BUDGET with a path.

    Raises InputError if the indenter does not touch the pad, or goes deeper than the tissue or the
    pad allows; Stopped if an equilibrium is not reached, or takes more than the allowance; it holds
    the Response of the steps before; ConvergenceError if that are fewer than WORTH.
    """
    stages = Stages(progress)
    press = Press.of(scene, FINITE_STRAIN, stages, mechanics=mechanics, notes=notes)
    allowance = allowance or (SLIDING_BUDGET if scene.motion.slides else BUDGET)
    history = solve(press, stages, refine=refine, allowance=allowance)
    response = finite_strain_response(press, history, stages)
    if history.halt:
        raise Stopped(history.halt, response)
    return response


def solve(
    press: Press,
    stages: Stages,
    *,
    refine: int = 1,
    allowance: load_path.FactorizationBudget | None = None,
) -> FiniteStrainHistory:
    """Solve the load steps, as far as they converge, and the reference press.

    Errors as `respond`, without Stopped.
    """
    motion, finger = press.motion, press.finger
    with stages.stage("factor"):
        elements = continuum(press.body.space, materials(finger), soft=(1, 2))
    relaxing = tissue_relaxations(finger)
    steps = load_steps(
        motion,
        press.time,
        relaxing,
        refine,
        friction=press.indenter.friction,
        depth=press.expected_depth,
        stride=stride_of(press.indenter),
    )
    frames = set(frames_of(steps.value, int(np.argmax(steps.value))).tolist())
    course = Course(
        load_path.LoadPath(
            motion.control,
            steps.times,
            lambda t: press.load_unit * float(motion.value(t)),
            press.places,
        ),
        lambda: load_path.StressHistory(
            elements, relaxations(finger), deviatoric=finger.relaxation == "deviatoric"
        ),
        steps,
        frozenset(frames | peak_steps(motion, steps, relaxing)),
        allowance=allowance,
    )
    history = follow_course(press, elements, course, stages)
    with stages.stage("reference"):
        reference = _reference(press, elements, history.halt)
    return replace(history, reference=reference)


def _reference(press: Press, elements: Continuum, halt: str) -> Reference | None:
    """Return the reference press of afferents; None if it fails after a halt."""
    if press.reference is None:
        return None
    try:
        unknowns = reference_unknowns(press, elements)
    except ConvergenceError:
        if halt:
            return None
        raise
    return reference_strain(press.body, press.reference.sites, unknowns)


class _EndedError(Exception):
    """Ends a solution early: contact is at the rim of candidates or pad, or at its target."""


class _Recorder:
    """Records every step for the response, and whole states at some; stops at a rim."""

    def __init__(
        self,
        body: Solid,
        contact: ContactSurface,
        probe: sparse.csr_matrix,
        course: "Course",
        friction: FrictionHistory | None,
    ) -> None:
        self.contact, self.probe, self.course = contact, probe, course
        self.space, self.friction = body.space, friction
        on = contact.on
        self.rim = on.border | np.isin(on.vertices, placement.border(body))
        self.rows: list[tuple[Any, ...]] = []
        self.frames: dict[int, Array] = {}
        self.last: Array | None = None

    def keep(self, number: int, state: State) -> None:
        """Record step `number`."""
        self.last = state.values
        clearance = self.contact.clearance(state)
        strain = logarithmic((self.probe @ state.values).reshape(-1, 3, 3))
        sideways = SideLoad.of(self.contact, self.space, state, self.friction)
        moment = self._moment(state)
        self.rows.append((state.depth, state.pressure, *clearance, moment, strain, sideways))
        if number in self.course.frames:
            self.frames[number] = state.values
        force = float(self.contact.projected @ state.pressure)
        at_rim = (state.pressure[self.rim] > 0).any()
        depth_enough, force_enough = self.course.enough
        if at_rim or (state.depth >= depth_enough and force >= force_enough):
            raise _EndedError

    def _moment(self, state: State) -> Array:
        """Return the moment (3,) mN mm of the pressure about the origin."""
        places = self.space.node_points
        loads, count = self.contact.at(state).loads, places.size
        forces = (loads @ state.pressure)[:count].reshape(-1, 3)
        arms = places + state.values[:count].reshape(-1, 3)
        return np.asarray(np.cross(arms, forces).sum(axis=0))


@dataclass(frozen=True)
class Course:
    """Load path of a press, its stress, the steps of the answer, and those whose state is kept.

    enough: depth in mm and force in mN on the meshed part from which the press may end; allowance:
    limit on tangent factorizations, none by default.
    """

    path: load_path.LoadPath
    stress: Callable[[], load_path.StressHistory]
    steps: LoadSteps
    frames: frozenset[int]
    enough: tuple[float, float] = (np.inf, np.inf)
    allowance: load_path.FactorizationBudget | None = None


def follow_course(
    press: Press, elements: Continuum, course: Course, stages: Stages
) -> FiniteStrainHistory:
    """Solve all steps, with more candidate vertices as long as the contact reaches their rim.

    Errors as `solve`.
    """
    body = press.body
    reach, under = SPREAD * problem.REACH * press.expected_depth, None
    if press.motion.slides and not press.obstacle.profile.plane:
        under = envelope(press.obstacle, press.motion.shift(press.time))
    for _ in range(problem.ATTEMPTS):
        contact = contact_surface(
            body.space,
            body.pad,
            body.normals,
            press.obstacle,
            reach,
            spreads=elements.nearly_incompressible,
            half=body.half,
            under=under,
        )
        contact = replace(contact, surface=object_surface(press.indenter, body, contact))
        mesh_limits.check_under(press.motion, press.obstacle, body, contact.on.beyond)
        history = _on_candidates(press, elements, contact, course, stages)
        pressed = np.asarray((history.pressure > 0).any(axis=0))
        _check_contact(press, contact, history)
        if not (pressed & contact.on.border).any():
            return history
        reach *= problem.GROW
    raise ConvergenceError(mesh_limits.spread_beyond(reach))


def _on_candidates(
    press: Press,
    elements: Continuum,
    contact: ContactSurface,
    course: Course,
    stages: Stages,
) -> FiniteStrainHistory:
    """Solve the steps on some candidates, as far as the contact stays off their rim."""
    body, halt = press.body, ""
    probe = recovered_gradient_at(body.space, press.site_points, body.planes)
    mu = press.indenter.friction, press.indenter.kinetic
    friction = FrictionHistory(contact, mu) if mu[0] else None
    equilibrium = Equilibrium(
        elements, contact, press.system, PRESS_EQUILIBRIUM, frictional=friction is not None
    )
    recorder = _Recorder(body, contact, probe, course, friction)
    with stages.stage("steps") as report:
        try:
            driven = course.stress(), course.path
            load_path.follow(
                equilibrium, *driven, recorder.keep, report, course.allowance, friction
            )
        except _EndedError:
            pass  # at a rim: seen again by the caller
        except ConvergenceError as error:
            halt = failure_message(error, elements, recorder.last)
            if len(recorder.rows) < WORTH:
                raise ConvergenceError(halt) from error
    return FiniteStrainHistory(
        contact=contact,
        steps=course.steps.until(len(recorder.rows)),
        **dict(zip(RECORDED, map(_column, zip(*recorder.rows, strict=True)), strict=True)),
        frames=recorder.frames,
        reference=None,
        iterations=equilibrium.iterations,
        descents=equilibrium.descents,
        factors=equilibrium.factors,
        halt=halt,
    )


def _column(values: tuple[Any, ...]) -> Any:
    """Return one quantity at all steps."""
    return SideLoad.stacked(values) if isinstance(values[0], SideLoad) else np.array(values)


def _check_contact(press: Press, contact: ContactSurface, history: FiniteStrainHistory) -> None:
    body = press.body
    bearing, on, deepest = history.pressure > 0, contact.on, float(history.depth.max())
    pressed = np.asarray(bearing.any(axis=0))
    placement.check_inside(body, on.vertices[pressed], deepest)
    if not pressed.any():
        raise InputError(mesh_limits.untouched(contact.obstacle, body, deepest))
    places = contact.at_rest[: len(contact)] + history.moved[:, : len(contact)]
    places = places - press.places(history.steps.times)[:, None]
    ended = (bearing & contact.obstacle.beyond(places)).any()
    if ended or (pressed & on.obstacle_border).any():
        raise InputError(
            mesh_limits.rim_reached(len(pressed), getattr(contact.obstacle, "profile", None))
        )
