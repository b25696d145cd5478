"""What the trade-off says: the verdict in sentences, and tables of what is stated and of spikes."""

from typing import Any

from fefinger.validation.tradeoff.held_out import ENOUGH

from fefinger.mechanics.evidence.stated_errors import stated
from fefinger.mechanics.evidence.tradeoff import STATED
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.results.plan_text import SAID
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Flat
from fefinger.scene.motion import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.text import percent


DEPTH = 1.0
"""Depth in mm of the press of which stated errors are shown."""

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
    read = (
        [f"Read from the report of {made['date'][:10]}, commit {made['commit']}."] if made else []
    )
    said = [*texts(data["summary"]), again(data["drawn_again"]), *read]
    return {"texts": said, "tables": [_stated(), _spikes(data["scenes"]), _settings(data)]}


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
        f"{100 * (1 - float(factor)):.0f} % smaller: {100 * share['within_1.2']:.0f} % within, "
        f"{100 * share['kept']:.0f} % kept, {100 * share['tolerance_met']:.0f} % within tolerance"
        for factor, share in summary["stated_smaller"].items()
    )
    return [
        f"Of {summary['scenes']} scenes that no rule was derived from the planner answers "
        f"{summary['answered']} on the meshes that are judged and "
        f"{summary['on_a_mesh_that_is_not_judged']} on the fine one, which is not; it refuses "
        f"{summary['refused_although_possible']} that a candidate would have answered as asked. "
        f"The rest none can. The tolerance is met by "
        f"{100 * summary['tolerance_met']:.0f} % of its picks.",
        "Stated errors are kept by this share of its picks (of all candidates): "
        f"{_shares(picks, every)}.",
        "They are too large by a factor of "
        + ", ".join(f"{over[name]:.1f} ({SAID[name]})" for name in STATED)
        + ", in the median of all candidates.",
        f"So the picks cost {summary['total_seconds_over_least']:.1f} times what they must, taken "
        f"together: {100 * summary['within_1.2']:.0f} % are within "
        f"{ENOUGH:g} times the cheapest that meets the tolerance, where 95 % are wanted. That asks "
        "for errors known almost exactly. An oracle that knows every actual error, and states "
        f"each too large by one factor, has picks within {ENOUGH:g} times as follows, {oracle}. "
        "The ways to an answer are far apart in cost, and a margin that excludes one leaves the "
        "next. Nor would smaller margins reach both aims: with all stated errors of the force by "
        f"one factor smaller there would be, {less}.",
    ]


def again(summary: dict[str, Any]) -> str:
    """Summarize the results on newly drawn scenes."""
    return (
        "The rules were changed after looks at these scenes (rules_read in the data). Of as many "
        "drawn anew on the same presses, not looked at before, the picks meet the tolerance in "
        f"{100 * summary['tolerance_met']:.0f} %, keep what they state (of all candidates) in "
        f"{_shares(summary['stated_kept'], summary['stated_kept_by_all_candidates'])}, and are "
        f"within {ENOUGH:g} times in {100 * summary['within_1.2']:.0f} %."
    )


def _shares(picks: dict[str, float], every: dict[str, float]) -> str:
    return ", ".join(
        f"{SAID[name]} {100 * picks[name]:.0f} % ({100 * every[name]:.0f} %)" for name in STATED
    )


def _stated() -> dict[str, Any]:
    """Return the table of what is stated under the 30 degree plate."""
    rows = []
    for candidate in CANDIDATES:
        mesh = Candidate.of(candidate).resolution or "standard"
        finger = Finger.subject("a.h.", resolution=mesh)
        motion = Ramp(60.0, DEPTH, corner=0.0)
        scene = Scene(finger=finger, indenter=Flat(30), motion=motion, ask=Ask(fields=False))
        estimates = [stated(Candidate.of(candidate), Situation.of(scene), name) for name in STATED]
        rows.append(
            [candidate, *("-" if each is None else percent(each.error) for each in estimates)]
        )
    caption = (
        f"Stated errors of a press by a plate at 30 degrees, {DEPTH:g} mm deep, with margins: "
        "of the force the largest through time, of its peak; of the rest that at the peak. lumped "
        "gives the force alone."
    )
    return {"caption": caption, "heading": ["candidate", *SAID.values()], "rows": rows}


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
        "Spikes of the four central afferents in the base scenes, against those of converged "
        "solid: missing and extra spikes of all, and the largest difference of a first spike. The "
        "planner tells the worst, as of scenes like these: spikes are thresholds, and what was "
        "found in few scenes is no bound for others."
    )
    return {"caption": caption, "heading": heading, "rows": rows}


def _settings(data: dict[str, Any]) -> dict[str, Any]:
    """Return the table of other settings: time steps, strain measures, membranes, carrying."""
    groups = {
        "time steps of direct runs: what finer ones change of the force": [
            [name, percent(row["force"]), ""] for name, row in data["time_steps"].items()
        ],
        "strain at the deepest press: other measures than the logarithmic one": [
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
        "a press of solid carried to a motion: the force against a direct run": [
            [name, percent(row["separable"]["force"]), ""]
            for name, row in data["scenes"].items()
            if row["separable"]
        ],
    }  # fmt: skip
    rows = [row for name, group in groups.items() for row in ([name], *group)]
    return {"caption": "Other settings.", "heading": ["setting", "error", ""], "rows": rows}
