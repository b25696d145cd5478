"""Contact of a finger as a linear viscoelastic body, from a scene to a response.

Shared by the small-strain mechanics: one factor, unit loads on the candidate vertices, then time.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.checks import ConvergenceError, InputError
from fefinger.fem.area import Surface as Touched
from fefinger.fem.body import Body, Reduced, Solid, body, reduce
from fefinger.fem.contact import Complementarity, Seen, patch
from fefinger.fem.forms import Elastic
from fefinger.fem.march import History, Prescribed, Relaxation, march
from fefinger.fem.obstacle import Obstacle, Rigid
from fefinger.fem.probe import strain_at_vertices, tensors
from fefinger.fem.recover import recovered_strain_at
from fefinger.indenter import STANDARD
from fefinger.mechanics import _missed, _placing
from fefinger.mechanics._hard import elastic, held, with_nail
from fefinger.mechanics._notes import normalized, relaxing
from fefinger.mechanics._skin import meshed
from fefinger.mechanics._symmetry import symmetric
from fefinger.mechanics._timeline import time_grid
from fefinger.mechanics._touch import (
    REFERENCE_DEPTH,
    check_reached,
    folded,
    meshed_at,
    organs,
    sites,
    unfolded,
)
from fefinger.mesh.ready import ready
from fefinger.mesh.record import FingerMesh
from fefinger.neural.populations import Surface
from fefinger.records import Fields, Pad, Progress, Reference, Response, Sites
from fefinger.scene import Finger, Indenter, Scene
from fefinger.stages import Stages
from fefinger.units import NEWTON_PER_MILLINEWTON


Array = NDArray[np.float64]

REACH = 1.25  # candidate vertices are those whose gap at first touch is below this times the depth
GROW = 1.4  # factor on the reach when contact meets the border of the candidates
ATTEMPTS = 4
FORCE_DEPTH = 0.22  # first guess of the depth under force control, of the finger's thickness
FRAMES_MOVING, FRAMES_RESTING = 20, 6


@dataclass(frozen=True)
class Method:
    """How a mechanics solves: the solid, its reduction to a patch, its march and its fields.

    solid(scene, mesh, report); reduce and march as in `fem.body` and `fem.march`; unknowns(solid,
    loads) gives the displacement under loads on the pad; touch(indenter) where the mesh is fine.
    """

    solid: Callable[..., Any]
    reduce: Callable[..., Reduced]
    march: Callable[..., History]
    unknowns: Callable[[Any, Array], Array]
    touch: Callable[[Indenter], float | tuple[float, float] | None]


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
    touch = _placing.obstacle(scene.indenter, finger)
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


def origins(mesh: FingerMesh, finger: Solid, stages: Stages) -> dict[str, str]:
    """Return what an answer was computed from, with what solver, and in how much memory."""
    found = {"mesh": mesh.name, "mesh_sha256": mesh.fingerprint, "memory": stages.memory}
    return found | {"solver": finger.system.name} if isinstance(finger, Body) else found


def gave_way(finger: Solid) -> tuple[str, ...]:
    """Return which factors in single precision failed."""
    if not isinstance(finger, Body):
        return ()
    count = len(finger.system.failed)
    if not count:
        return finger.system.solver.notes
    tangents = (
        f"Single precision failed for {count} factor{'s' if count > 1 else ''} of the tangent; "
        f"{'those' if count > 1 else 'that'} in double precision, of twice the memory, "
        f"{'were' if count > 1 else 'was'} taken instead."
    )
    return (*finger.system.solver.notes, tangents)


def inside(gap: Array) -> float:
    """Return how far a vertex of the pad lies inside the indenter at most, in mm.

    Contact closes the gaps weighted with the hats, not the one at each vertex.
    """
    return float(np.maximum(-gap, 0.0).max(initial=0.0))


def exact(penetration: float) -> str:
    """Return in what sense the complementarity of a contact is exact, for its status."""
    return (
        "exact complementarity of pressures and weighted gaps; "
        f"vertices lie up to {penetration:.2g} mm inside the indenter"
    )


def tissues(finger: Finger) -> dict[int, Elastic]:
    """Return the relaxed elasticity of the regions that deform."""
    layers = {1: finger.skin, 2: finger.subcutaneous}
    soft = {region: Elastic(layer.modulus, layer.poisson) for region, layer in layers.items()}
    return soft | elastic(finger)


def skin(finger: Solid) -> Surface:
    """Return the skin of the pad that a population lies under."""
    return meshed(finger.space.points, finger.pad, finger.normals, half=finger.half)


@dataclass(frozen=True)
class Contact:
    """The solved contact: where, on what, when, and the end organs that it strains."""

    touch: Rigid
    reduced: Reduced
    sites: Sites | None
    time: Array
    history: History


def _contact(
    scene: Scene, finger: Solid, touch: Obstacle, time: Array, stages: Stages, method: Method
) -> Contact:
    """Solve the contact, with more candidate vertices as long as it meets their rim.

    Beside an edge the gap grows within a facet to any reach: each time there is one ring more.
    """
    asked_sites = scene.ask.strain or scene.ask.spikes
    found = organs(scene, touch.origin, touch.axis, lambda: skin(finger)) if asked_sites else None
    where = found.points if found else np.empty((0, 3))
    where = folded(where) if finger.half else where
    probe = recovered_strain_at(finger.space, where, finger.planes)
    depth_control = scene.motion.control == "depth"
    value = scene.motion.value(time)
    if not depth_control:
        value = value / NEWTON_PER_MILLINEWTON / (2 if finger.half else 1)
    deepest = scene.motion.peak if depth_control else FORCE_DEPTH * scene.finger.thickness
    reach = REACH * deepest
    for rings in range(ATTEMPTS):
        candidates = patch(finger.space, finger.pad, finger.normals, touch, reach, rings)
        _missed.check_under(scene, len(candidates.vertices))
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
        _placing.check_inside(finger, candidates.vertices[pressed], float(history.depth.max()))
        if not pressed.any():
            raise InputError(_missed.unresolved(float(history.depth.max())))
        if (pressed & candidates.rim).any():
            raise InputError(_missed.rim_reached(len(candidates.vertices)))
        if not (pressed & candidates.edge).any():
            return Contact(touch, reduced, found, time, history)
        reach *= GROW
    message = f"contact: it spread beyond every patch tried, up to a gap of {reach:.3g} mm"
    raise ConvergenceError(message)


def check_depth(scene: Scene, mesh: FingerMesh, touch: Obstacle) -> None:
    """Raise InputError for a depth that leaves no tissue over the bone."""
    bone = mesh.points[np.unique(mesh.facets["bone"])]
    pulp = float(np.min(np.linalg.norm(bone - touch.origin, axis=1)))
    if scene.motion.control == "depth" and scene.motion.peak >= pulp:
        message = (
            f"motion.depth: expected less than the {pulp:.3g} mm of tissue over the bone, "
            f"received {scene.motion.peak:g} mm"
        )
        raise InputError(message)


def reference_press(
    finger: Solid, central: Sites, method: Method, reduced: Reduced | None = None
) -> Reference:
    """Press the standard plate a little and return the strain at the sites under it.

    `reduced` is the finger under that plate, with its strain there, where that is at hand.
    """
    if reduced is None:
        touch = _placing.obstacle(STANDARD, finger)
        reach = 2 * REACH * REFERENCE_DEPTH
        candidates = patch(finger.space, finger.pad, finger.normals, touch, reach)
        probe = recovered_strain_at(finger.space, central.points, finger.planes)
        reduced = method.reduce(finger, candidates, probe)
    free = reduced.patch.gap - REFERENCE_DEPTH * reduced.patch.travel
    pressure = Complementarity(reduced.flexibility).solve(free)
    if (pressure[reduced.patch.edge] > 0).any():
        message = "reference press: contact left its patch; the pad is much flatter than expected"
        raise ConvergenceError(message)
    strain = tensors((reduced.strain @ pressure).reshape(-1, 6))
    return Reference(REFERENCE_DEPTH, central.types, central.normals, strain)


def reference_of(scene: Scene, finger: Solid, contact: Contact, method: Method) -> Reference | None:
    """Return the reference press of afferents; on the scene's own patch if that is the same."""
    if contact.sites is None or not scene.ask.spikes:
        return None
    touch = _placing.obstacle(STANDARD, finger)
    central = sites(scene, touch.origin, touch.axis)
    own = scene.indenter == STANDARD and contact.history.depth.max() >= REFERENCE_DEPTH
    own = own and np.array_equal(contact.sites.points, central.points)
    return reference_press(finger, central, method, contact.reduced if own else None)


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


def frames_of(depth: Array, peak: int) -> NDArray[np.int64]:
    """Choose frames that share the path of the indenter, a few of its rests, and the peak."""
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(depth)))])
    moving = np.searchsorted(path, np.linspace(0, path[-1], FRAMES_MOVING))
    evenly = np.linspace(0, len(depth) - 1, FRAMES_RESTING).round()
    return np.unique(np.concatenate([moving, evenly, [peak]]).astype(np.int64))


def answer(
    scene: Scene,
    finger: Solid,
    contact: Contact,
    reference: Reference | None,
    fields: Fields | None,
) -> dict[str, Any]:
    """Return the fields of a Response that the solved contact gives."""
    history, on_pad = contact.history, contact.reduced.patch
    seen = on_pad.seen
    pad, column = whole_pad(finger, seen.vertices, seen.triangles, seen.areas)
    pressure = on_seen(history.pressure, seen)[:, column]
    sides = 2 if finger.half else 1
    force = sides * history.pressure @ on_pad.travel * NEWTON_PER_MILLINEWTON
    strain = None
    if contact.sites is not None:
        components = history.elastic @ contact.reduced.strain.T
        strain = tensors(components.reshape(len(contact.time), -1, 6))
        strain = unfolded(strain, contact.sites.points) if finger.half else strain
    asked = scene.ask.pressure
    approach = history.elastic @ contact.reduced.approach.T
    gap = on_pad.clearance(history.depth, approach)[:, column]
    penetration = inside(gap)
    surface = Touched(pad.points, pad.triangles, contact.touch.axis, contact.touch)
    return {
        "time": contact.time,
        "depth": history.depth,
        "force": force,
        "contact_area": surface.area(pressure > 0, gap) if asked else None,
        "centroid": centroid(pad, pressure) if asked else None,
        "pad": pad if asked else None,
        "pressure": pressure if asked else None,
        "gap": gap if asked else None,
        "moment": whole_moment(history.pressure @ on_pad.moment, finger.half) if asked else None,
        "sites": contact.sites,
        "strain": strain,
        "reference": reference,
        "fields": fields,
        "status": f"Solved: {history.exchanges} contact solutions with {exact(penetration)}.",
        "numbers": {
            "unknowns": finger.space.n_unknowns,
            "candidates": len(on_pad.vertices),
            "half": float(finger.half),
            "penetration_mm": penetration,
        },
    }


def on_seen(pressure: Array, seen: Seen) -> Array:
    """Return the pressure (n_t, n_seen) kPa at all vertices seen: none but the candidates'."""
    return np.pad(pressure, ((0, 0), (0, len(seen.vertices) - pressure.shape[1])))


def whole_moment(meshed: Array, half: bool) -> Array:
    """Return the moment (n_t, 3) N mm on the whole finger about the origin."""
    whole = meshed * np.array([0.0, 2.0, 0.0]) if half else meshed
    return np.asarray(whole * NEWTON_PER_MILLINEWTON)


def centroid(pad: Pad, pressure: Array) -> Array:
    """Return the center (n_t, 2) mm of the pressure in x and y, nan where there is none."""
    total = (pressure @ pad.areas)[:, None]
    moment = pressure @ first_moments(pad)[:, :2]
    return np.divide(moment, total, out=np.full_like(moment, np.nan), where=total > 0)


def first_moments(pad: Pad) -> Array:
    """Return the integrals (n_pad, 3) mm³ of every hat times the place, over the triangles."""
    corners = pad.points[pad.triangles]
    sides = corners[:, 1:] - corners[:, :1]
    twelfths = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 24
    moments = np.zeros_like(pad.points)
    share = twelfths[:, None, None] * (corners + corners.sum(axis=1, keepdims=True))
    np.add.at(moments, pad.triangles, share)
    return moments


def whole_pad(
    finger: Solid, vertices: NDArray[np.int64], faces: NDArray[np.int64], areas: Array
) -> tuple[Pad, NDArray[np.int64]]:
    """Return the pad of the whole finger, and which of `vertices` each of its points is."""
    points, normals = finger.space.points[vertices], finger.normals[vertices]
    column = np.arange(len(points))
    number = np.full(len(finger.space.points), -1, dtype=np.int64)
    number[vertices] = column
    triangles = number[faces]
    triangles = triangles[(triangles >= 0).all(axis=1)]
    if not finger.half:
        return Pad(points, areas, normals, triangles), column
    mirror = np.array([1.0, -1.0, 1.0])
    off = points[:, 1] > 0
    twin = column.copy()
    twin[off] = len(points) + np.arange(off.sum())
    whole = np.where(off, areas, 2 * areas)
    pad = Pad(
        points=np.concatenate([points, points[off] * mirror]),
        areas=np.concatenate([whole, whole[off]]),
        normals=np.concatenate([normals, normals[off] * mirror]),
        triangles=np.concatenate([triangles, twin[triangles][:, ::-1]]),
    )
    return pad, np.concatenate([column, column[off]])


def scene_notes(scene: Scene) -> tuple[str, ...]:
    """Return what a reader has to know of this scene's finger."""
    cut = "held" if scene.finger.cut == "fixed" else "free"
    own = relaxing(scene.finger)
    return (f"The proximal cut of the tissue is {cut}.", *normalized(scene.finger.prony), *own)
