"""Table and figure of suite `extremes`: outcomes of the trials by component and parameter."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from fefinger.validation.extremes.trial import ANSWERED, FAILED, REFUSED, Kind
from fefinger.validation.panels import panel

from fefinger.view.figures import INK, WIDE


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


def finding(cases: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
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


def figures(cases: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, Any]]:
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
