"""Scenes that the rules were not derived from: what the planner picks, and what would have done.

The truth is the converged press of the scene's object, carried to its motion; so are the answers
of the candidates, to whose error that of their time steps is added, of which carrying has none.
Presses are shared: the scenes differ in depth, speed, motion, tolerance and in what is asked.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from fefinger.validation.tradeoff import motion, scenes
from fefinger.validation.tradeoff.errors import Press, converged
from fefinger.validation.tradeoff.rules import answers, off

from fefinger.mechanics.evidence.table import TRADEOFF, read
from fefinger.mechanics.evidence.tradeoff import STATED
from fefinger.plan import rungs
from fefinger.results.records import Rung
from fefinger.scene.scene import Scene


ENOUGH = 1.2
"""Cost over that of the cheapest that meets the tolerance which is asked of the planner."""

KEPT = 0.95
"""Share of the scenes in which the stated error is to hold."""

OVERSTATED = (1.0, 1.1, 1.2, 1.5, 2.0, 2.5, 3.0)
"""Factors by which an oracle states errors too large."""

SMALLER = (0.9, 0.8, 0.7, 0.6, 0.5)
"""Factors of all that is stated, to see what margins cost and what they are for."""


def judge(scene: Scene, found: dict[str, Press], true: Press) -> dict[str, Any]:
    """Return the pick, the best possible and the stated and actual errors of a scene."""
    reference = motion.motion_history(true, scene)
    rows: dict[str, dict[str, Any]] = {}
    ladder = rungs(scene)
    for rung in ladder:
        name = rung.candidate.label
        if name not in found or any(r.about == "ability" for r in rung.refusals):
            continue
        actual = off(name, motion.motion_history(found[name], scene), reference)
        paced = read(TRADEOFF)["rules"]["steps"][rung.mechanics]
        known = {"force": rung.error, **rung.errors}
        rows[name] = {
            "seconds": float(f"{rung.seconds:.4g}"),
            "stated": {key: _short(known.get(key, np.inf)) for key in actual},
            "actual": {key: _short(each + paced[key]) for key, each in actual.items()},
            "willing": not rung.refusals,
        }
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
        "unjudged": _unjudged(ladder) if pick is None else None,
        "best": best,
        "ratio": rows[pick]["seconds"] / rows[best]["seconds"] if pick and best else None,
        "candidates": rows,
    }


def _unjudged(ladder: Sequence[Rung]) -> str | None:
    """Return the planner's choice where no judged candidate answers: a fine mesh, or none."""
    willing = [rung for rung in ladder if not rung.refusals and np.isfinite(rung.error)]
    return min(willing, key=lambda rung: rung.seconds).candidate.label if willing else None


def cheapest(rows: dict[str, dict[str, Any]], tolerance: float, by: str = "actual") -> str | None:
    """Return the cheapest candidate whose error of the force is within a tolerance."""
    able = [name for name, row in rows.items() if _force(row, by) <= tolerance]
    return min(able, key=lambda name: rows[name]["seconds"]) if able else None


def _short(value: float) -> float | None:
    return float(f"{value:.4g}") if np.isfinite(value) else None


def all_scenes(seed: int = scenes.SEED) -> dict[str, dict[str, Any]]:
    """Return the judgment of every held-out scene, of one draw."""
    truths = {name: converged(name).press for name in scenes.HELD_OUT}
    found = {name: answers(name) for name in scenes.HELD_OUT}
    return {
        key: judge(scene, found[key[3:]], truths[key[3:]])
        for key, scene in scenes.held_out(seed=seed).items()
    }


def summary(judged: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Judge the picks: costs against the best, tolerances met, stated errors kept."""
    picked = [each for each in judged.values() if each["pick"]]
    picks = [(each, each["candidates"][each["pick"]]) for each in picked]
    ratios = np.array([each["ratio"] for each in picked if each["ratio"] is not None])
    every = [row for each in judged.values() for row in each["candidates"].values()]
    own = [row for _, row in picks]
    cheap = [each["candidates"][each["best"]] for each in judged.values() if each["best"]]
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
        "stated_kept": {name: _kept(own, name) for name in STATED},
        "stated_kept_by_all_candidates": {name: _kept(every, name) for name in STATED},
        "stated_over_actual": {name: _over(every, name) for name in STATED},
        "stated_over_actual_of_the_cheapest": _over(cheap, "force"),
        "within_1.2": _share(list(ratios <= ENOUGH)),
        "oracle_within_1.2": {f"{x:g}": oracle(judged, x) for x in OVERSTATED},
        "stated_smaller": {f"{x:g}": smaller(judged, x) for x in SMALLER},
        "median_ratio": float(np.median(ratios)),
        "worst_ratio": float(ratios.max()),
        "geometric_mean_ratio": float(np.exp(np.log(ratios).mean())),
        "total_seconds_over_least": float(total / least),
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
    """Return stated and actual errors of a quantity, where it is stated."""
    pairs = [(row["stated"].get(quantity), row["actual"].get(quantity)) for row in rows]
    return [(stated, actual) for stated, actual in pairs if stated is not None]


def _kept(rows: list[dict[str, Any]], quantity: str) -> float:
    return _share([actual <= stated for stated, actual in _stated_and_actual(rows, quantity)])


def _over(rows: list[dict[str, Any]], quantity: str) -> float:
    """Return the median of the stated over the actual error, nan where none is stated."""
    ratios = [stated / actual for stated, actual in _stated_and_actual(rows, quantity)]
    return float(np.median(ratios)) if ratios else float("nan")


def _share(held: list[Any]) -> float:
    return float(np.mean(held)) if held else float("nan")
