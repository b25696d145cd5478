"""Indentation over finger thickness under a force, read from relaxed curves of measured presses."""

from collections.abc import Mapping, Sequence
from functools import cache
from json import loads
from typing import Any

import numpy as np

from fefinger.scene import library
from fefinger.scene.finger import Finger
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


def under_force(
    finger: Finger,
    force: float,
    row: Mapping[str, Any],
    forces: Sequence[float],
    curve: Mapping[str, Any] | None = None,
) -> float:
    """Return depth over thickness under a force in N, by a press `row` and the forces in N of it.

    Forces scale with the modulus and the square of the size; a calibrated finger may have a `curve`
    of its own. Beyond the largest force the depth is taken to grow on as before, more than it does.
    """
    if curve is not None:
        return _extended(force, curve["force_N"], curve["depth_mm"]) / finger.thickness
    stiffer = finger.subcutaneous.modulus / row["subcutaneous_kPa"]
    larger = (finger.thickness / row["thickness_mm"]) ** 2
    return _extended(force / stiffer / larger, forces, row["depth_mm"]) / row["thickness_mm"]


def _extended(wanted: float, force: Sequence[float], depth: Sequence[float]) -> float:
    """Return the depth in mm at a force, linear between those that are known and beyond them."""
    forces, depths = np.array([0.0, *force]), np.array([0.0, *depth])
    beyond = max(wanted - forces[-1], 0.0)
    slope = (depths[-1] - depths[-2]) / (forces[-1] - forces[-2])
    return float(np.interp(wanted, forces, depths) + slope * beyond)
