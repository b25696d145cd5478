"""How fast tabulated finite strain is: a new table, a scene from it, and a step in a loop."""

import time
from dataclasses import replace

import numpy as np
from fefinger.validation.bench.organs import COUNT, crowd
from fefinger.validation.bench.suites import Figure, Progress
from fefinger.validation.bench.timing import of_each, timed
from fefinger.validation.empty_cache import empty_cache

from fefinger.mechanics import pressed, solid
from fefinger.mechanics.loop import Loop
from fefinger.scene import builtin
from fefinger.scene.finger import Finger
from fefinger.support.processes import one_thread


STEPS, DT = 2000, 1e-3
ANGLE = 30.5
"""A plate of which no press is shipped, on the mesh of the one at 30 degrees."""


@one_thread
def figures(progress: Progress) -> list[Figure]:
    """Measure CPU seconds of flat-press by `solid` and `pressed`, and milliseconds of a step."""
    measured: list[Figure] = []
    with empty_cache():
        for number, mesh in enumerate(("coarse", "standard")):
            measured += _scene(mesh)
            progress("pressed", (number + 1) / 3)
        measured += _loop()
    return measured


def _scene(mesh: str) -> list[Figure]:
    """Measure flat-press on a mesh; the first of each compiles or solves what is then kept."""
    shipped = builtin.load("flat-press", {"finger.resolution": mesh})
    new = builtin.load("flat-press", {"finger.resolution": mesh, "indenter.angle": ANGLE})
    pressed.respond(shipped)
    _, at_hand = timed(lambda: pressed.respond(shipped))
    _, table = timed(lambda: pressed.respond(new))
    _, reference = timed(lambda: solid.respond(shipped))
    return [
        Figure(f"{mesh}: a scene from a table at hand", at_hand, "CPU s", reference),
        Figure(f"{mesh}: a new table", table - at_hand, "CPU s", reference),
    ]


def _loop() -> list[Figure]:
    """Measure steps of a finger with many end organs."""
    finger = Loop(Finger.subject("a.h."))
    finger = Loop(replace(finger.finger), sites=crowd(finger.sites))
    depths = 0.7 - 0.7 * np.cos(10 * DT * np.arange(STEPS))
    taken = of_each(lambda depth: finger.step(DT, depth=depth), depths.tolist(), time.perf_counter)
    median, slow = np.quantile(taken, (0.5, 0.99)).tolist()
    return [
        Figure(f"a step with {COUNT} end organs, median", median, "ms"),
        Figure(f"a step with {COUNT} end organs, 99 % of them within", slow, "ms"),
    ]
