"""Page on whether deviations of a calibration cover: ranks of the truth, by parameter."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.panels import panels
from scipy.special import ndtr
from scipy.stats import binom

from fefinger.calibration.record import LIMIT
from fefinger.pages import page
from fefinger.support.arrays import Array
from fefinger.view import figures


BINS = 10
WANTED = (0.9, 0.99)
"""Part of the 95 % intervals that should hold the truth."""

GROUPS = {
    False: "Fingers by the law that is fitted, with the error of its mesh",
    True: "Fingers by solid, whose stress relaxes in every element",
}

RANKS = (
    "Part of each stated distribution below the truth, in tenths: level, and within the band that "
    "holds 95 % of counts of a uniform distribution, where deviations are right; a hill in the "
    "middle where they are too wide, hills at the ends where they are too narrow, a slope where "
    "the parameter is off to one side. Scores: fit less truth, over the stated deviation; of right "
    "ones the mean is 0 and the spread 1."
)


def ranks(scores: Sequence[float] | Array) -> Array:
    """Return the parts (n,) of stated normal distributions that lie below the truth.

    scores (n,): by how many standard deviations the fit is above the truth.
    """
    return np.asarray(ndtr(-np.asarray(scores, float)))


def covered(scores: Sequence[float] | Array) -> float:
    """Return the part of 95 % intervals that hold the truth."""
    return float(np.mean(np.abs(scores) < LIMIT))


def write(record: Mapping[str, Any], path: Path) -> None:
    """Write the page on a record of `evidence.coverage` to the HTML file `path`."""
    about = "By how many deviations calibrations of drawn fingers and rigs miss the truth."
    html = page.render(
        "study.html",
        made_by="fefinger.validation.evidence.coverage",
        title="Whether the deviations of a calibration cover",
        data=(path.with_suffix(".json").name,),
        answer=about,
        notes=(),
        lines=(f"Wanted: {100 * WANTED[0]:g} to {100 * WANTED[1]:g} % of the 95 % intervals.",),
        parts=list(_parts(record["rows"])),
        provenance=[(name, record[name]) for name in ("command", "commit", "date")],
    )
    path.write_text(html, encoding="utf-8")


def _parts(rows: Sequence[Mapping[str, Any]]) -> Iterator[dict[str, object]]:
    for by_solid, title in GROUPS.items():
        drawn = [row for row in rows if row["solid"] is by_solid]
        scores = by_parameter(drawn)
        refused = [row["refused"] for row in drawn if "refused" in row]
        count = len(next(iter(scores.values()), []))
        texts = [f"{count} records were calibrated, {len(refused)} refused in a sentence."]
        heading = ("", "95 % intervals that hold the truth", "mean score", "its spread", "largest")
        cells = [
            (
                name,
                f"{100 * covered(each):.0f} %",
                f"{each.mean():+.2f}",
                f"{each.std():.2f}",
                f"{np.abs(each).max():.1f}",
            )
            for name, each in scores.items()
        ]
        if count:
            with figures.style():
                picture = page.svg(histograms(scores))
            table = {"heading": heading, "rows": cells}
            yield {"title": title, "texts": [*texts, RANKS], "picture": picture, "table": table}
        if refused:
            yield {"title": f"{title}: refused", "texts": (), "bullets": refused}


def by_parameter(rows: Sequence[Mapping[str, Any]]) -> dict[str, Array]:
    """Return the scores (n,) of each parameter in rows that were calibrated."""
    done = [row["scores"] for row in rows if "scores" in row]
    return {name: np.array([each[name] for each in done]) for name in (done[0] if done else ())}


def histograms(scores: Mapping[str, Array]) -> Any:
    """Return a figure of the histogram of ranks of each parameter, with the band of chance."""
    columns = 5
    lines = -(-len(scores) // columns)
    drawn, axes = panels(figures.WIDE, 1.5 * lines, lines, columns, sharex=True, sharey=True)
    for axis, (name, each) in zip(axes.ravel(), scores.items(), strict=False):
        low, high = binom.interval(0.95, len(each), 1 / BINS)
        axis.axhspan(low, high, color="#dbe9f4")
        axis.axhline(len(each) / BINS, color=figures.INK, linewidth=0.8)
        axis.hist(ranks(each), np.linspace(0, 1, BINS + 1), color=figures.COLORS["SAI"], rwidth=0.8)
        axis.set_title(f"{name}: {100 * covered(each):.0f} %")
    for axis in axes.ravel()[len(scores) :]:
        axis.set_visible(False)
    drawn.supxlabel("part of the stated distribution below the truth", fontsize=9)
    drawn.supylabel("records", fontsize=9)
    return drawn
