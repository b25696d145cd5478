"""How fast the finite elements are: a finger by stages, Hertz to an accuracy, growth with size.

The baseline of factor and loads is SciPy's SuperLU in symmetric mode, given the same order of the
unknowns (its own orders are several times slower) and one BLAS thread, which is faster for it too.
"""

import resource
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from fefinger import scenes
from fefinger.bench import Figure, Progress
from fefinger.fem import body, solve
from fefinger.fem.contact import patch
from fefinger.fem.forms import Elastic, stiffness
from fefinger.fem.grids import box
from fefinger.fem.march import Prescribed, Relaxation, march
from fefinger.fem.probe import strain_at
from fefinger.fem.threads import one_thread
from fefinger.mechanics import _placing, _press
from fefinger.mesh.ready import ready
from fefinger.scene import Finger
from fefinger.validation import fem_hertz


RESOLUTION, REPEATS = "standard", 3
LOADS, STEPS = 64, 1000
DEPTH, REACH = 1.5, 2.0  # mm
NU = 0.49
HERTZ = fem_hertz.Grading(fem_hertz.LINES, core=0.3, rim=0.06, slope=0.42, sectors=6)
CUBES = (7, 10, 15, 22)  # boxes along an edge: 11 thousand to 285 thousand unknowns
COLUMNS = 16  # loads of a cube
FITTED = 3  # largest cubes that the exponents are fitted over

T = TypeVar("T")


def figures(progress: Progress) -> list[Figure]:
    """Measure the finger, Hertz contact and the growth with size."""
    return [*finger_figures(progress), *hertz_figures(), *growth_figures(progress)]


@one_thread
def finger_figures(progress: Progress) -> list[Figure]:
    """Measure the half finger of flat-press; the best of REPEATS runs of each stage."""
    finger = replace(scenes.load("flat-press").finger, resolution=RESOLUTION)
    mesh = ready(finger, half=True)
    tissues, held = _press.tissues(finger), _press.held(finger)
    solid = body.body(mesh, tissues, held)
    space, system = solid.space, solid.system
    progress("fem", 0.05)
    _, assembly = best(lambda: stiffness(space, tissues))
    _, factoring = best(lambda: solve.factor(space, system.matrix, system.fixed))
    loads = np.random.default_rng(0).normal(size=(space.n_unknowns, LOADS))
    _, solving = best(lambda: system.solve(loads))
    progress("fem", 0.1)
    superlu, superlu_factoring = timed(
        lambda: solve.factor(space, system.matrix, system.fixed, "superlu")
    )
    _, superlu_solving = best(lambda: superlu.solve(loads))
    progress("fem", 0.2)
    return [
        Figure("unknowns", space.n_unknowns, "1"),
        Figure("assembly: CPU", assembly, "s"),
        Figure("factor: CPU", factoring, "s", superlu_factoring),
        Figure("factor: entries", system.solver.entries, "1", superlu.solver.entries),
        Figure(f"{LOADS} loads: CPU", solving, "s", superlu_solving),
        Figure("contact: CPU per step", contact(solid, finger) / STEPS, "s"),
    ]


@one_thread
def hertz_figures() -> list[Figure]:
    """Measure Hertz contact on a mesh that is there: CPU seconds, and what they bought."""
    truth = fem_hertz.hertz(NU)
    space = HERTZ.space(truth.contact_radius)
    _ = space.scalar.dx  # the mesh's own tables, which are part of meshing
    started = time.process_time()
    pressed = fem_hertz.body_on(space, NU).pressed(truth.depth)
    seconds = time.process_time() - started
    errors = fem_hertz.measured(pressed, truth)
    name = f"Hertz, nu {NU:g}"
    return [
        Figure(f"{name}: displacement nodes", errors["nodes"], "1"),
        Figure(f"{name}: CPU, assembly to contact", seconds, "s"),
        *(
            Figure(f"{name}: {key}", errors[key], "%", limit)
            for key, (limit, _) in fem_hertz.TARGETS.items()
            if "anywhere" not in key
        ),
    ]


def growth_figures(progress: Progress) -> Iterator[Figure]:
    """Measure cubes held at one face, the worst shape for a factor, and fit how costs grow."""
    rows = []
    for number, boxes in enumerate(CUBES):
        unknowns, costs = _cube(boxes)
        rows.append([unknowns, *costs.values()])
        for name, value in costs.items():
            yield Figure(f"cube of {unknowns} unknowns, {name}", value, name.split()[-1])
        progress("fem", 0.2 + 0.8 * (number + 1) / len(CUBES))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    yield Figure("peak memory of the process", peak, "MB")
    logs = np.log(np.array(rows)[-FITTED:])
    for name, column in zip(costs, logs[:, 1:].T, strict=True):
        slope = float(np.polyfit(logs[:, 0], column, 1)[0])
        yield Figure(f"exponent in the unknowns, {name.split(' /')[0]}", slope, "1")


@one_thread
def _cube(boxes: int) -> tuple[int, dict[str, float]]:
    """Return the unknowns of a cube and its costs by name, each with its unit at the end."""
    line: NDArray[np.float64] = np.linspace(0, 10, boxes + 1)
    space = box(line, line, line)
    held = np.flatnonzero(np.repeat(space.node_points[:, 2] == 10, 3))
    times = [time.process_time()]
    matrix = stiffness(space, {1: Elastic(34.0, NU)})
    times.append(time.process_time())
    system = solve.factor(space, matrix, held)
    times.append(time.process_time())
    system.solve(np.random.default_rng(0).normal(size=(space.n_unknowns, COLUMNS)))
    times.append(time.process_time())
    assembly, factor, loads = np.diff(times)
    return space.n_unknowns, {
        "assembly / s": float(assembly),
        "factor / s": float(factor),
        f"{COLUMNS} loads / s": float(loads),
        "memory of the factor / MB": 8e-6 * system.solver.entries,
    }


def contact(solid: body.Body, finger: Finger) -> float:
    """Return the CPU seconds of STEPS steps of a press to DEPTH and back on a reduced finger."""
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


def timed(work: Callable[[], T]) -> tuple[T, float]:
    """Return what `work` gives and its CPU seconds."""
    started = time.process_time()
    answer = work()
    return answer, time.process_time() - started


def best(work: Callable[[], T]) -> tuple[T, float]:
    """Return what `work` gives and the CPU seconds of its fastest run."""
    runs = [timed(work) for _ in range(REPEATS)]
    return runs[-1][0], min(seconds for _, seconds in runs)
