"""Suite `finger`: a real finger balances, converges, fires the same again, and is not Hertz's."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import product

import numpy as np
from fefinger.validation.case import Case, Expected, Row, tabled
from fefinger.validation.finger import causes, strain
from fefinger.validation.finger import figures as finger_figures
from fefinger.validation.finger import solid as finger_solid
from fefinger.validation.problems import published

from fefinger.afferents import fire
from fefinger.contact.complementarity import Complementarity
from fefinger.fem.body import body, reduce
from fefinger.fem.contact.patch import patch
from fefinger.fem.elements.probe import strain_at
from fefinger.mechanics import linear, solid
from fefinger.mechanics.press import finite_strain, placement, small_strain
from fefinger.mechanics.press.problem import fixed_facets, tissues, with_nail
from fefinger.mesh.store import load_or_build
from fefinger.results.records import Response
from fefinger.scene.finger import RIGID
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Hard
from fefinger.support.arrays import Array


DEPTH = 1.0  # mm
BONE_TISSUE = Hard(17e6, 0.3)  # along the bone: Reilly and Burstein, J. Biomech. 8:393, 1975
NAIL = Hard(2e6, 0.3)  # some GPa: Baden, J. Invest. Dermatol. 55:115, 1970
QUICK, STANDARD = "coarse", "standard"
KINDS = ("SAI", "SAII", "FAI", "FAII")


@dataclass(frozen=True)
class Balance:
    """A small-strain press: force in mN of the meshed half, and the sum (3,) of the reactions."""

    axis: Array
    force: float
    reactions: Array


@cache
def pressed(
    resolution: str, depth: float, bone: str | Hard = RIGID, nail: Hard | None = None
) -> Balance:
    """Return the press of relaxed tissue; an elastic bone is held at its cut, not all around."""
    finger = published.load("flat-press").finger
    finger = replace(finger, resolution=resolution, bone=bone, nail=nail)
    mesh = with_nail(finger, load_or_build(finger, half=True))
    whole = body(mesh, tissues(finger), fixed_facets(finger))
    touch = placement.obstacle(Flat(30), whole)
    on_pad = patch(whole.space, whole.pad, whole.normals, touch, 1.25 * depth)
    small = reduce(whole, on_pad, strain_at(whole.space, np.empty((0, 3))))
    pressure = Complementarity(small.flexibility).solve(on_pad.gap - depth * on_pad.projected)
    loads = on_pad.loads @ pressure
    reactions = np.zeros(whole.space.n_unknowns)
    reactions[whole.system.fixed] = whole.system.reactions(whole.system.solve(loads), loads)
    total = reactions[: whole.space.n_displacements].reshape(-1, 3).sum(axis=0)
    return Balance(touch.axis, float(on_pad.projected @ pressure), total)


def balance(resolution: str, bone: str | Hard = RIGID) -> tuple[float, float]:
    """Return the relative differences of contact force and reactions, along and across the axis."""
    solution = pressed(resolution, DEPTH, bone)
    across = np.cross([0.0, 1.0, 0.0], solution.axis)
    along = float(-solution.reactions @ solution.axis / solution.force - 1)
    return along, float(solution.reactions @ across / solution.force)


def yielding(resolution: str, bone: str | Hard = BONE_TISSUE, nail: Hard | None = None) -> float:
    """Return the relative change of the force at DEPTH by an elastic bone or nail."""
    rigid = pressed(resolution, DEPTH).force
    return pressed(resolution, DEPTH, bone, nail).force / rigid - 1


def peak(resolution: str) -> float:
    """Return the relative change of the peak force of `solid` by a bone that does not relax."""
    scene = published.load(
        "flat-press", {"ask.fields": False, "ask.strain": False, "ask.spikes": []}
    )
    motion, forces = Ramp(60, DEPTH), []
    for bone in (RIGID, BONE_TISSUE):
        finger = replace(scene.finger, resolution=resolution, bone=bone)
        forces.append(solid.respond(replace(scene, finger=finger, motion=motion)).force.max())
    return float(forces[1] / forces[0] - 1)


@cache
def ramp(resolution: str, angle: float = 30.0, tilt: float = 0.0) -> Response:
    """Return the response to a slow ramp of DEPTH."""
    scene = published.load("flat-press")
    ask_of_scene = replace(scene.ask, spikes=(), fields=False)
    finger = replace(scene.finger, resolution=resolution)
    press = Scene(
        finger=finger, indenter=Flat(angle, tilt), motion=Ramp(60, DEPTH), ask=ask_of_scene
    )
    return linear.respond(press)


def mirror(resolution: str) -> float:
    """Return the largest difference of the forces at opposite tilts, over the largest force."""
    left, right = ramp(resolution, tilt=10.0), ramp(resolution, tilt=-10.0)
    return float(np.abs(left.force - right.force).max() / left.force.max())


def pull(resolution: str) -> float:
    """Return the lowest pressure in kPa."""
    pressure = ramp(resolution).pressure
    assert pressure is not None
    return float(pressure.min())


@cache
def spikes(mechanics: str, refine: int) -> dict[str, int]:
    """Return the spike counts of flat-press with every time step divided by `refine`.

    `solid` answers on the coarse mesh.
    """
    scene = published.load("flat-press", {"ask.fields": False})
    if mechanics == solid.name:
        scene = replace(scene, finger=replace(scene.finger, resolution=QUICK))
    solver = {linear.name: small_strain, solid.name: finite_strain}[mechanics]
    response = solver.respond(scene, mechanics=mechanics, notes=(), refine=refine)
    fired = fire(scene.ask, response)
    return dict(zip(fired.types, fired.count().tolist(), strict=True))


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield balance, symmetry and, when not quick, the spikes of flat-press at half the step."""
    yield from tabled(_on_mesh(QUICK if quick else STANDARD))
    yield from causes.cases(quick=quick)
    if quick:
        return
    name = "solid, coarse: an elastic bone of 17 GPa: change of the peak after 17 ms"
    limits = Expected(0.0, 1.0, "%")
    reason = "bone does not relax, so that it bends more under tissue that has not yet"
    yield Case(name, lambda: 100 * peak(QUICK), limits, "the rigid bone", reason=reason)
    yield from tabled(finger_solid.CASES)
    yield from strain.cases()
    for mechanics, kind in product((linear.name, solid.name), KINDS):
        title = f"{mechanics}: spikes of {kind} in flat-press, change with half the time step"
        measure = partial(lambda m, k: spikes(m, 2)[k] - spikes(m, 1)[k], mechanics, kind)
        yield Case(title, measure, Expected(0.0, 0.0, "spikes"), "the full step")


def _on_mesh(resolution: str) -> dict[str, Row]:
    statics = "equilibrium of the body"
    return {
        "contact force against reactions": Row(
            lambda: balance(resolution)[0], Expected(0.0, 1e-6), statics
        ),
        "tangential reaction over the force": Row(
            lambda: balance(resolution)[1], Expected(0.0, 1e-6), statics
        ),
        "an elastic bone of 17 GPa held at its cut: change of the force": Row(
            lambda: 100 * yielding(resolution),
            Expected(0.0, 0.5, "%"),
            "the rigid bone",
            "it bends; what the rigid bone of every scene leaves out",
        ),
        "a nail of 2 GPa that floats on its bed: change of the force": Row(
            lambda: 100 * yielding(resolution, RIGID, NAIL),
            Expected(0.0, 3.0, "%"),
            "the nail that is held, as glued in the experiment",
            "it moves as one piece, and stiffens the skin under it",
        ),
        "an elastic bone: contact force against reactions, moduli 5e5 apart": Row(
            lambda: balance(resolution, BONE_TISSUE)[0], Expected(0.0, 1e-8), statics
        ),
        "lowest pressure": Row(lambda: pull(resolution), Expected(0.0, 0.0, "kPa"), "no adhesion"),
        "forces at tilts of 10 and -10 degrees": Row(
            lambda: mirror(resolution), Expected(0.0, 1e-6), "mirror image"
        ),
    }


finding = finger_figures.finding
figures = finger_figures.figures
