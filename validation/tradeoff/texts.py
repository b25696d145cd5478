"""Texts and tables of the trade-off page: verdict on held-out scenes, stated errors, spikes."""

from typing import Any

from fefinger.validation.tradeoff.held_out import ENOUGH

from fefinger.mechanics.evidence.stated_errors import stated
from fefinger.mechanics.evidence.tradeoff import STATED
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.results.plan_text import QUANTITIES
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.text import percent


DEPTH = 1.0
"""Depth in mm of the press of the table of stated errors."""

CANDIDATES = (
    *("lumped", "hertz", "layered"),
    *(
        f"{name} {mesh}"
        for name in ("condensed", "linear", "solid")
        for mesh in ("coarse", "standard")
    ),
)


def finding(data: dict[str, Any]) -> dict[str, Any]:
    """Return sentences and tables of a report."""
    made = data.get("provenance", {})
    source = [f"Data of {made['date'][:10]}, commit {made['commit']}."] if made else []
    sentences = [*texts(data["summary"]), *source]
    return {"texts": sentences, "tables": [_stated(), _spikes(data["scenes"]), _settings(data)]}


def texts(summary: dict[str, Any]) -> list[str]:
    """Return the verdict on the held-out scenes in a few sentences."""
    picks, every = summary["stated_kept"], summary["stated_kept_by_all_candidates"]
    over = summary["stated_over_actual"]
    oracle = "; ".join(
        f"{100 * (float(factor) - 1):.0f} % too large: {100 * share:.0f} %"
        for factor, share in summary["oracle_within_1.2"].items()
        if factor != "1"
    )
    less = "; ".join(
        f"{100 * (1 - float(factor)):.0f} % smaller: {100 * share['within_1.2']:.0f} %, "
        f"{100 * share['kept']:.0f} %, {100 * share['tolerance_met']:.0f} %"
        for factor, share in summary["stated_smaller"].items()
    )
    within = f"within {ENOUGH:g} times the cost of the cheapest sufficient one"
    return [
        f"{summary['scenes']} scenes took no part in deriving the rules. The planner answers "
        f"{summary['answered']} of them on the meshes that are compared, and "
        f"{summary['on_a_mesh_that_is_not_judged']} on the fine mesh, which is not compared. It "
        f"refuses {summary['refused_although_possible']} that a candidate could have answered; no "
        "candidate can answer the rest. "
        f"{100 * summary['tolerance_met']:.0f} % of its choices meet the tolerance.",
        "The stated error is an upper bound of the actual error in this share of its choices (of "
        f"all candidates): {_shares(picks, every)}.",
        "Median ratio of stated to actual error over all candidates: "
        + ", ".join(f"{over[name]:.1f} ({QUANTITIES[name]})" for name in STATED)
        + ".",
        f"All choices together cost {summary['total_seconds_over_least']:.1f} times the least "
        f"possible. {100 * summary['within_1.2']:.0f} % of them are {within}; the target is 85 %. "
        "Reaching it would require stated errors that are almost exact: for a planner that knows "
        "all actual errors and states them too large by one factor, the share is as follows: "
        f"{oracle}. The candidates differ widely in cost, so that a margin that excludes one of "
        "them leads to a much more expensive one. Smaller margins do not reach both targets: if "
        "all stated errors of the force were smaller by one factor, the shares of choices "
        f"{within}, of stated errors that are upper bounds, and of choices within the tolerance "
        f"would be: {less}.",
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
        finger = Finger.subject("a.h.", resolution=mesh, tissue="maeno1998")
        motion = Ramp(60.0, DEPTH, corner=0.0)
        scene = Scene(finger=finger, indenter=Flat(30), motion=motion, ask=Ask(fields=False))
        estimates = [stated(Candidate.of(candidate), Situation.of(scene), name) for name in STATED]
        rows.append(
            [candidate, *("-" if each is None else percent(each.error) for each in estimates)]
        )
    caption = (
        f"Stated errors, with margins, of a press by a plate at 30 degrees to {DEPTH:g} mm. Of "
        "the force: the largest error over time, relative to the peak; otherwise the error at the "
        "peak. lumped gives the force only."
    )
    return {"caption": caption, "heading": ["candidate", *QUANTITIES.values()], "rows": rows}


def _spikes(scenes: dict[str, Any]) -> dict[str, Any]:
    """Return the table of what the mechanics do to the spikes of the base scenes."""
    rows = []
    for candidate in CANDIDATES[1:]:
        every = [row["candidates"].get(candidate, {}).get("spikes") for row in scenes.values()]
        spikes = [each for each in every if each]
        firsts = [each["first_ms"] for each in spikes if each["first_ms"] is not None]
        count = sorted(each["count"] for each in spikes)
        middle = count[len(count) // 2]
        first = f"{max(firsts):.2g} ms" if firsts else "-"
        rows.append([candidate, str(len(spikes)), percent(middle), percent(count[-1]), first])
    heading = ["candidate", "scenes", "count, median", "count, worst", "first spike, worst"]
    caption = (
        "Spikes of the four central afferents in the base scenes, compared with those of the "
        "converged solid: missing and extra spikes as a share of all, and the largest difference "
        "of a first spike. The planner states the worst value for similar scenes. Spikes depend "
        "on thresholds, so a few scenes give no bound for others."
    )
    return {"caption": caption, "heading": heading, "rows": rows}


def _settings(data: dict[str, Any]) -> dict[str, Any]:
    """Return the table of other settings: time steps, strain measures, membranes, transfer."""
    groups = {
        "time steps of direct runs: change of the force by finer steps": [
            [name, percent(row["force"]), ""] for name, row in data["time_steps"].items()
        ],
        "strain at the deepest press: difference of other measures from logarithmic strain": [
            [f"{name}, largest {row['largest_log_strain']:.2g}",
             f"Green-Lagrange {percent(row['green_lagrange'])}",
             f"small strain of linear {percent(row['small'])}"]
            for name, row in data["strain_measures"].items()
        ],
        "membrane: worst error of a spike time against Runge-Kutta at 5 us": [
            [f"{scene}: {name}", f"{row['worst_ms']:.2g} ms", f"{1e3 * row['cpu_s']:.3g} ms CPU"]
            for scene, settings in data["integrators"].items()
            for name, row in settings.items()
        ],
        "a press of solid transferred to a motion: force compared with a direct run": [
            [name, percent(row["separable"]["force"]), ""]
            for name, row in data["scenes"].items()
            if row["separable"]
        ],
    }  # fmt: skip
    rows = [row for name, group in groups.items() for row in ([name], *group)]
    return {"caption": "Other settings.", "heading": ["setting", "error", ""], "rows": rows}
