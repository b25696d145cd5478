"""A plate that slides at finite strain, against small strain, balances and symmetry."""

from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cache
from unittest.mock import patch

import numpy as np
from fefinger.validation.friction.finger import ASK, ELASTIC, MU, difference, lateral

from fefinger.fem.hyperelastic.continuum import continuum
from fefinger.fem.hyperelastic.state import State
from fefinger.mechanics import linear, solid
from fefinger.mechanics.press import finite_strain
from fefinger.mechanics.press.problem import Press, materials
from fefinger.results.records import Response
from fefinger.scene.indenters import Flat
from fefinger.scene.scene import Scene
from fefinger.scene.sliding import Slide
from fefinger.support.arrays import Array
from fefinger.support.progress import Stages
from fefinger.support.tolerances import EQUILIBRIUM


SHALLOW, DEEP = 0.08, 1.0  # mm
ROUGH = 0.8


def scene(depth: float, mu: float, direction: float = 180.0) -> Scene:
    """Return a plate that is pressed and slides proximally, on elastic tissue."""
    motion = Slide(20, depth, distance=max(2 * depth, 1.0), direction=direction, settle=0.0)
    finger = replace(ELASTIC, resolution="coarse")
    return Scene(finger=finger, indenter=Flat(30, friction=mu), motion=motion, ask=ASK)


@cache
def shallow(mechanics: str, mu: float) -> Response:
    """Return the answer of small or finite strain to a shallow slide."""
    return {each.name: each for each in (linear, solid)}[mechanics].respond(scene(SHALLOW, mu))


def change_ratio() -> float:
    """Return by how much friction changes the force, at finite over small strain."""
    small, finite = (
        shallow(name, ROUGH).force[-1] / shallow(name, 0.0).force[-1] - 1
        for name in ("linear", "solid")
    )
    return float(finite / small)


def onset_ratio() -> float:
    """Return the path at which the whole contact slips, at finite over small strain.

    At small strain none of it sticks from there on; at finite strain no skin was drawn as far.
    """
    small = lateral(shallow("linear", ROUGH))
    assert small.stick_area is not None
    path = np.abs(small.shift[:, 0])
    first = int(np.flatnonzero((path > 0) & (small.stick_area == 0))[0])
    words = lateral(shallow("solid", ROUGH)).outcome
    assert words.startswith("Gross slip")
    return float(words.split("moved by ")[1].split(" mm")[0]) / float(path[first])


def _iterated_far() -> AbstractContextManager[object]:
    """Iterate presses as far as any body, for comparisons to more digits than an answer needs."""
    return patch.object(finite_strain, "PRESS_EQUILIBRIUM", EQUILIBRIUM)


@cache
def balance() -> tuple[float, float]:
    """Return the deviations from P (axis + mu s), over P, in the contact and on the bone.

    They are those after a deep slide.
    """
    press = Press.of(
        scene(DEEP, MU), finite_strain.FINITE_STRAIN, Stages(None), mechanics="solid", notes=()
    )
    with _iterated_far():
        history = finite_strain.solve(press, Stages(None))
    elements = continuum(press.body.space, materials(press.finger), soft=(1, 2))
    last = len(history.depth) - 1
    values = history.frames[last]
    inner, _ = elements.residual(values, elements.at_rest)
    count = press.body.space.n_displacements
    reaction = inner[:count].copy()
    reaction[press.system.free[press.system.free < count]] = 0.0
    borne = float(history.contact.projected @ history.pressure[-1])
    proximal = np.array([-np.cos(np.radians(30)), 0.0, -np.sin(np.radians(30))])
    along = press.obstacle.axis + MU * proximal
    state = State(values, history.pressure[last], float(history.depth[last]))
    pulled = history.contact.at(state).pulled(MU * proximal) @ state.pressure
    forces = [pulled[:count], -reaction]
    missing = [each.reshape(-1, 3).sum(axis=0) / borne - along for each in forces]
    contact, bone = (float(np.abs(each[[0, 2]]).max()) for each in missing)
    return contact, bone


def mirrored() -> float:
    """Return the difference of a slide to the other side from the mirror image."""
    sides: list[list[Array]] = []
    for direction, sign in ((90.0, 1.0), (270.0, -1.0)):
        with _iterated_far():
            response = solid.respond(scene(0.3, MU, direction))
        one = lateral(response)
        sides.append([response.force, sign * one.force[:, 1], np.asarray(one.work)])
    return difference(*sides)
