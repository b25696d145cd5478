"""How fast the finite elements of a finger are: assembly, factor, loads and steps of contact.

The baseline of factor and loads is SciPy's SuperLU in symmetric mode, given the same order of the
unknowns (its own orders are several times slower) and one BLAS thread, which is faster for it too.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from scipy.sparse.linalg import splu

from fefinger import scenes
from fefinger.bench import Figure, Progress
from fefinger.fem import body, solve
from fefinger.fem.contact import patch
from fefinger.fem.forms import stiffness
from fefinger.fem.march import Prescribed, Relaxation, march
from fefinger.fem.probe import strain_at
from fefinger.fem.threads import one_thread
from fefinger.mechanics import _placing, _press
from fefinger.mesh.ready import ready
from fefinger.scene import Finger


RESOLUTION, REPEATS = "standard", 3
LOADS, STEPS = 64, 1000
DEPTH, REACH = 1.5, 2.0  # mm

T = TypeVar("T")


@one_thread
def figures(progress: Progress) -> list[Figure]:
    """Measure the half finger of flat-press; the best of REPEATS runs of each stage."""
    finger = replace(scenes.load("flat-press").finger, resolution=RESOLUTION)
    mesh = ready(finger, half=True)
    tissues, held = _press.tissues(finger), _press.held(finger)
    solid = body.body(mesh, tissues, held)
    space, system = solid.space, solid.system
    progress("fem", 0.2)
    _, assembly = best(lambda: stiffness(space, tissues))
    _, factoring = best(lambda: solve.factor(space, system.matrix, system.fixed))
    loads = np.random.default_rng(0).normal(size=(space.n_unknowns, LOADS))
    _, solving = best(lambda: system.solve(loads))
    progress("fem", 0.5)
    order = system.factor.order
    arranged = system.reduced[order][:, order].tocsc()
    started = time.perf_counter()
    superlu = splu(
        arranged,
        permc_spec="NATURAL",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True, "Equil": False},
    )
    superlu_factoring = time.perf_counter() - started
    _, superlu_solving = best(lambda: superlu.solve(loads[system.free]))
    progress("fem", 0.8)
    return [
        Figure("unknowns", space.n_unknowns, "1"),
        Figure("assembly: wall", assembly, "s"),
        Figure("factor: wall", factoring, "s", superlu_factoring),
        Figure("factor: entries", system.factor.entries, "1", superlu.L.nnz),
        Figure(f"{LOADS} loads: wall", solving, "s", superlu_solving),
        Figure("contact: wall per step", contact(solid, finger) / STEPS, "s"),
    ]


def contact(solid: body.Body, finger: Finger) -> float:
    """Return the seconds of STEPS steps of a press to DEPTH and back on a reduced finger."""
    touch = _placing.obstacle(_press.STANDARD, solid)
    on_pad = patch(solid.space, solid.pad, solid.normals, touch, REACH)
    small = body.reduce(solid, on_pad, strain_at(solid.space, np.empty((0, 3))))
    prony, size = finger.prony, len(on_pad.vertices)
    times = np.linspace(0.0, 1.0, STEPS)
    asked = Prescribed("depth", times, DEPTH * np.sin(np.pi * times))

    def pressed() -> Any:
        memory = Relaxation(np.array(prony.weights), np.array(prony.v), size)
        return march(small.flexibility, on_pad.gap, on_pad.travel, memory, asked)

    return best(pressed)[1]


def best(work: Callable[[], T]) -> tuple[T, float]:
    """Return what `work` gives and the seconds of its fastest run."""
    seconds = []
    for _ in range(REPEATS):
        started = time.perf_counter()
        answer = work()
        seconds.append(time.perf_counter() - started)
    return answer, min(seconds)
