"""The scenes of the trade-off, drawn at random: held out, and those that rules were tried on."""

import numpy as np

from fefinger.scene import library
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Bar, Cylinder, Flat, Sphere
from fefinger.scene.motion import Motion
from fefinger.scene.motions import Ramp, RampHold, Sinusoid, Trapezoid
from fefinger.scene.scene import Scene
from fefinger.scene.textured import Grating


DEVELOPMENT = {37: 12, 38: 24, 39: 24}
"""Seeds and numbers of the scenes from which the factors of the rule of stated errors come."""

N_HELD_OUT, SEED = 40, 50

PLAIN = (
    *("plate", "ball", "plate", "bar", "plate", "ball", "plate", "grating"),
    *("plate", "ball", "plate", "cylinder"),
)
"""Kinds of objects of the scenes of development, in turn."""

OBJECTS = (
    *("plate", "ball", "tilted", "bar", "plate", "grating", "ball", "cylinder"),
    *("plate", "bar", "ball", "grating", "plate"),
)
"""Kinds of objects of the held-out scenes, in turn."""

DEEPEST = {
    **{"plate": 0.19, "ball": 0.17, "tilted": 0.13, "bar": 0.11, "grating": 0.14},
    "cylinder": 0.14,
}
"""Largest depth of each kind, over the thickness of the finger."""

STEEP, STEEP_DEEPEST = 35.0, 0.16
"""Angle in degrees beyond which plates go less deep, and their largest depth."""

TOLERANCES = (0.02, 0.05, 0.1, 0.2, 0.4)


def development() -> dict[str, Scene]:
    """Return the scenes of development, drawn as the held-out ones; seeds are in their names."""
    draws = {seed: held_out(count, seed, PLAIN) for seed, count in DEVELOPMENT.items()}
    return {
        f"{seed}, {key}": scene for seed, drawn in draws.items() for key, scene in drawn.items()
    }


def held_out(
    count: int = N_HELD_OUT, seed: int = SEED, objects: tuple[str, ...] = OBJECTS
) -> dict[str, Scene]:
    """Return the held-out scenes: finger, object, depth, speed, motion and tolerance at random.

    All are within what was measured: depths are 15 to 95 % of DEEPEST, speeds 1 to 100 mm/s. Every
    other finger has published tissue; the others are those that were calibrated, or of any size
    with the tissue of the means.
    """
    rng = np.random.default_rng(seed)
    scenes = {}
    for number in range(count):
        kind = objects[number % len(objects)]
        finger, whose = _finger(rng, published=bool(number // 2 % 2))
        indenter = object_of(rng, kind)
        steep = indenter.flat is not None and indenter.flat.angle > STEEP
        deepest = finger.thickness * (STEEP_DEEPEST if steep else DEEPEST[kind])
        name = f"{whose}, {kind}"
        key = f"{number:02d} {name}"
        scenes[key] = _drawn(rng, f"held-out {number:02d}, {name}", finger, indenter, deepest)
    return scenes


def _finger(rng: np.random.Generator, *, published: bool) -> tuple[Finger, str]:
    """Return a finger at random, and what it is called."""
    if published:
        subject = str(rng.choice(["a.h.", "a.h.", "d.s."]))
        return Finger.subject(subject, tissue=library.PUBLISHED), f"published {subject}"
    subject = str(rng.choice(["a.h.", "a.h.", "d.s.", "d.p.", "p.w.", ""]))
    if subject:
        return Finger.subject(subject), subject
    thickness = round(float(rng.uniform(10.0, 12.5)), 1)
    width = round(thickness * float(rng.uniform(1.2, 1.4)), 1)
    return Finger(width, thickness), f"{width:g} x {thickness:g} mm"


def object_of(rng: np.random.Generator, kind: str) -> Indenter:
    """Return an object of a kind at random."""
    if kind == "plate":
        return Flat(round(float(rng.uniform(0.0, 60.0)), 1))
    if kind == "tilted":
        angle, tilt = rng.uniform(15.0, 45.0), rng.uniform(4.0, 15.0)
        return Flat(round(float(angle), 1), tilt=round(float(tilt), 1))
    if kind == "ball":
        return Sphere(round(float(rng.uniform(3.0, 12.0)), 1))
    if kind == "cylinder":
        return Cylinder(round(float(rng.uniform(5.0, 9.0)), 1), roll=90.0)
    if kind == "bar":
        width = round(float(rng.uniform(2.0, 4.0)), 2)
        return Bar(width, corner=width / 2)
    period = round(float(rng.uniform(4.0, 6.0)), 2)
    return Grating(period, period / 2, 0.6, angle=round(float(rng.uniform(10.0, 30.0)), 1))


def _drawn(
    rng: np.random.Generator, name: str, finger: Finger, indenter: Indenter, deepest: float
) -> Scene:
    depth = round(float(rng.uniform(0.15, 0.95)) * deepest, 3)
    speed = float(f"{10 ** rng.uniform(0, 2):.3g}")
    kind = str(rng.choice(["ramp-hold", "ramp", "trapezoid", "sinusoid"]))
    alone = bool(rng.random() < 0.4)  # the force and nothing else
    ask = Ask(
        pressure=not alone,
        strain=not alone,
        fields=False,
        rel_error=float(rng.choice(TOLERANCES)),
    )
    motion = _motion(kind, depth, speed)
    return Scene(name=name, finger=finger, indenter=indenter, motion=motion, ask=ask)


def _motion(kind: str, depth: float, speed: float) -> Motion:
    corner = min(0.01, 0.1 * depth / speed)
    if kind == "ramp":
        return Ramp(speed, depth, corner=corner)
    if kind == "ramp-hold":
        return RampHold(speed, depth, hold=1.0, corner=corner)
    if kind == "trapezoid":
        return Trapezoid(speed, depth, hold=0.3, corner=corner)
    return Sinusoid(depth / 2, float(f"{speed / (np.pi * depth):.3g}"), 2)
