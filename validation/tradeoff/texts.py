"""Texts and tables of the trade-off page: verdict on held-out scenes, and stated errors."""

import math
from typing import Any

from fefinger.validation.tradeoff.held_out import AIM, CANDIDATES, ENOUGH

from fefinger.mechanics import get
from fefinger.mechanics.evidence.stated_errors import STATED
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.results.result_record import QUANTITIES
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.text import percent


DEPTH = 1.0
"""Depth in mm of the press of the table of stated errors."""


def finding(data: dict[str, Any]) -> dict[str, Any]:
    """Return sentences and tables of a report."""
    sentences = [*texts(data["summary"]), *_developed(data["development"])]
    tables = [_margins(data["summary"]), *_times(data["summary"]), _stated()]
    return {"texts": sentences, "tables": tables}


def texts(summary: dict[str, Any]) -> list[str]:
    """Return the verdict on the held-out scenes in a few sentences."""
    picks, every = summary["stated_kept"], summary["stated_kept_by_all_candidates"]
    over = summary["stated_over_actual"]
    within = f"within {ENOUGH:g} times the cost of the cheapest sufficient one"
    return [
        f"{summary['scenes']} scenes took no part in deriving the rules. The planner answers "
        f"{summary['answered']} of them on the meshes that are compared, and "
        f"{summary['on_a_mesh_that_is_not_judged']} on the fine mesh, which is not compared. It "
        f"refuses {summary['refused_although_possible']} that a candidate could have answered. "
        f"{100 * summary['tolerance_met']:.0f} % of its choices meet the tolerance.",
        "The stated error is an upper bound of the actual error in this share of its choices (of "
        f"all candidates): {_shares(picks, every)}.",
        "Median ratio of stated to actual error over all candidates: "
        + ", ".join(f"{over[name]:.1f} ({QUANTITIES[name]})" for name in STATED)
        + ".",
        f"All choices together cost {summary['total_seconds_over_least']:.1f} times the least "
        f"possible. {100 * summary['within_1.2']:.0f} % of them are {within}; the target is "
        f"{100 * AIM:.0f} %.{_taken(summary)} It asks for stated errors that are almost "
        "exact (first table), as the candidates differ widely in cost, so that a margin that "
        "excludes one of them leads to a much more expensive one.",
    ]


def _developed(summary: dict[str, Any]) -> list[str]:
    picks, every = summary["stated_kept"], summary["stated_kept_by_all_candidates"]
    return [
        f"On the {summary['scenes']} scenes of development, which were held out until the present "
        f"rules were tried on them, {100 * summary['within_1.2']:.0f} % of the choices are within "
        f"{ENOUGH:g} times the least cost, all together cost "
        f"{summary['total_seconds_over_least']:.1f} times the least, "
        f"{100 * summary['tolerance_met']:.0f} % meet the tolerance, and stated errors are upper "
        f"bounds in {_shares(picks, every)}."
    ]


def _taken(summary: dict[str, Any]) -> str:
    """Sentence on the choices that were cheap by the CPU seconds of the runs, if timed."""
    if "within_1.2_as_taken" not in summary:
        return ""
    share = 100 * summary["within_1.2_as_taken"]
    return f" By the CPU seconds that the runs took, {share:.0f} % are."


def _margins(summary: dict[str, Any]) -> dict[str, Any]:
    """Table of what other stated errors would do to the choices."""
    exact = [
        [f"{100 * (float(factor) - 1):.0f} % too large", f"{100 * share:.0f} %", "-", "-"]
        for factor, share in summary["oracle_within_1.2"].items()
        if factor != "1"
    ]
    less = [
        [
            f"{100 * (1 - float(factor)):.0f} % smaller",
            *(f"{100 * share[key]:.0f} %" for key in ("within_1.2", "kept", "tolerance_met")),
        ]
        for factor, share in summary["stated_smaller"].items()
    ]
    return {
        "caption": (
            f"Shares of the choices at most {ENOUGH:g} times the least cost, of stated errors "
            "that are upper bounds, and of choices within the tolerance, if stated errors were "
            "others."
        ),
        "heading": [
            "stated errors",
            f"at most {ENOUGH:g} times the least cost",
            "upper bounds",
            "within tolerance",
        ],
        "rows": [
            ["the actual ones, all by one factor"],
            *exact,
            ["those of the force as stated, all by one factor"],
            *less,
        ],
    }


def _times(summary: dict[str, Any]) -> list[dict[str, Any]]:
    """Table of the expected times over the CPU seconds of the runs, where they were timed."""
    if "expected_over_taken_seconds" not in summary:
        return []
    ratios = summary["expected_over_taken_seconds"]
    return [
        {
            "caption": "Expected time over the CPU seconds that a run took, in the median.",
            "heading": ["candidate", "expected / taken"],
            "rows": [[name, f"{ratio:.2g}"] for name, ratio in ratios.items()],
        }
    ]


def _shares(picks: dict[str, float], every: dict[str, float]) -> str:
    return ", ".join(
        f"{QUANTITIES[name]} {100 * picks[name]:.0f} % ({100 * every[name]:.0f} %)"
        for name in STATED
    )


def _stated() -> dict[str, Any]:
    """Return the table of errors stated under the plate at 30 degrees."""
    rows = []
    for candidate in CANDIDATES:
        mesh = Candidate.of(candidate).resolution or "standard"
        finger = Finger.subject("a.h.", resolution=mesh)
        motion = Ramp(60.0, DEPTH, corner=0.0)
        scene = Scene(finger=finger, indenter=Flat(30), motion=motion, ask=Ask(fields=False))
        case, mechanics = Situation.of(scene), get(Candidate.of(candidate).mechanics)
        estimates = [mechanics.error(case, name)[0] for name in STATED]
        rows.append(
            [candidate, *("-" if math.isnan(each) else percent(each) for each in estimates)]
        )
    caption = (
        f"Stated errors, with margins, of a press by a plate at 30 degrees to {DEPTH:g} mm on a.h. "
        "Of the force: the largest error over time, relative to the peak; otherwise the error at "
        "the peak. lumped gives the force only."
    )
    return {"caption": caption, "heading": ["candidate", *QUANTITIES.values()], "rows": rows}
