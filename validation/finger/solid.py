"""Cases of suite `finger` on finite strain: balance, symmetry, the limit of small depth."""

from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Expected, Row
from fefinger.validation.problems.chain import scene

from fefinger.contact.complementarity import Complementarity
from fefinger.fem.body import Body, body
from fefinger.fem.contact.deformed_gap import ContactSurface, contact_surface
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.hyperelastic.continuum import Continuum, continuum
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.hyperelastic.state import State, Target
from fefinger.mechanics import solid
from fefinger.mechanics.press import finite_strain, placement
from fefinger.mechanics.press.problem import fixed_facets, materials, tissues
from fefinger.mesh.store import load_or_build
from fefinger.results.records import Response
from fefinger.scene.ask import Ask
from fefinger.scene.indenters import Flat
from fefinger.scene.motion import Motion
from fefinger.scene.motions import Ramp
from fefinger.scene.samples import Sampled
from fefinger.support.arrays import Array


DEPTH, REACH = 0.4, 0.5  # mm
SHALLOW = 0.01  # mm
FINER = 8
CHANGING = {
    "a press that drifts on": Sampled((0.0, 0.05, 5.0), (0.0, 0.5, 0.52), corner=0.0),
    "two presses and a slow start": Sampled(
        (0.0, 0.5, 0.52, 2.0, 2.02, 4.0), (0.0, 0.02, 0.25, 0.27, 0.5, 0.52), corner=0.0
    ),
}
"""Motions that change their speed."""

PRESSURE = Ask(force=True, pressure=True, strain=False, spikes=(), fields=False)


@dataclass(frozen=True)
class PressedFinger:
    """The relaxed coarse finger, its candidates for contact within REACH, and the plate."""

    finger: Body
    elements: Continuum
    touch: Obstacle
    contact: ContactSurface

    def at(self, depths: Array) -> list[State]:
        """Return the states of finite strain at growing depths in mm."""
        state = State(np.zeros(self.finger.space.n_unknowns), np.zeros(len(self.contact)), 0.0)
        equilibrium = Equilibrium(self.elements, self.contact, self.finger.system)
        states = []
        for depth in depths:
            target = Target("depth", float(depth), self.elements.at_rest)
            state = equilibrium.find(state, target)
            states.append(state)
        return states


@cache
def plate() -> PressedFinger:
    """Return the finger of flat-press under its plate."""
    finger = scene("a.h.", "flat-30", "coarse").finger
    rigid = body(load_or_build(finger, half=True), tissues(finger), fixed_facets(finger))
    touch = placement.obstacle(Flat(30), rigid)
    contact = contact_surface(rigid.space, rigid.pad, rigid.normals, touch, REACH)
    return PressedFinger(rigid, continuum(rigid.space, materials(finger)), touch, contact)


@cache
def balance() -> tuple[float, float]:
    """Return the relative differences of contact force and reactions, along and across the axis."""
    on = plate()
    state = on.at(np.linspace(0, DEPTH, 5)[1:])[-1]
    inner, _ = on.elements.residual(state.values, on.elements.at_rest)
    loads = on.contact.at(state).loads
    reactions, fixed = np.zeros_like(inner), on.finger.system.fixed
    reactions[fixed] = (inner - loads @ state.pressure)[fixed]
    total = reactions[: on.finger.space.n_displacements].reshape(-1, 3).sum(axis=0)
    force = float(on.contact.projected @ state.pressure)
    across = np.cross([0.0, 1.0, 0.0], on.touch.axis)
    return float(-total @ on.touch.axis / force - 1), float(total @ across / force)


def approach() -> float:
    """Return the order in the force with which the force becomes that of small strain.

    That of the weighted gaps as they are before the finger moves: those of `linear` are not bent.
    So shallow that one vertex of the coarse mesh touches, and the contact does not grow.
    """
    on, depths = plate(), SHALLOW * np.array([1.0, 2.0])
    expected = np.array([_small(on, depth) for depth in depths])
    forces = np.array([on.contact.projected @ state.pressure for state in on.at(depths)])
    apart = np.abs(forces / expected - 1)
    return float(np.log(apart[1] / apart[0]) / np.log(expected[1] / expected[0]))


def _small(on: PressedFinger, depth: float) -> float:
    """Return the force in mN at small strain under the weighted gaps of the finger at rest."""
    rest = np.zeros(on.finger.space.n_unknowns)
    gap = on.contact.at(State(rest, np.zeros(len(on.contact)), depth))
    loads = gap.loads.toarray()
    flexibility = loads.T @ on.finger.system.solve(loads)
    return float(on.contact.projected @ Complementarity(flexibility).solve(gap.gaps))


def tilted(tilt: float) -> Response:
    """Return the response to a plate rolled about the finger."""
    pressed = scene("a.h.", "flat-30", "coarse")
    motion = Ramp(60, DEPTH, corner=0.0)
    return solid.respond(replace(pressed, indenter=Flat(30, tilt), motion=motion, ask=PRESSURE))


def mirror() -> float:
    """Return the largest difference of the forces at opposite tilts, over the largest force."""
    left, right = tilted(10.0), tilted(-10.0)
    return float(np.abs(left.force - right.force).max() / left.force.max())


def pull() -> float:
    """Return the lowest pressure in kPa."""
    pressure = tilted(10.0).pressure
    assert pressure is not None
    return float(pressure.min())


def finer(motion: Motion) -> float:
    """Difference of the force through time from that with FINER times the steps, over its peak.

    On the coarse mesh; the times of both are the same.
    """
    ask = replace(PRESSURE, pressure=False)
    finer_scene = replace(scene("a.h.", "flat-30", "coarse"), motion=motion, ask=ask)
    few, many = (
        finite_strain.respond(finer_scene, mechanics="solid", notes=(), refine=refine).force
        for refine in (1, FINER)
    )
    return float(np.abs(few - many).max() / many.max())


CASES: dict[str, Row] = {
    "finite strain: contact force against reactions": Row(
        lambda: balance()[0], Expected(0.0, 1e-6), "equilibrium of the body"
    ),
    "finite strain: tangential reaction over the force": Row(
        lambda: balance()[1], Expected(0.0, 1e-6), "equilibrium of the body"
    ),
    "finite strain: order in the force of the limit of small strain": Row(
        approach, Expected(1.0, 0.05), "first order of the strain"
    ),
    "finite strain: forces at tilts of 10 and -10 degrees": Row(
        mirror, Expected(0.0, 1e-5), "mirror image"
    ),
    "finite strain: lowest pressure": Row(pull, Expected(0.0, 0.0, "kPa"), "no adhesion"),
    # Between steps the coarse contact grows by whole vertices.
    **{
        f"finite strain: steps of {name}": Row(
            partial(finer, motion),
            Expected(0.0, 0.015),
            f"{FINER} times the steps",
        )
        for name, motion in CHANGING.items()
    },
}
"""Balance, order, symmetry, the lowest pressure and steps in time, on the coarse mesh."""
