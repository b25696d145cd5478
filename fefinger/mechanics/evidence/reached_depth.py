"""Indentation over finger thickness under a force, read from relaxed curves of measured presses."""

from collections.abc import Sequence

import numpy as np

from fefinger.mechanics.evidence.pressed_objects import PLATE, neighbor_presses
from fefinger.mechanics.evidence.table import MAIN, PRESS_MESH, Measured, table
from fefinger.mechanics.press.notes import stiffens
from fefinger.results.candidate import Candidate
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter


def curves(finger: Finger, indenter: Indenter) -> tuple[Measured, ...]:
    """Return the force over the depth in presses of the finger's tissue by objects like this one.

    Without a press of that tissue, those of MAIN, whose tissue stiffens in nearly the same way;
    without any object like it, the press by the plate of the subjects.
    """
    forces = table().presses(PRESS_MESH, "force", Candidate("solid"))
    tissue = library.fitted_to(finger.tissue) or (MAIN if stiffens(finger) else library.PUBLISHED)
    names, _ = neighbor_presses(indenter)
    for owner in (tissue, MAIN) if stiffens(finger) else (tissue,):
        presses = [forces[f"{owner}/{name}"] for name in names if f"{owner}/{name}" in forces]
        if presses:
            return tuple(presses)
    return (forces[f"{tissue}/{PLATE}"],)


def under_force(finger: Finger, force: float, measured: Sequence[Measured]) -> float:
    """Return the largest depth over the thickness under a force in N, by curves of presses.

    Forces scale with the modulus and the square of the size. Beyond the largest force the depth is
    extrapolated linearly, an upper bound.
    """
    return max(_under(finger, force, each) for each in measured)


def _under(finger: Finger, force: float, measured: Measured) -> float:
    assert measured.depth is not None
    stiffer = finger.subcutaneous.modulus / measured.conditions["subcutaneous_kPa"]
    thickness = float(measured.conditions["thickness_mm"])
    scaled = force / stiffer / (finger.thickness / thickness) ** 2
    forces, depths = np.array([0.0, *measured.values]), np.array([0.0, *measured.depth])
    beyond = max(scaled - forces[-1], 0.0)
    slope = (depths[-1] - depths[-2]) / (forces[-1] - forces[-2])
    return float(np.interp(scaled, forces, depths) + slope * beyond) / thickness
