"""Figures of a study: every measure against a field, and spikes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from fefinger.scene.field_units import split
from fefinger.studies.columns import MEASURES, Row, bounds, words
from fefinger.studies.grid import DIGITS
from fefinger.view import figures


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

Rows = Sequence[Row]
Groups = dict[str, list[Row]]

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#E69F00", "#56B4E9", "#1f2933", "#8b98a5")
"""Colors of series: Okabe and Ito (2008), as for the afferents."""

MARKERS = "os^D"
"""Markers of the first to the fourth series of a color."""


HERTZ, OF_HERTZ = "hertz_", "elliptic Hertz at that depth"
"""Prefix of the columns of a half-space, drawn as dotted lines in the same panels; its label."""

LEGEND = (
    "Solid lines are the finger that was simulated, with a point per scene; bars are its stated "
    "error. Dotted lines are Hertz's formula for the same curvatures at the same depth, without "
    "bone."
)
"""Caption of panels that have lines of both kinds."""

SAME = 0.005
"""Relative variation of a measure up to which it counts as constant."""

NOTHING = 1e-9
"""Value of a measure, in its unit, that counts as zero: it is rounding."""


def label(row: Row, series: Sequence[str]) -> str:
    """Return the label of a row's series: the values of the fields in `series` with their units."""
    fields = {name: split(name)[0].rpartition(".")[2] for name in series}
    texts = (
        row[name] if isinstance(row[name], str) else f"{field} {_value(row, name)}"
        for name, field in fields.items()
    )
    return ", ".join(texts)


def _value(row: Row, name: str) -> str:
    value = row[name]
    text = f"{value:.{DIGITS}g}" if isinstance(value, float) else str(value)
    return f"{text} {split(name)[1]}".strip()


class Look(TypedDict):
    """Color and marker of a series."""

    color: str
    marker: str


def _look(number: int) -> Look:
    """Return the color and marker of a series; series of the same color differ in marker."""
    turn, color = divmod(number, len(PALETTE))
    return {"color": PALETTE[color], "marker": MARKERS[turn % len(MARKERS)]}


def panels(
    rows: Rows,
    x: str,
    series: Sequence[str],
    skip: Sequence[str] = (),
    labels: Sequence[str] = (),
) -> "Figure":
    """Draw every measure of `rows` against the column `x`, a color for each of the `series`.

    Bars are expected errors. Measures in `skip` and constant ones, such as the depth at the end of
    equal presses, are left out. `labels` of all series of a page keep each in its color, though
    these rows may lack some.
    """
    from matplotlib.lines import Line2D

    groups, names = grouped(rows, series, labels), varying(rows, skip)
    count = max(-(-len(names) // 3), 1)
    with figures.style():
        drawn = figures.figure(figures.WIDE, 0.7 + 2.15 * count)
        axes = drawn.subplots(count, 3, squeeze=False, sharex=True)
        for axis, name in zip(axes.flat, names, strict=False):
            _panel(axis, groups, x, name)
        for axis in axes.flat[len(names) :]:
            axis.set_axis_off()
        for column in axes.T:
            for axis in [axis for axis in column if axis.axison][-1:]:
                axis.set_xlabel(words(x))
                axis.tick_params(labelbottom=True)
        hertz = Line2D([], [], color=figures.INK, linestyle=":", label=OF_HERTZ)
        there = any(_number(row, name) for row in rows for name in row if name.startswith(HERTZ))
        _legend(drawn, groups, [hertz] if there else [])
        return drawn


def varying(rows: Rows, skip: Sequence[str] = ()) -> list[str]:
    """Return the measures that are not the same in all rows."""
    return [name for name in MEASURES if name not in skip and _varies(rows, name)]


def _panel(axis: "Axes", groups: Groups, x: str, name: str) -> None:
    """Draw one measure with its expected errors, and the same of a half-space."""
    for number, group in enumerate(groups.values()):
        look = _look(number)
        _bars(axis, group, x, name, number)
        for style, column in (("-", name), (":", HERTZ + name)):
            finite = [row for row in group if _number(row, column)]
            axis.plot(
                [row[x] for row in finite],
                [row[column] for row in finite],
                style,
                color=look["color"],
                marker=look["marker"] if style == "-" else None,
                markersize=2.5,
                linewidth=1.6 if style == "-" else 1.1,
            )
    axis.set_title(words(name))
    if name in ("asymmetry", "shift_distal_mm"):
        axis.axhline(0, color=figures.STEEL, linewidth=0.7)


def _bars(axis: "Axes", group: Rows, x: str, name: str, number: int) -> None:
    """Draw the bounds of a measure by its expected error; caps of series differ in size."""
    limits = [(row, bounds(row, name)) for row in group if _number(row, name)]
    bars = [(row, each) for row, each in limits if each is not None]
    if not bars:
        return
    values = np.array([row[name] for row, _ in bars], float)
    ends = np.array([each for _, each in bars])
    axis.errorbar(
        [row[x] for row, _ in bars],
        values,
        yerr=[values - ends[:, 0], ends[:, 1] - values],
        fmt="none",
        ecolor=_look(number)["color"],
        elinewidth=0.9,
        capsize=2 + 1.5 * (number % len(PALETTE)),
        alpha=0.6,
    )


def grouped(rows: Rows, series: Sequence[str], labels: Sequence[str] = ()) -> Groups:
    """Group the rows by the label of their series, in the order of `labels` and of the rows."""
    groups: Groups = {name: [] for name in labels}
    for row in rows:
        groups.setdefault(label(row, series), []).append(row)
    return groups


def _legend(drawn: "Figure", groups: Groups, others: "Sequence[Line2D]" = ()) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], label=name, markersize=2.5, **_look(number))
        for number, (name, group) in enumerate(groups.items())
        if name and group
    ]
    handles += others
    if handles:
        drawn.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 4))


def _number(row: Row, name: str) -> bool:
    """Return whether a row has a finite number in a column."""
    value = row.get(name)
    return isinstance(value, int | float) and bool(np.isfinite(value))


def _varies(rows: Rows, name: str) -> bool:
    """Return whether numbers of a column vary by more than SAME and NOTHING; so does one alone."""
    values = [row[name] for row in rows if _number(row, name)]
    most = max(SAME * np.abs(values).max(initial=0.0), NOTHING)
    return len(values) == 1 or (len(values) > 1 and np.ptp(values) > most)


def spikes(rows: Rows, x: str, series: Sequence[str], labels: Sequence[str] = ()) -> "Figure":
    """Draw the spikes of each type against the column `x`, in the colors of `panels`."""
    groups = grouped(rows, series, labels)
    types = [kind for kind in figures.COLORS if any(f"spikes_{kind}" in row for row in rows)]
    with figures.style():
        drawn = figures.figure(figures.WIDE, 2.4)
        axes = drawn.subplots(1, len(types), squeeze=False)
        for axis, kind in zip(axes[0], types, strict=True):
            for number, group in enumerate(groups.values()):
                counted = [row for row in group if _number(row, f"spikes_{kind}")]
                counts = [row[f"spikes_{kind}"] for row in counted]
                axis.plot([row[x] for row in counted], counts, markersize=2.5, **_look(number))
            axis.set(title=f"{kind}: spikes", xlabel=words(x))
            axis.set_ylim(bottom=0)
            axis.yaxis.get_major_locator().set_params(integer=True)
        _legend(drawn, groups)
        return drawn
