"""Measure the force of `layered` against `linear` and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence_layered reports`; it takes about a minute.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

from fefinger.validation.provenance import provenance

from fefinger import scenes
from fefinger.mechanics import layered, linear
from fefinger.mechanics._evidence import LAYERED_PRESSES, LAYERED_REPORT
from fefinger.scene import Scene


DEPTHS = {
    "sphere-2": (0.2, 0.5, 0.6),  # deeper, the pad of `linear` reaches the equator of the ball
    "sphere-5": (0.2, 0.5, 1.0, 1.5),
    "flat-30": (0.2, 0.5, 1.0, 1.5),
}
"""Depths in mm at which the force is measured under each object."""

ALONE = {"ask.fields": False, "ask.spikes": []}


def scene(press: str, depth: float) -> Scene:
    """Return the ramp to `depth` mm at 60 mm/s on the finger of flat-press, standard mesh."""
    kind, number = press.split("-")
    size = {"angle": float(number)} if kind == "flat" else {"radius": LAYERED_PRESSES[press]}
    motion = {"kind": "ramp", "speed": 60, "depth": depth, "corner": 0}
    indenter = {"kind": kind, **size}
    return scenes.load("flat-press", {"indenter": indenter, "motion": motion, **ALONE})


def row(press: str) -> dict[str, list[float]]:
    """Return depth, both peak forces and their relative difference under one object."""
    asked = [scene(press, depth) for depth in DEPTHS[press]]
    mine = [float(layered.respond(each).force.max()) for each in asked]
    theirs = [float(linear.respond(each).force.max()) for each in asked]
    return {
        "depth_mm": list(DEPTHS[press]),
        "layered_N": mine,
        "linear_N": theirs,
        "force_error": [round(abs(a / b - 1), 5) for a, b in zip(mine, theirs, strict=True)],
    }


def seconds() -> dict[str, float]:
    """Return the wall time in s of an answer to flat-press, and of each of its time steps."""
    # Another tissue first: it loads what is loaded once and leaves no contact of this one behind.
    layered.respond(scenes.load("flat-press", {"finger.tissue": "saal2017", **ALONE}))
    started = time.perf_counter()
    response = layered.respond(scenes.load("flat-press", {"ask.fields": False}))
    whole, contact = time.perf_counter() - started, response.seconds["contact"]
    return {
        "setup_seconds": round(whole - contact, 3),
        "step_seconds": round(contact / len(response.time), 7),
    }


def tissue() -> dict[str, Any]:
    """Return what the error depends on of the tissues: the ratio of moduli, Poisson's ratios."""
    finger = scenes.load("flat-press").finger
    skin, rest = finger.skin, finger.subcutaneous
    return {
        "skin_over_subcutaneous": skin.modulus / rest.modulus,
        "poisson": {"skin": skin.poisson, "subcutaneous": rest.poisson},
    }


def report() -> dict[str, Any]:
    """Return force, error and cost of `layered`."""
    return {
        **provenance("python -m fefinger.validation.evidence_layered reports"),
        "scene": "flat-press with fields off, ramps of 60 mm/s with sharp corners, standard mesh",
        "tissue": tissue(),
        **seconds(),
        "presses": {press: row(press) for press in LAYERED_PRESSES},
    }


if __name__ == "__main__":
    target = Path(sys.argv[1]) / LAYERED_REPORT
    target.write_text(json.dumps(report(), indent=1) + "\n", encoding="utf-8")
    print(target.read_text(encoding="utf-8"))
