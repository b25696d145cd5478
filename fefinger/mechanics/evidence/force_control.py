"""Stated errors where the force is prescribed: of its depth, and of all else at that force."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from fefinger.mechanics.evidence.tradeoff import rules
from fefinger.mechanics.situation import Situation


def errors(at_depth: Mapping[str, float], force: float, case: Situation) -> dict[str, float]:
    """Return the relative errors at a force, of those `at_depth` and that of the `force` there.

    What grows no faster than the force is wrong by no more than the force in addition. The force
    grows as depth to a power p, so that the depth is wrong by (1 - force)^(-1/p) - 1 at most.
    """
    depth = (1 - force) ** (-1 / steepness(case)) - 1 if force < 1 else math.inf
    return {"depth": depth} | {name: error + force for name, error in at_depth.items()}


def steepness(case: Situation) -> float:
    """Return the least p of the measured presses next to a scene, about its depth.

    Of a scene that is like none of them it is 1: a contact only stiffens as it grows.
    """
    if case.place is None or not case.measured_tissue:
        return 1.0
    rows = rules()["presses"]
    return max(1.0, min(_power(rows[name], case.deepest(name)) for name in case.neighbors))


def _power(press: Mapping[str, Any], part: float) -> float:
    """Return the least power of the force over depth beside a depth over thickness in a press."""
    depth = np.array(press["depth_mm"])
    powers = np.diff(np.log(press["force_N"])) / np.diff(np.log(depth))
    at = int(np.searchsorted(depth, part * press["thickness_mm"]))
    return float(powers[max(at - 2, 0) : at + 1].min(initial=powers[-1]))
