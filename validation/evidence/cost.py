"""Measure the cost of `solid` by mesh and depth, and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence.cost reports` on a machine that does nothing else; it
takes some ten minutes of one core.
"""

import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fefinger.validation.empty_cache import only_meshes
from fefinger.validation.evidence.cost_table import SOLID as SOLID_COST
from fefinger.validation.provenance import save

from fefinger.mechanics import solid
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Bar, Flat, Sphere
from fefinger.scene.motions import RampHold
from fefinger.scene.scene import Scene


OWN = "maeno1998"
"""The tissue that fingers have by default."""

PRESSES: tuple[tuple[str, str, str, Indenter, tuple[float, ...]], ...] = (
    ("coarse", "a.h.", OWN, Flat(30), (0.3, 0.7, 1.1, 1.5, 1.9, 2.3)),
    ("coarse", "a.h.", OWN, Flat(0), (0.9,)),
    ("coarse", "a.h.", OWN, Flat(45), (1.5, 2.3)),
    ("coarse", "a.h.", OWN, Sphere(5), (0.7, 1.5)),
    ("coarse", "a.h.", OWN, Sphere(10), (2.0,)),
    ("coarse", "a.h.", OWN, Bar(2.0, corner=1.0), (0.3, 0.6)),
    ("coarse", "a.h.", "calibrated_ah", Flat(30), (1.0, 1.5)),
    ("coarse", "d.s.", OWN, Flat(30), (1.5,)),
    ("coarse", "p.w.", OWN, Flat(30), (1.5,)),
    ("standard", "a.h.", OWN, Flat(30), (0.5, 1.0, 1.5, 1.9)),
    ("standard", "a.h.", OWN, Sphere(5), (1.5,)),
    ("standard", "a.h.", OWN, Bar(2.0, corner=1.0), (0.6,)),
    ("standard", "a.h.", "calibrated_ah", Flat(30), (1.5,)),
)
"""Mesh, subject, tissue, object and depths in mm; each a ramp of 60 mm/s and a hold of 1 s."""


def scene(mesh: str, subject: str, tissue: str, indenter: Indenter, depth: float) -> Scene:
    """Return a press with all that `solid` may be asked."""
    return Scene(
        finger=Finger.subject(subject, tissue=tissue, resolution=mesh),
        indenter=indenter,
        motion=RampHold(60, depth, hold=1.0),
        ask=Ask(spikes=("SAI",)),
    )


def row(mesh: str, subject: str, tissue: str, indenter: Indenter, depth: float) -> dict[str, Any]:
    """Return the CPU seconds of a press, by stage, and the work that it was."""
    pressed = scene(mesh, subject, tissue, indenter, depth)
    with only_meshes():  # a first answer solves its reference press
        started = time.process_time()
        response = solid.respond(pressed)
    spent, seconds = time.process_time() - started, response.seconds
    share = spent / sum(seconds.values())  # stages are in wall time
    steps = int(response.numbers["steps"])
    return {
        "mesh": mesh,
        "subject": subject,
        "tissue": tissue,
        "kind": indenter.kind,
        "indenter": asdict(indenter),
        "law": pressed.finger.subcutaneous.law,
        "depth_mm": depth,
        "thickness_mm": pressed.finger.thickness,
        "unknowns": int(response.numbers["unknowns"]),
        "steps": steps,
        "iterations": int(response.numbers["iterations"]),
        "setup_seconds": round(share * (seconds["mesh"] + seconds["factor"]), 3),
        "reference_seconds": round(share * seconds["reference"], 3),
        "step_seconds": round(share * seconds["steps"] / steps, 4),
        "seconds": round(spent, 2),
    }


def report() -> dict[str, Any]:
    """Return the report: every press on its mesh."""
    solid.respond(scene("coarse", "a.h.", OWN, Flat(30), 0.1))  # compiles
    return {
        "scene": "ramps of 60 mm/s with a hold of 1 s, on half a finger; CPU seconds",
        "rows": [
            row(mesh, subject, tissue, indenter, depth)
            for mesh, subject, tissue, indenter, depths in PRESSES
            for depth in depths
        ],
    }


if __name__ == "__main__":
    save(Path(sys.argv[1]) / SOLID_COST, report())
