"""Contact of a finger as a linear viscoelastic body, from a scene to a response.

Shared by the small-strain mechanics: one factor, unit loads on the candidate vertices, then time.
"""

import numpy as np
from numpy.typing import NDArray

from fefinger.fem.body import Body, Solid, body, reduce
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import patch
from fefinger.fem.contact.viscoelastic import Prescribed, Relaxation, march
from fefinger.fem.elements.probe import strain_at_vertices
from fefinger.fem.elements.recovery import recovered_strain_at
from fefinger.geometry import mirror
from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.mechanics.press import limits, placement
from fefinger.mechanics.press.constitutive import tissues
from fefinger.mechanics.press.discretization import meshed_at, symmetric
from fefinger.mechanics.press.limits import check_depth, check_reached
from fefinger.mechanics.press.materials import held, with_nail
from fefinger.mechanics.press.problem import ATTEMPTS, FORCE_DEPTH, GROW, REACH, Contact, Method
from fefinger.mechanics.press.reference import reference_of
from fefinger.mechanics.press.response import answer, frames_of, gave_way, origins, scene_notes
from fefinger.mechanics.press.sites import organs
from fefinger.mechanics.press.skin import meshed
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.mesh.store import ready
from fefinger.neural.populations import Surface
from fefinger.results.records import Fields, Response
from fefinger.scene.scene import Scene
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.progress import Progress, Stages
from fefinger.support.units import NEWTON_PER_MILLINEWTON


Array = NDArray[np.float64]


def assembled(scene: Scene, mesh: FingerMesh, *, factored: bool) -> Body:
    """Return the finger of a scene as a body with a linear solver of its own."""
    finger = scene.finger
    whole, solver = with_nail(finger, mesh), scene.ask.solver
    return body(whole, tissues(finger), held(finger), solver, factored=factored)


WHOLE_MESH = Method(
    lambda scene, mesh, report: assembled(scene, mesh, factored=True),
    reduce,
    march,
    lambda solid, loads: solid.system.solve(loads),
    meshed_at,
)


def press(
    scene: Scene,
    progress: Progress | None = None,
    *,
    mechanics: str,
    notes: tuple[str, ...],
    refine: int = 1,
    method: Method = WHOLE_MESH,
) -> Response:
    """Answer the scene; `refine` divides every time step.

    Raises
    ------
    InputError
        If the indenter does not touch the pad, or goes deeper than the tissue or the pad allows.
    ConvergenceError
        If a linear or contact solution is not reached.
    """
    stages = Stages(progress)
    with stages.stage("mesh"):
        mesh = ready(scene.finger, half=symmetric(scene), touch=method.touch(scene.indenter))
    with stages.stage("factor") as report:
        finger = method.solid(scene, mesh, report)
    touch = placement.obstacle(scene.indenter, finger)
    check_depth(scene, mesh, touch)
    time = time_grid(scene.motion, fast="FAII" in scene.ask.spikes, refine=refine)
    contact = _contact(scene, finger, touch, time, stages, method)
    with stages.stage("reference"):
        reference = reference_of(scene, finger, contact, method)
    with stages.stage("fields"):
        fields = _fields(contact, finger, mesh, method) if scene.ask.fields else None
    with stages.stage("pressure"):
        answered = answer(scene, finger, contact, reference, fields)
    return Response(
        mechanics=mechanics,
        **answered,
        seconds=stages.seconds,
        notes=(*notes, *scene_notes(scene), *mesh.quality.get("notes", ()), *gave_way(finger)),
        sources=origins(mesh, finger, stages),
    )


def skin(finger: Solid) -> Surface:
    """Return the skin of the pad that a population lies under."""
    return meshed(finger.space.points, finger.pad, finger.normals, half=finger.half)


def _contact(
    scene: Scene, finger: Solid, touch: Obstacle, time: Array, stages: Stages, method: Method
) -> Contact:
    """Solve the contact, with more candidate vertices as long as it meets their rim.

    Beside an edge the gap grows within a facet to any reach: each time there is one ring more.
    """
    asked_sites = scene.ask.strain or scene.ask.spikes
    found = organs(scene, touch.origin, touch.axis, lambda: skin(finger)) if asked_sites else None
    where = found.points if found else np.empty((0, 3))
    where = mirror.to_half(where) if finger.half else where
    probe = recovered_strain_at(finger.space, where, finger.planes)
    depth_control = scene.motion.control == "depth"
    value = scene.motion.value(time)
    if not depth_control:
        value = value / NEWTON_PER_MILLINEWTON / (2 if finger.half else 1)
    deepest = scene.motion.peak if depth_control else FORCE_DEPTH * scene.finger.thickness
    reach = REACH * deepest
    for rings in range(ATTEMPTS):
        candidates = patch(finger.space, finger.pad, finger.normals, touch, reach, rings)
        limits.check_under(scene, len(candidates.vertices))
        with stages.stage("unit loads") as report:
            reduced = method.reduce(finger, candidates, probe, report)
        prony = scene.finger.prony
        memory = Relaxation(np.array(prony.weights), np.array(prony.v), len(candidates.vertices))
        asked = Prescribed(scene.motion.control, time, value)
        with stages.stage("contact") as report:
            history = method.march(
                reduced.flexibility, candidates.gap, candidates.travel, memory, asked, report
            )
        check_reached(scene, float(history.depth.max()))
        pressed = (history.pressure > 0).any(axis=0)
        placement.check_inside(finger, candidates.vertices[pressed], float(history.depth.max()))
        if not pressed.any():
            raise InputError(limits.unresolved(float(history.depth.max())))
        if (pressed & candidates.rim).any():
            raise InputError(limits.rim_reached(len(candidates.vertices)))
        if not (pressed & candidates.edge).any():
            return Contact(touch, reduced, found, time, history)
        reach *= GROW
    message = f"contact: it spread beyond every patch tried, up to a gap of {reach:.3g} mm"
    raise ConvergenceError(message)


def _fields(contact: Contact, finger: Solid, mesh: FingerMesh, method: Method) -> Fields:
    """Solve for the whole body at some of the times."""
    force = contact.history.pressure @ contact.reduced.patch.travel
    frames = frames_of(contact.history.depth, int(np.argmax(force)))
    loads = contact.reduced.patch.loads @ contact.history.elastic[frames].T
    unknowns = method.unknowns(finger, np.asarray(loads))
    n_points, n_frames = len(mesh.points), len(frames)
    displacement = np.zeros((n_frames, n_points, 3))
    strain = np.zeros((n_frames, n_points, 6))
    pressure = np.zeros((n_frames, n_points))
    vertices = 3 * len(finger.original)
    displacement[:, finger.original] = unknowns[:vertices].T.reshape(n_frames, -1, 3)
    at_vertices = strain_at_vertices(finger.space) @ unknowns
    strain[:, finger.original] = at_vertices.T.reshape(n_frames, -1, 6)
    pressed = finger.original[contact.reduced.patch.vertices]
    pressure[:, pressed] = contact.history.pressure[frames]
    times = contact.time[frames]
    return Fields(mesh.points, mesh.cells, mesh.region, times, displacement, strain, pressure)
