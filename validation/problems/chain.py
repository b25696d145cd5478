"""A press on a finger by a chain of models, each of which differs from the last in one thing.

Hertz's half-space is the first and finite strain on the finger the last. All are of relaxed tissue,
so that what relaxes drops out: with one G the force at any pace is the same integral of it.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fefinger.mechanics import hertz, layered, linear, solid
from fefinger.results.records import Response
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.theory.relaxation import Prony


SUBJECTS = ("a.h.", "d.s.", "d.p.", "p.w.")

SPEED = 60.0
"""mm/s of every ramp, that of the experiments and of flat-press."""

DEPTHS = 12
"""Depths of a curve: every fifth time of a ramp, which are steps that `solid` solves."""

FLUSH, LEAST = 8, 2
"""Depths that a plate along the bone is tried at, before its contact reaches the cut, and at least.
"""

PART = 0.2
"""Largest depth over the thickness of the finger, for all but the smallest ball."""

BALL = 0.6
"""Largest depth in mm under the ball of 2 mm; beyond, the pad of `linear` passes its equator."""

PRESSES: dict[str, Indenter] = {"flat-30": Flat(30), "sphere-5": Sphere(5), "sphere-2": Sphere(2)}

CHAIN = {
    "hertz": "Hertz's half-space of one tissue",
    "bone": "the bone, under a flat layer as thick as the pulp",
    "layered": "the layers, skin over subcutaneous tissue",
    "level": "the shape of finger and bone, with the plate along the bone",
    "linear": "the angle of 30 degrees",
    "solid": "finite strain",
}
"""The models in the order of the split, and what each adds to the one before."""

ASIDE = {"whole": "the shape without layers: one tissue on the finger at 30 degrees"}


def deepest(finger: Finger, press: str) -> float:
    """Return the largest depth in mm of a press."""
    return BALL if press == "sphere-2" else PART * finger.thickness


def scene(subject: str, press: str, resolution: str = "standard", *, relaxed: bool = True) -> Scene:
    """Return the ramp of a press, of relaxed tissue or of one that relaxes."""
    finger = Finger.subject(subject, resolution=resolution, tissue="maeno1998")
    if relaxed:
        finger = replace(finger, prony=Prony((1.0,), ()))
    motion = Ramp(SPEED, deepest(finger, press), corner=0.0)
    ask = Ask(force=True, pressure=False, strain=False, spikes=(), fields=False)
    return Scene(finger=finger, indenter=PRESSES[press], motion=motion, ask=ask)


def stiffening(pressed: Scene, exponent: float) -> Scene:
    """Return the scene with tissue that stiffens as exp(b (I1 - 3)), Demiray's law."""
    finger = pressed.finger
    skin = replace(finger.skin, law="demiray", exponent=exponent)
    rest = replace(finger.subcutaneous, law="demiray", exponent=exponent)
    return replace(pressed, finger=replace(finger, skin=skin, subcutaneous=rest))


def one_tissue(pressed: Scene) -> Scene:
    """Return the scene with one tissue for both layers, the one that `hertz` has."""
    finger = pressed.finger
    modulus, poisson = hertz.tissue(finger)
    skin = replace(finger.skin, modulus=modulus, poisson=poisson)
    rest = replace(finger.subcutaneous, modulus=modulus, poisson=poisson)
    return replace(pressed, finger=replace(finger, skin=skin, subcutaneous=rest))


def level(pressed: Scene) -> Scene:
    """Return the scene with the plate parallel to the bone."""
    return replace(pressed, indenter=Flat(0))


MODELS: dict[str, Callable[[Scene], Response]] = {
    "hertz": hertz.respond,
    "bone": lambda pressed: layered.respond(one_tissue(pressed)),
    "layered": layered.respond,
    "level": lambda pressed: linear.respond(level(pressed)),
    "linear": linear.respond,
    "whole": lambda pressed: linear.respond(one_tissue(pressed)),
    "solid": solid.respond,
}
"""What answers a scene, by the names of CHAIN and ASIDE."""


def models(press: str) -> tuple[str, ...]:
    """Return the names of the chain for a press; a ball has no angle."""
    return tuple(name for name in CHAIN if name != "level" or PRESSES[press] == Flat(30))


def reaching(model: str, pressed: Scene) -> tuple[Array, Array, Response]:
    """Return the curve as deep as the model allows, the rest nan.

    The contact of a plate that lies along the bone soon reaches the cut of the finger.

    Raises
    ------
    InputError, ConvergenceError
        If it allows less than LEAST of the depths.
    """
    most = FLUSH if model == "level" else DEPTHS
    for count in range(most, LEAST - 1, -2):
        depth = pressed.motion.peak * count / DEPTHS
        motion = Ramp(SPEED, depth, corner=0.0)
        try:
            response = MODELS[model](replace(pressed, motion=motion))
        except (InputError, ConvergenceError):
            if count - 2 < LEAST:
                raise
            continue
        wanted = pressed.motion.peak * np.arange(1, DEPTHS + 1) / DEPTHS
        forces = np.full(DEPTHS, np.nan)
        forces[:count] = np.interp(wanted[:count], response.depth, response.force)
        return wanted, forces, response
    raise AssertionError
