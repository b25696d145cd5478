"""Identify the `lumped` law of fingers from their presses; write the report the planner reads.

Run as `python -m fefinger.validation.evidence.lumped reports`; it reads what other reports hold of
`solid` under plates, in seconds.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.evidence.press_mesh import MAIN, MEASUREMENTS
from fefinger.validation.evidence.press_mesh import REPORT as PRESS_MESH
from fefinger.validation.evidence.solid import REPORT as SOLID
from fefinger.validation.provenance import save
from scipy.optimize import least_squares

from fefinger.mechanics.evidence.presses import read
from fefinger.mechanics.lumped import REPORT as LUMPED
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array
from fefinger.theory.lumped.spring import Spring


ANGLE = 30.0
"""Angle in degrees of the plate under which the other subjects' fingers were pressed."""


def row(subject: str, angle: float, depth: Array, force: Array, source: str) -> dict[str, Any]:
    """Return b, m of relaxed force in N against depth in mm, the misfit, and whose finger it is."""
    finger = Finger.subject(subject, tissue="maeno1998")
    spring = identified(depth, force)
    off = np.abs(_force(spring, depth) - force).max() / force.max()
    return {
        "subject": subject,
        "angle": angle,
        "b": float(f"{spring.b:.5g}"),
        "m": float(f"{spring.m:.5g}"),
        "residual": float(f"{off:.3g}"),
        "deepest_mm": float(depth[-1]),
        "width_mm": finger.width,
        "thickness_mm": finger.thickness,
        "pad_radius_mm": finger.pad_radius,
        "subcutaneous_kPa": finger.subcutaneous.modulus,
        "skin_over_subcutaneous": finger.skin.modulus / finger.subcutaneous.modulus,
        "skin_mm": finger.skin.thickness,
        "source": source,
    }


def identified(depth: Array, force: Array) -> Spring:
    """Return the spring of Eq. 2.1 that is nearest to a force (n,) in N over depths (n,) in mm."""
    optimum = least_squares(
        lambda logs: _force(Spring(*np.exp(logs).tolist()), depth) - force, np.zeros(2)
    )
    return Spring(*np.exp(optimum.x).tolist())


def _force(spring: Spring, depth: Array) -> Array:
    return np.array([spring.force(each) for each in depth.tolist()])


def rows() -> Iterator[dict[str, Any]]:
    """Give the laws of every finger and plate of which a press of `solid` is kept."""
    for name, press in read(PRESS_MESH)["rows"].items():
        tissue, flat = name.partition("/")[0], MEASUREMENTS[name].indenter.flat
        if tissue == library.PUBLISHED and flat is not None:
            depth, force = (np.array(press[key]) for key in ("depth_mm", "force_N"))
            yield row(MAIN, flat.angle, depth, force, f"reports/{PRESS_MESH}, {name}")
    for name, press in read(SOLID)["rows"].items():
        subject, _, kind = name.partition("/")
        if kind == f"flat-{ANGLE:g}" and subject != MAIN:
            depth, force = np.array(press["depth_mm"]), np.array(press["force_N"]["solid"])
            yield row(subject, ANGLE, depth, force, f"reports/{SOLID}, {name}")


if __name__ == "__main__":
    save(Path(sys.argv[1]) / LUMPED, {"rows": list(rows())})
