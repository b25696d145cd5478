"""Figure of suite `extremes`: how many trials ended how, by who answers and by edge."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from fefinger.validation.extremes_trial import ANSWERED, FAILED, REFUSED, Trial, ended, ending

from fefinger.figures import INK, WIDE, figure, style


COLORS = {ANSWERED: "#009E73", REFUSED: "#56B4E9", FAILED: "#D55E00"}


def figures(trials: Sequence[Trial]) -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure on those trials that have run."""
    done = [trial for trial in trials if ended(trial)]
    if not done:
        return
    with style():
        kinds = Counter(ending(trial).kind for trial in done)
        yield _caption(len(done), kinds), _table(done)


def _caption(count: int, kinds: Counter[Any]) -> str:
    return (
        f"{count} trials at the edges by who answers and by what is extreme: {kinds[ANSWERED]} "
        f"answered with every invariant kept (green), {kinds[REFUSED]} refused in a sentence "
        f"(blue), {kinds[FAILED]} failed (red). The numbers in a cell are those of its trials."
    )


def _table(done: Sequence[Trial]) -> Any:
    edges = list(dict.fromkeys(trial.edge for trial in done))
    groups = list(dict.fromkeys(trial.group for trial in done))
    counts = Counter((trial.edge, trial.group, ending(trial).kind) for trial in done)
    drawn = figure(WIDE, 0.24 * len(edges) + 0.8)
    axis = drawn.subplots()
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
