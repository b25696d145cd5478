"""Friction at finite strain, against small strain, balances, symmetry and Uzawa's method."""

from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cache
from unittest.mock import patch

import numpy as np
from fefinger.validation.friction.finger import ASK, ELASTIC, MU, difference, lateral
from fefinger.validation.problems.cube import glued_cube
from scipy.sparse.linalg import splu

from fefinger.fem.hyperelastic.continuum import continuum
from fefinger.fem.hyperelastic.load_path import FrictionHistory
from fefinger.fem.hyperelastic.state import State, Target
from fefinger.geometry.profiles import Plane, frame
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


def _iterated_far() -> AbstractContextManager[object]:
    """Iterate presses as far as any body, for comparisons to more digits than an answer needs."""
    return patch.object(finite_strain, "PRESS_EQUILIBRIUM", EQUILIBRIUM)


@cache
def balance() -> tuple[float, float]:
    """Return friction over mu P less 1, and the load on the bone less P axis + Q, over P.

    They are those after a deep slide.
    """
    press = Press.of(
        scene(DEEP, MU), finite_strain.FINITE_STRAIN, Stages(None), mechanics="solid", notes=()
    )
    with _iterated_far():
        history = finite_strain.solve(press, Stages(None))
    elements = continuum(press.body.space, materials(press.finger), soft=(1, 2))
    values = history.frames[len(history.depth) - 1]
    inner, _ = elements.residual(values, elements.at_rest)
    count = press.body.space.n_displacements
    reaction = inner[:count].copy()
    reaction[press.system.free[press.system.free < count]] = 0.0
    borne = float(history.contact.projected @ history.pressure[-1])
    pulled = history.sideways.force[-1]
    load = borne * press.obstacle.axis + pulled @ frame(press.obstacle.axis)[:2]
    missing = (-reaction.reshape(-1, 3).sum(axis=0) - load) / borne
    return float(np.hypot(*pulled) / (MU * borne) - 1.0), float(np.abs(missing[[0, 2]]).max())


def curve_error() -> float:
    """Return the largest difference of the friction through a slide from small strain.

    Over the largest; at the times between the load steps it is interpolated.
    """
    small, finite = (lateral(shallow(name, ROUGH)).force[:, 0] for name in ("linear", "solid"))
    return float(np.abs(finite - small).max() / np.abs(small).max())


def projected() -> float:
    """Return the difference of pressures and tractions of a cube from those of Uzawa's method.

    Over the highest pressure. The plate is .1 mm deep and moves by .04 mm, so that part of the skin
    slips. By turns the body takes a Newton step under the present tractions, and these are
    projected on Coulomb's law: nothing is shared with the solver but residuals, gaps and slips.
    """
    body, solver = glued_cube(np.eye(3), Plane(), 0.4)
    contact, free = solver.contact, solver.system.free
    areas, none = contact.projected, np.zeros((2, len(contact)))
    rest = State(np.zeros(body.space.n_unknowns), none[0], 0.0, traction=none)
    friction = FrictionHistory(contact, (MU, MU))
    before = solver.find(rest, Target("depth", 0.1, body.at_rest, friction=friction.after(rest)))
    moved = Target(
        "depth", 0.1, body.at_rest, shift=np.array([0.04, 0, 0]), friction=friction.after(before)
    )
    after = solver.find(before, moved)
    state = replace(before, shift=moved.shift)
    step = 2.0  # kPa/mm; less than 2 over the largest compliance of the cube
    inverse = splu(body.tangent(before.values, body.at_rest).tocsc()[np.ix_(free, free)])
    for _ in range(8000):
        gap = contact.at(state)
        inner, _ = body.residual(state.values, body.at_rest)
        loads = gap.loads @ state.pressure + gap.tangential @ state.traction.ravel()
        values = state.values.copy()
        values[free] += inverse.solve((loads - inner)[free])
        state = replace(state, values=values)
        gap = contact.at(state)
        pressure = np.maximum(state.pressure - step * gap.gaps / areas, 0.0)
        traction = state.traction - step * contact.slip(gap, state, before) / areas
        bound, size = MU * pressure, np.hypot(*traction)
        traction *= np.divide(bound, size, where=size > bound, out=np.ones_like(size))
        found = replace(state, pressure=pressure, traction=traction)
        change, state = np.abs(found.contact - state.contact).max(), found
        if change < 1e-9 * pressure.max():
            break
    return float(np.abs(state.contact - after.contact).max() / after.pressure.max())


def mirrored() -> float:
    """Return the difference of a slide to the other side from the mirror image."""
    sides: list[list[Array]] = []
    for direction, sign in ((90.0, 1.0), (270.0, -1.0)):
        with _iterated_far():
            response = solid.respond(scene(0.3, MU, direction))
        one = lateral(response)
        sides.append([response.force, sign * one.force[:, 1], np.asarray(one.work)])
    return difference(*sides)
