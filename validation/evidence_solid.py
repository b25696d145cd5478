"""Measure `solid` against everything cheaper and write the report that planner and suite read.

Run as `python -m fefinger.validation.evidence_solid reports [ROW ...]`; all rows take about half an
hour. A row is a subject and a press, as "a.h./flat-30"; rows that are not named are kept.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.chain import (
    ASIDE,
    CHAIN,
    PRESSES,
    SUBJECTS,
    Array,
    models,
    reaching,
    scene,
)
from fefinger.validation.evidence import ORDER
from fefinger.validation.provenance import provenance

from fefinger.checks import ConvergenceError, InputError
from fefinger.mechanics import solid
from fefinger.mechanics._evidence import SOLID_REPORT, SOLID_SUBJECT
from fefinger.records import Response


ROWS = tuple(f"{subject}/{press}" for subject in SUBJECTS for press in PRESSES)


def row(name: str) -> dict[str, Any]:
    """Return depths and the forces of all models, relaxed, and what they cost.

    The subject that the planner goes by also has both meshes and the ramp with relaxation.
    """
    subject, press = name.split("/")
    pressed = scene(subject, press)
    forces: dict[str, list[float | None]] = {}
    seconds: dict[str, float] = {}
    for model in (*models(press), *ASIDE):
        started = time.perf_counter()
        depth, force, response = reaching(model, pressed)
        seconds[model] = round(time.perf_counter() - started, 3)
        forces[model] = _listed(force)
        if model == "solid":
            cost = _cost(response)
    record: dict[str, Any] = {
        "thickness_mm": pressed.finger.thickness,
        "subcutaneous_kPa": pressed.finger.subcutaneous.modulus,
        "depth_mm": _listed(depth),
        "force_N": forces,
        "seconds": seconds,
        "cost": cost,
    }
    if subject == SOLID_SUBJECT:
        record |= {"coarse": _coarse(subject, press), "relaxing_N": _relaxing(subject, press)}
        record["mesh_error"] = _mesh_error(record)
    return record


def _coarse(subject: str, press: str) -> dict[str, Any] | None:
    """Return forces and cost on the coarse mesh, or None where it is too coarse for the object."""
    pressed, out = scene(subject, press, "coarse"), dict[str, Any]()
    for model in ("linear", "solid"):
        try:
            _, force, response = reaching(model, pressed)
        except (InputError, ConvergenceError):
            return None
        if np.isnan(force).any():
            return None
        out |= {model: _listed(force)}
    return out | {"cost": _cost(response)}


def _relaxing(subject: str, press: str) -> dict[str, Any]:
    """Return the forces of a ramp with relaxation."""
    pressed = scene(subject, press, relaxed=False)
    return {model: _listed(reaching(model, pressed)[1]) for model in ("hertz", "linear", "solid")}


def _mesh_error(record: dict[str, Any]) -> dict[str, float] | None:
    """Return the error of the force at the end against the mesh extrapolated from both."""
    if record["coarse"] is None:
        return None
    costs = {"coarse": record["coarse"]["cost"], "standard": record["cost"]}
    forces = {"coarse": record["coarse"]["solid"][-1], "standard": record["force_N"]["solid"][-1]}
    ratio = (costs["standard"]["unknowns"] / costs["coarse"]["unknowns"]) ** (ORDER / 3)
    limit = forces["standard"] + (forces["standard"] - forces["coarse"]) / (ratio - 1)
    return {name: round(abs(force / limit - 1), 5) for name, force in forces.items()}


def _cost(response: Response) -> dict[str, float]:
    numbers, seconds = response.numbers, response.seconds
    return {
        "unknowns": int(numbers["unknowns"]),
        "steps": int(numbers["steps"]),
        "iterations": int(numbers["iterations"]),
        "setup_seconds": round(seconds["mesh"] + seconds["factor"], 3),
        "step_seconds": round(seconds["steps"] / numbers["steps"], 3),
    }


def _listed(values: Array) -> list[float | None]:
    return [None if np.isnan(value) else float(f"{value:.6g}") for value in values]


def report(kept: dict[str, Any], names: tuple[str, ...]) -> dict[str, Any]:
    """Return the report with the rows called `names` measured and the others as they were."""
    solid.respond(scene("a.h.", "flat-30", "coarse"))  # compiles
    rows = kept | {name: row(name) for name in names}
    return {
        **provenance("python -m fefinger.validation.evidence_solid reports"),
        "scene": "ramps of 60 mm/s with sharp corners, standard mesh unless it says coarse; "
        "relaxed: the elastic force of relaxed tissue, relaxing: with Table 3.1",
        "extrapolation": f"order {ORDER:g} in the cell length from the two meshes",
        "models": CHAIN | ASIDE,
        "rows": {name: rows[name] for name in ROWS if name in rows},
    }


if __name__ == "__main__":
    target = Path(sys.argv[1]) / SOLID_REPORT
    asked = tuple(sys.argv[2:]) or ROWS
    before = json.loads(target.read_text(encoding="utf-8"))["rows"] if target.exists() else {}
    target.write_text(json.dumps(report(before, asked), indent=1) + "\n", encoding="utf-8")
