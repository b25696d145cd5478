"""Derive the evidence that the planner reads of the measured reports, in one layout.

Run as `python -m fefinger.validation.evidence.derive reports`, some seconds. It joins the presses
of `press-mesh.json`, `strain-types.json` and `grid-errors.json`, what tabulation leaves out
(`pressed-error.json`), and errors under raised parts (suite `friction`); and it computes the
factors of the rule (`mechanics/evidence/stated_errors.py`) from the scenes of development in
`held-out.json`, those of the strain of each type, and of pressure and area by formulas, by leaving
presses out.
"""

import math
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.evidence import cost_table, strain_types
from fefinger.validation.evidence.grid_errors import GRID_ERRORS, PLATE
from fefinger.validation.evidence.press_mesh import MEASUREMENTS, REPORT, Measurement
from fefinger.validation.pressed.measure import TABULATION, TABULATION_SETS
from fefinger.validation.provenance import save, saved, short
from fefinger.validation.tradeoff import scenes
from numpy.typing import NDArray

from fefinger.mechanics import layered, lumped
from fefinger.mechanics.evidence import presses
from fefinger.mechanics.evidence.presses import EVIDENCE, Features, Press
from fefinger.mechanics.evidence.stated_errors import (
    LEAST,
    STATED,
    STRAINS,
    Estimate,
    estimate,
)
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.scene.textured import Dots


HELD_OUT = "held-out.json"

QUANTILE = 0.95
"""Share of the stated errors that is to hold."""

PARTS = np.geomspace(0.001, 0.3, 30)
"""Depths over the thickness at which errors of tabulation are kept."""

LIKE = 0.35
"""Difference of the logarithms of depths within which tabulation errs alike."""

RAISED = {"coarse": 0.30, "standard": 0.13, "fine": 0.08}
"""Error of the mean force on raised dots 0.7 mm wide that are scanned, by the mesh: against that
extrapolated from all three; letters and Braille have wider parts and err less
(validation/friction)."""

RAISED_ON_GRID = 0.001
"""The same error on a grid: 1.5 times as many points change the force on dots by 0.03 % at most."""

SPACING = 3.0
"""Distance in mm of the dots; it does not count."""

RAISED_PRESSES = ("a.h./flat-30", "maeno1998/flat-30")
"""Presses by a plate whose errors those of raised parts add to."""

AS_CONDENSED = ("condensed standard", "linear coarse", "linear standard")
"""Candidates whose strain by type errs as that of `condensed` on the coarse mesh."""

FORMULAS, BY_TISSUE = ("hertz", "layered"), ("pressure", "area")
"""Mechanics without a mesh, and what of theirs is judged by leaving presses out."""

Errors = dict[str, dict[str, Any]]


def joined(folder: Path) -> dict[str, Any]:
    """Return all presses by name, with their features and errors."""
    rows, typed, gridded = (
        saved(folder / name)["rows"] for name in (REPORT, strain_types.REPORT, GRID_ERRORS)
    )
    measurements = {**strain_types.MEASURED, **MEASUREMENTS}
    found = {}
    for name in (*rows, *(name for name in typed if name not in rows)):
        row = rows.get(name) or other_tissue(name, typed[name], rows)
        if "refused" in row:
            continue
        part = row.get("part") if name not in rows else None
        parts = np.array(part or np.divide(row["depth_mm"], row["thickness_mm"]))
        errors = {label: dict(each) for label, each in row["errors"].items()}
        add_types(errors, parts, typed.get(name))
        if name in gridded and not name.endswith(PLATE):
            errors[layered.name] = on_grid(parts, gridded[name])
        found[name] = record(measurements[name], parts, row["force_N"], errors)
    return found | dict(raised(found, gridded))


def record(
    measurement: Measurement, part: NDArray[np.float64], force: Any, errors: Errors
) -> dict[str, Any]:
    """Return a press as the report holds it."""
    finger = measurement.finger
    features = Features.of(finger, measurement.indenter)
    numbers = [round(each, 4) for each in features.numbers]
    return {
        "features": features._asdict() | {"numbers": numbers},
        "thickness_mm": finger.thickness,
        "subcutaneous_kPa": finger.subcutaneous.modulus,
        "part": short(part),
        "force_N": list(force),
        "errors": {
            label: {what: [_two_digits(each) for each in values] for what, values in row.items()}
            for label, row in errors.items()
        },
    }


def _two_digits(error: float | None) -> float | None:
    """Round an error; factors are far larger than what that changes."""
    known = error is not None and math.isfinite(error)
    return float(f"{error:.2g}") if known else None


def other_tissue(name: str, typed: Mapping[str, Any], rows: Mapping[str, Any]) -> dict[str, Any]:
    """Return a press that was compared on the coarse mesh alone.

    Its errors on a mesh are those of small strain and, in quadrature, of the mesh under the same
    object on published tissue.
    """
    object_ = name.partition("/")[2]
    like = rows.get(f"maeno1998/{object_}") or rows[f"a.h./{object_}"]
    part = np.divide(like["depth_mm"], like["thickness_mm"])
    errors: Errors = {
        label: dict(typed["errors"][label])
        for label in ("hertz", "layered")
        if label in typed["errors"]
    }
    for label in ("condensed coarse", *AS_CONDENSED):
        mesh = like["errors"][f"solid {label.split()[1]}"]
        errors[label] = {
            what: short(
                np.hypot(
                    typed["errors"]["condensed coarse"][what],
                    np.interp(typed["part"], part, np.array(mesh[what], dtype=float)),
                ),
                3,
            )
            for what in STATED
        }
    return {"part": typed["part"], "force_N": typed["force_N"], "errors": errors}


def add_types(errors: Errors, part: NDArray[np.float64], typed: Any) -> None:
    """Add errors of the strain of each type, where it was measured, at the depths of a press."""
    if typed is None:
        return
    by_label = dict(typed["errors"])
    by_label |= dict.fromkeys(AS_CONDENSED, by_label["condensed coarse"])
    if "solid standard" in by_label:
        by_label["solid fine"] = by_label["solid standard"]
    for label, row in by_label.items():
        for what in STRAINS:
            values = np.interp(part, typed["part"], row[what], left=np.nan, right=np.nan)
            if label in errors and np.isfinite(values).any():
                errors[label][what] = values


def on_grid(part: NDArray[np.float64], row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the errors of `layered` on a grid at the depths of a press."""
    return {
        what: np.interp(part, row["part"], each, left=np.nan, right=np.nan)
        for what, each in row["errors"].items()
    }


def tabulation(report: Mapping[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Return logarithms of depth over thickness and error (n, 2) of tabulation, by quantity.

    Of the force the larger one of loading and retreat.
    """
    pairs: dict[str, list[tuple[float, float]]] = {}
    for row in (row for draw in TABULATION_SETS for row in report[draw].values()):
        if "refused" in row:
            continue
        errors = {what: row["peak"][what] for what in ("pressure", "area", "strain")}
        forces = [row[each]["force"] for each in ("loading", "retreat") if "force" in row[each]]
        errors |= {"force": max(forces)} if forces else {}
        for what, error in errors.items():
            pairs.setdefault(what, []).append((math.log(row["part"]), math.log(max(error, LEAST))))
    return {what: np.array(each) for what, each in pairs.items()}


def tabulated_at(pairs: NDArray[np.float64], part: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean error (n,) of tabulation at depths over the thickness (n,)."""
    apart = (pairs[:, 0] - np.log(part)[:, None]) / LIKE
    weights = np.exp(-0.5 * (apart**2 - (apart**2).min(axis=1, keepdims=True)))
    return np.asarray(np.exp(weights @ pairs[:, 1] / weights.sum(axis=1)))


def tabulation_errors(pairs: Mapping[str, NDArray[np.float64]]) -> dict[str, list[float]]:
    """Return the mean errors of tabulation by quantity, over PARTS."""
    means = {what: short(tabulated_at(each, PARTS), 3) for what, each in pairs.items()}
    return {"part": short(PARTS)} | means


def raised(found: Mapping[str, Any], gridded: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield the errors under raised dots: of the mesh under them, and those under a plate."""
    for name in RAISED_PRESSES:
        plate, (owner, _, _) = found[name], name.partition("/")
        errors = {
            f"{mechanics} {mesh}": {
                "force": short(
                    np.array(plate["errors"][f"{mechanics} {measured}"]["force"]) + error, 3
                )
            }
            for mechanics in ("condensed", "linear", "solid")
            for mesh, error in RAISED.items()
            for measured in [mesh if MECHANICS[mechanics].finite or mesh != "fine" else "standard"]
        }
        on_plate = on_grid(np.array(plate["part"]), gridded[name])["force"]
        errors[layered.name] = {"force": short(on_plate + RAISED_ON_GRID, 3)}
        dots = replace(MEASUREMENTS[name], indenter=Dots(SPACING))
        yield f"{owner}/dots", record(dots, np.array(plate["part"]), plate["force_N"], errors)


def group(mechanics: str) -> str:
    """Return the mechanics whose factors one has: `condensed` and `linear` share theirs."""
    return {"linear": "condensed"}.get(mechanics, mechanics)


def factors(folder: Path) -> dict[str, dict[str, float]]:
    """Return the factor on the estimate of every mechanics and quantity."""
    residuals: dict[tuple[str, str], list[tuple[str, float]]] = {}
    for (candidate, quantity), scene, value in (*of_scenes(folder), *of_presses()):
        residuals.setdefault((group(candidate.mechanics), quantity), []).append((scene, value))
    table: dict[str, dict[str, float]] = {}
    for name in MECHANICS:
        for (mechanics, quantity), pairs in residuals.items():
            if mechanics == group(name):
                table.setdefault(name, {})[quantity] = float(f"{quantile(pairs):.3g}")
    return table


def quantile(pairs: list[tuple[str, float]]) -> float:
    """Return the quantile of actual over estimated errors, for one scene more than there are.

    pairs: scene and logarithm.
    """
    count = len({scene for scene, _ in pairs})
    level = min(QUANTILE * (count + 1) / count, 1.0)
    return float(np.exp(np.quantile([value for _, value in pairs], level)))


Residual = tuple[tuple[Candidate, str], str, float]
"""Candidate and quantity, the scene, and the logarithm of the actual error over the estimate."""


def of_scenes(folder: Path) -> Iterator[Residual]:
    """Yield the residuals of the scenes of development, of what was measured in them."""
    errors = saved(folder / HELD_OUT)["errors"]
    for key, scene in scenes.development().items():
        case = Situation.of(scene)
        for label, row in errors[key].items():
            candidate = Candidate.of(label)
            for quantity in (each for each in STATED if each in row):
                found = estimate(candidate, quantity, case.features, case.depth_over_thickness)
                if isinstance(found, Estimate) and judged(candidate, case):
                    ratio = max(row[quantity], LEAST) / found.error
                    yield (candidate, quantity), key, math.log(ratio)


def judged(candidate: Candidate, case: Situation) -> bool:
    """Whether a mechanics states an error there: `lumped` where it has the law of the finger."""
    return candidate.mechanics != "lumped" or (
        case.indenter.flat is not None and not lumped.law(case).caveat
    )


def of_presses() -> Iterator[Residual]:
    """Yield the residuals in every press, from all other presses.

    Of the strain of each type; of formulas also of pressure and area, which scatter with the tissue
    more than the few scenes of development show.
    """
    for press in presses.presses():
        for label, row in press.errors.items():
            wanted = (*STRAINS, *BY_TISSUE) if label in FORMULAS else STRAINS
            for quantity in (each for each in wanted if each in row):
                yield from _left_out(press, Candidate.of(label), quantity)


def _left_out(press: Press, candidate: Candidate, quantity: str) -> Iterator[Residual]:
    for part, error in zip(press.part, press.errors[candidate.label][quantity], strict=True):
        found = estimate(candidate, quantity, press.features, part, press.name)
        if isinstance(found, Estimate) and math.isfinite(error):
            ratio = max(error, LEAST) / found.error
            where = f"{candidate.label}: {press.name} at {part:g}"
            yield (candidate, quantity), where, math.log(ratio)


def on_retreat(report: Mapping[str, Any]) -> dict[str, float]:
    """Return the quantile of the errors of tabulation on retreat, of strain and area."""
    rows = [row.get("retreat", {}) for draw in TABULATION_SETS for row in report[draw].values()]
    errors = {what: [row[what] for row in rows if what in row] for what in ("strain", "area")}
    return {what: float(f"{np.quantile(x, QUANTILE):.3g}") for what, x in errors.items()}


def main(folder: Path) -> None:
    """Write the presses, then the factors that the rule needs with them."""
    path = folder / EVIDENCE
    report: dict[str, Any] = {
        "presses": joined(folder),
        "tabulation": tabulation_errors(tabulation(saved(folder / TABULATION))),
        "on retreat": on_retreat(saved(folder / TABULATION)),
        "costs": cost_table.coefficients(folder),
    }
    save(path, report | {"factors": {}})
    presses.read.cache_clear()
    presses.presses.cache_clear()
    presses.nearest.cache_clear()
    save(path, report | {"factors": factors(folder)})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
