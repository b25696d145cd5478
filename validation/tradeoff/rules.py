"""The rules that the planner reads, derived from the presses of the trade-off.

Per press and candidate: the numerical error (of the mesh) and the model error (of what is left
out) in presses to each depth. The stated error is their sum, between the neighbors of a scene, with
a margin for what lies between the presses and one for motions.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from fefinger.validation.evidence.solid import REPORT as SOLID
from fefinger.validation.tradeoff import motion, runs, scenes
from fefinger.validation.tradeoff.errors import (
    ORDER,
    QUANTITIES,
    Converged,
    Identified,
    Press,
    converged,
    errors,
    identify,
    law,
    mesh_errors,
    press,
    spring,
    unknowns,
)
from fefinger.validation.tradeoff.runs import Run

from fefinger.mechanics import hertz
from fefinger.mechanics.evidence import tradeoff
from fefinger.mechanics.evidence.lumped_law import between
from fefinger.mechanics.evidence.press_margins import MAIN
from fefinger.mechanics.evidence.table import Measured, Table, presses_of_tradeoff, read
from fefinger.mechanics.evidence.tradeoff import STATED
from fefinger.results.candidate import Candidate
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array


MESHES = ("coarse", "standard")

WITHOUT_MESH = ("hertz", "layered")

NO_MESH = (*WITHOUT_MESH, "lumped")

WITH_MESH = ("condensed", "linear", "solid")

LIMIT = {"condensed": "linear"}
"""Whose limit of fine meshes a mechanics has, if not its own."""

FINGERS = ("d.p.", "p.w.")
"""Fingers that tell how much the model error differs; the held-out one is not among them."""

LEAST = 0.05
"""Model error from which that is stated."""

QUANTILE = 0.95
"""Share of the depths of all presses, predicted by their neighbors, that the margin covers."""


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


def candidates(name: str, true: Converged) -> dict[str, dict[str, dict[str, list[float]]]]:
    """Return numerical and model errors of every candidate in a press, by quantity."""
    found: dict[str, dict[str, dict[str, list[float]]]] = {}
    zero = dict.fromkeys(QUANTITIES, np.zeros(runs.DEPTHS))
    for mechanics in WITHOUT_MESH:
        pressed = press(name, mechanics)
        if pressed is not None:
            found[mechanics] = _listed(zero, errors(pressed, true.press))
    if name.startswith("flat"):
        own = replace(true.press, force=law(springs(name), true.press.depth))
        apart = errors(own, true.press)["force"]
        found["lumped"] = {
            "numerical": {"force": [0.0] * len(apart)},
            "model": {"force": _short(apart)},
        }
    for mechanics in WITH_MESH:
        own = converged(name, LIMIT.get(mechanics, mechanics))
        model = errors(own.press, true.press) if mechanics != "solid" else zero
        for mesh in MESHES:
            pressed = press(name, mechanics, mesh)
            if pressed is not None:
                found[f"{mechanics} {mesh}"] = _listed(mesh_errors(pressed, own), model)
        force = _FINE * np.array(found[f"{mechanics} standard"]["numerical"]["force"])
        found[f"{mechanics} fine"] = _listed({**mesh_errors(None, own), "force": force}, model)
    return found


_FINE = float((40926 / 99374) ** (ORDER / 3))
"""Error of the force on the fine mesh over that on the standard one, of order 2 in the cells."""


def _listed(numerical: dict[str, Array], model: dict[str, Array]) -> dict[str, Any]:
    return {
        "numerical": {key: _short(values) for key, values in numerical.items()},
        "model": {key: _short(values) for key, values in model.items()},
    }


def _short(values: Array) -> list[float]:
    return [float(f"{value:.4g}") for value in values]


def row(name: str) -> dict[str, Any]:
    """Return the entry of one press in the rules."""
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
        "candidates": candidates(name, true),
    }


def margins(presses: dict[str, Any], motions: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the margin added to the interpolated error of each quantity.

    between: half of the 95th percentile of what the neighbors of a press tell too little of it,
    where it has one on either side; half, because leaving a press out doubles the gap. motion: the
    largest share of its error that a press tells too little of its base scenes, by press.
    """
    names = sorted({name for each in presses.values() for name in each["candidates"]})
    others = {name: _without(presses, name) for name in presses}
    return {
        name: {
            quantity: _margins(presses, others, motions, name, quantity) for quantity in _of(name)
        }
        for name in names
    }


def _without(presses: dict[str, Any], left_out: str) -> Table:
    """Return the table of all presses but one."""
    rows = {name: row for name, row in presses.items() if name != left_out}
    return Table(presses_of_tradeoff(rows))


def _margins(
    presses: dict[str, Any],
    others: dict[str, Table],
    motions: dict[str, Any],
    candidate: str,
    quantity: str,
) -> dict[str, Any]:
    missed = [
        each
        for name, row in presses.items()
        for each in _missed(row, others[name], candidate, quantity)
    ]
    alike = candidate.replace("fine", "standard")
    moving: dict[str, float] = {}
    for each in motions.values():
        name = each["press"]
        if alike in each["carried"]:
            share = (
                each["carried"][alike][quantity] / _own(presses[name], alike, each, quantity) - 1
            )
            moving[name] = max(moving.get(name, 0.0), _margin(share))
    return {
        "between": _margin(float(np.quantile(missed, QUANTILE)) / 2 if missed else 0.0),
        "motion": moving,
    }


def _of(candidate: str) -> tuple[str, ...]:
    """Return the stated errors of a candidate."""
    return STATED[:1] if candidate == "lumped" else STATED


def directs(presses: dict[str, Any], motions: dict[str, Any]) -> dict[str, dict[str, float]]:
    """Return by what the errors of a mechanics are larger in direct runs than its press tells.

    The largest over the base scenes; on model errors, which carrying a press leaves too small. Of
    the contact area it is not stated: direct runs are on the coarse mesh, too rough for it.
    `condensed` has the model of `linear`, and errors of a mesh that does not follow the touch.
    """
    factors = {name: dict.fromkeys(_of(name), 1.0) for name in (*NO_MESH, *WITH_MESH)}
    for each in motions.values():
        for candidate, found in each["direct"].items():
            known = factors[Candidate.of(candidate).mechanics]
            for quantity in found.keys() - {"area"}:
                error = found[quantity]
                factor = error / _own(presses[each["press"]], candidate, each, quantity)
                known[quantity] = max(known[quantity], float(f"{factor:.3g}"))
    return factors | {"condensed": factors["linear"]}


def _missed(own: dict[str, Any], others: Table, candidate: str, quantity: str) -> Iterator[float]:
    """Give the error in a press less that which the other presses tell, at every depth."""
    place, forces = tradeoff.place(own["angle"], own["radius"]), tradeoff.forces(others)
    if candidate not in own["candidates"] or len(tradeoff.neighbors(forces, place)) < 2:
        return
    if candidate == "lumped":
        actual = _between(own, forces)
    else:
        actual = total(own["candidates"][candidate], quantity)
    for depth, error in zip(own["depth_mm"], actual, strict=True):
        part = depth / own["thickness_mm"]
        expected = tradeoff.interpolated(others, Candidate.of(candidate), place, part, quantity)
        if expected is not None:
            yield error - sum(expected)


def _between(own: dict[str, Any], others: dict[str, Measured]) -> Array:
    """Return the error of `lumped` at every depth of a press, with b and m from its neighbors."""
    rows = []
    for other in others.values():
        if other.conditions["angle"] is not None:
            b, m = spring(np.asarray(other.depth), other.values)
            rows.append({"angle": other.conditions["angle"], "b": b, "m": m})
    found = between(rows, own["angle"])
    assert found is not None
    depth, force = (np.array(own[key]) for key in ("depth_mm", "force_N"))
    return np.asarray(np.maximum.accumulate(np.abs(law(found, depth) - force)) / force)


def total(candidate: Mapping[str, Any], quantity: str) -> Array:
    """Return the sum (n,) of numerical and model error of a candidate in a press."""
    return np.add(candidate["numerical"][quantity], candidate["model"][quantity])


def _own(row: dict[str, Any], candidate: str, moved: dict[str, Any], quantity: str) -> float:
    """Return the error of a quantity in a press at the depth of a motion."""
    errors_ = total(row["candidates"][candidate], quantity)
    return float(np.interp(moved["depth_mm"], row["depth_mm"], errors_))


def _margin(missed: float) -> float:
    return float(f"{max(missed, 0.0):.3g}")


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


def fingers() -> dict[str, float]:
    """Return by what the model error of other fingers is larger, at the same part of the thickness.

    The largest over presses and depths at which it is above LEAST on the measured finger, of the
    force; of the rest none is known.
    """
    rows = read(SOLID)["rows"]
    found = dict.fromkeys(("hertz", "layered", "linear"), 1.0)
    for mechanics in found:
        for kind in ("flat-30", "sphere-5"):
            own = _relative(rows[f"{MAIN}/{kind}"], mechanics)
            for subject in FINGERS:
                other = _relative(rows[f"{subject}/{kind}"], mechanics)
                known = (own > LEAST) & np.isfinite(other)
                found[mechanics] = max(found[mechanics], float((other / own)[known].max()))
    found = {name: float(f"{factor:.3g}") for name, factor in found.items()}
    return found | {"condensed": found["linear"], "lumped": 1.0, "solid": 1.0}


def _relative(row: dict[str, Any], mechanics: str) -> Array:
    forces = [np.array(row["force_N"][name], float) for name in (mechanics, "solid")]
    return np.abs(forces[0] / forces[1] - 1)


def motions() -> dict[str, Any]:
    """Return the errors through the base scenes of what is stated, by candidate.

    carried: against the converged press of `solid`, carried to the motion as the candidate's is;
    direct: against `solid` run through the scene on the coarse mesh, for what shares that mesh or
    has none.
    """
    found = {}
    for name, (pressed, moved) in scenes.MOTIONS.items():
        scene, true = scenes.base(name), converged(pressed).press
        reference = motion.motion_history(true, scene)
        passed = {key: motion.motion_history(own, scene) for key, own in answers(pressed).items()}
        run, direct = motion.direct(name, "solid", "coarse"), {}
        if run is not None:
            alike = [key for key in passed if key.split()[-1] in ("coarse", *NO_MESH)]
            alike = [key for key in alike if not key.startswith("solid")]
            direct = {key: off(key, passed[key], run) for key in alike}
        found[name] = {
            "press": pressed,
            "depth_mm": moved.peak,
            "carried": {key: off(key, each, reference) for key, each in passed.items()},
            "direct": direct,
        }
    return found


def off(
    candidate: str, found: motion.MotionHistory, true: motion.MotionHistory
) -> dict[str, float]:
    """Return the errors of what a candidate gives."""
    apart = _rounded(motion.errors(found, true))
    return {quantity: apart[quantity] for quantity in _of(candidate)}


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
    presses, moved = {name: row(name) for name in scenes.BASE}, motions()
    finger = scenes.finger("flat-30")
    measured = [finger, *(Finger.subject(name, tissue="maeno1998") for name in FINGERS)]
    shares = [float(each.skin.thickness or 0.0) / each.thickness for each in measured]
    return {
        "quantities": tradeoff.MEANT,
        "tissue": {
            "skin_over_subcutaneous": finger.skin.modulus / finger.subcutaneous.modulus,
            "skin_over_thickness": [min(shares), max(shares)],
            "poisson": {"skin": finger.skin.poisson, "subcutaneous": finger.subcutaneous.poisson},
        },
        "unknowns": {mesh: unknowns("flat-30", "solid", mesh) for mesh in MESHES},
        "presses": presses,
        "motions": moved,
        "margins": margins(presses, moved),
        "directs": directs(presses, moved),
        "fingers": fingers(),
        "steps": paced(steps()),
        "costs": costs(),
    }
