"""Viscoelastic contact step by step: a plain loop over the solver with factored active sets."""

import numpy as np

from fefinger.contact.complementarity import Complementarity, pressure_at_force
from fefinger.contact.prony_history import Relaxation
from fefinger.contact.stepper import History, Prescribed
from fefinger.support.arrays import Array


def march(
    flexibility: Array,
    gap: Array,
    projected: Array,
    relaxation: Relaxation,
    prescribed: Prescribed,
) -> History:
    """Compute the contact history of a body at rest, as `contact.stepper.march` does."""
    solver = Complementarity(flexibility)
    time, value = prescribed.time, prescribed.value
    peak = float(value.max(initial=0.0))
    depths, pressures, elastics = [], [], []
    depth = 0.0
    solved = 0
    for k, target in enumerate(value):
        step = float(time[k] - time[k - 1]) if k else 0.0
        g, past = relaxation.history(step)
        free = gap - flexibility @ past / g
        if not prescribed.by_force:
            depth, pressure, count = float(target), g * solver.solve(free - target * projected), 1
        else:
            before = depth
            depth, pressure, count = pressure_at_force(
                solver, g, free, projected, float(target), depth, peak
            )
            if target <= 0:  # the obstacle stays, or is pushed back
                depth = min(before, depth)
        elastic = (pressure - past) / g
        relaxation.advance(step, elastic)
        depths.append(depth)
        pressures.append(pressure)
        elastics.append(elastic)
        solved += count
    return History(np.array(depths), np.array(pressures), np.array(elastics), solved)
