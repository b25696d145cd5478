"""Figures of a study: every measure against a field, spikes, and readings of the array.

Every function returns a matplotlib Figure.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fefinger.scene.field_units import split
from fefinger.studies.columns import MEASURES, READINGS, bounds, words
from fefinger.studies.grid import DIGITS
from fefinger.support.arrays import Array
from fefinger.view import figures, quantities


Rows = Sequence[Mapping[str, Any]]
Groups = dict[str, list[Mapping[str, Any]]]

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#E69F00", "#56B4E9", "#1f2933", "#8b98a5")
"""Okabe and Ito (2008), as the colors of the afferents."""

MARKERS = "os^D"
"""Markers of the series that have each color, of the first to the fourth."""

SHARED: dict[str, tuple[Any, str, dict[str, str]]] = {
    "sensor_": (
        "--",
        "from the array's readings",
        {
            "highest_pressure_1mm2_kPa": "sensor_peak_kPa",
            "contact_area_mm2": "sensor_area_mm2",
        },
    ),
    "hertz_": (":", "elliptic Hertz at that depth", {}),
}
"""Prefixes of columns that are drawn in the same panel: line style, label, other names."""

LEGEND = (
    "Solid lines are the finger that was simulated, with a point per scene; bars are its stated "
    "error. Dashed lines are what the array of the thesis, between plate and pad, would read. "
    "Dotted lines are Hertz's formula for the same curvatures at the same depth, without bone."
)
"""Caption of panels that have lines of all kinds."""

SAME = 0.005
"""Relative variation of a measure up to which it counts as constant."""

NOTHING = 1e-9
"""Value of a measure, in its unit, up to which it counts as zero (rounding)."""

STEP = 4.0
"""kPa between isobars, as in Figure 3-3."""


def label(row: Mapping[str, Any], series: Sequence[str]) -> str:
    """Label of a row's series: the values of the fields in `series`, with their units."""
    return ", ".join(
        row[name] if isinstance(row[name], str) else f"{_field(name)} {_value(row, name)}"
        for name in series
    )


def _field(name: str) -> str:
    """Name of a field in a label: without its table and its unit."""
    return split(name)[0].rpartition(".")[2]


def _value(row: Mapping[str, Any], name: str) -> str:
    value = row[name]
    text = f"{value:.{DIGITS}g}" if isinstance(value, float) else str(value)
    return f"{text} {split(name)[1]}".strip()


def _look(number: int) -> dict[str, Any]:
    """Color and marker of a series by its number; the markers tell equal colors apart."""
    turn, color = divmod(number, len(PALETTE))
    return {"color": PALETTE[color], "marker": MARKERS[turn % len(MARKERS)]}


def panels(
    rows: Rows,
    x: str,
    series: Sequence[str],
    skip: Sequence[str] = (),
    labels: Sequence[str] = (),
) -> Any:
    """Draw every measure of `rows` against the column `x`, one color per series.

    Bars are the expected errors where the rows have them. A constant measure, such as the depth at
    the end of equal presses, is left out. `labels`: of all series of a page, some of which
    these rows may lack: they keep a series in its color.
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
        handles = [
            Line2D([], [], color=figures.INK, linestyle=style, label=text)
            for prefix, (style, text, _) in SHARED.items()
            if any(_number(row, name) for row in rows for name in row if name.startswith(prefix))
        ]
        _legend(drawn, groups, handles)
        return drawn


def varying(rows: Rows, skip: Sequence[str] = ()) -> list[str]:
    """Measures that are not the same in all rows."""
    return [name for name in MEASURES if name not in skip and _varies(rows, name)]


def _panel(axis: Any, groups: Groups, x: str, name: str) -> None:
    """Draw one measure with its expected errors, and the same of the array and of Hertz."""
    shared = ((style, more.get(name, to + name)) for to, (style, _, more) in SHARED.items())
    styles = [("-", name), *shared]
    for number, group in enumerate(groups.values()):
        look = _look(number)
        _bars(axis, group, x, name, number)
        for style, column in styles:
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


def _bars(axis: Any, group: Rows, x: str, name: str, number: int) -> None:
    """Draw the bounds of a measure by its expected error; caps grow with the series' number."""
    limits = [(row, bounds(row, name)) for row in group if _number(row, name)]
    bars = [(row[x], row[name], ends) for row, ends in limits if ends is not None]
    if not bars:
        return
    values, ends = (np.array([each[i] for each in bars], float) for i in (1, 2))
    axis.errorbar(
        [each[0] for each in bars],
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


def _legend(drawn: Any, groups: Groups, others: Sequence[Any] = ()) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], label=name, markersize=2.5, **_look(number))
        for number, (name, group) in enumerate(groups.items())
        if name and group
    ]
    handles += others
    if handles:
        drawn.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 4))


def _number(row: Mapping[str, Any], name: str) -> bool:
    """Whether a row has a finite number in a column."""
    value = row.get(name)
    return isinstance(value, int | float) and bool(np.isfinite(value))


def _varies(rows: Rows, name: str) -> bool:
    """Whether a column has numbers that vary by more than SAME and NOTHING, or only one."""
    values = [row[name] for row in rows if _number(row, name)]
    most = max(SAME * np.abs(values).max(initial=0.0), NOTHING)
    return len(values) == 1 or (len(values) > 1 and np.ptp(values) > most)


def spikes(rows: Rows, x: str, series: Sequence[str], labels: Sequence[str] = ()) -> Any:
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


def isobars(rows: Rows, x: str) -> Any:
    """Draw the readings of the 8 x 8 array in each row, tip up, as isobars 4 kPa apart.

    Colors are the same in all panels. A cross marks first touch.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    from fefinger.theory.array.sensor import ArraySensor

    across = min(len(rows), 5)
    count = -(-len(rows) // across)
    line = np.unique(ArraySensor().positions[:, 0])
    top = max(max(row[READINGS]) for row in rows)
    levels = np.arange(STEP, max(top, 2.5 * STEP), STEP)
    with figures.style():
        drawn = figures.figure(figures.WIDE, 0.5 + 2.1 * count)
        axes = drawn.subplots(count, across, squeeze=False, sharex=True, sharey=True)
        for axis, row in zip(axes.flat, rows, strict=False):
            middle = row["sensor_middle_distal_mm"]
            pressure: Array = np.reshape(row[READINGS], (len(line), len(line)))
            shown = levels[levels < pressure.max()]
            if len(shown):
                spread = {"vmin": levels[0], "vmax": levels[-1], "cmap": quantities.EVEN}
                axis.contour(line, line + middle, pressure.T, shown, linewidths=0.9, **spread)
            axis.plot(0, 0, "+", color="#D55E00", markersize=8)
            axis.set(aspect="equal", title=_value(row, x), xlim=(-7, 7), ylim=(-8, 8))
        for axis in axes.flat[len(rows) :]:
            axis.set_axis_off()
        drawn.supxlabel("sideways / mm", fontsize=9)
        drawn.supylabel("distal from first touch / mm", fontsize=9)
        colors = ScalarMappable(Normalize(levels[0], levels[-1]), quantities.EVEN)
        label = "pressure on the array / kPa"
        drawn.colorbar(colors, ax=axes, shrink=0.8, aspect=30, ticks=levels, label=label)
        return drawn
