"""Force of the tactile finger beside `solid`: the errors that `Touch.error` states.

Run as `python -m fefinger.validation.evidence.tactile reports`; some ten minutes. Loading, hold and
retreat under plates, balls, cylinders, edges and pins, on the default finger with its own tissue
and, of another kind, with published one. The error of a press in a range of depths is the largest
difference of force there over the largest force up to there.
"""

import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.provenance import save

from fefinger import pipeline, shapes
from fefinger.fem.body import solid
from fefinger.geometry.mirror import whole
from fefinger.mechanics.press.placement import obstacle
from fefinger.mechanics.tactile_finger import REPORT, TactileFinger
from fefinger.mesh.store import load_or_build
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Bar, Cylinder, Flat, Pin, Sphere
from fefinger.scene.motions import Trapezoid
from fefinger.scene.scene import Scene
from fefinger.shapes import Shape
from fefinger.support.arrays import Array


DEEPEST = 1.5
"""Depth in mm of every press."""

BANDS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
"""Ends of the ranges of depth in mm."""

PLATES = (0.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0)
BALLS = (3.0, 5.0, 8.0, 12.0)
LONG = 40.0
"""Length in mm of cylinders and bars, which reach beyond the finger."""


def objects() -> Iterator[tuple[Indenter, Shape, float, list[int]]]:
    """Give every object as of a scene, as of the tactile finger, and how this one lies.

    That is: the height of its center in mm, and which axes of the obstacle are its own.
    """
    upright, lying = [0, 1, 2], [2, 0, 1]
    for angle in PLATES:
        yield Flat(angle), shapes.Plane(), 0.0, upright
    for radius in BALLS:
        yield Sphere(radius), shapes.Sphere(radius), radius, upright
    for place in ((-4.0, 0.0), (-2.0, 2.0), (-7.0, -1.0)):
        yield Sphere(6.0, at=place), shapes.Sphere(6.0), 6.0, upright
    for radius, roll in ((4.0, 0.0), (8.0, 90.0), (5.0, 45.0)):
        yield Cylinder(radius, roll=roll), shapes.Cylinder(radius, LONG), radius, lying
    for width, roll in ((3.0, 0.0), (5.0, 90.0)):
        yield Bar(width, 0.5, roll=roll), shapes.Box(width, LONG, 6.0, edge=0.5), 3.0, upright
    yield Pin(6.0, 1.0), shapes.Cylinder(3.0, 6.0, edge=1.0), 3.0, upright


def motions(number: int) -> Trapezoid:
    """Return the motion of a press: fast and slow, held for a short or a long time."""
    speed, hold = ((5.0, 0.2), (20.0, 0.5), (60.0, 1.0))[number % 3]
    return Trapezoid(speed, DEEPEST, hold=hold)


def row(
    tip: TactileFinger,
    given: Indenter,
    shape: Shape,
    height: float,
    axes: list[int],
    motion: Trapezoid,
) -> dict[str, Any]:
    """Press the tactile finger as `solid` is pressed; return the errors of its force."""
    ask = Ask(spikes=(), fields=False)
    scene = Scene(finger=tip.finger, indenter=given, motion=motion, ask=ask)
    result = pipeline.run(scene, mechanics="solid")
    placed = obstacle(given, solid(whole(load_or_build(tip.finger, half=True)), (1, 2)))
    frame = placed.frame.T[:, axes]
    axis, origin = placed.axis, placed.origin
    tip.reset()
    force = []
    for depth, dt in zip(result.depth, np.diff(result.time, prepend=0.0), strict=True):
        touch = tip.step([(shape, frame, origin + (depth - height) * axis)], float(dt))
        force.append(float(touch.wrench[0, :3] @ axis))
    return {
        "object": given.describe(),
        "tissue": tip.finger.tissue,
        "speed": motion.speed,
        "valid": bool(touch.valid),
        **errors(np.array(result.depth), np.array(force), np.array(result.force)),
    }


def errors(depth: Array, force: Array, reference: Array) -> dict[str, list[float]]:
    """Return the errors of a force by ranges of depth, on loading and after the largest depth."""
    turn = int(np.argmax(depth))
    parts = {"loading": slice(0, turn + 1), "later": slice(turn, None)}
    found: dict[str, list[float]] = {name: [] for name in parts}
    for name, part in parts.items():
        for low, high in pairwise(BANDS):
            within = (depth[part] > low) & (depth[part] <= high + 1e-9)
            up_to = reference[: turn + 1][depth[: turn + 1] <= high + 1e-9]
            scale = up_to.max() if name == "loading" else reference.max()
            off = np.abs(force[part] - reference[part])[within]
            found[name].append(round(float(off.max(initial=0.0) / scale), 4))
    return found


if __name__ == "__main__":
    rows = []
    for tissue in (None, "maeno1998"):
        finger = Finger.subject("a.h.", resolution="coarse", tissue=tissue)
        tip = TactileFinger(finger, deepest=DEEPEST)
        chosen = list(objects())
        for number, each in enumerate(chosen):
            if tissue is None or number % 4 == 0:
                rows.append(row(tip, *each, motions(number)))
                print(rows[-1], flush=True)
    about = "Errors of the force of the tactile finger beside `solid`, by object and depth"
    save(Path(sys.argv[1]) / REPORT, {"about": about, "bands_mm": list(BANDS), "rows": rows})
