"""Stated errors where the force is prescribed: of its depth, and of all else at that force."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from fefinger.mechanics.evidence import tradeoff
from fefinger.scene.scene import Scene


def errors(at_depth: Mapping[str, float], force: float, scene: Scene) -> dict[str, float]:
    """Return the relative errors at a force, of those `at_depth` and that of the `force` there.

    What grows no faster than the force is wrong by no more than the force in addition. The force
    grows as depth to a power p, so that the depth is wrong by (1 - force)^(-1/p) - 1 at most.
    """
    depth = (1 - force) ** (-1 / steepness(scene)) - 1 if force < 1 else math.inf
    return {"depth": depth} | {name: error + force for name, error in at_depth.items()}


def steepness(scene: Scene) -> float:
    """Return the least p of the measured presses next to a scene, about its depth.

    Of a scene that is like none of them it is 1: a contact only stiffens as it grows.
    """
    place = tradeoff.where(scene)
    if place is None or not tradeoff.like(scene.finger):
        return 1.0
    presses = tradeoff.rules()["presses"]
    names = tradeoff.neighbors(presses, place)
    return max(1.0, min(_power(presses[name], tradeoff.part(scene, name)) for name in names))


def _power(press: Mapping[str, Any], part: float) -> float:
    """Return the least power of the force over depth beside a depth over thickness in a press."""
    depth = np.array(press["depth_mm"])
    powers = np.diff(np.log(press["force_N"])) / np.diff(np.log(depth))
    at = int(np.searchsorted(depth, part * press["thickness_mm"]))
    return float(powers[max(at - 2, 0) : at + 1].min(initial=powers[-1]))
