"""Contact of a finger at finite strain, from a scene to a response."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.fem.body import Body
from fefinger.fem.contact.contact_area import Surface
from fefinger.fem.contact.deformed_gap import Sliding, sliding
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import Candidates
from fefinger.fem.elements.probe import gradient_at_vertices
from fefinger.fem.elements.recovery import recovered_gradient_at
from fefinger.fem.hyperelastic.continuum import Continuum, continuum
from fefinger.fem.hyperelastic.load_path import Allowance, Path, StressHistory, follow
from fefinger.fem.hyperelastic.logarithmic_strain import logarithmic
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.hyperelastic.state import State
from fefinger.geometry import mirror
from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.mechanics.press import limits, placement, problem, response, small_strain
from fefinger.mechanics.press.constitutive import laws, relaxations
from fefinger.mechanics.press.discretization import meshed_at, symmetric
from fefinger.mechanics.press.failure import told
from fefinger.mechanics.press.finite_reference import reference
from fefinger.mechanics.press.load_steps import Stride, heaviest, memories, stride
from fefinger.mechanics.press.sites import organs
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.mesh.store import ready
from fefinger.neural.reference import Reference
from fefinger.results.records import Fields, Pad, Response, Sites
from fefinger.scene.scene import Scene
from fefinger.support.checks import ConvergenceError, InputError, Stopped
from fefinger.support.progress import Progress, Stages
from fefinger.support.units import NEWTON_PER_MILLINEWTON


Array = NDArray[np.float64]

SOLVER = "single"  # of the tangents; in double precision where that fails, which a note says
WORTH = 4  # steps that are worth keeping when a run has to stop
SPREAD = 2.0  # of the candidates at finite strain, beyond those at small: a pad flattens

VOIGT_ROWS, VOIGT_COLUMNS = (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)


def squeeze(
    scene: Scene,
    progress: Progress | None = None,
    *,
    mechanics: str,
    notes: tuple[str, ...],
    refine: int = 1,
    allowance: Allowance | None = None,
) -> Response:
    """Answer the scene; `refine` divides every step of the motion.

    Without an `allowance` its steps may take any work.

    Raises
    ------
    InputError
        If the indenter does not touch the pad, or goes deeper than the tissue or the pad allows.
    Stopped
        If an equilibrium is not reached, or takes more than the allowance; it holds the Response of
        the steps before.
    ConvergenceError
        If that are fewer than WORTH.
    """
    stages = Stages(progress)
    with stages.stage("mesh"):
        mesh = ready(scene.finger, half=symmetric(scene), touch=meshed_at(scene.indenter))
    with stages.stage("factor"):
        finger = small_strain.assembled(scene, mesh, factored=False)
        _ = finger.system.rough  # that all steps start from
        elements = continuum(finger.space, laws(scene.finger), soft=(1, 2))
    touch = placement.obstacle(scene.indenter, finger)
    limits.check_depth(scene, mesh, touch)
    time = time_grid(scene.motion, fast="FAII" in scene.ask.spikes)
    steps = stride(scene.motion, time, memories(scene.finger), refine)
    passage = _passage(scene, finger, elements, touch, steps, stages, allowance)
    if passage.halt:
        steps = steps.until(len(passage.depth))
    with stages.stage("reference"):
        pressed = _reference(scene, finger, elements, passage)
    with stages.stage("fields"):
        fields = _fields(passage, finger, mesh) if scene.ask.fields else None
    with stages.stage("pressure"):
        answer = _answer(scene, finger, passage, steps)
    answered = Response(
        mechanics=mechanics,
        time=steps.time,
        **answer,
        sites=passage.sites,
        reference=pressed,
        fields=fields,
        seconds=stages.seconds,
        notes=(
            *notes,
            *response.scene_notes(scene),
            *mesh.quality.get("notes", ()),
            *response.gave_way(finger),
        ),
        sources=response.origins(mesh, finger, stages) | {"solver": SOLVER},
    )
    if passage.halt:
        raise Stopped(passage.halt, answered)
    return answered


def _reference(
    scene: Scene, finger: Body, elements: Continuum, passage: "_Passage"
) -> Reference | None:
    """Return the reference press of afferents; None after a halt, of which all else is kept."""
    if not scene.ask.spikes:
        return None
    try:
        return reference(scene, finger, elements)
    except ConvergenceError:
        if passage.halt:
            return None
        raise


@dataclass(frozen=True)
class _Passage:
    """The solved steps.

    depth (n,) mm; pressure kPa (n, n_candidates); gap and moved mm (n, n_seen), the latter in three
    components; moment (n, 3) mN mm of the meshed part; strain (n, n_sites, 3, 3).
    """

    contact: Sliding
    sites: Sites | None
    depth: Array
    pressure: Array
    gap: Array
    moved: Array
    moment: Array
    strain: Array
    times: Array
    frames: dict[int, Array]
    halt: str
    status: str
    numbers: dict[str, float]


class _Rim(Exception):
    """The contact has met the rim of its candidates, or of the pad: what follows is in vain."""


class _Recorder:
    """Keeps what a response needs of every step, and whole states at some; stops at a rim."""

    def __init__(self, finger: Body, contact: Sliding, probe: Any, frames: set[int]) -> None:
        self.contact, self.probe, self.wanted = contact, probe, frames
        self.places = finger.space.node_points
        on = contact.on
        self.rim = on.edge | np.isin(on.vertices, placement.border(finger))
        self.depth: list[float] = []
        self.pressure: list[Array] = []
        self.gap: list[Array] = []
        self.moved: list[Array] = []
        self.moment: list[Array] = []
        self.strain: list[Array] = []
        self.frames: dict[int, Array] = {}
        self.last: Array | None = None

    def keep(self, number: int, state: State) -> None:
        """Keep step `number`."""
        self.last = state.values
        self.depth.append(state.depth)
        self.pressure.append(state.pressure)
        gap, moved = self.contact.clearance(state.values, state.depth)
        self.gap.append(gap)
        self.moved.append(moved)
        self.moment.append(self._moment(state))
        self.strain.append(logarithmic((self.probe @ state.values).reshape(-1, 3, 3)))
        if number in self.wanted:
            self.frames[number] = state.values
        if (state.pressure[self.rim] > 0).any():
            raise _Rim

    def _moment(self, state: State) -> Array:
        """Return the moment (3,) mN mm of the pressure about the origin."""
        loads, count = self.contact.at(state).loads, self.places.size
        forces = (loads @ state.pressure)[:count].reshape(-1, 3)
        arms = self.places + state.values[:count].reshape(-1, 3)
        return np.asarray(np.cross(arms, forces).sum(axis=0))


def _passage(
    scene: Scene,
    finger: Body,
    elements: Continuum,
    touch: Obstacle,
    steps: Stride,
    stages: Stages,
    allowance: Allowance | None,
) -> _Passage:
    """Solve all steps, with more candidate vertices as long as the contact meets their rim."""
    skin = partial(small_strain.skin, finger)
    found = organs(scene, touch.origin, touch.axis, skin) if _asked(scene) else None
    motion = scene.motion
    deepest = motion.peak
    if motion.control != "depth":
        deepest = problem.FORCE_DEPTH * scene.finger.thickness
    reach = SPREAD * problem.REACH * deepest
    for _ in range(problem.ATTEMPTS):
        contact = sliding(finger.space, finger.pad, finger.normals, touch, reach)
        limits.check_under(scene, len(contact))
        passage = _followed(scene, finger, elements, contact, found, steps, stages, allowance)
        pressed = np.asarray((passage.pressure > 0).any(axis=0))
        _check_contact(finger, contact.on, pressed, passage.depth)
        if not (pressed & contact.on.edge).any():
            return passage
        reach *= problem.GROW
    message = f"contact: it spread beyond every patch tried, up to a gap of {reach:.3g} mm"
    raise ConvergenceError(message)


def _followed(
    scene: Scene,
    finger: Body,
    elements: Continuum,
    contact: Sliding,
    sites: Sites | None,
    steps: Stride,
    stages: Stages,
    allowance: Allowance | None,
) -> _Passage:
    """Solve the steps on some candidates, as far as the contact stays off their rim."""
    motion = scene.motion
    sides = 2 if finger.half else 1
    unit = 1.0 if motion.control == "depth" else 1 / NEWTON_PER_MILLINEWTON / sides
    path = Path(motion.control, steps.times, lambda t: unit * float(motion.value(t)))
    where = sites.points if sites else np.empty((0, 3))
    where = mirror.to_half(where) if finger.half else where
    probe = recovered_gradient_at(finger.space, where, finger.planes)
    frames = set(response.frames_of(steps.value, int(np.argmax(steps.value))).tolist())
    frames |= heaviest(motion, steps, memories(scene.finger))
    equilibrium = Equilibrium(elements, contact, finger.system)
    deviatoric = scene.finger.relaxation == "deviatoric"
    history = StressHistory(elements, relaxations(scene.finger), deviatoric=deviatoric)
    recorder = _Recorder(finger, contact, probe, frames)
    halt = ""
    with stages.stage("steps") as report:
        try:
            follow(equilibrium, history, path, recorder.keep, report, allowance)
        except _Rim:
            pass  # seen again by the caller
        except ConvergenceError as error:
            halt = told(error, elements, recorder.last)
            if len(recorder.depth) < WORTH:
                raise ConvergenceError(halt) from error
    gap = np.array(recorder.gap)
    penetration = response.inside(gap)
    return _Passage(
        contact=contact,
        sites=sites,
        depth=np.array(recorder.depth),
        pressure=np.array(recorder.pressure),
        gap=gap,
        moved=np.array(recorder.moved),
        moment=np.array(recorder.moment),
        strain=np.array(recorder.strain),
        times=steps.times,
        frames=recorder.frames,
        halt=halt,
        status=_status(equilibrium, len(recorder.depth), penetration, halt),
        numbers={
            "unknowns": finger.space.n_unknowns,
            "candidates": len(contact),
            "half": float(finger.half),
            "steps": len(recorder.depth),
            "iterations": equilibrium.iterations,
            "downhill": equilibrium.descents,
            "penetration_mm": penetration,
        },
    )


def _status(solver: Equilibrium, steps: int, penetration: float, halt: str) -> str:
    downhill = (
        f", {solver.descents} of them downhill past unstable ones," if solver.descents else ""
    )
    return (
        f"{'Stopped' if halt else 'Solved'}: {steps} steps{downhill} in {solver.iterations} "
        f"iterations on {solver.factors + 1} factors, with {response.exact(penetration)}."
        f"{f' Then: {halt}' if halt else ''}"
    )


def _asked(scene: Scene) -> bool:
    return scene.ask.strain or bool(scene.ask.spikes)


def _check_contact(finger: Body, on: Candidates, pressed: NDArray[np.bool_], depth: Array) -> None:
    placement.check_inside(finger, on.vertices[pressed], float(depth.max()))
    if not pressed.any():
        raise InputError(limits.unresolved(float(depth.max())))
    if (pressed & on.rim).any():
        raise InputError(limits.rim_reached(len(pressed)))


def _answer(scene: Scene, finger: Body, passage: _Passage, steps: Stride) -> dict[str, Any]:
    """Return the fields of a Response that the solved steps give, at all times."""
    pressure = steps.bounded(passage.pressure)
    by_force = scene.motion.control == "force"
    sides = 2 if finger.half else 1
    force = sides * pressure @ passage.contact.travel * NEWTON_PER_MILLINEWTON
    if by_force:  # between the steps as well
        share = np.divide(steps.path, force, out=np.ones_like(force), where=force > 0)
        pressure, force = pressure * share[:, None], force * share
    answer = {
        "depth": steps.bounded(passage.depth) if by_force else steps.path,
        "force": force,
        "strain": _strain(finger, passage, steps),
        "status": passage.status,
        "numbers": passage.numbers,
    }
    on_pad = ("contact_area", "centroid", "pad", "pressure", "gap", "moment")
    if not scene.ask.pressure:
        return answer | dict.fromkeys(on_pad)
    seen = passage.contact.seen
    pad, column = response.whole_pad(finger, seen.vertices, seen.triangles, seen.areas)
    pressure = response.on_seen(pressure, seen)[:, column]
    return answer | {
        "contact_area": steps.bounded(_areas(passage, pad, column)),
        "centroid": response.centroid(pad, pressure),
        "pad": pad,
        "pressure": pressure,
        "gap": steps.smooth(passage.gap)[:, column],
        "moment": response.whole_moment(steps.smooth(passage.moment), finger.half),
    }


def _areas(passage: _Passage, pad: Pad, column: NDArray[np.int64]) -> Array:
    """Return the contact areas (n,) mm² of the whole, deformed finger at the steps."""
    touch, seen, sign = passage.contact.obstacle, passage.contact.seen, np.ones((len(column), 3))
    sign[len(seen.vertices) :] = mirror.SIGNS  # the mirror images follow
    pressed = response.on_seen(passage.pressure, seen)[:, column] > 0
    areas = np.empty(len(passage.depth))
    for step, moved in enumerate(passage.moved):
        surface = Surface(pad.points + sign * moved[column], pad.triangles, touch.axis, touch)
        areas[step] = surface.area(pressed[step][None], passage.gap[step][column][None])[0]
    return areas


def _strain(finger: Body, passage: _Passage, steps: Stride) -> Array | None:
    """Return the strain at the sites of the whole finger at all times."""
    if passage.sites is None:
        return None
    strain = steps.smooth(passage.strain)
    return mirror.from_half(strain, passage.sites.points) if finger.half else strain


def _fields(passage: _Passage, finger: Body, mesh: FingerMesh) -> Fields:
    """Return the kept states on the mesh."""
    numbers = np.array(sorted(passage.frames))
    n_points, n_frames = len(mesh.points), len(numbers)
    displacement = np.zeros((n_frames, n_points, 3))
    strain, pressure = np.zeros((n_frames, n_points, 6)), np.zeros((n_frames, n_points))
    gradients = gradient_at_vertices(finger.space)
    pressed = finger.original[passage.contact.on.vertices]
    for frame, number in enumerate(numbers):
        values = passage.frames[number]
        own = values[: 3 * len(finger.original)].reshape(-1, 3)
        displacement[frame, finger.original] = own
        logs = logarithmic((gradients @ values).reshape(-1, 3, 3))
        strain[frame, finger.original] = logs[:, VOIGT_ROWS, VOIGT_COLUMNS]
        pressure[frame, pressed] = passage.pressure[number]
    times = passage.times[numbers]
    return Fields(mesh.points, mesh.cells, mesh.region, times, displacement, strain, pressure)
