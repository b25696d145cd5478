"""What the planner reads of the trade-off: force of the presses, tissue, error of time steps."""

from dataclasses import replace
from functools import cache
from typing import Any

from fefinger.validation.tradeoff import motion, runs, scenes
from fefinger.validation.tradeoff.errors import (
    Identified,
    Press,
    converged,
    identify,
    law,
    press,
    unknowns,
)
from fefinger.validation.tradeoff.runs import Run

from fefinger.mechanics import hertz
from fefinger.mechanics.evidence.tradeoff import STATED
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array


MESHES = ("coarse", "standard")

WITHOUT_MESH = ("hertz", "layered")

NO_MESH = (*WITHOUT_MESH, "lumped")

WITH_MESH = ("condensed", "linear", "solid")

LIMIT = {"condensed": "linear"}
"""Whose limit of fine meshes a mechanics has, if not its own."""

FINGERS = ("d.p.", "p.w.")
"""Fingers whose share of skin counts as measured, beside that of the presses."""


@cache
def identified(name: str = "flat-30") -> Identified:
    """Return the mechanics without a mesh as fitted to the converged press of a plate."""
    layered = press(name, "layered")
    assert layered is not None
    return identify(converged(name).press, layered, hertz.tissue(scenes.finger(name))[1])


def springs(name: str) -> tuple[float, float]:
    """Return b N/mm and m 1/mm of `lumped` under a plate, as identified from its press."""
    own = identified(name)
    return own.b, own.m


def _short(values: Array) -> list[float]:
    return [float(f"{value:.4g}") for value in values]


def row(name: str) -> dict[str, Any]:
    """Return the entry of one press: force of `solid` over the depth, and its uncertainty."""
    true, made = converged(name), scenes.BASE[name]
    flat = made.indenter.flat
    return {
        "angle": None if flat is None else flat.angle,
        "radius": made.indenter.ball_radius,
        "width_mm": scenes.finger(name).width,
        "thickness_mm": scenes.finger(name).thickness,
        "pad_radius_mm": scenes.finger(name).pad_radius,
        "subcutaneous_kPa": scenes.finger(name).subcutaneous.modulus,
        "depth_mm": _short(true.press.depth[true.press.at]),
        "force_N": _short(true.press.force[true.press.at]),
        "area_mm2": _short(true.press.area[true.press.at]),
        "bars": {key: _short(values) for key, values in true.bars.items()},
    }


def _of(candidate: str) -> tuple[str, ...]:
    """Return the stated errors of a candidate."""
    return STATED[:1] if candidate == "lumped" else STATED


def steps() -> dict[str, dict[str, float]]:
    """Return the changes by finer time steps in direct runs, by run."""
    rows = {}
    for run in runs.steps():
        if run.refine == 1:
            continue
        ours = motion.direct(run.name, run.mechanics, run.resolution)
        finer = motion.direct(run.name, run.mechanics, run.resolution, run.refine)
        if ours is not None and finer is not None:
            label = f"{run.mechanics}, {run.name}, steps / {run.refine}"
            rows[label] = _rounded(motion.errors(ours, finer))
    return rows


def paced(rows: dict[str, dict[str, float]]) -> dict[str, dict[str, float]]:
    """Return the errors that the time steps of a mechanics make, the largest known."""
    found = {name: dict.fromkeys(_of(name), 0.0) for name in (*NO_MESH, *WITH_MESH)}
    for label, row in rows.items():
        known = found[label.split(",")[0]]
        for quantity, error in row.items():
            known[quantity] = max(known[quantity], error)
    return found | {"condensed": found["linear"]}


def _rounded(row: dict[str, float]) -> dict[str, float]:
    return {key: float(f"{value:.4g}") for key, value in row.items()}


def answers(name: str) -> dict[str, Press]:
    """Return the press by every candidate; `lumped` with the b and m of `springs`."""
    found: dict[str, Press | None] = {each: press(name, each) for each in WITHOUT_MESH}
    for mechanics in WITH_MESH:
        for mesh in MESHES:
            found[f"{mechanics} {mesh}"] = press(name, mechanics, mesh)
    if "flat" in name:
        true = converged(name).press
        found["lumped"] = replace(true, force=law(springs(name), true.depth))
    return {key: each for key, each in found.items() if each is not None}


def costs() -> dict[str, dict[str, float]]:
    """Return CPU seconds and memory of every candidate on the press of the 30 degree plate."""
    found = {}
    names = [(mechanics, "standard") for mechanics in WITHOUT_MESH]
    names += [(mechanics, mesh) for mechanics in WITH_MESH for mesh in MESHES]
    for mechanics, mesh in names:
        arrays = runs.load(Run("press", "flat-30", mechanics, mesh))
        assert arrays is not None
        stages = {key[6:]: float(arrays[key]) for key in arrays if key.startswith("stage_")}
        cpu = float(arrays["cpu_s"])
        moving = {"solid": "steps"}.get(mechanics, "contact")
        share = cpu * stages[moving] / sum(stages.values())
        steps = float(arrays["steps"]) if mechanics == "solid" else len(arrays["time"])
        label = mechanics if mechanics in WITHOUT_MESH else f"{mechanics} {mesh}"
        found[label] = {
            "cpu_s": round(cpu, 4),
            "setup_s": round(cpu - share, 4),
            "step_s": float(f"{share / steps:.3g}"),
            "steps": steps,
            "memory_MB": round(float(arrays["memory_MB"])),
        }
    return found


def rules() -> dict[str, Any]:
    """Return all that the planner reads."""
    finger = scenes.finger("flat-30")
    measured = [finger, *(Finger.subject(name, tissue="maeno1998") for name in FINGERS)]
    shares = [float(each.skin.thickness or 0.0) / each.thickness for each in measured]
    return {
        "tissue": {
            "skin_over_subcutaneous": finger.skin.modulus / finger.subcutaneous.modulus,
            "skin_over_thickness": [min(shares), max(shares)],
            "poisson": {"skin": finger.skin.poisson, "subcutaneous": finger.subcutaneous.poisson},
        },
        "unknowns": {mesh: unknowns("flat-30", "solid", mesh) for mesh in MESHES},
        "presses": {name: row(name) for name in scenes.BASE},
        "steps": paced(steps()),
        "costs": costs(),
    }
