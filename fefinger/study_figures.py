"""Figures of the rows of a study: every measure against a field, and what the array would read.

Every function returns a matplotlib Figure.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fefinger import figures
from fefinger.records import Array


Rows = Sequence[Mapping[str, Any]]

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#E69F00", "#56B4E9", "#1f2933", "#8b98a5")
"""Okabe and Ito (2008), as the colors of the afferents."""

PANELS = {
    "force_N": "force / N",
    "depth_mm": "depth / mm",
    "contact_area_mm2": "contact area / mm²",
    "peak_pressure_kPa": "peak pressure / kPa",
    "shift_distal_mm": "centroid shift / mm, distal",
    "asymmetry": "asymmetry of the force",
    "ellipticity": "ellipticity 1 - b/a",
    "stiffness_N_per_mm": "stiffness / N/mm",
    "reach_distal_mm": "reach of 4 kPa, distal / mm",
    "reach_proximal_mm": "reach of 4 kPa, proximal / mm",
}
"""Measures with their axis labels."""

SHARED: dict[str, tuple[Any, str, dict[str, str]]] = {
    "sensor_": ("--", "as the array sees it", {"peak_pressure_kPa": "sensor_peak_kPa"}),
    "hertz_": (":", "elliptic Hertz at that depth", {}),
}
"""Prefixes of columns that are drawn in the same panel: line style, label, other names."""

LINES = {"sensor_contact_area_mm2": "sensor_area_mm2"}

SAME = 0.005
"""Part of a measure by which it may vary and count as the same."""

STEP = 4.0
"""kPa between isobars, as in Figure 3-3."""


def label(row: Mapping[str, Any], series: Sequence[str]) -> str:
    """Return what tells a row's series from the others."""
    values = {name: row[name] for name in series}
    return ", ".join(
        value if isinstance(value, str) else f"{name.rpartition('.')[2]} {value}"
        for name, value in values.items()
    )


def panels(rows: Rows, x: str, series: Sequence[str], skip: Sequence[str] = ()) -> Any:
    """Draw every measure of `rows` against the column `x`, one color per series.

    A measure that is the same everywhere, as the depth at the end of equal presses, is left out.
    """
    known = [name for name in PANELS if name not in skip and _varies(rows, name)]
    count = max(-(-len(known) // 3), 1)
    with figures.style():
        drawn = figures.figure(figures.WIDE, 0.7 + 2.15 * count)
        axes = drawn.subplots(count, 3, squeeze=False, sharex=True)
        for axis, name in zip(axes.flat, known, strict=False):
            _panel(axis, rows, x, series, name)
        for axis in axes.flat[len(known) :]:
            axis.set_axis_off()
        for column in axes.T:
            for axis in [axis for axis in column if axis.axison][-1:]:
                axis.set_xlabel(_words(x))
                axis.tick_params(labelbottom=True)
        _legend(drawn, rows, series)
        return drawn


def _panel(axis: Any, rows: Rows, x: str, series: Sequence[str], name: str) -> None:
    """Draw one measure, and the same of the array and of Hertz, where they are known."""
    styles = [("-", name)]
    for prefix, (style, _, others) in SHARED.items():
        styles.append((style, others.get(name, prefix + name)))
    for number, group in enumerate(grouped(rows, series).values()):
        for style, column in styles:
            found = [row for row in group if _number(row, LINES.get(column, column))]
            axis.plot(
                [row[x] for row in found],
                [row[LINES.get(column, column)] for row in found],
                style,
                color=PALETTE[number % len(PALETTE)],
                marker="o" if style == "-" else None,
                markersize=2.5,
                linewidth=1.6 if style == "-" else 1.1,
            )
    axis.set_title(PANELS[name])
    if name in ("asymmetry", "shift_distal_mm"):
        axis.axhline(0, color=figures.STEEL, linewidth=0.7)


def grouped(rows: Rows, series: Sequence[str]) -> dict[str, list[Mapping[str, Any]]]:
    """Return the rows of each series, in their order."""
    found: dict[str, list[Mapping[str, Any]]] = {}
    for row in rows:
        found.setdefault(label(row, series), []).append(row)
    return found


def _legend(drawn: Any, rows: Rows, series: Sequence[str]) -> None:
    from matplotlib.lines import Line2D

    names = [name for name in grouped(rows, series) if name]
    handles = [
        Line2D([], [], color=PALETTE[i % len(PALETTE)], label=name) for i, name in enumerate(names)
    ]
    for prefix, (style, words, _) in SHARED.items():
        if any(_number(row, name) for row in rows for name in row if name.startswith(prefix)):
            handles.append(Line2D([], [], color=figures.INK, linestyle=style, label=words))
    if handles:
        drawn.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 4))


def _number(row: Mapping[str, Any], name: str) -> bool:
    """Return whether a row has a finite number in a column."""
    value = row.get(name)
    return isinstance(value, int | float) and bool(np.isfinite(value))


def _varies(rows: Rows, name: str) -> bool:
    """Return whether a column has numbers, and not one and the same within SAME."""
    found = [row[name] for row in rows if _number(row, name)]
    return len(found) == 1 or (len(found) > 1 and np.ptp(found) > SAME * np.abs(found).max())


def _words(column: str) -> str:
    """Return an axis label from the name of a column."""
    name, _, unit = column.rpartition("_")
    return f"{name} / {unit}" if name and "." not in unit else column


def spikes(rows: Rows, x: str, series: Sequence[str]) -> Any:
    """Draw the spikes of each type against the column `x`."""
    types = [kind for kind in figures.COLORS if any(f"spikes_{kind}" in row for row in rows)]
    with figures.style():
        drawn = figures.figure(figures.WIDE, 2.4)
        axes = drawn.subplots(1, len(types), squeeze=False)
        for axis, kind in zip(axes[0], types, strict=True):
            for number, group in enumerate(grouped(rows, series).values()):
                found = [row for row in group if _number(row, f"spikes_{kind}")]
                counts = [row[f"spikes_{kind}"] for row in found]
                color = PALETTE[number % len(PALETTE)]
                axis.plot([row[x] for row in found], counts, "o-", color=color, markersize=2.5)
            axis.set(title=f"{kind}: spikes", xlabel=_words(x))
            axis.set_ylim(bottom=0)
        return drawn


def isobars(rows: Rows, x: str, readings: str) -> Any:
    """Draw what the 8 x 8 array reads at each row, tip up, as isobars 4 kPa apart.

    A cross marks first touch.
    """
    from fefinger.theory.sensor import ArraySensor

    across = 5
    count = -(-len(rows) // across)
    line = np.unique(ArraySensor().positions[:, 0])
    with figures.style():
        drawn = figures.figure(figures.WIDE, 2.1 * count)
        axes = drawn.subplots(count, across, squeeze=False, sharex=True, sharey=True)
        for axis, row in zip(axes.flat, rows, strict=False):
            middle = row["sensor_middle_distal_mm"]
            felt: Array = np.reshape(row[readings], (len(line), len(line)))
            levels = np.arange(STEP, felt.max(), STEP)
            if len(levels):
                axis.contour(line, line + middle, felt.T, levels, cmap="viridis", linewidths=0.9)
            axis.plot(0, 0, "+", color="#D55E00", markersize=8)
            axis.set(aspect="equal", title=f"{row[x]:g}", xlim=(-7, 7), ylim=(-8, 8))
        for axis in axes.flat[len(rows) :]:
            axis.set_axis_off()
        drawn.supxlabel("sideways / mm", fontsize=9)
        drawn.supylabel("distal from first touch / mm", fontsize=9)
        return drawn
