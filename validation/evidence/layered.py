"""Measure the force of `layered` against `linear` and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence.layered reports`; it takes about two minutes.
"""

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.problems import published
from fefinger.validation.provenance import compact, provenance

from fefinger.mechanics import layered, linear
from fefinger.mechanics.evidence.reports import LAYERED_PRESSES
from fefinger.mechanics.evidence.table import LAYERED
from fefinger.results.records import Response
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene


SUBJECTS = ("d.p.", "d.s.", "a.h.", "p.w.")
"""Subjects whose standard meshes are ready."""

DEPTHS = {
    "sphere-2": (0.2, 0.5, 0.6),  # deeper, the pad of `linear` reaches the equator of the ball
    "sphere-5": (0.2, 0.5, 1.0, 1.5),
    "flat-30": (0.2, 0.5, 1.0, 1.5),
}
"""Depths in mm at which the force is measured under each object, all in one ramp."""

ALONE = {"ask.fields": False, "ask.spikes": []}


def scene(press: str, subject: str = "a.h.") -> Scene:
    """Return the ramp at 60 mm/s to the deepest of DEPTHS on a subject's finger, standard mesh."""
    kind, number = press.split("-")
    size = {"angle": float(number)} if kind == "flat" else {"radius": LAYERED_PRESSES[press]}
    motion = {"kind": "ramp", "speed": 60, "depth": DEPTHS[press][-1], "corner": 0}
    changes = {"indenter": {"kind": kind, **size}, "motion": motion, "finger.subject": subject}
    return published.load("flat-press", {**changes, **ALONE})


def forces(response: Response, press: str) -> list[float]:
    """Return the force in N at the depths of a press, which are among the time steps."""
    at = [int(np.argmin(np.abs(response.depth - depth))) for depth in DEPTHS[press]]
    np.testing.assert_allclose(response.depth[at], DEPTHS[press], rtol=1e-9)
    return response.force[at].tolist()


def row(press: str) -> dict[str, Any]:
    """Return depth, both forces and their relative difference under one object, by subject."""
    subjects = {}
    for subject in SUBJECTS:
        pressed = scene(press, subject)
        mine, theirs = (forces(kind.respond(pressed), press) for kind in (layered, linear))
        subjects[subject] = {
            "layered_N": mine,
            "linear_N": theirs,
            "force_error": [round(abs(a / b - 1), 5) for a, b in zip(mine, theirs, strict=True)],
        }
    errors = [one["force_error"] for one in subjects.values()]
    return {
        "depth_mm": list(DEPTHS[press]),
        "force_error": np.max(errors, axis=0).tolist(),
        "subjects": subjects,
    }


def seconds() -> dict[str, float]:
    """Return the wall time in s of an answer to flat-press, and of each of its time steps.

    `again_seconds` is that of a second one, whose contacts and fields are kept from the first.
    """
    # Another tissue first: it loads what is loaded once and leaves no contact of this one behind.
    layered.respond(published.load("flat-press", {"finger.tissue": "saal2017", **ALONE}))
    flat_press = published.load("flat-press", {"ask.fields": False})
    taken = []
    for _ in range(2):
        started = time.perf_counter()
        response = layered.respond(flat_press)
        taken.append(time.perf_counter() - started - response.seconds["contact"])
    return {
        "setup_seconds": round(taken[0], 3),
        "again_seconds": round(taken[1], 3),
        "step_seconds": round(response.seconds["contact"] / len(response.time), 7),
    }


def tissue() -> dict[str, Any]:
    """Ratios of the tissues' moduli, thicknesses and Poisson ratios, on which the error depends."""
    finger = published.load("flat-press").finger
    skin, rest = finger.skin, finger.subcutaneous
    shares = [
        layered.skin_share(Finger.subject(subject, tissue="maeno1998")) for subject in SUBJECTS
    ]
    return {
        "skin_over_subcutaneous": skin.modulus / rest.modulus,
        "skin_over_stack": [min(shares), max(shares)],
        "poisson": {"skin": skin.poisson, "subcutaneous": rest.poisson},
    }


def report() -> dict[str, Any]:
    """Return force, error and cost of `layered`."""
    return {
        **provenance("python -m fefinger.validation.evidence.layered reports"),
        "scene": "flat-press with fields off, ramps of 60 mm/s with sharp corners, standard mesh",
        "tissue": tissue(),
        **seconds(),
        "presses": {press: row(press) for press in LAYERED_PRESSES},
    }


if __name__ == "__main__":
    target = Path(sys.argv[1]) / LAYERED
    target.write_text(compact(report()), encoding="utf-8")
    print(target.read_text(encoding="utf-8"))
