"""Scenes on which `pressed` is compared with `solid`.

They are four draws, the deep built-in scenes, and light touches.
"""

from dataclasses import replace
from itertools import product

import numpy as np
from numpy.random import Generator

from fefinger.scene import builtin
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.library import calibrated_name
from fefinger.scene.motion import Motion
from fefinger.scene.motions import RampHold, RampSinusoid, Sinusoid, Trapezoid
from fefinger.scene.scene import Scene


BUILT_IN = ("press-to-1N", "flat-sinusoid", "p5-quasi-static-array", "p9-ramp-hold-retract")
"""Built-in scenes deeper than 0.16 of the thickness: under the plate at 30 degrees, on a.h."""

SEEDS = {"rules": 24_01, "held-out": 24_02, "deep": 24_03, "standard": 24_04}
COUNTS = {"rules": 30, "held-out": 48, "deep": 8, "standard": 20}
STANDARD = {"rules": 2, "held-out": 4, "deep": 0, "standard": 20}
"""How many scenes of each set, the last, are on the standard mesh; others are on the coarse one."""

SUBJECTS = ("a.h.", "d.p.", "d.s.", "p.w.")
PUBLISHED = ("maeno1998", "saal2017")
KINDS = ("ramp-hold", "trapezoid", "ramp-sinusoid", "sinusoid", "force-ramp-hold")

PARTS = {
    "rules": (0.05, 0.16),
    "held-out": (0.05, 0.16),
    "deep": (0.16, 0.24),
    "standard": (0.05, 0.16),
}
"""Least and largest depth over the thickness of the finger."""

SPEED = (0.2, 500.0)
"""Least and largest speed in mm/s."""

OBJECTS: tuple[Indenter, ...] = (Flat(30), Sphere(5.0))
LIGHT, LIGHT_SPEEDS = (0.02, 0.03, 0.05, 0.07), (5.0, 20.0, 100.0)
"""Objects, depths over the thickness and speeds in mm/s of the light touches: few or no scenes are
drawn at these depths."""


def drawn(name: str) -> list[Scene]:
    """Return the scenes of a set, the same each time.

    "built-in" and "light" ones are on the coarse mesh.
    """
    if name == "built-in":
        coarse_mesh = {"finger.resolution": "coarse"}
        ask = Ask(fields=False)
        return [replace(builtin.load(each, coarse_mesh), ask=ask) for each in BUILT_IN]
    if name == "light":
        return [_light(*each) for each in product(OBJECTS, LIGHT, LIGHT_SPEEDS)]
    rng = np.random.default_rng(SEEDS[name])
    scenes = [_scene(rng, f"{name} {number}", PARTS[name]) for number in range(COUNTS[name])]
    coarse = COUNTS[name] - STANDARD[name]
    meshes = ["coarse"] * coarse + ["standard"] * STANDARD[name]
    return [
        replace(scene, finger=replace(scene.finger, resolution=mesh))
        for scene, mesh in zip(scenes, meshes, strict=True)
    ]


def _light(indenter: Indenter, part: float, speed: float) -> Scene:
    """Return a light touch on the coarse finger of a.h. that retreats after a short hold."""
    finger = Finger.subject("a.h.", resolution="coarse")
    motion = Trapezoid(speed, part * finger.thickness, hold=0.2)
    name = f"light {indenter.kind} {part:g} {speed:g}"
    return Scene(name=name, finger=finger, indenter=indenter, motion=motion, ask=Ask(fields=False))


def _scene(rng: Generator, name: str, part: tuple[float, float]) -> Scene:
    subject = str(rng.choice(SUBJECTS))
    calibrated = rng.random() < 0.75
    tissue = calibrated_name(subject) if calibrated else str(rng.choice(PUBLISHED))
    finger = Finger.subject(subject, tissue=tissue)
    indenter = _indenter(rng)
    deepest = float(rng.uniform(*part)) * finger.thickness
    motion = _motion(rng, str(rng.choice(KINDS)), deepest)
    return Scene(name=name, finger=finger, indenter=indenter, motion=motion, ask=Ask(fields=False))


def _indenter(rng: Generator) -> Indenter:
    """Return a plate within the angles of the shipped meshes, or a ball in their middle."""
    if rng.random() < 0.6:
        return Flat(angle=round(float(rng.uniform(23.0, 37.0)), 1))
    return Sphere(radius=round(float(rng.uniform(3.5, 8.0)), 1))


def _motion(rng: Generator, kind: str, deepest: float) -> Motion:
    speed = float(np.exp(rng.uniform(*np.log(SPEED))))
    hold = float(np.exp(rng.uniform(np.log(0.05), np.log(3.0))))
    if kind == "ramp-hold":
        return RampHold(speed=speed, depth=deepest, hold=hold)
    if kind == "trapezoid":
        return Trapezoid(speed=speed, depth=deepest, hold=hold)
    share = float(rng.uniform(0.1, 0.5))
    frequency = float(np.exp(rng.uniform(np.log(0.5), np.log(8.0))))
    if kind == "ramp-sinusoid":
        return RampSinusoid(
            speed=speed,
            depth=deepest * (1 - share),
            amplitude=deepest * share,
            frequency=frequency,
            cycles=2,
        )
    if kind == "sinusoid":
        return Sinusoid(amplitude=deepest / 2, frequency=frequency, cycles=2)
    return RampHold(
        loading_rate=float(np.exp(rng.uniform(np.log(0.2), np.log(5.0)))),
        force=float(rng.uniform(0.2, 1.0)),
        hold=hold,
    )
