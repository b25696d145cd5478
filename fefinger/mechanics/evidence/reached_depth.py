"""Indentation over finger thickness under a force, read from relaxed curves of measured presses."""

import numpy as np

from fefinger.mechanics.evidence.table import LUMPED, Measured, table
from fefinger.results.candidate import Candidate
from fefinger.scene import library
from fefinger.scene.finger import Finger


def calibrated(finger: Finger) -> str:
    """Return the name of the press of an unchanged calibrated finger; empty for other fingers."""
    name = finger.subject_name
    if name not in library.pawluk_bulk() or finger.tissue != library.calibrated_name(name):
        return ""
    shipped = Finger.subject(name, tissue=finger.tissue, resolution=finger.resolution)
    return f"calibrated {name}" if finger == shipped else ""


def force_curve(press: str) -> Measured:
    """Return the force of a calibrated finger over the depth, under a plate."""
    return table().presses(LUMPED, "force", Candidate("lumped"))[press]


def under_force(
    finger: Finger, force: float, measured: Measured, own: Measured | None = None
) -> float:
    """Return the depth over the thickness under a force in N, by the force curve of a press.

    Forces scale with the modulus and the square of the size; a calibrated finger may have a curve
    of its `own`. Beyond the largest force the depth is extrapolated linearly, an upper bound.
    """
    if own is not None:
        return _extended(force, own) / finger.thickness
    stiffer = finger.subcutaneous.modulus / measured.conditions["subcutaneous_kPa"]
    thickness = float(measured.conditions["thickness_mm"])
    larger = (finger.thickness / thickness) ** 2
    return _extended(force / stiffer / larger, measured) / thickness


def _extended(force: float, measured: Measured) -> float:
    """Return the depth in mm at a force, linear between those that are known and beyond them."""
    assert measured.depth is not None
    forces, depths = np.array([0.0, *measured.values]), np.array([0.0, *measured.depth])
    beyond = max(force - forces[-1], 0.0)
    slope = (depths[-1] - depths[-2]) / (forces[-1] - forces[-2])
    return float(np.interp(force, forces, depths) + slope * beyond)
