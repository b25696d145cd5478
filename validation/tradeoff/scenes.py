"""The scenes of the trade-off: presses of relaxed tissue, base scenes, and scenes held out.

With one G for all tissue the elastic press decides every motion (`tradeoff_motion`), so one press
serves many scenes of its object.
"""

from dataclasses import dataclass, replace

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
from fefinger.theory.relaxation import Prony


TYPES = ("SAI", "SAII", "FAI", "FAII")

SPEED = 60.0
"""mm/s of every press; of relaxed tissue, so that it has no meaning but the number of steps."""


@dataclass(frozen=True)
class Object:
    """A press: subject whose finger is pressed, the object, and the largest depth in mm."""

    subject: str
    indenter: Indenter
    depth: float


BASE = {
    "flat-30": Object("a.h.", Flat(30), 1.9),
    "flat-15": Object("a.h.", Flat(15), 1.5),
    "flat-0": Object("a.h.", Flat(0), 1.0),
    "sphere-10": Object("a.h.", Sphere(10), 2.0),
    "sphere-5": Object("a.h.", Sphere(5), 1.5),
    "sphere-2": Object("a.h.", Sphere(2), 0.6),
}
"""Presses that the planner's rules are derived from."""

GRATING = Grating(5.0, 2.4, 0.6)

DEVELOPMENT: dict[str, tuple[Finger, Indenter, float]] = {
    name: (finger, indenter, part * finger.thickness)
    for name, finger, indenter, part in (
        ("published, plate", Finger.subject("a.h.", tissue=library.PUBLISHED), Flat(20), 0.15),
        ("published, ball", Finger.subject("a.h.", tissue=library.PUBLISHED), Sphere(7), 0.18),
        ("published, d.s.", Finger.subject("d.s.", tissue=library.PUBLISHED), Flat(30), 0.17),
        ("published, bar", Finger.subject("a.h.", tissue=library.PUBLISHED), Bar(2.6, 1.2), 0.1),
        ("published, steep", Finger.subject("a.h.", tissue=library.PUBLISHED), Flat(52), 0.14),
        ("plate", Finger.subject("a.h."), Flat(22), 0.18),
        ("d.s., steep", Finger.subject("d.s."), Flat(37), 0.16),
        ("p.w., ball", Finger.subject("p.w."), Sphere(6), 0.16),
        ("another finger", Finger(15.0, 12.0), Flat(30), 0.15),
        ("small ball", Finger.subject("a.h."), Sphere(3), 0.12),
        ("grating", Finger.subject("a.h."), Grating(5.0, 2.4, 0.6, angle=20.0), 0.13),
        ("bar", Finger.subject("d.p."), Bar(3.0, 1.5), 0.1),
        ("cylinder", Finger.subject("a.h."), Cylinder(6.0, roll=90.0), 0.14),
        ("published, grating", Finger.subject("a.h.", tissue=library.PUBLISHED), GRATING, 0.12),
    )
}
"""Fingers, objects and largest depths in mm of the scenes of development.

They were held out first; the present rules were chosen when their answers were known.
"""

MOTIONS: dict[str, tuple[str, Motion]] = {
    "flat-0 fast": ("flat-0", RampHold(60, 0.8, hold=1.0)),
    "flat-30 fast, deep": ("flat-30", RampHold(60, 1.5, hold=1.0)),
    "flat-30 slow, shallow": ("flat-30", RampHold(1, 0.5, hold=0.5, corner=0.05)),
    "sphere-2 fast": ("sphere-2", RampHold(20, 0.5, hold=0.5)),
    "sphere-10 fast, deep": ("sphere-10", RampHold(60, 1.5, hold=1.0)),
    "sphere-10 slow, shallow": ("sphere-10", RampHold(2, 0.5, hold=0.5, corner=0.05)),
    "flat-30 sinusoid": ("flat-30", Sinusoid(0.5, 2.0, 2)),
}
"""Base scenes: which press each is of, and its motion. The sinusoid unloads to first touch."""

N_DEVELOPMENT, DEVELOPMENT_SEED = 32, 30

N_HELD_OUT, SEED = 21, 31

OBJECTS = (
    *("plate", "ball", "plate", "bar", "plate", "ball", "plate", "grating"),
    *("plate", "ball", "plate", "cylinder"),
)
"""Kinds of objects of the held-out scenes, in turn."""

DEEPEST = {"plate": 0.19, "ball": 0.17, "bar": 0.11, "grating": 0.14, "cylinder": 0.14}
"""Largest depth of each kind, over the thickness of the finger."""

STEEP, STEEP_DEEPEST = 35.0, 0.16
"""Angle in degrees beyond which plates go less deep, and their largest depth."""

TOLERANCES = (0.02, 0.05, 0.1, 0.2, 0.4)

PALE = Ask(pressure=True, strain=True, fields=False)


def finger(name: str, resolution: str = "standard") -> Finger:
    """Return the finger of a press."""
    return Finger.subject(BASE[name].subject, resolution=resolution, tissue="maeno1998")


def press(name: str, resolution: str = "standard") -> Scene:
    """Return the ramp of relaxed tissue to the largest depth of a press."""
    relaxed = replace(finger(name, resolution), prony=Prony((1.0,), ()))
    motion = Ramp(SPEED, BASE[name].depth, corner=0.0)
    # Spikes for the reference press, by which the strains of `thesis` make them.
    ask = replace(PALE, spikes=TYPES, afferents="thesis")
    return Scene(name=name, finger=relaxed, indenter=BASE[name].indenter, motion=motion, ask=ask)


def base(name: str, resolution: str = "standard") -> Scene:
    """Return a base scene, with the tissue that relaxes and all four afferents."""
    pressed, motion = MOTIONS[name]
    ask = replace(PALE, spikes=TYPES, afferents="thesis")
    return Scene(
        name=name,
        finger=finger(pressed, resolution),
        indenter=BASE[pressed].indenter,
        motion=motion,
        ask=ask,
    )


def development() -> dict[str, Scene]:
    """Return the scenes of development: depth, speed, motion, tolerance and quantities by chance.

    Depths are 15 to 95 % of that of DEVELOPMENT, speeds 1 to 100 mm/s.
    """
    rng = np.random.default_rng(DEVELOPMENT_SEED)
    names, scenes = list(DEVELOPMENT), {}
    for number in range(N_DEVELOPMENT):
        name = names[number % len(names)]
        finger, indenter, deepest = DEVELOPMENT[name]
        key = f"{number:02d} {name}"
        scenes[key] = _drawn(rng, f"development {number:02d}, {name}", finger, indenter, deepest)
    return scenes


def held_out(count: int = N_HELD_OUT, seed: int = SEED) -> dict[str, Scene]:
    """Return the held-out scenes: finger and object by chance too, within what was measured.

    Every other finger has published tissue; the others are those that were calibrated, or of any
    size with the tissue of the means.
    """
    rng = np.random.default_rng(seed)
    scenes = {}
    for number in range(count):
        kind = OBJECTS[number % len(OBJECTS)]
        finger, whose = _finger(rng, published=bool(number // 2 % 2))
        indenter = _object(rng, kind)
        steep = indenter.flat is not None and indenter.flat.angle > STEEP
        deepest = finger.thickness * (STEEP_DEEPEST if steep else DEEPEST[kind])
        name = f"{whose}, {kind}"
        key = f"{number:02d} {name}"
        scenes[key] = _drawn(rng, f"held-out {number:02d}, {name}", finger, indenter, deepest)
    return scenes


def _finger(rng: np.random.Generator, *, published: bool) -> tuple[Finger, str]:
    """Return a finger by chance, and what it is called."""
    if published:
        subject = str(rng.choice(["a.h.", "a.h.", "d.s."]))
        return Finger.subject(subject, tissue=library.PUBLISHED), f"published {subject}"
    subject = str(rng.choice(["a.h.", "a.h.", "d.s.", "d.p.", "p.w.", ""]))
    if subject:
        return Finger.subject(subject), subject
    thickness = round(float(rng.uniform(10.0, 12.5)), 1)
    width = round(thickness * float(rng.uniform(1.2, 1.4)), 1)
    return Finger(width, thickness), f"{width:g} x {thickness:g} mm"


def _object(rng: np.random.Generator, kind: str) -> Indenter:
    """Return an object of a kind by chance."""
    if kind == "plate":
        return Flat(round(float(rng.uniform(0.0, 60.0)), 1))
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
    """Return a scene with a motion, quantities and a tolerance by chance."""
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
