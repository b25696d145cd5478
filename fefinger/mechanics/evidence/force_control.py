"""Errors under force control, from those at a given depth."""

import math
from collections.abc import Mapping

import numpy as np

from fefinger.mechanics.evidence.pressed_objects import axis_and_value
from fefinger.mechanics.evidence.table import Measured
from fefinger.mechanics.situation import Situation


def errors(at_depth: Mapping[str, float], force: float, case: Situation) -> dict[str, float]:
    """Convert relative errors at a depth, `at_depth` and that of the `force`, to those at a force.

    A quantity that grows no faster than the force gains at most the error of the force. The force
    grows as a power p of the depth, so the error of the depth is at most (1 - force)^(-1/p) - 1.
    """
    depth = (1 - force) ** (-1 / steepness(case)) - 1 if force < 1 else math.inf
    return {"depth": depth} | {name: error + force for name, error in at_depth.items()}


def steepness(case: Situation) -> float:
    """Return the smallest exponent p of force = a depth^p in the measured presses around a scene.

    It is 1 for a scene without comparable presses: a contact stiffens as it grows.
    """
    if axis_and_value(case.indenter) is None or not (
        case.published_tissue or case.calibrated_tissue
    ):
        return 1.0
    return max(1.0, min(_power(each, case.depth_over_thickness) for each in case.force_curves))


def _power(force: Measured, part: float) -> float:
    """Return the smallest exponent of force over depth near a relative depth of a press."""
    depth = np.asarray(force.depth)
    powers = np.diff(np.log(force.values)) / np.diff(np.log(depth))
    at = int(np.searchsorted(depth, part * force.conditions["thickness_mm"]))
    return float(powers[max(at - 2, 0) : at + 1].min(initial=powers[-1]))
