"""Speed of the finite elements: a finger by stages, Hertz to an accuracy.

The baseline of factor and loads is SciPy's SuperLU in symmetric mode, given the same order of the
unknowns (its own orders are several times slower) and one BLAS thread, which is faster for it too.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from fefinger.validation.bench import superlu
from fefinger.validation.bench.suites import Figure, Progress
from fefinger.validation.bench.timing import fastest, timed
from fefinger.validation.fem import hertz
from fefinger.validation.problems import published

from fefinger.contact.frictionless import FrictionlessContact
from fefinger.contact.stepper import Prescribed, march
from fefinger.fem import body
from fefinger.fem.contact.patch import patch
from fefinger.fem.elements.assembly import stiffness
from fefinger.fem.elements.probe import strain_at
from fefinger.fem.linalg import system as solve
from fefinger.mechanics.press import placement, problem
from fefinger.mesh.store import load_or_build
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import STANDARD
from fefinger.support.processes import one_thread


RESOLUTION, REPEATS = "standard", 3
LOADS, STEPS = 64, 1000
DEPTH, REACH = 1.5, 2.0  # mm
NU = 0.49
HERTZ = hertz.Grading(hertz.LINES, core=0.3, rim=0.06, slope=0.42, sectors=6)


def figures(progress: Progress) -> list[Figure]:
    """Measure the finger and Hertz contact."""
    return [*finger_figures(progress), *hertz_figures()]


@one_thread
def finger_figures(progress: Progress) -> list[Figure]:
    """Measure the half finger of flat-press; the best of REPEATS runs of each stage."""
    finger = replace(published.load("flat-press").finger, resolution=RESOLUTION)
    mesh = load_or_build(finger, half=True)
    tissues, held = problem.tissues(finger), problem.fixed_facets(finger)
    solid = body.body(mesh, tissues, held)
    space, system = solid.space, solid.system
    progress("fem", 0.05)
    _, assembly = fastest(lambda: stiffness(space, tissues), REPEATS)
    _, factoring = fastest(lambda: solve.factor(space, system.matrix, system.fixed), REPEATS)
    loads = np.random.default_rng(0).normal(size=(space.n_unknowns, LOADS))
    _, solving = fastest(lambda: system.solve(loads), REPEATS)
    progress("fem", 0.1)
    baseline, baseline_factoring = timed(lambda: superlu.factor(space, system.matrix, system.fixed))
    _, baseline_solving = fastest(lambda: baseline.solve(loads), REPEATS)
    progress("fem", 0.2)
    return [
        Figure("unknowns", space.n_unknowns, "1"),
        Figure("assembly: CPU", assembly, "s"),
        Figure("factor: CPU", factoring, "s", baseline_factoring),
        Figure("factor: entries", system.dissection.entries, "1", superlu.entries(baseline)),
        Figure(f"{LOADS} loads: CPU", solving, "s", baseline_solving),
        Figure("contact: CPU per step", contact(solid, finger) / STEPS, "s"),
    ]


@one_thread
def hertz_figures() -> list[Figure]:
    """Measure Hertz contact on a mesh that is there: CPU seconds, and what they bought."""
    truth = hertz.hertz(NU)
    space = HERTZ.space(truth.contact_radius)
    _ = space.scalar.dx  # the mesh's own tables, which are part of meshing
    pressed, seconds = timed(lambda: hertz.body_on(space, NU).pressed(truth.depth))
    errors = hertz.measured(pressed, truth)
    name = f"Hertz, nu {NU:g}"
    return [
        Figure(f"{name}: displacement nodes", errors["nodes"], "1"),
        Figure(f"{name}: CPU, assembly to contact", seconds, "s"),
        *(
            Figure(f"{name}: {key}", errors[key], "%", limit)
            for key, (limit, _) in hertz.TARGETS.items()
            if "anywhere" not in key
        ),
    ]


def contact(solid: body.Body, finger: Finger) -> float:
    """Return the CPU seconds of STEPS steps of a press to DEPTH and back on a reduced finger."""
    touch = placement.obstacle(STANDARD, solid)
    on_pad = patch(solid.space, solid.pad, solid.normals, touch, REACH)
    small = body.reduce(solid, on_pad, strain_at(solid.space, np.empty((0, 3))))
    times = np.linspace(0.0, 1.0, STEPS)
    prescribed = Prescribed("depth", times, DEPTH * np.sin(np.pi * times))

    def pressed() -> Any:
        pad = small.flexibility, on_pad.gap, on_pad.projected, finger.prony.branches
        return march(FrictionlessContact(*pad), prescribed)

    return fastest(pressed, REPEATS)[1]
