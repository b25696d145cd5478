"""How fast finite strain is: the relaxing hemisphere that FEBio was measured on.

`problems.febio` times FEBio on the same mesh and machine (reports/febio.json): its 61 steps take
40 CPU s with one thread. Compilation is not counted.
"""

from functools import partial

import numpy as np
from fefinger.validation.bench.suites import Figure, Progress
from fefinger.validation.bench.timing import timed

from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.hyperelastic.material import material_of
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.support.processes import one_thread
from fefinger.support.tolerances import PRESS_EQUILIBRIUM


SIZES = (4.0, 2.4)  # mm of the cells at the pole; the first compiles


@one_thread
def figures(progress: Progress) -> list[Figure]:
    """Measure the ramp and hold, and what its parts take."""
    from fefinger.validation.fem.solid import MODULUS, SERIES, TIMES, WEIGHTS
    from fefinger.validation.problems.hemisphere import SPEED, Hemisphere

    law = material_of(Elastic(MODULUS * WEIGHTS[0], 0.49))
    for number, size in enumerate(SIZES):
        ball = Hemisphere(law, size, sectors=6)
        space = ball.space
        _ = space.unknowns  # numbered here: meshing is not counted
        press = partial(ball.pressed, TIMES, SPEED, SERIES, PRESS_EQUILIBRIUM)
        (force, solver), seconds = timed(press)
        progress("solid", (number + 1) / (len(SIZES) + 1))
    parts = _parts(solver)
    return [
        Figure("hemisphere: unknowns of displacement", space.n_displacements, "1"),
        Figure("hemisphere: steps", len(TIMES), "1"),
        Figure("hemisphere: iterations", solver.iterations, "1"),
        Figure("hemisphere: factors", solver.factors + 1, "1"),
        Figure("hemisphere: peak force", float(force.max()), "N"),
        Figure("hemisphere: ramp and hold", seconds, "CPU s"),
        *(Figure(f"hemisphere: {name}", value, "CPU s") for name, value in parts.items()),
    ]


def _parts(solver: Equilibrium) -> dict[str, float]:
    """Return the CPU seconds of one residual, tangent, factor and solution."""
    body, system = solver.body, solver.system
    values = 1e-4 * np.random.default_rng(0).normal(size=body.space.n_unknowns)
    right = values[system.free]
    from fefinger.fem.linalg.system import approximate_factor

    factor = approximate_factor(system.matrix, system)

    work = {
        "residual": lambda: body.residual(values, body.at_rest),
        "tangent": lambda: body.tangent(values, body.at_rest),
        "factor": lambda: approximate_factor(system.matrix, system),
        "solution": lambda: factor.solve(right),
    }
    seconds = {}
    for name, call in work.items():
        call()
        _, seconds[name] = timed(call)
    return seconds
