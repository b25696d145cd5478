"""Press: all inputs of a finite-element contact problem, from a scene; and its solved contact.

The materials of the regions of the mesh: soft tissue, and bone and nail that are rigid and fixed,
elastic, or left out.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Self, TypeVar

import numpy as np
from scipy.spatial import cKDTree

from fefinger.contact.stepper import History
from fefinger.fem.body import Body, Reduced, Solid
from fefinger.fem.condensation import OutsideError
from fefinger.fem.contact.deformed_gap import ContactSurface
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import Patch
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.hyperelastic.load_path import Series, SideLoad
from fefinger.fem.hyperelastic.material import Material, material_of
from fefinger.fem.linalg.system import System
from fefinger.geometry.finger_mesh import BONE, SKIN, FingerMesh
from fefinger.geometry.profiles import frame
from fefinger.laws import LAWS
from fefinger.mechanics.press import mesh_limits, placement
from fefinger.mechanics.press.load_steps import LoadSteps
from fefinger.mechanics.press.mesh_limits import FORCE_DEPTH, check_depth, needs_continuation
from fefinger.mechanics.press.notes import finger_notes, object_note
from fefinger.mechanics.press.sites import central_sites, end_organ_sites, meshed
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.mesh.store import load_or_build
from fefinger.neural.drives import Reference
from fefinger.results.records import Sites
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD
from fefinger.scene.motion import Motion
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Hard
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import ConvergenceError
from fefinger.support.progress import Stages
from fefinger.support.units import NEWTON_PER_MILLINEWTON


REACH = 1.25  # candidate vertices are those whose gap at first touch is below this times the depth

GROW = 1.4  # factor on the reach when contact meets the border of the candidates

ATTEMPTS = 4  # with GROW: up to 2.7 times the first reach


FRAMES_MOVING, FRAMES_RESTING = 20, 6  # stored fields: along the path, and evenly in time


@dataclass(frozen=True)
class SolutionMethod:
    """How a mechanics builds a body and solves it.

    body(finger, mesh, report) gives the soft tissue, with what solves it under loads;
    reduce as in `fem.body`; unknowns(body, loads) gives the displacement under loads on the pad;
    touch(indenter) where the mesh is fine.
    """

    body: Callable[..., Any]
    reduce: Callable[..., Reduced]
    unknowns: Callable[[Any, Array], Array]
    touch: Callable[[Indenter], float | tuple[float, float] | None]


@dataclass(frozen=True)
class ReferencePlate:
    """The standard plate at first touch, and the central sites below it: the reference press."""

    obstacle: Obstacle
    sites: Sites


@dataclass(frozen=True)
class Press:
    """Inputs of a finite-element contact problem; a solver uses nothing else of a scene.

    mechanics: the name that the answer carries; method: how the body was built and is solved;
    mesh: of all regions; body: the soft tissue that is solved; finger: its sizes and tissues;
    indenter, and the obstacle that it is at first touch; motion, and time (n_t,) s of the answer;
    sites: the end organs whose strain is wanted, if any; reference: the press that scales that
    strain, where spikes are wanted; pressure, fields: whether they are wanted; notes: the
    simplifications that a reader of the answer has to know; inclines (n_t, 2): slopes of a plate
    that turns, if it does; foreseen: a first guess in mm of the largest depth under force control,
    if any.
    """

    mechanics: str
    method: SolutionMethod
    mesh: FingerMesh
    body: Solid
    finger: Finger
    indenter: Indenter
    obstacle: Obstacle
    motion: Motion
    time: Array
    sites: Sites | None
    reference: ReferencePlate | None
    pressure: bool
    fields: bool
    notes: tuple[str, ...]
    inclines: Array | None = None
    foreseen: float | None = None

    @classmethod
    def of(
        cls,
        scene: Scene,
        method: SolutionMethod,
        stages: Stages,
        *,
        mechanics: str,
        notes: tuple[str, ...],
        refine: int = 1,
    ) -> Self:
        """Mesh the finger of a scene, build its body, and place indenter and end organs on it.

        `refine` divides every time step.

        InputError if the indenter does not touch the pad, or goes deeper than the tissue allows.
        """
        finger, ask, motion = scene.finger, scene.ask, scene.motion
        with stages.stage("mesh"):
            # Scenes that are their own mirror image are solved on half a finger.
            half = scene.mirrored
            touch, long = (
                method.touch(scene.indenter),
                needs_continuation(finger, scene.indenter, motion),
            )
            mesh = load_or_build(finger, half=half, touch=touch, with_continuation=long)
        with stages.stage("factor") as report:
            body = method.body(finger, mesh, report)
        obstacle = placement.obstacle(scene.indenter, body)
        check_depth(motion, mesh, obstacle)
        sites = None
        if ask.wants("strain") or ask.spikes:
            skin = partial(meshed, body.space.points, body.pad, body.normals, half=body.half)
            sites = end_organ_sites(ask, finger.pulp, obstacle.first_touch, obstacle.axis, skin)
        feature = scene.indenter.feature if motion.slides else np.inf
        time = time_grid(motion, fast="FAII" in ask.spikes, refine=refine, feature=feature)
        plate = scene.indenter.flat if motion.turns_plate else None
        return cls(
            mechanics=mechanics,
            method=method,
            mesh=mesh,
            body=body,
            finger=finger,
            indenter=scene.indenter,
            obstacle=obstacle,
            motion=motion,
            time=time,
            sites=sites,
            reference=reference_plate(finger, body, ask) if ask.spikes else None,
            pressure=ask.wants("pressure"),
            fields=ask.wants("fields"),
            notes=(
                *notes,
                *finger_notes(finger),
                *mesh.quality.get("notes", ()),
                *of_texture(scene, body, obstacle),
                object_note(scene.indenter),
            ),
            inclines=None if plate is None else motion.inclines(time, plate),
        )

    @property
    def site_points(self) -> Array:
        """Places (n, 3) mm in the meshed part at which the sites are read; none without sites."""
        return self.body.folded(self.sites.points if self.sites else np.empty((0, 3)))

    def unfolded(self, strain: Array) -> Array:
        """Return tensors (..., n, 3, 3) at the sites, given those at `site_points`."""
        return self.body.unfolded(strain, self.sites.points) if self.sites else strain

    def places(self, time: Array | float) -> Array:
        """Return the places (..., 3) mm of the indenter across its axis, at times (...,) in s."""
        return np.asarray(self.motion.shift(time) @ frame(self.obstacle.axis)[:2])

    @property
    def tangential(self) -> bool:
        """Whether the indenter moves sideways or has friction, so that it may push sideways."""
        return self.motion.slides or self.indenter.friction > 0

    @property
    def standard(self) -> bool:
        """Whether it is the press of the standard plate, along its normal."""
        return self.indenter == STANDARD and not self.motion.slides

    @property
    def expected_depth(self) -> float:
        """Largest depth in mm of the motion or, under force control, a first guess."""
        deepest = self.motion.deepest
        return self.foreseen or FORCE_DEPTH * self.finger.thickness if deepest is None else deepest

    @property
    def system(self) -> System:
        """The linear system of a body on a whole mesh; a reduced body has none."""
        if not isinstance(self.body, Body):
            message = f"press: expected a Body with a system, received {type(self.body).__name__}"
            raise TypeError(message)
        return self.body.system

    @property
    def load_unit(self) -> float:
        """Factor from the unit of the motion, mm or N, to mm or mN on the meshed part."""
        return self.motion.control.of(1.0, 1 / NEWTON_PER_MILLINEWTON / self.body.sides)


def of_texture(scene: Scene, body: Solid, obstacle: Obstacle) -> Iterator[str]:
    """Yield notes on a texture that slides, or has stated crests: what the pad's facets blur."""
    indenter, slides = scene.indenter, scene.motion.slides
    if not ((slides or indenter.raised) and np.isfinite(indenter.feature)):
        return
    corners = body.space.points[body.pad]
    # Facets are measured within 4 mm of first touch: the nearest, if waves as high keep it away.
    away = np.linalg.norm(corners.mean(axis=1) - obstacle.first_touch, axis=1)
    near = away <= max(4.0, away.min())
    facet = float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)[near].mean())
    part = indenter.feature / facet
    size = f"its smallest part / facet = {indenter.feature:.2g} / {facet:.2g} mm = {part:.2g}"
    # Width of a dot, ridge or groove over a facet below which a texture is too fine, a convention.
    facets_per_feature = 1.5
    if part < facets_per_feature:
        yield (
            f"Warning: the texture is finer than the mesh resolves, {size} < "
            f"{facets_per_feature:g}: it is averaged over each facet; take a finer mesh "
            "(finger.resolution) or a coarser texture."
        )
    # Width in facets below which FAII count vertices of the mesh: they do over dots 5.4 facets wide
    # (61 impulses/s, on exact layers 0.4) and over narrower ones (suite `friction`).
    facets_per_rate = 6.0
    if slides and "FAII" in scene.ask.spikes and part < facets_per_rate:
        yield (
            f"FAII: over this texture ({size} < {facets_per_rate:g}) they count vertices of the "
            "mesh that come into contact, not its parts (reports/friction.html)."
        )


def reference_plate(finger: Finger, body: Solid, ask: Ask) -> ReferencePlate:
    """Place the standard plate on the body of a finger, with one site per type below it."""
    obstacle = placement.obstacle(STANDARD, body)
    sites = central_sites(ask, finger.pulp, obstacle.origin, obstacle.axis)
    return ReferencePlate(obstacle, sites)


@dataclass(frozen=True)
class SmallStrainHistory:
    """A press solved at small strain, at all times of the answer.

    reduced: the body under unit loads on the candidate vertices; contact: their pressure through
    time; reference: the press that scales strain for the afferents.
    """

    reduced: Reduced
    contact: History
    reference: Reference | None


@dataclass(frozen=True)
class FiniteStrainHistory:
    """A press solved at finite strain, at load steps.

    contact: the candidates and their gaps; steps: the n load steps that were solved, among the
    times of the answer; depth (n,) mm; pressure kPa (n, n_candidates); gap and moved mm (n,
    n_seen), the latter in three components; moment (n, 3) mN mm of the meshed part; strain (n,
    n_sites, 3, 3); sideways: what the object pulls across its axis at the n steps; frames: whole
    states by number of the step; reference: the press that scales strain for the afferents;
    iterations, descents, factors: the work; halt: why it ended before the motion, or nothing.
    """

    contact: ContactSurface
    steps: LoadSteps
    depth: Array
    pressure: Array
    gap: Array
    moved: Array
    moment: Array
    strain: Array
    sideways: SideLoad
    frames: dict[int, Array]
    reference: Reference | None
    iterations: int
    descents: int
    factors: int
    halt: str


def frames_of(depth: Array, peak: int) -> Integers:
    """Choose frames that share the path of the indenter, a few of its rests, and the peak."""
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(depth)))])
    moving = np.searchsorted(path, np.linspace(0, path[-1], FRAMES_MOVING))
    evenly = np.linspace(0, len(depth) - 1, FRAMES_RESTING).round()
    return np.unique(np.concatenate([moving, evenly, [peak]]).astype(np.int64))


Answer = TypeVar("Answer")


def on_enough_candidates(
    body: Solid,
    depth: float,
    candidates: Callable[[float, int], Patch],
    attempt: Callable[[Patch, int], tuple[Answer, Flags]],
) -> Answer:
    """Return the answer of a contact that stays within its candidates.

    candidates(reach, rings) gives those within `reach` mm at first touch, and rings of vertices
    around them: next to an edge the gap grows within a facet to any reach, so each attempt has one
    ring more. attempt(candidates, rings) gives the answer on them, and which (n,) are pressed.
    depth mm: a first guess of the largest.

    Raises
    ------
    OutsideError
        If contact leaves the loadable part of the pad.
    ConvergenceError
        If contact spreads beyond all candidates that are tried.
    """
    reach = REACH * depth
    for rings in range(ATTEMPTS):
        on_pad = candidates(reach, rings)
        answer, pressed = attempt(on_pad, rings)
        reached = np.flatnonzero(on_pad.border & pressed)
        if len(reached) == 0:
            return answer
        if body.cut_off(on_pad.vertices[reached]):
            raise OutsideError(mesh_limits.OUTSIDE)
        reach *= GROW
    raise ConvergenceError(mesh_limits.spread_beyond(reach))


NAIL = 4
"""Region of the skin under an elastic nail; other regions are those of the mesh."""


def elastic(finger: Finger) -> dict[int, Elastic]:
    """Return the elasticity of the regions that are hard and not rigid."""
    parts = {BONE: finger.bone, NAIL: finger.nail}
    return {
        region: Elastic(part.modulus, part.poisson)
        for region, part in parts.items()
        if isinstance(part, Hard)
    }


def fixed_facets(finger: Finger) -> tuple[str, ...]:
    """Return the facets that do not move."""
    bone = "bone-cut" if isinstance(finger.bone, Hard) else "bone"
    nail = ("nail",) if finger.nail is None else ()
    return (bone, *nail, *(("cut",) if finger.cut == "fixed" else ()))


def with_nail(finger: Finger, mesh: FingerMesh) -> FingerMesh:
    """Return the mesh with an elastic nail: the skin that lies nearest to its facets."""
    if not isinstance(finger.nail, Hard):
        return mesh
    skin = np.flatnonzero(mesh.region == SKIN)
    outside = [mesh.points[mesh.facets[name]].mean(axis=1) for name in ("nail", "pad")]
    _, nearest = cKDTree(np.concatenate(outside)).query(mesh.points[mesh.cells[skin]].mean(axis=1))
    region = mesh.region.copy()
    region[skin[nearest < len(outside[0])]] = NAIL
    return replace(mesh, region=region)


def tissues(finger: Finger) -> dict[int, Elastic]:
    """Return the relaxed elasticity of the regions that deform."""
    layers = {1: finger.skin, 2: finger.subcutaneous}
    soft = {region: Elastic(layer.modulus, layer.poisson) for region, layer in layers.items()}
    return soft | elastic(finger)


def materials(finger: Finger) -> dict[int, Material]:
    """Return the relaxed materials at finite strain of the regions that deform."""
    by_region = {region: material_of(each) for region, each in tissues(finger).items()}
    for region, layer in ((1, finger.skin), (2, finger.subcutaneous)):
        law, soft = LAWS[layer.law], by_region[region]
        by_region[region] = replace(soft, law=law, values=layer.law_values)
    return by_region


def relaxations(finger: Finger) -> dict[int, Series]:
    """Return the Prony series of the soft regions, by region."""
    layers = {1: finger.skin.prony, 2: finger.subcutaneous.prony}
    series = {region: prony or finger.prony for region, prony in layers.items()}
    return {
        region: Series(np.array(prony.weights), np.array(prony.v))
        for region, prony in series.items()
    }
