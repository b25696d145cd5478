"""Suite `extremes`: scenes and problems at the edges of every range, named and drawn by seed.

Each ends as an answer whose invariants hold, or as a refusal in a sentence. The value of a case is
the worst violation of an invariant over the most that is allowed, 0 for a refusal; a crash, a
warning of Python, a number that is not finite and too long a time fail.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from fefinger.validation.case import Case, Expected, Noted
from fefinger.validation.extremes import bodies, drawn, nerve, scenes, theory
from fefinger.validation.extremes.trial import ANSWERED, FAILED, REFUSED, Kind, Trial, ending
from fefinger.validation.panels import panel

from fefinger.view.figures import INK, WIDE


PARTS: tuple[Callable[[], tuple[Trial, ...]], ...] = (
    scenes.trials,
    drawn.trials,
    theory.trials,
    bodies.trials,
    nerve.trials,
)

QUICK = ("lumped", "hertz", "theory")
"""Groups whose trials take milliseconds."""

SLOW = ("cycles", "stack", "contact in and out")
"""Edges of them that take seconds."""

SOURCES = {
    "answered": "invariants, closed forms, twins; has to answer",
    "refused": "has to refuse in a sentence",
    "either": "invariants, closed forms, twins; or a refusal in a sentence",
}

EVERY = 3
"""Of the trials of QUICK, one in so many is for a quick look."""

MESHED = (
    ("linear", "time step", "a jump to 0.6 mm"),
    ("condensed", "time step", "a jump to 0.6 mm"),
    ("solid", "finite strain", "at 1e4 mm/s"),
)
"""Group, edge and name of those on a mesh, the coarse one, that a quick look takes too."""


def trials(*, quick: bool) -> tuple[Trial, ...]:
    """Return all trials; `quick` takes some of those that take milliseconds, and MESHED."""
    every = tuple(trial for part in PARTS for trial in part())
    if not quick:
        return every
    fast = [trial for trial in every if trial.group in QUICK and trial.edge not in SLOW]
    meshed = [trial for trial in every if (trial.group, trial.edge, trial.name) in MESHED]
    return (*fast[::EVERY], *meshed)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield one case per trial."""
    for trial in trials(quick=quick):
        name = f"{trial.group}, {trial.edge}: {trial.name}"
        limits = Expected(0.0, 1.0, "of the limit")
        yield Case(name, partial(_measured, trial), limits, SOURCES[trial.wants or "either"])


def _measured(trial: Trial) -> Noted:
    end = ending(trial)
    return Noted(end.worst, f"{end.kind}: {end.text}")


COLORS: dict[Kind, str] = {ANSWERED: "#009E73", REFUSED: "#56B4E9", FAILED: "#D55E00"}


@dataclass(frozen=True)
class Ended:
    """How a trial ended, as the record of its case says; worst: violation over its limit."""

    group: str
    edge: str
    kind: Kind
    worst: float
    limit: str

    @classmethod
    def of(cls, case: Mapping[str, Any]) -> "Ended":
        """Read the record of a case, named "group, edge: name"."""
        group, _, rest = case["name"].partition(", ")
        text = case["note"]
        refused = REFUSED if text.startswith(REFUSED) else ANSWERED
        kind = FAILED if case["verdict"] == "fail" else refused
        limit = text.rpartition("nearest to its limit: ")[2] if kind == ANSWERED else ""
        return cls(group, rest.partition(": ")[0], kind, case["value"] or 0.0, limit)


def finding_of(cases: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Summarize the outcomes of the trials: a sentence, and a table by mechanics."""
    done = [Ended.of(case) for case in cases]
    rows = []
    for group in dict.fromkeys(each.group for each in done):
        members = [each for each in done if each.group == group]
        kinds, worst = (
            Counter(each.kind for each in members),
            max(members, key=lambda each: each.worst),
        )
        closest = f"{100 * worst.worst:.0f} % ({worst.limit}; {worst.edge})" if worst.limit else ""
        rows.append([group, *(str(kinds[kind]) for kind in COLORS), closest])
    return {
        "texts": [_caption(done)],
        "tables": [
            {
                "caption": "Last column: largest share of a limit (invariant; parameter).",
                "heading": ["component", *COLORS, "largest share of a limit"],
                "rows": rows,
            }
        ],
    }


def figures_of(cases: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure."""
    done = [Ended.of(case) for case in cases]
    yield (
        f"{_caption(done)} Green: answered; blue: refused; red: failed. Columns: component; "
        "rows: parameter at an extreme value. Numbers: trials.",
        _table(done),
    )


def _caption(done: Sequence[Ended]) -> str:
    kinds = Counter(each.kind for each in done)
    return (
        f"Of {len(done)} trials at extreme values {kinds[ANSWERED]} are answered and satisfy all "
        f"invariants, {kinds[REFUSED]} are refused with a message, {kinds[FAILED]} failed."
    )


def _table(done: Sequence[Ended]) -> Any:
    edges = list(dict.fromkeys(each.edge for each in done))
    groups = list(dict.fromkeys(each.group for each in done))
    counts = Counter((each.edge, each.group, each.kind) for each in done)
    drawn, axis = panel(WIDE, 0.24 * len(edges) + 0.8)
    for row, edge in enumerate(edges):
        for column, group in enumerate(groups):
            cell = {kind: counts[edge, group, kind] for kind in COLORS}
            total, left = sum(cell.values()), column - 0.45
            for kind, number in cell.items():
                if number:
                    wide = 0.9 * number / total
                    axis.barh(row, wide, 0.8, left, align="center", color=COLORS[kind])
                    place = {"x": left + wide / 2, "y": row, "s": str(number)}
                    axis.text(**place, ha="center", va="center", fontsize=7, color=INK)
                    left += wide
    axis.set_xticks(np.arange(len(groups)), groups)
    axis.set_yticks(np.arange(len(edges)), edges)
    axis.set(xlim=(-0.6, len(groups) - 0.4), ylim=(len(edges) - 0.4, -0.6))
    axis.xaxis.tick_top()
    axis.grid(visible=False)
    return drawn
