"""Scenes that the rules were not derived from: what the planner picks, and what would have done.

In the scenes of development, from which the factors of the rule come, every candidate was run. The
truth is `solid` on the coarse and the standard mesh: its force is extrapolated, with errors of
order 2 in the facets of the pad; of all else the standard mesh is taken, and what is left of its
error is added to that of a candidate.

Held-out scenes are run on the coarse mesh, and compared with `solid` there: the error of the mesh,
which candidate and reference share, is not judged anew. For the picks, what the mesh errs by in the
nearest measured presses is added in full, an upper bound.

Run as `python -m fefinger.validation.tradeoff.held_out reports [COUNT]`; 10 s of a core for each of
the held-out scenes, of which the first COUNT are run. Scenes that are in the report already are not
run again, but judged again.
"""

import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from fefinger.validation.empty_cache import only_meshes
from fefinger.validation.evidence.press_errors import curve, left_on
from fefinger.validation.provenance import save, saved
from fefinger.validation.tradeoff import scenes

from fefinger.afferents import fire
from fefinger.mechanics import get
from fefinger.mechanics.evidence.stated_errors import STATED, STRAINS, Estimate, estimate
from fefinger.mechanics.situation import Situation
from fefinger.plan import rungs
from fefinger.results.candidate import Candidate
from fefinger.results.records import Response, Rung
from fefinger.scene.ask import Ask
from fefinger.scene.finger import STANDARD
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.text import finite


REPORT = "held-out.json"

CANDIDATES = (
    *("lumped", "hertz", "layered"),
    *(
        f"{name} {mesh}"
        for name in ("condensed", "pressed", "linear", "solid")
        for mesh in ("coarse", "standard")
    ),
)
"""Candidates that are compared."""

RUN = tuple(label for label in CANDIDATES if "standard" not in label)
"""Candidates that are run in held-out scenes."""

SPIKES = ("SAI", "SAII", "FAI")
"""Types of afferents whose spikes are compared; those of FAII need time steps of their own."""

EVERYTHING = Ask(pressure=True, strain=True, spikes=SPIKES, fields=False)

STATED_ONLY = replace(EVERYTHING, spikes=())
"""What held-out scenes are asked; the error of spikes is not stated."""

ENOUGH = 1.2
"""Cost over that of the cheapest that meets the tolerance which is asked of the planner."""

AIM = 0.85
"""Share of the picks that is aimed at within ENOUGH."""

OVERSTATED = (1.0, 1.1, 1.2, 1.5, 2.0, 2.5, 3.0)
"""Factors by which an oracle states errors too large."""

SMALLER = (0.9, 0.8, 0.7, 0.6, 0.5)
"""Factors of all that is stated, to see what margins cost and what they are for."""


class Answer(NamedTuple):
    """What a candidate answers, and the CPU seconds that it took with nothing kept but meshes.

    counts: the number of spikes of each unit; None without strain, or where none are asked.
    """

    response: Response
    seconds: float
    counts: Integers | None


def answers(scene: Scene, labels: Sequence[str], ask: Ask) -> dict[str, Answer]:
    """Answers of those candidates that are able to answer."""
    answered = {}
    for label in labels:
        candidate = Candidate.of(label)
        mesh = candidate.resolution or STANDARD
        on_mesh = replace(scene, finger=replace(scene.finger, resolution=mesh), ask=ask)
        mechanics = get(candidate.mechanics)
        asked = replace(on_mesh, ask=Ask(pressure=False, strain=False, spikes=(), fields=False))
        able = on_mesh if candidate.mechanics != "lumped" else asked
        if any(each.about == "ability" for each in mechanics.refuse(Situation.of(able))):
            continue
        with suppress(InputError, ConvergenceError), only_meshes():
            started = time.process_time()
            response = mechanics.respond(able)
            seconds = time.process_time() - started
            counts = None
            if response.strain is not None and ask.spikes:
                counts = np.array([len(train) for train in fire(ask, response).times])
            answered[label] = Answer(response, seconds, counts)
    return answered


def actual(answered: Mapping[str, Answer]) -> dict[str, dict[str, float]]:
    """Return the errors of every candidate in a scene, by their answers, as fractions.

    Of the force (or depth, where the force is prescribed) the largest through time, of its peak;
    of spikes the missing and extra ones of every unit, of all; of the rest that when the force is
    largest. Empty where `solid` does not answer.
    """
    if not {"solid coarse", "solid standard"} <= answered.keys():
        return {}
    responses = {label: each.response for label, each in answered.items()}
    rough, fine = responses["solid coarse"], responses["solid standard"]
    spikes = answered["solid standard"].counts
    size = left_on("coarse", "standard")
    quantities = {name: curve(fine, name) for name in STATED}
    coarse = {name: curve(rough, name) for name in STATED}
    force = quantities["force"] + size * (quantities["force"] - coarse["force"])
    top = int(np.argmax(fine.force))
    bars = {name: size * _apart(coarse[name][top], quantities[name][top]) for name in STATED[1:]}
    types = _types(fine)
    for site, kind in enumerate(types):
        bars[kind] = size * _apart(coarse["strain"][top, site], quantities["strain"][top, site])
    rows = {}
    for label, response in responses.items():
        interpolated = np.interp(fine.time, response.time, response.force)
        row = {"force": float(np.abs(interpolated - force).max() / force.max())}
        for name in STATED[1:]:
            if response.strain is not None:
                value = curve(response, name)[_nearest(response, fine.time[top])]
                row[name] = _apart(value, quantities[name][top]) + bars[name]
        if response.strain is not None:
            sites = response.strain[_nearest(response, fine.time[top])]
            for value, true, kind in zip(sites, quantities["strain"][top], types, strict=True):
                row[kind] = _apart(value, true) + bars[kind]
        counts = answered[label].counts
        if counts is not None and spikes is not None:
            row["spikes"] = float(np.abs(counts - spikes).sum() / max(spikes.sum(), 1))
        rows[label] = {name: float(f"{value:.4g}") for name, value in row.items()}
    return rows


def differences(answered: Mapping[str, Answer]) -> dict[str, dict[str, float]]:
    """Return the errors of candidates against `solid` on the same, coarse mesh."""
    if "solid coarse" not in answered:
        return {}
    rows = actual({**answered, "solid standard": answered["solid coarse"]})
    return {label: row for label, row in rows.items() if not label.startswith("solid")}


def with_mesh(
    scene: Scene, found: Mapping[str, Mapping[str, float]]
) -> dict[str, dict[str, float]]:
    """Return the errors of all candidates, from differences on the coarse mesh.

    To each difference the error of the mesh is added, the mean in the nearest measured presses;
    on the standard mesh a candidate is taken to differ as on the coarse one.
    """
    case, rows = Situation.of(scene), {}
    part = case.depth_over_thickness
    for label in CANDIDATES:
        candidate = Candidate.of(label)
        mesh = Candidate("solid", candidate.resolution or "coarse")
        row = found.get(f"{candidate.mechanics} coarse" if candidate.resolution else label)
        if candidate.mechanics == "solid":
            row = dict.fromkeys((*STATED, *STRAINS), 0.0)
        if row is not None:
            near = {name: estimate(mesh, name, case.features, part) for name in row}
            rows[label] = {
                name: float(f"{row[name] + each.error:.4g}")
                for name, each in near.items()
                if isinstance(each, Estimate)
            }
    return rows


def _types(response: Response) -> list[str]:
    """Return the names of the strains at the end organs, by their type of afferent."""
    assert response.sites is not None
    return [f"strain {kind}" for kind in response.sites.types]


def _nearest(response: Response, instant: float) -> int:
    return int(np.argmin(np.abs(response.time - instant)))


def _apart(value: Array, true: Array) -> float:
    return float(np.linalg.norm(np.ravel(value - true)) / np.linalg.norm(np.ravel(true)))


def judge(
    scene: Scene,
    errors: dict[str, dict[str, float]],
    taken: Mapping[str, float] | None = None,
    apart: Mapping[str, Mapping[str, float]] | None = None,
) -> dict[str, Any]:
    """Return the pick, the best possible and the stated and actual errors of a scene.

    Times are the expected ones of a first answer, with nothing kept from another one; `taken` are
    the CPU seconds that the candidates took, where they were timed; `apart`: differences on the
    coarse mesh, where those alone were measured.
    """
    taken = taken or {}
    rows: dict[str, dict[str, Any]] = {}
    case = Situation.of(scene)
    with only_meshes():
        ladder = rungs(scene)
    for rung in ladder:
        name = rung.candidate.label
        if name not in errors or any(r.about == "ability" for r in rung.refusals):
            continue
        mechanics, on_mesh = get(rung.mechanics), case.on(rung.resolution or case.mesh)
        stated = {"force": rung.error, **rung.errors}
        stated |= {key: mechanics.error(on_mesh, key)[0] for key in STRAINS}
        rows[name] = {
            "seconds": float(f"{rung.seconds:.4g}"),
            "stated": {
                key: _short(stated.get(key, np.inf))
                for key in (*STATED, *STRAINS)
                if key in errors[name]
            },
            "actual": errors[name],
            "willing": not rung.refusals,
            "run": apart is None or name in apart,
            "apart": None if apart is None else apart.get(name),
        }
        if name in taken:
            rows[name]["taken"] = taken[name]
    tolerance = scene.ask.rel_error
    willing = [name for name, row in rows.items() if row["willing"]]
    pick = min(willing, key=lambda name: rows[name]["seconds"]) if willing else None
    best = cheapest(rows, tolerance)
    return {
        "motion": scene.motion.kind,
        "depth_mm": scene.motion.peak,
        "seconds": scene.motion.duration,
        "asked": [x for x in ("pressure", "strain") if getattr(scene.ask, x)],
        "tolerance": tolerance,
        "pick": pick,
        "unjudged": _planned(ladder) if pick is None else None,
        "best": best,
        "ratio": rows[pick]["seconds"] / rows[best]["seconds"] if pick and best else None,
        "taken_ratio": _taken_ratio(rows, pick, tolerance) if taken else None,
        "candidates": rows,
    }


def _taken_ratio(
    rows: Mapping[str, dict[str, Any]], pick: str | None, tolerance: float
) -> float | None:
    """Return the CPU seconds of the pick over the least of those that meet the tolerance."""
    able = [row["taken"] for row in rows.values() if _force(row) <= tolerance]
    return rows[pick]["taken"] / min(able) if pick and able else None


def _planned(ladder: Sequence[Rung]) -> str | None:
    """Return the planner's choice, which may be on the fine mesh; None where all refuse."""
    willing = [rung for rung in ladder if not rung.refusals and np.isfinite(rung.error)]
    return min(willing, key=lambda rung: rung.seconds).candidate.label if willing else None


def cheapest(rows: dict[str, dict[str, Any]], tolerance: float, by: str = "actual") -> str | None:
    """Return the cheapest candidate whose error of the force is within a tolerance."""
    able = [name for name, row in rows.items() if _force(row, by) <= tolerance]
    return min(able, key=lambda name: rows[name]["seconds"]) if able else None


def _short(value: float) -> float | None:
    return float(f"{value:.4g}") if np.isfinite(value) else None


def summary(judged: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Judge the picks: costs against the best, tolerances met, stated errors kept."""
    picked = [each for each in judged.values() if each["pick"]]
    picks = [(each, each["candidates"][each["pick"]]) for each in picked]
    ratios = np.array([each["ratio"] for each in picked if each["ratio"] is not None])
    rows = [row for each in judged.values() for row in each["candidates"].values()]
    every = [row for row in rows if row["run"]]
    pick_rows = [row for _, row in picks]
    cheap = [each["candidates"][each["best"]] for each in judged.values() if each["best"]]
    cheap = [row | {"apart": None} for row in cheap]
    total = sum(each["candidates"][each["pick"]]["seconds"] for each in picked if each["best"])
    least = sum(each["candidates"][each["best"]]["seconds"] for each in picked if each["best"])
    return {
        "scenes": len(judged),
        "answered": len(picked),
        "refused_although_possible": sum(
            1
            for each in judged.values()
            if each["best"] and not each["pick"] and not each["unjudged"]
        ),
        "on_a_mesh_that_is_not_judged": sum(1 for each in judged.values() if each["unjudged"]),
        "tolerance_met": _share(
            [row["actual"]["force"] <= each["tolerance"] for each, row in picks]
        ),
        "stated_kept": {name: _kept(pick_rows, name) for name in STATED},
        "stated_kept_by_all_candidates": {name: _kept(every, name) for name in STATED},
        "stated_kept_with_mesh": {
            name: _kept([row | {"apart": None} for row in every], name) for name in STATED
        },
        "stated_kept_of_types": {name: _kept(every, name) for name in STRAINS},
        "stated_over_actual": {name: _over(every, name) for name in (*STATED, *STRAINS)},
        "stated_over_actual_of_the_cheapest": _over(cheap, "force"),
        "within_1.2": _share(list(ratios <= ENOUGH)),
        "oracle_within_1.2": {f"{x:g}": oracle(judged, x) for x in OVERSTATED},
        "stated_smaller": {f"{x:g}": smaller(judged, x) for x in SMALLER},
        **_timed(judged),
        "median_ratio": float(np.median(ratios)),
        "worst_ratio": float(ratios.max()),
        "geometric_mean_ratio": float(np.exp(np.log(ratios).mean())),
        "total_seconds_over_least": float(total / least),
    }


def _timed(judged: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the share of cheap choices, and expected over taken times, where they were timed."""
    ratios = [each["taken_ratio"] for each in judged.values() if each.get("taken_ratio")]
    if not ratios:
        return {}
    over: dict[str, list[float]] = {}
    for each in judged.values():
        for name, row in each["candidates"].items():
            over.setdefault(name, []).append(row["seconds"] / row["taken"])
    within = [value <= ENOUGH for value in ratios]
    return {
        "within_1.2_as_taken": _share(within),
        "expected_over_taken_seconds": {
            name: _short(float(np.median(values))) for name, values in over.items()
        },
    }


def oracle(judged: dict[str, dict[str, Any]], factor: float) -> float:
    """Return the share of picks within ENOUGH if every error were stated too large by a factor.

    That is what a planner could do which knew all actual errors, but for that factor.
    """
    ratios = []
    for each in judged.values():
        rows, tolerance = each["candidates"], each["tolerance"]
        pick, best = cheapest(rows, tolerance / factor), cheapest(rows, tolerance)
        if pick and best:
            ratios.append(rows[pick]["seconds"] / rows[best]["seconds"])
    return _share([ratio <= ENOUGH for ratio in ratios])


def smaller(judged: dict[str, dict[str, Any]], factor: float) -> dict[str, float]:
    """Judge the picks if every stated error of the force were smaller by a factor.

    Shares of those within ENOUGH, of those whose error of the force is as stated, or as asked.
    """
    picks = []
    for each in judged.values():
        rows = each["candidates"]
        pick = cheapest(rows, each["tolerance"] / factor, by="stated")
        if pick and each["best"]:
            picks.append((rows[pick], rows[each["best"]], each["tolerance"]))
    return {
        "within_1.2": _share(
            [row["seconds"] <= ENOUGH * best["seconds"] for row, best, _ in picks]
        ),
        "kept": _share([_force(row) <= factor * _force(row, "stated") for row, *_ in picks]),
        "tolerance_met": _share([_force(row) <= tolerance for row, _, tolerance in picks]),
    }


def _force(row: dict[str, Any], kind: str = "actual") -> float:
    """Return the error of the force of a candidate, infinite where none is stated."""
    error = row[kind]["force"]
    return np.inf if error is None else float(error)


def _stated_and_actual(rows: list[dict[str, Any]], quantity: str) -> list[tuple[float, float]]:
    """Return stated and actual errors of a quantity, where it is stated.

    Differences on the coarse mesh where those alone were measured.
    """
    pairs = [
        (row["stated"].get(quantity), (row["apart"] or row["actual"]).get(quantity)) for row in rows
    ]
    return [(stated, actual) for stated, actual in pairs if stated is not None]


def _kept(rows: list[dict[str, Any]], quantity: str) -> float:
    return _share([actual <= stated for stated, actual in _stated_and_actual(rows, quantity)])


def _over(rows: list[dict[str, Any]], quantity: str) -> float:
    """Return the median of the stated over the actual error, nan where none is stated."""
    ratios = [stated / actual for stated, actual in _stated_and_actual(rows, quantity)]
    return float(np.median(ratios)) if ratios else float("nan")


def _share(held: list[Any]) -> float:
    return float(np.mean(held)) if held else float("nan")


def main(folder: Path, most: int = scenes.N_HELD_OUT) -> None:
    """Run what is missing, judge all, and write the report after every scene.

    most: number of held-out scenes, of the first ones that were drawn.
    """
    path = folder / REPORT
    earlier = saved(path)
    held, developed = scenes.held_out(most), scenes.development()
    errors, taken = (
        {key: earlier[what][key] for key in held | developed if key in earlier.get(what, {})}
        for what in ("errors", "taken")
    )
    report = {"errors": errors, "taken": taken}
    for key, scene in (held | developed).items():
        if key not in errors:
            if key in held:
                errors[key] = differences(answers(scene, RUN, STATED_ONLY))
            else:
                errors[key], taken[key] = measured(scene)
            print(key, flush=True)  # progress
            save(path, finite(report))
    save(path, finite(report | judgment(report)), f"reports {most}")


def measured(scene: Scene) -> tuple[dict[str, dict[str, float]], dict[str, float]]:
    """Return the errors and the CPU seconds of all candidates in a scene."""
    answered = answers(scene, CANDIDATES, EVERYTHING)
    return actual(answered), {name: float(f"{each.seconds:.3g}") for name, each in answered.items()}


def judgment(report: Mapping[str, Any]) -> dict[str, Any]:
    """Return the judged scenes that are held out, and the summaries of both sets.

    They are judged by what the planner states now.
    """
    errors, taken = report["errors"], report["taken"]
    held = {
        key: judge(scene, with_mesh(scene, errors[key]), None, errors[key])
        for key, scene in scenes.held_out().items()
        if errors.get(key)  # `solid` answers it
    }
    developed = {
        key: judge(scene, errors[key], taken[key])
        for key, scene in scenes.development().items()
        if errors.get(key)
    }
    return {"scenes": held, "summary": summary(held), "development": summary(developed)}


if __name__ == "__main__":
    main(Path(sys.argv[1]), *map(int, sys.argv[2:]))
