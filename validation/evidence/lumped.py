"""Identify the `lumped` law of fingers from their presses; write the report the planner reads.

Run as `python -m fefinger.validation.evidence.lumped reports`; it reads what other reports hold of
`solid` under plates, presses the calibrated fingers while they relax, and takes two minutes.
"""

import json
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.calibration.subjects import calibrated
from fefinger.validation.provenance import provenance
from fefinger.validation.tradeoff.errors import law, spring

from fefinger.mechanics import solid
from fefinger.mechanics.evidence.reports import SOLID_SUBJECT
from fefinger.mechanics.evidence.table import LUMPED, SOLID, TRADEOFF, read
from fefinger.scene import library
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.theory.lumped.spring import Spring, contact_force
from fefinger.theory.relaxation import Prony


ANGLE = 30.0
"""Angle in degrees of the plate under which the subjects' fingers were pressed and calibrated."""

DEPTHS = 40

SPEED = 64.0
"""Speed in mm/s of the ramp that tells what relaxation adds, that of the thesis's fast curves."""

EARLY = 0.3
"""Part of the depth before which it is not judged: the law is far off there in any case."""


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
            yield row(SOLID_SUBJECT, press["angle"], depth, force, source)
    for name, press in read(SOLID)["rows"].items():
        subject, _, kind = name.partition("/")
        if kind == f"flat-{ANGLE:g}" and subject != SOLID_SUBJECT:
            depth, force = np.array(press["depth_mm"]), np.array(press["force_N"]["solid"])
            yield row(subject, ANGLE, depth, force, f"reports/{SOLID}, {name}")


def misfit(subject: str) -> dict[str, list[float]]:
    """Relative difference of Table 2.1 from the finger that was fitted to it, by depth in mm.

    The largest difference of forces down to each depth over the force there, of the relaxed or
    of the instantaneous finger, whichever is larger.
    """
    calibration, printed = calibrated(subject), library.pawluk_bulk()[subject]
    depth = np.linspace(0, calibration.curve.deepest, DEPTHS + 1)[1:]
    relaxed = calibration.curve.force(depth)
    table = law((printed.b, printed.m), depth)
    pairs = (
        (table, relaxed / calibration.prony.long_time),
        (table * printed.prony.long_time, relaxed),
    )
    errors = [np.maximum.accumulate(np.abs(one - other)) / other for one, other in pairs]
    listed = {"depth_mm": depth, "force_N": relaxed, "error": np.max(errors, axis=0)}
    return {key: [float(f"{x:.4g}") for x in values] for key, values in listed.items()}


def relaxing(subject: str) -> float:
    """Return by how much more Table 2.1 errs of the fitted finger while it relaxes.

    At finite strain a finger that is pressed fast is stiffer than one at rest by more than the
    whole of G. Of a ramp of SPEED on the coarse mesh, beyond EARLY of its depth.
    """
    finger = Finger.subject(subject, tissue=library.calibrated_name(subject), resolution="coarse")
    depth = np.linspace(EARLY, 1, DEPTHS) * calibrated(subject).curve.deepest
    motion = Ramp(SPEED, float(depth[-1]), corner=0.0)
    ask = Ask(pressure=False, strain=False, fields=False)
    errors = []
    for prony in (Prony((1.0,), ()), finger.prony):
        pressed = replace(finger, prony=prony)
        scene = Scene(finger=pressed, indenter=Flat(ANGLE), motion=motion, ask=ask)
        response, printed = solid.respond(scene), library.pawluk_bulk()[subject]
        spring = Spring(printed.b, printed.m)
        prony_of_spring = printed.prony if prony.v else prony
        scale = 1.0 if prony.v else printed.prony.long_time
        forces = scale * contact_force(spring, prony_of_spring, response.time, response.depth)
        apart = np.interp(depth, response.depth, forces) / np.interp(
            depth, response.depth, response.force
        )
        errors.append(np.abs(apart - 1))
    return float(f"{max((errors[1] - errors[0]).max(), 0.0):.3g}")


def main(folder: Path) -> None:
    """Write the report."""
    command = "python -m fefinger.validation.evidence.lumped reports"
    report = provenance(command) | {
        "angle": ANGLE,
        "rows": list(rows()),
        "calibrated": {
            name: misfit(name) | {"relaxing": relaxing(name)}
            for name in ("d.p.", "d.s.", "a.h.", "p.w.")
        },
    }
    text = json.dumps(report, indent=1) + "\n"
    (folder / LUMPED).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
