"""How fast a sliding finger is: its operator with tractions, steps in a loop, a scan of dots.

A whole finger of the standard mesh, 1000 end organs, strains in single precision: an object that
slides at 60 mm/s in steps of 1 ms, without friction and with it. Times are medians of wall time, or
seconds of the processor.
"""

import resource
import time
from functools import partial

import numpy as np
from fefinger.validation.bench.suites import Figure, Progress
from fefinger.validation.bench.timing import load, timed
from fefinger.validation.empty_cache import empty_cache

from fefinger import afferents
from fefinger.mechanics import condensed
from fefinger.mechanics.loop import Loop
from fefinger.results.records import Sites
from fefinger.scene import builtin
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat
from fefinger.scene.textured import Dots
from fefinger.support.processes import one_thread


STEPS, DT, SPEED = 600, 1e-3, 60.0
ORGANS, MU = 1000, 0.3
OBJECTS: tuple[tuple[str, Indenter, float], ...] = (
    ("plate", Flat(30), 1.0),
    ("dots every 1.5 mm", Dots(1.5), 1.2),
    ("plate with friction", Flat(30, friction=MU), 1.0),
    ("dots every 1.5 mm with friction", Dots(1.5, friction=MU), 1.2),
)
"""Names, objects, and depths in mm at which they slide."""


@one_thread
def figures(progress: Progress) -> list[Figure]:
    """Measure operator, steps and scan."""
    busy = load()
    measured = [*_operator()]
    progress("sliding", 0.3)
    for number, (name, indenter, depth) in enumerate(OBJECTS):
        measured += _steps("standard", name, indenter, depth)
        if indenter.friction:
            measured += _steps("coarse", name, indenter, depth)
        progress("sliding", 0.3 + 0.12 * (number + 1))
    measured += _scan()
    return [*measured, busy]


def finger(mesh: str) -> Finger:
    """Return the finger of a mesh."""
    return Finger.subject("a.h.", resolution=mesh, tissue="maeno1998")


def sites() -> Sites:
    """Return the end organs, around a place below first touch."""
    rng = np.random.default_rng(1)
    places = np.array([0.5, 0.7, 1.5]) + rng.uniform(-0.4, 0.4, (ORGANS, 3))
    normals = np.tile([0.0, 0.0, -1.0], (ORGANS, 1))
    return Sites(places, normals, np.full(ORGANS, 1.5), ("SAI",) * ORGANS)


def _operator() -> list[Figure]:
    """Measure a finger with friction in an empty cache, and again; the peak is of the process."""

    def make() -> Loop:
        plate = Flat(30, friction=MU)
        return Loop(finger("standard"), plate, mechanics="condensed", deepest=1.05, sites=sites())

    with empty_cache():
        (_, new), (_, again) = timed(make), timed(make)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    return [
        Figure("operator of a whole finger and its rows of tractions: new", new, "CPU s"),
        Figure("the same, kept", again, "CPU s", new),
        Figure("largest memory", peak, "GB"),
    ]


def _steps(mesh: str, name: str, indenter: Indenter, depth: float) -> list[Figure]:
    """Measure steps of an object that slides at a depth in mm."""
    stepped = Loop(
        finger(mesh),
        indenter,
        mechanics="condensed",
        deepest=1.05 * depth,
        reach=0.0,
        sites=sites(),
        precision="single",
    )
    stepped.step(0.1, depth=depth)
    taken, pressed = [], []
    for k in range(STEPS):
        started = time.perf_counter()
        now = stepped.step(DT, depth=depth, shift=(-SPEED * DT * k, 0.01 * k))
        taken.append(1e3 * (time.perf_counter() - started))
        pressed.append(int((now.pressure > 0).sum()))
    median, slow = np.quantile(taken, (0.5, 0.95)).tolist()
    label = f"{mesh}, {name}, {int(np.median(pressed))} vertices in contact"
    return [
        Figure(f"step: {label}, median", median, "ms"),
        Figure(f"step: {label}, 95 % of them within", slow, "ms"),
    ]


def _scan() -> list[Figure]:
    """Measure 60 mm of dots over 102 units in processor time, once the operator is at hand."""
    changes = {
        "motion.distance": 60,
        "finger.resolution": "standard",
        "ask.population.radius": 3.4,
        "ask.pressure": False,
    }
    scene = builtin.load("slide-dots", changes)
    condensed.respond(scene)
    response, solved = timed(lambda: condensed.respond(scene))
    fire = partial(afferents.fire, scene.ask, response, since=scene.motion.recorded_from)
    trains, fired = timed(fire)
    units = f"60 mm of dots at 60 mm/s, {len(trains)} units"
    return [
        Figure(f"{units}: contact and strain, {len(response.time)} steps", solved, "CPU s"),
        Figure(f"{units}: spikes", fired, "CPU s"),
    ]
