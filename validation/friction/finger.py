"""Sliding fingers: symmetries, limits and balances that hold whatever the finger is."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from fefinger.mechanics import condensed, linear
from fefinger.mechanics.loop import Loop
from fefinger.results.records import Lateral, Response, Sites
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motion import Motion
from fefinger.scene.motions import RampHold
from fefinger.scene.scene import Scene
from fefinger.scene.sliding import SampledPath, Slide
from fefinger.scene.texts import Letters
from fefinger.scene.textured import Dots
from fefinger.support.arrays import Array
from fefinger.theory.relaxation import Prony


FINGER = Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
ELASTIC = replace(FINGER, prony=Prony((1.0,), ()))
ASK = Ask(fields=False)
MU = 0.4


def respond(indenter: Indenter, motion: Motion, finger: Finger = FINGER) -> Response:
    """Answer a scene by `condensed`."""
    return condensed.respond(Scene(finger=finger, indenter=indenter, motion=motion, ask=ASK))


def lateral(response: Response) -> Lateral:
    """Path, lateral force and friction of a response."""
    assert response.lateral is not None
    return response.lateral


def difference(values: Sequence[Array], expected: Sequence[Array]) -> float:
    """Return the largest difference of arrays, each over its largest value."""
    errors = [
        float(np.abs(a - b).max() / max(np.abs(b).max(), 1e-300))
        for a, b in zip(values, expected, strict=True)
    ]
    return max(errors)


def quantities(response: Response) -> tuple[Array, Array, Array]:
    """Return force, pressure and strain of a response."""
    assert response.pressure is not None
    assert response.strain is not None
    return response.force, response.pressure, response.strain


def slid_and_pressed() -> float:
    """Return the difference of a smooth plate that slid without friction from one that pressed."""
    slid = respond(Flat(30), Slide(20, 0.8, distance=2, settle=0.1), ELASTIC)
    pressed = respond(Flat(30), RampHold(10, 0.8, hold=0.1), ELASTIC)
    found, expected = ([quantities(one)[k][-1] for k in (0, 2)] for one in (slid, pressed))
    return difference(found, expected)


def frictionless_limit() -> float:
    """Return the difference of a vanishing coefficient from none at all, on letters."""
    motion = Slide(40, 0.7, distance=3, direction=180, settle=0.1)
    smooth = respond(Letters("I", start=2.0), motion)
    almost = respond(Letters("I", start=2.0, friction=1e-12), motion)
    return difference(quantities(almost), quantities(smooth))


def shifted_by_a_period() -> float:
    """Return the difference of dots that were moved by their period before they touch."""
    dots, time = Dots(2.5), (0.0, 0.1, 0.2, 0.4)
    depth, x = (0.0, 0.6, 0.6, 0.6), np.array([0.0, 0.0, 0.0, 1.3])
    first = SampledPath(time, tuple(x), (0.0,) * 4, depth)
    later = SampledPath(time, tuple(x + 2 * dots.spacing), (-dots.spacing,) * 4, depth)
    return difference(quantities(respond(dots, later)), quantities(respond(dots, first)))


def mirrored() -> float:
    """Return the difference of a slide to the other side, mirrored, with friction on a ball."""
    sides = [
        respond(Sphere(5.0, friction=MU), Slide(20, 0.6, distance=1.5, direction=s, settle=0.1))
        for s in (90, -90)
    ]
    one, other = map(lateral, sides)
    signs = np.array([1.0, -1.0])
    found = [sides[1].force, other.force * signs, other.work, other.stick_area]
    expected = [sides[0].force, one.force, one.work, one.stick_area]
    return difference([np.asarray(a) for a in found], [np.asarray(a) for a in expected])


def half_and_whole() -> float:
    """Return the difference of half a finger, doubled, from the whole one that is sheared alike."""
    slide = Slide(20, 0.8, distance=1.0, settle=0.1)
    halved = respond(Flat(30, friction=MU), slide)
    askew = replace(slide, direction=1e-9)
    whole = respond(Flat(30, friction=MU), askew)
    one, other = lateral(halved), lateral(whole)
    found = [halved.force, one.force[:, 0], np.asarray(one.work), np.asarray(one.stick_area)]
    expected = [
        whole.force,
        other.force[:, 0],
        np.asarray(other.work),
        np.asarray(other.stick_area),
    ]
    return difference(found, expected)


def condensed_and_linear() -> float:
    """Return the difference of `condensed` from `linear`, with friction on dots."""
    motion = Slide(40, 0.7, distance=1.0, direction=180, settle=0.1)
    scene = Scene(finger=FINGER, indenter=Dots(3.0, friction=MU), motion=motion, ask=ASK)
    both = [mechanics.respond(scene) for mechanics in (condensed, linear)]
    found, expected = ((*quantities(each), lateral(each).force) for each in both)
    return difference(found, expected)


def loop_and_scene() -> float:
    """Return the difference of steps in a loop from the scene, by force and with friction."""
    motion = Slide(40, force=0.3, distance=2.0, direction=150, settle=0.05)
    dots = Dots(2.5, friction=MU)
    scene = respond(dots, motion)
    assert scene.sites is not None
    deepest = 1.4 * float(scene.depth.max())
    stepped = Loop(FINGER, dots, mechanics="condensed", deepest=deepest, sites=scene.sites)
    rows = []
    for k, time in enumerate(scene.time.tolist()):
        x, y = motion.shift(time).tolist()
        dt = time - scene.time[k - 1] if k else 0.0
        now = stepped.step(float(dt), force=float(motion.value(time)), shift=(x, y))
        rows.append([now.force, now.depth, *now.lateral_force.tolist(), now.work, now.stick_area])
    found = np.array(rows).T
    one = lateral(scene)
    expected = [scene.force, scene.depth, *one.force.T, one.work, one.stick_area]
    return difference(list(found), [np.asarray(each) for each in expected])


LOOP = Slide(10, 0.8, distance=3.0, passes=4, settle=0.05)
"""Forth and back, twice, far enough that the whole contact slides each time."""


@cache
def sheared() -> Response:
    """Return a finger of elastic tissue that is pressed and sheared along LOOP."""
    return respond(Flat(30, friction=MU), LOOP, ELASTIC)


def cone() -> float:
    """Return by how much tractions exceed mu p, over the largest mu p; 0 if none does."""
    response = sheared()
    traction = lateral(response).traction
    assert traction is not None
    assert response.pressure is not None
    over = np.hypot(traction[..., 0], traction[..., 1]) - MU * response.pressure
    return float(max(0.0, over.max()) / (MU * response.pressure.max()))


def gross() -> float:
    """Return the largest | |t| - mu p | over mu p while the whole contact slides."""
    response = sheared()
    one, pressure = lateral(response), response.pressure
    assert one.traction is not None
    assert pressure is not None
    assert one.stick_area is not None
    slides = (one.stick_area == 0) & (np.abs(one.force[:, 0]) > 0.5 * MU * response.force)
    assert slides.sum() > 100
    size = np.hypot(one.traction[slides, :, 0], one.traction[slides, :, 1])
    return float(np.abs(size - MU * pressure[slides]).max() / (MU * pressure.max()))


def energy() -> float:
    """Return the error of the balance of energy over the last closed cycle of elastic tissue.

    What the plate does along its path is what friction loses; over that.
    """
    response, one = sheared(), lateral(sheared())
    assert one.work is not None
    x = one.shift[:, 0]
    middle = LOOP.recorded_from + 2 * LOOP.pass_seconds
    early = response.time < middle
    start, stop = int(np.argmax(np.where(early, x, 0.0))), int(np.argmax(np.where(early, 0.0, x)))
    assert abs(x[stop] - x[start]) < 1e-9
    force = one.force[:, 0]
    done = np.sum(np.diff(x[start : stop + 1]) * (force[start + 1 : stop + 1] + force[start:stop]))
    return abs(float(done) / 2 / float(one.work[stop] - one.work[start]) - 1)


def returned_work() -> float:
    """Return the largest work that friction returns in a step, over all that it takes."""
    work = lateral(sheared()).work
    assert work is not None
    return float(max(0.0, -np.diff(work).min() / work[-1]))


def viscous_work() -> float:
    """Return the work of a closed path without friction over relaxing tissue, over its forces.

    The path goes forth and back over dots at a constant depth: what it takes is what tissue loses.
    """
    response = respond(Dots(2.5), Slide(40, 0.7, distance=5, passes=2, direction=180, settle=0.3))
    one = lateral(response)
    done = np.sum(np.diff(one.shift, axis=0) * (one.force[1:] + one.force[:-1]) / 2)
    return float(done / (np.abs(one.force).max() * 10))


def stick_curve(finger: Finger) -> tuple[Array, Array]:
    """Return tangential force over its largest, and the part of the contact that sticks.

    A plate at 30 degrees under 1 N, dragged slowly proximally until all slides.
    """
    response = respond(
        Flat(30, friction=MU),
        Slide(1.0, force=1.0, distance=1.5, direction=180, settle=2.0),
        finger,
    )
    one, area = lateral(response), response.contact_area
    assert area is not None
    assert one.stick_area is not None
    assert response.pad is not None
    assert response.pressure is not None
    moved = (response.time > 2.2) & (response.time < response.time[-1] - 0.02)  # not its stop
    areas = (response.pressure > 0) @ response.pad.areas
    q = np.abs(one.force[moved, 0]) / np.abs(one.force[moved, 0]).max()
    return q, one.stick_area[moved] / areas[moved]


def surface_strain(force: float, mu: float = 1.0) -> Array:
    """Return the largest and smallest principal strain (2,) of the skin under a dragged plate.

    0.1 mm below the surface on a line along the finger, once the whole contact slides.
    """
    plate = Flat(30, friction=mu)
    stepped = Loop(FINGER, plate, mechanics="condensed", deepest=1.8, sites=_below(0.1))
    stepped.step(1.0, force=force)
    for k in range(1, 81):
        now = stepped.step(0.02, force=force, shift=(-0.05 * k, 0.0))
    a = now.strain
    tensors = np.empty((len(a), 3, 3))
    for k, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))):
        tensors[:, i, j] = tensors[:, j, i] = a[:, k]
    values = np.linalg.eigvalsh(tensors)
    return np.array([values.max(), values.min()])


def _below(depth: float) -> Sites:
    """Return places `depth` mm below the skin along the finger, where it faces down."""
    from fefinger.mechanics.press import operator

    solid = operator.operator(FINGER, half=False)
    pad = np.unique(solid.pad)
    points, normals = solid.space.points[pad], solid.normals[pad]
    chosen = (np.abs(points[:, 1]) < 0.5) & (normals[:, 2] < -0.5)
    inner = points[chosen] - depth * normals[chosen]
    count = len(inner)
    return Sites(inner, normals[chosen], np.full(count, depth), ("SAI",) * count)
