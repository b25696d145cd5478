"""Identify the `lumped` law of fingers from their presses; write the report the planner reads.

Run as `python -m fefinger.validation.evidence.lumped reports`; it reads what other reports hold of
`solid` under plates, in seconds.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.calibration.subjects import calibrated
from fefinger.validation.evidence.solid import REPORT as SOLID
from fefinger.validation.provenance import compact, provenance
from fefinger.validation.tradeoff.errors import law, spring

from fefinger.mechanics.evidence.press_margins import MAIN
from fefinger.mechanics.evidence.table import LUMPED, TRADEOFF, read
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array


ANGLE = 30.0
"""Angle in degrees of the plate under which the subjects' fingers were pressed and calibrated."""

DEPTHS = 40


def row(subject: str, angle: float, depth: Array, force: Array, source: str) -> dict[str, Any]:
    """Return b, m of relaxed force in N against depth in mm, the misfit, and whose finger it is."""
    finger = Finger.subject(subject, tissue="maeno1998")
    b, m = spring(depth, force)
    off = np.abs(law((b, m), depth) - force).max() / force.max()
    return {
        "subject": subject,
        "angle": angle,
        "b": float(f"{b:.5g}"),
        "m": float(f"{m:.5g}"),
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


def rows() -> Iterator[dict[str, Any]]:
    """Give the laws of every finger and plate of which a press of `solid` is kept."""
    for name, press in read(TRADEOFF)["rules"]["presses"].items():
        if press["angle"] is not None:
            depth, force = (np.array(press[key]) for key in ("depth_mm", "force_N"))
            source = f"reports/{TRADEOFF}, {name}"
            yield row(MAIN, press["angle"], depth, force, source)
    for name, press in read(SOLID)["rows"].items():
        subject, _, kind = name.partition("/")
        if kind == f"flat-{ANGLE:g}" and subject != MAIN:
            depth, force = np.array(press["depth_mm"]), np.array(press["force_N"]["solid"])
            yield row(subject, ANGLE, depth, force, f"reports/{SOLID}, {name}")


def relaxed(subject: str) -> dict[str, list[float]]:
    """Return the relaxed force in N of the finger that was fitted to a subject, by depth in mm."""
    curve = calibrated(subject).curve
    depth = np.linspace(0, curve.deepest, DEPTHS + 1)[1:]
    listed = {"depth_mm": depth, "force_N": curve.force(depth)}
    return {key: [float(f"{x:.4g}") for x in values] for key, values in listed.items()}


def main(folder: Path) -> None:
    """Write the report."""
    command = "python -m fefinger.validation.evidence.lumped reports"
    report = provenance(command) | {
        "angle": ANGLE,
        "rows": list(rows()),
        "calibrated": {name: relaxed(name) for name in ("d.p.", "d.s.", "a.h.", "p.w.")},
    }
    text = compact(report)
    (folder / LUMPED).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
