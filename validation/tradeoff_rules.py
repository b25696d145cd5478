"""The rules that the planner reads, derived from the presses of the trade-off.

Per press and candidate: the numerical error (of the mesh) and the model error (of what is left
out) in presses to each depth. The stated error is their sum, times a margin for what lies between
the presses, which comes from predicting each press by its neighbors.
"""

from typing import Any

import numpy as np
from fefinger.validation import tradeoff_runs as runs
from fefinger.validation import tradeoff_scenes as scenes
from fefinger.validation.evidence import ORDER
from fefinger.validation.tradeoff_errors import (
    QUANTITIES,
    Converged,
    Identified,
    Press,
    converged,
    errors,
    identify,
    law,
    press,
    unknowns,
)
from fefinger.validation.tradeoff_runs import Run
from numpy.typing import NDArray

from fefinger.mechanics import _tradeoff, hertz


Array = NDArray[np.float64]

MESHES = ("coarse", "standard")

WITHOUT_MESH = ("hertz", "layered")

WITH_MESH = ("condensed", "linear", "solid")

QUANTILE = 0.95
"""Share of the depths of all presses, predicted by their neighbors, that the margin covers."""


def identified(name: str = "flat-30") -> Identified:
    """Return the mechanics without a mesh as fitted to the converged press of a plate."""
    layered = press(name, "layered")
    assert layered is not None
    return identify(converged(name).press, layered, hertz.tissue(scenes.finger(name))[1])


def candidates(name: str, true: Converged) -> dict[str, dict[str, dict[str, list[float]]]]:
    """Return numerical and model errors of every candidate in a press, by quantity."""
    found: dict[str, dict[str, dict[str, list[float]]]] = {}
    zero = dict.fromkeys(QUANTITIES, np.zeros(runs.DEPTHS))
    for mechanics in WITHOUT_MESH:
        pressed = press(name, mechanics)
        if pressed is not None:
            found[mechanics] = _listed(zero, errors(pressed, true.press))
    if name.startswith("flat"):
        force = law(identified(), true.press.depth)
        apart = np.maximum.accumulate(np.abs(force - true.press.force)) / true.press.force
        found["lumped"] = {
            "numerical": {"force": [0.0] * len(apart)},
            "model": {"force": _short(apart)},
        }
    for mechanics in WITH_MESH:
        own = converged(name, mechanics)
        model = errors(own.press, true.press) if mechanics != "solid" else zero
        for mesh in MESHES:
            pressed = press(name, mechanics, mesh)
            if pressed is not None:
                found[f"{mechanics} {mesh}"] = _listed(errors(pressed, own.press), model)
        standard = found[f"{mechanics} standard"]["numerical"]
        shrunk = {key: np.array(values) * _FINE for key, values in standard.items()}
        found[f"{mechanics} fine"] = _listed(shrunk, model)
    return found


_FINE = float((40926 / 99374) ** (ORDER / 3))
"""Error of the fine mesh over that of the standard one, of order 2 in the cell length."""


def _listed(numerical: dict[str, Array], model: dict[str, Array]) -> dict[str, Any]:
    return {
        "numerical": {key: _short(values) for key, values in numerical.items()},
        "model": {key: _short(values) for key, values in model.items()},
    }


def _short(values: Array) -> list[float]:
    return [float(f"{value:.4g}") for value in values]


def row(name: str) -> dict[str, Any]:
    """Return what the rules hold of one press."""
    true, made = converged(name), scenes.PRESSES[name]
    kind = {"angle": getattr(made.indenter, "angle", None)}
    return {
        **kind,
        "radius": getattr(made.indenter, "radius", None),
        "thickness_mm": scenes.finger(name).thickness,
        "subcutaneous_kPa": scenes.finger(name).subcutaneous.modulus,
        "depth_mm": _short(true.press.depth),
        "force_N": _short(true.press.force),
        "area_mm2": _short(true.press.area),
        "bars": {key: _short(values) for key, values in true.bars.items()},
        "candidates": candidates(name, true),
    }


def margins(presses: dict[str, Any]) -> dict[str, float]:
    """Return the margin of every candidate: by what its neighbors predict a press too well."""
    found: dict[str, float] = {}
    for candidate in sorted({name for each in presses.values() for name in each["candidates"]}):
        ratios: list[float] = []
        for name, each in presses.items():
            others = {key: value for key, value in presses.items() if key != name}
            if candidate not in each["candidates"]:
                continue
            actual = _tradeoff.total(each["candidates"][candidate], "force")
            for depth, error in zip(each["depth_mm"], actual, strict=True):
                part = depth / each["thickness_mm"]
                place = _tradeoff.place(each["angle"], each["radius"])
                guess = _tradeoff.predicted(others, candidate, place, part)
                if guess is not None:
                    ratios.append(error / max(guess, 1e-9))
        margin = float(np.quantile(ratios, QUANTILE)) if ratios else 1.0
        found[candidate] = float(f"{max(margin, 1.0):.3g}")
    return found


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
    presses = {name: row(name) for name in scenes.BASE}
    finger = scenes.finger("flat-30")
    return {
        "quantities": {"force": "of the force there", "pressure": "L2 of taxels of 1 mm"},
        "tissue": {
            "skin_over_subcutaneous": finger.skin.modulus / finger.subcutaneous.modulus,
            "poisson": {"skin": finger.skin.poisson, "subcutaneous": finger.subcutaneous.poisson},
        },
        "unknowns": {mesh: unknowns("flat-30", "solid", mesh) for mesh in MESHES},
        "presses": presses,
        "margins": margins(presses),
        "costs": costs(),
    }


def scale(pressed: Press, factor: float) -> Press:
    """Return a press of a body that is stiffer by a factor."""
    return pressed.scaled(factor)
