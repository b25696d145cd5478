"""Presses of the default finger that suite `human` compares with measurements on people.

Run as `python -m fefinger.validation.human.presses reports`; it solves deep presses, in some ten
minutes on one core. The suite reads the report, and solves the presses of shipped tables again.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.provenance import save, short
from numpy.typing import NDArray

from fefinger.mechanics import pressed
from fefinger.results.pressure import peaks
from fefinger.results.records import Response
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motion import Motion
from fefinger.scene.motions import Ramp, RampHold
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError, InputError


REPORT = "human-presses.json"

SUBJECTS = ("d.p.", "d.s.", "a.h.", "p.w.")

DEFAULT = "a.h."
"""Subject of the built-in scenes."""

TAPPING = 16.0
"""Speed in mm/s of the deep presses: 2.6 mm in a half period at 3 Hz."""

DEEPEST = (2.9, 2.75, 2.6, 2.4)
"""Depths in mm that a deep press is tried to, largest first."""

PROFILES = {"0.54": (1.61, 4.75, 11.4), "1.1": (1.89, 5.14, 19.9), "2.3": (2.19, 5.54, 35.8)}
"""Depth mm, contact radius mm, highest pressure kPa that the source's model has at held forces."""

ANGLES = (20.0, 30.0, 40.0)
"""Angles in degrees of the plate (Pawluk 1997, section 2.2)."""


def means(resolution: str) -> Finger:
    """Return the finger of mean size, whose tissue is calibrated on the mean subject."""
    return Finger(14.0, 11.0, resolution=resolution)


def finger(name: str, resolution: str = "standard") -> Finger:
    """Return the finger of a subject, or of the means."""
    if name == "means":
        return means(resolution)
    return Finger.subject(name, resolution=resolution)


def press(name: str, motion: Motion, angle: float = 30.0, resolution: str = "standard") -> Response:
    """Press a finger under a plate by `pressed`."""
    return pressed.respond(
        Scene(
            finger=finger(name, resolution),
            indenter=Flat(angle),
            motion=motion,
            ask=Ask(pressure=True, strain=False, fields=False),
        )
    )


def ramp(name: str, depth: float, resolution: str = "standard") -> Response:
    """Press at the 60 mm/s of the source and hold for 5 s."""
    return press(name, RampHold(60.0, depth, hold=5.0), resolution=resolution)


def deep(name: str) -> dict[str, Any]:
    """Return force and area over the depth of a press as deep as it goes, on the coarse mesh."""
    reason = ""
    for depth in DEEPEST:
        try:
            response = press(name, Ramp(TAPPING, depth, corner=0.0), resolution="coarse")
        except (InputError, ConvergenceError) as error:
            reason = reason or str(error)
            continue
        assert response.contact_area is not None
        return {
            "speed_mm_s": TAPPING,
            "depth_mm": short(response.depth),
            "force_N": short(response.force),
            "area_mm2": short(response.contact_area),
            "halt": reason,
        }
    return {"refused": reason}


def held(name: str, force: float, angle: float = 30.0) -> dict[str, Any]:
    """Return depth, area, pressures and the profile along the finger of a held force."""
    response = press(name, RampHold(loading_rate=1.0, force=force, hold=20.0), angle)
    assert response.pad is not None
    assert response.pressure is not None
    assert response.contact_area is not None
    assert response.centroid is not None
    pressure, points = response.pressure[-1], response.pad.points
    middle = (_palmar(points) | (pressure > 0)) & (np.abs(points[:, 1]) < 0.3)
    along = np.argsort(points[middle, 0])
    pushed = points[pressure > 0, 0]
    return {
        "mesh": "standard",
        "force_N": float(response.force[-1]),
        "depth_mm": float(f"{response.depth[-1]:.4g}"),
        "area_mm2": float(f"{response.contact_area[-1]:.4g}"),
        "highest_kPa": float(f"{peaks(response.pad, response.pressure[-1:])[0]:.4g}"),
        "centroid_mm": short(response.centroid[-1]),
        "proximal_mm": float(f"{-pushed.min():.4g}"),
        "distal_mm": float(f"{pushed.max():.4g}"),
        "x_mm": short(points[middle, 0][along]),
        "pressure_kPa": short(pressure[middle][along]),
    }


def _palmar(points: Array) -> NDArray[np.bool_]:
    """Whether points (n, 3) of the pad lie no higher than its most distal one.

    The pad reaches around the tip, so that a place along x has a palmar and a dorsal point there.
    """
    return points[:, 2] <= points[np.argmax(points[:, 0]), 2]


def main(folder: Path) -> None:
    """Solve all presses, and write the report."""
    report = {
        "held": {force: held("means", float(force)) for force in PROFILES},
        "angles": {f"{angle:g}": held(DEFAULT, 0.7, angle) for angle in ANGLES},
        "deep": {name: deep(name) for name in (DEFAULT, "means")},
    }
    save(folder / REPORT, report)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
