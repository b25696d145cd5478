"""Measure `solid` against everything cheaper and write the report that the suite `finger` reads.

Run as `python -m fefinger.validation.evidence.solid reports [ROW ...]`; all rows take about half an
hour. A row is a subject and a press, as "a.h./flat-30"; rows that are not named are kept.
"""

import sys
import time
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.empty_cache import only_meshes
from fefinger.validation.evidence.press_errors import ORDER
from fefinger.validation.evidence.press_mesh import MAIN
from fefinger.validation.problems.chain import (
    ASIDE,
    CHAIN,
    PRESSES,
    SUBJECTS,
    models,
    reaching,
    scene,
    stiffening,
)
from fefinger.validation.provenance import save, saved

from fefinger.mechanics import solid
from fefinger.results.records import Response
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError, InputError


REPORT = "solid-force.json"

RESOLUTION = "standard"
"""The mesh of all rows but those of tissue that itself stiffens, which are on the coarse one."""

EXPONENT = 3.0
"""b of Demiray's law in the rows of tissue that itself stiffens, a round number."""

ROWS = (
    *(f"{MAIN}/{press}" for press in PRESSES),
    *(f"{other}/{press}" for other in SUBJECTS[1:] for press in ("flat-30", "sphere-5")),
    *(f"{subject}/demiray" for subject in SUBJECTS),
)


def demiray(subject: str) -> dict[str, Any]:
    """Return depths and the force of `solid` under the plate on tissue that itself stiffens."""
    pressed = scene(subject, "flat-30", "coarse")
    depth, force, _ = reaching("solid", stiffening(pressed, EXPONENT))
    return {
        "resolution": "coarse",
        "exponent": EXPONENT,
        "thickness_mm": pressed.finger.thickness,
        "depth_mm": _listed(depth),
        "force_N": {"solid": _listed(force)},
    }


def row(name: str) -> dict[str, Any]:
    """Return depths and the forces of all models, relaxed, and what they cost.

    The subject that the planner goes by also has the ramp with relaxation.
    """
    subject, press = name.split("/")
    if press == "demiray":
        return demiray(subject)
    pressed = scene(subject, press, RESOLUTION)
    forces: dict[str, list[float | None]] = {}
    for model in (*models(press), *ASIDE):
        with only_meshes() if model == "solid" else nullcontext():  # its cost is of a first answer
            started = time.process_time()
            depth, force, response = reaching(model, pressed)
        forces[model] = _listed(force)
        if model == "solid":
            cost = _cost(response, time.process_time() - started)
    record: dict[str, Any] = {
        "resolution": RESOLUTION,
        "thickness_mm": pressed.finger.thickness,
        "subcutaneous_kPa": pressed.finger.subcutaneous.modulus,
        "depth_mm": _listed(depth),
        "force_N": forces,
        "cost": cost,
        "coarse": _coarse(subject, press),
    }
    if subject == MAIN:
        record["relaxing_N"] = _relaxing(subject, press)
    return record | {"mesh_error": _mesh_error(record)}


def _coarse(subject: str, press: str) -> dict[str, Any] | None:
    """Return forces and cost on the coarse mesh, or None where it is too coarse for the object."""
    pressed, out = scene(subject, press, "coarse"), dict[str, Any]()
    for model in ("linear", "solid"):
        try:
            with only_meshes():
                started = time.process_time()
                _, force, response = reaching(model, pressed)
        except (InputError, ConvergenceError):
            return None
        if np.isnan(force).any():
            return None
        out |= {model: _listed(force)}
    return out | {"cost": _cost(response, time.process_time() - started)}


def _relaxing(subject: str, press: str) -> dict[str, Any] | None:
    """Return the forces of a ramp with relaxation; under a ball on the coarse mesh, or None."""
    resolution = RESOLUTION if press == "flat-30" else "coarse"
    pressed = scene(subject, press, resolution, relaxed=False)
    try:
        return {model: _listed(reaching(model, pressed)[1]) for model in ("linear", "solid")}
    except (InputError, ConvergenceError):
        return None


def _mesh_error(record: dict[str, Any]) -> dict[str, float] | None:
    """Return the error of the force at the end against the mesh extrapolated from both."""
    if record["coarse"] is None:
        return None
    costs = {"coarse": record["coarse"]["cost"], "standard": record["cost"]}
    forces = {"coarse": record["coarse"]["solid"][-1], "standard": record["force_N"]["solid"][-1]}
    ratio = (costs["standard"]["unknowns"] / costs["coarse"]["unknowns"]) ** (ORDER / 3)
    limit = forces["standard"] + (forces["standard"] - forces["coarse"]) / (ratio - 1)
    return {name: round(abs(force / limit - 1), 5) for name, force in forces.items()}


def _cost(response: Response, spent: float) -> dict[str, float]:
    """Return size and cost: the CPU time `spent`, shared as the stages share the wall time."""
    numbers, seconds = response.numbers, response.seconds
    setup = seconds["mesh"] + seconds["factor"]
    share = spent / sum(seconds.values())
    return {
        "unknowns": int(numbers["unknowns"]),
        "steps": int(numbers["steps"]),
        "iterations": int(numbers["iterations"]),
        "setup_seconds": round(share * setup, 3),
        "step_seconds": round(share * seconds["steps"] / numbers["steps"], 3),
    }


def _listed(values: Array) -> list[float | None]:
    return [None if np.isnan(value) else float(f"{value:.6g}") for value in values]


def report(rows: dict[str, Any]) -> dict[str, Any]:
    """Return the report on those rows."""
    return {
        "scene": "ramps of 60 mm/s with sharp corners; force_N is that of relaxed tissue, "
        "relaxing_N with Table 3.1 (under a ball on the coarse mesh)",
        "seconds": "of CPU, for setup and a step of solid, on a busy machine; the planner goes by "
        "solid-cost.json",
        "extrapolation": f"order {ORDER:g} in the cell length from the two meshes",
        "models": CHAIN | ASIDE,
        "rows": {name: rows[name] for name in ROWS if name in rows},
    }


if __name__ == "__main__":
    target = Path(sys.argv[1]) / REPORT
    solid.respond(scene(MAIN, "sphere-5", "coarse"))  # compiles
    rows = {name: row(name) for name in sys.argv[2:] or ROWS}
    # Read last, so that rows may be measured at the same time.
    save(target, report(saved(target).get("rows", {}) | rows))
