"""How deep a scene goes: under force control when the finger has crept, as presses like it tell."""

from collections.abc import Mapping, Sequence
from functools import cache
from json import loads
from typing import Any

import numpy as np

from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.support.package_data import report


REPORT = "lumped-force.json"


@cache
def read() -> dict[str, Any]:
    """Return the report with the curves of calibrated fingers."""
    found: dict[str, Any] = loads(report(REPORT))
    return found


def calibrated(finger: Finger) -> dict[str, Any] | None:
    """Return the curve of a finger that was calibrated on a subject, with nothing changed."""
    name = finger.subject_name
    if name not in library.pawluk_bulk() or finger.tissue != library.calibrated_name(name):
        return None
    shipped = Finger.subject(name, tissue=finger.tissue, resolution=finger.resolution)
    row: dict[str, Any] = read()["calibrated"][str(name)]
    return row if finger == shipped else None


def part(scene: Scene, row: Mapping[str, Any], force: Sequence[float]) -> float:
    """Return depth over thickness, by a press `row` and its forces in N at its depths.

    Forces scale with the modulus and the square of the size; under a plate a calibrated finger has
    a curve of its own. Beyond the largest force the depth is taken to grow on as before, more than
    it does.
    """
    thickness, wanted = scene.finger.thickness, scene.motion.peak
    if scene.motion.control == "depth":
        return wanted / thickness
    own = calibrated(scene.finger) if scene.indenter.flat is not None else None
    if own is not None:
        return _extended(wanted, own["force_N"], own["depth_mm"]) / thickness
    stiffer = scene.finger.subcutaneous.modulus / row["subcutaneous_kPa"]
    larger = (thickness / row["thickness_mm"]) ** 2
    return _extended(wanted / stiffer / larger, force, row["depth_mm"]) / row["thickness_mm"]


def _extended(wanted: float, force: Sequence[float], depth: Sequence[float]) -> float:
    """Return the depth in mm at a force, linear between those that are known and beyond them."""
    forces, depths = np.array([0.0, *force]), np.array([0.0, *depth])
    beyond = max(wanted - forces[-1], 0.0)
    slope = (depths[-1] - depths[-2]) / (forces[-1] - forces[-2])
    return float(np.interp(wanted, forces, depths) + slope * beyond)
