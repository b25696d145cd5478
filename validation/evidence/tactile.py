"""Errors of the tactile finger beside `solid`, which `Touch.error` states.

Run as `python -m fefinger.validation.evidence.tactile reports`; a quarter of an hour. Plates,
balls, cylinders, edges and pins on the default finger with its own tissue and, of another kind,
with published one: loading, hold and retreat, and two plates that slide. The factor of finite
strain was fitted to the presses that are `fitted`; the other ones judge it.

The error of a press in a range of depths is the largest difference there over the largest value up
to there: of the force, the contact area, and the strain of the four central end organs together.
Steps that are not valid do not count.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.provenance import save

from fefinger import pipeline, shapes
from fefinger.fem.body import solid
from fefinger.geometry.finger_mesh import whole
from fefinger.mechanics.evidence.tactile_errors import REPORT
from fefinger.mechanics.press.placement import obstacle
from fefinger.mechanics.tactile_finger import TactileFinger
from fefinger.mesh.store import load_or_build
from fefinger.result import Result
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Bar, Cylinder, Flat, Pin, Sphere
from fefinger.scene.motions import Trapezoid
from fefinger.scene.scene import Scene
from fefinger.scene.sliding import Slide
from fefinger.shapes import Shape
from fefinger.support.arrays import Array, Flags


DEEPEST = 1.5
"""Depth in mm of every press."""

BANDS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
"""Ends of the ranges of depth in mm."""

LONG = 40.0
"""Length in mm of cylinders and bars, which reach beyond the finger."""

SLID = 0.75
"""Part of its path from which a slide is judged: `solid` leaves out stick, before gross slip."""

UPRIGHT, LYING = (0, 1, 2), (2, 0, 1)
"""Axes of an obstacle that are those of the shape."""


Errors = dict[str, list[float | None]]
"""By ranges of depth, on loading and later."""


@dataclass(frozen=True)
class Press:
    """A motion of an object, as of a scene and as of the tactile finger.

    height mm of the center of the shape over its foremost point; axes of the obstacle that are the
    shape's; fitted: whether the factor of finite strain was fitted to it.
    """

    given: Indenter
    shape: Shape
    height: float
    axes: tuple[int, ...]
    motion: Trapezoid | Slide
    fitted: bool


def objects(fitted: bool) -> Iterator[tuple[Indenter, Shape, float, tuple[int, ...]]]:
    """Give the objects of presses that the factor was fitted to, or of the other ones."""
    flat = (0, 10, 15, 20, 25, 30, 35, 40, 45) if fitted else (5, 12, 27, 38)
    rolled = () if fitted else ((0.0, 15.0), (20.0, 20.0))
    plates = [Flat(float(angle)) for angle in flat] + [Flat(a, tilt=tilt) for a, tilt in rolled]
    yield from ((each, shapes.Plane(), 0.0, UPRIGHT) for each in plates)
    for radius, at in FITTED_BALLS if fitted else OTHER_BALLS:
        yield Sphere(radius, at=at), shapes.Sphere(radius), radius, UPRIGHT
    for radius, roll, at in FITTED_CYLINDERS if fitted else OTHER_CYLINDERS:
        yield Cylinder(radius, roll=roll, at=at), shapes.Cylinder(radius, LONG), radius, LYING
    for width, roll, at in FITTED_BARS if fitted else OTHER_BARS:
        box = shapes.Box(width, LONG, 6.0, edge=0.5)
        yield Bar(width, 0.5, roll=roll, at=at), box, 3.0, UPRIGHT
    width, at = (6.0, None) if fitted else (5.0, (-7.0, 0.0))
    yield Pin(width, 1.0, at=at), shapes.Cylinder(width / 2, 6.0, edge=1.0), 3.0, UPRIGHT


At = tuple[float, float] | None
FITTED_BALLS: tuple[tuple[float, At], ...] = (
    *((3.0, None), (5.0, None), (8.0, None), (12.0, None)),
    *((6.0, (-4.0, 0.0)), (6.0, (-2.0, 2.0)), (6.0, (-7.0, -1.0))),
)
OTHER_BALLS: tuple[tuple[float, At], ...] = (
    *((7.0, (-8.0, 0.0)), (4.0, (-6.0, 1.5)), (10.0, (-5.0, -1.0)), (5.0, (0.0, 0.0))),
    *((4.0, (-9.0, 0.0)), (8.0, (-3.0, 2.5)), (6.0, (1.0, -1.0))),
)
FITTED_CYLINDERS: tuple[tuple[float, float, At], ...] = (
    *((4.0, 0.0, None), (8.0, 90.0, None), (5.0, 45.0, None)),
)
OTHER_CYLINDERS: tuple[tuple[float, float, At], ...] = (
    *((6.0, 0.0, (-7.0, 0.0)), (5.0, 90.0, (-5.0, 0.5)), (7.0, 30.0, (-3.0, 0.0))),
)
FITTED_BARS: tuple[tuple[float, float, At], ...] = (3.0, 0.0, None), (5.0, 90.0, None)
OTHER_BARS: tuple[tuple[float, float, At], ...] = (
    *((4.0, 0.0, (-7.0, 0.0)), (3.0, 90.0, (-4.0, 0.0)), (4.0, 45.0, (-2.0, 1.0))),
)


def presses(fitted: bool) -> Iterator[Press]:
    """Give the presses, fast and slow, held for a short or a long time; then slides."""
    for number, each in enumerate(objects(fitted)):
        speed, hold = ((5.0, 0.2), (20.0, 0.5), (60.0, 1.0))[number % 3]
        yield Press(*each, Trapezoid(speed, DEEPEST, hold=hold), fitted)
    if fitted:
        return
    for angle, mu, depth, direction in ((30.0, 0.4, 1.0, 180.0), (20.0, 0.3, 0.7, 90.0)):
        slide = Slide(20.0, depth, distance=4.0, direction=direction, settle=0.1)
        yield Press(Flat(angle, friction=mu), shapes.Plane(), 0.0, UPRIGHT, slide, False)


def row(finger: Finger, press: Press) -> dict[str, Any]:
    """Press the tactile finger as `solid` is pressed; return its errors."""
    given, ask = press.given, Ask(spikes=(), fields=False)
    scene = Scene(finger=finger, indenter=given, motion=press.motion, ask=ask)
    result = pipeline.run(scene, mechanics="solid")
    placed = obstacle(given, solid(whole(load_or_build(finger, half=True)), (1, 2)))
    tip = TactileFinger(finger, deepest=DEEPEST, friction=given.friction, sites=result.sites)
    frame, shift = placed.frame.T[:, press.axes], shifts(result)
    at = placed.origin + (result.depth[:, None] - press.height) * placed.axis
    at = at + shift @ placed.frame[:2]
    felt = [
        tip.step([(press.shape, frame, place)], float(dt))
        for place, dt in zip(at, np.diff(result.time, prepend=0.0), strict=True)
    ]
    assert result.force is not None
    assert result.contact_area is not None
    assert result.strain is not None
    path = np.linalg.norm(shift, axis=1)
    judged = np.array([bool(touch.valid) for touch in felt])
    if given.friction:
        judged &= path > SLID * path.max()
    lateral = np.zeros_like(shift) if result.lateral is None else result.lateral.force
    truth = np.column_stack([lateral, result.force])
    force = np.array([placed.frame @ touch.wrench[0, :3] for touch in felt])
    axes = slice(None) if given.friction else slice(2, 3)
    pairs: dict[str, tuple[Array, Array]] = {
        "force": (force[:, axes], truth[:, axes]),
        "area": (np.array([touch.contact_area[0] for touch in felt]), result.contact_area),
        "strain": (np.array([matrices(touch.strain) for touch in felt]), result.strain),
    }
    return {
        "object": given.describe(),
        "at": getattr(given, "at", None),
        "tissue": finger.tissue,
        "speed": press.motion.speed,
        "fitted": press.fitted,
        "valid": round(float(np.mean([touch.valid for touch in felt])), 3),
        **{what: errors(result.depth, *each, judged) for what, each in pairs.items()},
    }


def shifts(result: Result) -> Array:
    """Return how far (n_t, 2) mm the object has moved across its travel."""
    return np.zeros((len(result.time), 2)) if result.lateral is None else result.lateral.shift


def matrices(strain: Array) -> Array:
    """Return xx yy zz xy yz xz (n, 6) as tensors (n, 3, 3)."""
    return np.asarray(strain[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]])


def errors(depth: Array, found: Array, reference: Array, judged: Flags) -> Errors:
    """Return the errors of a quantity (n_t, ...) by ranges of depth, None where there is none."""
    turn, count = int(np.argmax(depth)), len(depth)
    off, size = (
        np.linalg.norm(each.reshape(count, -1), axis=1) for each in (found - reference, reference)
    )
    parts = {"loading": slice(0, turn + 1), "later": slice(turn, None)}
    answer: Errors = {name: [] for name in parts}
    for name, part in parts.items():
        for low, high in pairwise(BANDS):
            within = judged[part] & (depth[part] > low) & (depth[part] <= high + 1e-9)
            up_to = size[: turn + 1][depth[: turn + 1] <= high + 1e-9]
            scale = up_to.max() if name == "loading" else size.max()
            worst = float(off[part].max(where=within, initial=0.0) / scale)
            answer[name].append(round(worst, 4) if within.any() else None)
    return answer


def main(folder: Path) -> None:
    """Press both kinds of tissue, first what judges; write the report after every press."""
    about = "Errors of the tactile finger beside `solid`, by object and depth"
    rows: list[dict[str, Any]] = []
    for fitted in (False, True):
        for tissue in (None, "maeno1998"):
            finger = Finger.subject("a.h.", resolution="coarse", tissue=tissue)
            for number, press in enumerate(presses(fitted)):
                if tissue is None or number % 4 == 0:
                    rows.append(row(finger, press))
                    print(rows[-1], flush=True)
                    record = {"about": about, "bands_mm": list(BANDS), "rows": rows}
                    save(folder / REPORT, record)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
