"""Small-strain contact: factor once, make the flexibility of candidate vertices, march in time.

Shared by `linear` and `condensed`, which differ in the `SolutionMethod` alone.
"""

from collections.abc import Callable, Hashable
from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np

from fefinger.contact.frictional import FrictionalContact
from fefinger.contact.stepper import Gaps, History, Prescribed, Stepper, march
from fefinger.fem.body import Body, Reduced, body, reduce
from fefinger.fem.condensation import OutsideError
from fefinger.fem.contact.patch import Patch, patch
from fefinger.fem.contact.travel import Travel
from fefinger.fem.elements.probe import recovered_strain_at
from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.mechanics.press import mesh_limits, moving_contact, placement, problem
from fefinger.mechanics.press.mesh_limits import refinement_location
from fefinger.mechanics.press.problem import (
    Press,
    SmallStrainHistory,
    SolutionMethod,
    fixed_facets,
    on_enough_candidates,
    tissues,
    with_nail,
)
from fefinger.mechanics.press.reference import reference_of
from fefinger.mechanics.press.response import small_strain_response
from fefinger.results.records import Response
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.support import cache
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import InputError
from fefinger.support.progress import Progress, Stages


Advance = Callable[[Press, Reduced, Prescribed, Callable[[float], None]], History]
"""Contact of a body on its candidates through time, with a report of progress."""


KEPT = 60_000
"""Most unknowns of a body that is kept for the next press of its finger, as on the standard mesh,
where one takes some 150 MB."""

_kept: dict[Hashable, Body] = {}


def assembled(finger: Finger, mesh: FingerMesh, *, factored: bool) -> Body:
    """Return the soft tissue, and elastic hard parts, of a finger.

    Its system has the factor of small strain or, if not `factored`, the approximate one. The last
    two bodies are kept, as is what is in the user's cache, so that presses of one finger in turn
    assemble and factor it once.
    """
    held, soft, whole = fixed_facets(finger), tissues(finger), with_nail(finger, mesh)
    facets = tuple((name, whole.facets[name].tobytes()) for name in sorted(whole.facets))
    shape = whole.name, whole.fingerprint, whole.pad_normals.tobytes(), whole.half, facets
    key = (*shape, held, tuple(soft.items()), factored, cache.root())
    found = _kept.pop(key, None)
    if found is None:
        while len(_kept) > 1:  # a coarser mesh may be asked in between; before the next is built
            _kept.pop(next(iter(_kept)), None)
        found = body(whole, soft, held, factored=factored)
        if not factored:
            _ = found.system.approximate_factor
    if found.space.n_unknowns <= KEPT:
        _kept[key] = found
    system = copy(found.system)  # which shares the factors
    system.failed = list(system.failed)
    return replace(found, system=system)


WHOLE_MESH = SolutionMethod(
    lambda finger, mesh, report: assembled(finger, mesh, factored=True),
    reduce,
    lambda body, loads: body.system.solve(loads),
    refinement_location,
)
"""Method of `linear`: a factor of the whole mesh, which is fine where the indenter touches."""


def respond(
    scene: Scene,
    progress: Progress | None = None,
    *,
    mechanics: str,
    notes: tuple[str, ...],
    method: SolutionMethod = WHOLE_MESH,
    refine: int = 1,
) -> Response:
    """Solve the scene; `refine` divides every time step.

    InputError if the indenter does not touch the pad, or goes deeper than the tissue or the pad
    allows. ConvergenceError if a linear or contact solution is not reached.
    """
    stages = Stages(progress)
    press = Press.of(scene, method, stages, mechanics=mechanics, notes=notes, refine=refine)
    history = solve(press, stages)
    return small_strain_response(press, history, stages)


def solve(press: Press, stages: Stages) -> SmallStrainHistory:
    """Solve the contact at all times, and the reference press.

    Errors as `respond`.
    """
    reduced, contact = solve_contact(press, stages)
    with stages.stage("reference"):
        reference = reference_of(press, reduced, float(contact.depth.max()))
    return SmallStrainHistory(reduced, contact, reference)


def solve_contact(
    press: Press, stages: Stages, advance: Advance | None = None
) -> tuple[Reduced, History]:
    """Solve the contact, on enough candidate vertices.

    `advance` solves a body on its candidates through time; by default without inertia.

    Errors as `respond`; OutsideError where contact leaves the loadable part of the pad.
    """

    def attempt(on_pad: Patch, rings: int) -> tuple[tuple[Reduced, History], Flags]:
        try:
            reduced, history = _on_candidates(press, on_pad, stages, advance or quasistatic)
            pressed: Flags = np.any(history.pressure > 0, axis=0)
            if not (on_pad.border & pressed).any() or rings == problem.ATTEMPTS - 1:
                # Not before: with too few candidates a prescribed force presses too deep.
                yielded = reduced.object.recession(press.time, history.pressure).max(axis=1)
                deepest = float((history.depth - yielded).max())  # of the skin alone
                mesh_limits.check_reached(press.motion, press.finger.pulp, deepest)
                placement.check_inside(press.body, on_pad.vertices[pressed], deepest)
        except InputError:
            reach = problem.REACH * press.expected_depth * problem.GROW**rings
            if _touches_outside(press, reach):  # without that skin the press is another
                raise OutsideError(mesh_limits.OUTSIDE) from None
            raise
        return (reduced, history), pressed

    return on_enough_candidates(
        press.body, press.expected_depth, partial(_candidates, press), attempt
    )


def _on_candidates(
    press: Press, candidates: Patch, stages: Stages, advance: Advance
) -> tuple[Reduced, History]:
    body, motion, obstacle = press.body, press.motion, press.obstacle
    ended = obstacle.beyond(body.space.points[candidates.vertices])
    mesh_limits.check_under(motion, obstacle, body, ended)
    with stages.stage("unit loads") as report:
        where = press.site_points
        probe = recovered_strain_at(body.space, where, body.planes)
        reduced = moving_contact.reduce_to_patch(press, candidates, where, probe, report)
    with stages.stage("contact") as report:
        value = press.load_unit * motion.value(press.time)
        shift = motion.shift(press.time) if press.tangential else None
        prescribed = Prescribed(motion.control, press.time, value, shift, press.inclines)
        history = advance(press, reduced, prescribed, report)
    pressed = (history.pressure > 0).any(axis=0)
    if not pressed.any():
        raise InputError(mesh_limits.untouched(obstacle, body, float(history.depth.max())))
    if (pressed & candidates.obstacle_border).any():
        raise InputError(mesh_limits.rim_reached(len(candidates.vertices), obstacle.profile))
    return reduced, history


def _touches_outside(press: Press, reach: float) -> bool:
    """Whether vertices that cannot be loaded lie within a gap of `reach` mm at first touch."""
    body = press.body
    if body.loadable is None:
        return False
    outside = np.setdiff1d(body.pad, np.flatnonzero(body.loadable))
    return bool((press.obstacle.gap(body.space.points[outside])[0] <= reach).any())


def _candidates(press: Press, reach: float, rings: int) -> Patch:
    """Return the patch of a press, with `rings` of vertices around those within the reach in mm."""
    body, obstacle = press.body, press.obstacle
    if not press.tangential:
        return patch(body.space, body.pad, body.normals, obstacle, reach, rings, body.loadable)
    path = press.motion.shift(press.time)
    deepest = reach / problem.REACH
    return moving_contact.candidates(body, obstacle, path, deepest, rings, inclines=press.inclines)


def quasistatic(
    press: Press, reduced: Reduced, prescribed: Prescribed, report: Callable[[float], None]
) -> History:
    """Solve the contact of a reduced body at all times, without inertia."""
    return march(contact_of(press, reduced), prescribed, report)


def contact_of(press: Press, reduced: Reduced) -> Stepper:
    """Return the contact of a reduced body with the object of a press, at rest."""
    on, indenter, branches = reduced.patch, press.indenter, press.finger.prony.branches
    gap: Array | Gaps = on.gap
    if press.tangential:
        gap = Travel.of(press.body.space, press.body.normals, on, press.obstacle)
    turns = press.inclines is not None
    if not indenter.friction:
        parts = reduced.flexibility, gap, on.projected, branches
        return reduced.object.frictionless(*parts, turns=turns)
    mu = indenter.friction, indenter.kinetic
    return FrictionalContact(reduced.flexibility, mu, gap, on.projected, branches, turns=turns)
