"""Errors under force control, from those at a depth: of the depth, and of the rest there."""

import math
from collections.abc import Mapping

import numpy as np

from fefinger.mechanics.evidence.table import Measured
from fefinger.mechanics.evidence.tradeoff import forces
from fefinger.mechanics.situation import Situation


def errors(at_depth: Mapping[str, float], force: float, case: Situation) -> dict[str, float]:
    """Return the relative errors at a force, of those `at_depth` and that of the `force` there.

    What grows no faster than the force is wrong by no more than the force in addition. The force
    grows as depth to a power p, so that the depth is wrong by (1 - force)^(-1/p) - 1 at most.
    """
    depth = (1 - force) ** (-1 / steepness(case)) - 1 if force < 1 else math.inf
    return {"depth": depth} | {name: error + force for name, error in at_depth.items()}


def steepness(case: Situation) -> float:
    """Return the smallest exponent p of force = a depth^p in the measured presses around a scene.

    It is 1 for a scene that is like none of them: a contact only stiffens as it grows.
    """
    if case.place is None or not case.measured_tissue:
        return 1.0
    presses = forces()
    return max(1.0, min(_power(presses[name], case.deepest(name)) for name in case.neighbors))


def _power(force: Measured, part: float) -> float:
    """Return the smallest exponent of force over depth, near a depth over thickness of a press."""
    depth = np.asarray(force.depth)
    powers = np.diff(np.log(force.values)) / np.diff(np.log(depth))
    at = int(np.searchsorted(depth, part * force.conditions["thickness_mm"]))
    return float(powers[max(at - 2, 0) : at + 1].min(initial=powers[-1]))
