"""Figures of a result for its report, drawn with matplotlib's objects (no pyplot).

`style` is to be active while a figure is drawn; `svg` turns one into text.
"""

import io
import re
from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fefinger.neural.trains import FEW
from fefinger.results.records import Harmonic
from fefinger.results.result_record import ResultRecord
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array, Floats, Integers
from fefinger.support.vocabulary import TYPES


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

# Okabe and Ito (2008): distinguishable with every type of color vision.
COLORS = {"SAI": "#0072B2", "SAII": "#009E73", "FAI": "#D55E00", "FAII": "#AA4499"}
INK, STEEL, BONE = "#1f2933", "#8b98a5", "#efe6d6"
RECORD = "#E69F00"
STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9,
    "axes.edgecolor": STEEL,
    "axes.labelcolor": INK,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e8ecf0",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "xtick.color": INK,
    "ytick.color": INK,
    "text.color": INK,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "svg.hashsalt": "fefinger",
    "svg.fonttype": "none",
}
WIDE = 9.2  # inches: the width of a figure that fills the report
SHORT = 0.25  # s: shorter spans are labeled in ms


class Curve(NamedTuple):
    """A curve of a signal: label (empty: not in the legend), color and values (n_t,)."""

    label: str
    color: str
    values: Array


class Row(NamedTuple):
    """A row of panels with the same vertical axis: its label, times (n_t,) s, and the curves."""

    label: str
    time: Array
    curves: Sequence[Curve]


class Window(NamedTuple):
    """A span of time in s that signals are drawn over, with its title."""

    title: str
    start: float
    stop: float


def style() -> AbstractContextManager[None]:
    """Return a context in which figures get the style of the report."""
    import matplotlib

    return matplotlib.rc_context(STYLE)


def figure(width: float, height: float) -> "Figure":
    """Return an empty Figure of a size in inches, with constrained layout."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained", facecolor="white")


def svg(drawn: "Figure") -> str:
    """Return a figure as SVG text with letters in the font of the browser.

    Its layout is computed here, since `savefig` would draw everything twice, once for the layout.
    """
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    buffer = io.StringIO()
    with style():
        canvas = FigureCanvasSVG(drawn)
        points = 72  # units of an SVG per inch, for its layout
        drawn.set_dpi(points)
        if (layout := drawn.get_layout_engine()) is not None:
            layout.execute(drawn)
        drawn.set_layout_engine("none")
        # The parts of an SVG that are pixels stay sharp on a phone.
        drawn.set_dpi(200)
        canvas.print_svg(buffer, metadata={"Date": None})
    return rounded(buffer.getvalue())


def rounded(text: str) -> str:
    """Shorten an SVG text, on one line: in the address of a picture in a page it takes 0.6 of it.

    Coordinates are rounded to 0.01 pt; metadata, names that nothing refers to, spaces and repeated
    commands of paths are left out, and tags have the quotes that an address does not escape.
    """
    drawn = text[text.index("<svg") :]  # without the declaration of XML
    drawn = re.sub(r"<metadata>.*?</metadata>", "", drawn, flags=re.DOTALL)
    used = set(re.findall(r"#([\w-]+)", drawn))

    def number(found: re.Match[str]) -> str:
        return f"{float(found[0]):.2f}".rstrip("0").rstrip(".")

    def tight(found: re.Match[str]) -> str:
        if found[1] == "style":
            return re.sub("([:;]) ", r"\1", found[0])
        path = re.sub(r"\s*([MLQCz])\s*", r"\1", found[0])
        # A line goes on from a start, and from a line, without its letter.
        return re.sub(
            r"[ML][^MLQCz]*(L[^MLQCz]*)+",
            lambda run: run[0][0] + run[0][1:].replace("L", " "),
            path,
        )

    def short(found: re.Match[str]) -> str:
        tag = re.sub(r"\d+\.\d+", number, found[0])
        tag = re.sub(r' id="([^"]*)"', lambda name: name[0] if name[1] in used else "", tag)
        tag = re.sub(r' (d|style)="[^"]*"', tight, tag)
        return tag if "'" in tag else tag.replace('"', "'")

    tags = re.sub(r">\s*\n\s*<", "><", re.sub(r"<[^>]*>", short, drawn))
    return re.sub(r"\s*\n\s*", " ", tags)


def windows(scene: Scene, end: float) -> list[Window]:
    """Return the spans over which a signal that ends at `end` s is drawn, the whole one last.

    A first movement in less than a fifth of the time gets a panel of its own, and so do the last
    four of more than 20 cycles of a vibration.
    """
    spans = [Window("whole stimulus", 0.0, end)]
    wave = scene.motion.trajectory.wave
    if wave is not None and end * wave.last_frequency > 20:
        spans.insert(0, Window("last four cycles", end - 4 / wave.last_frequency, end))
    # A wave begins a movement of its own, so the ramp ends at the first break in the middle.
    moves = scene.motion.moving
    stop = moves[0][1] if moves else end
    if stop < end / 5:
        spans.insert(0, Window("first movement", 0.0, min(end, 1.8 * stop)))
    return spans


def signals(result: ResultRecord, rows: Sequence[Row]) -> "Figure":
    """Draw rows of curves against time over all `windows`, in ms where a span is short."""
    with style():
        drawn, axes, scales = _panels(result, [1.0] * len(rows), 0.5 + 1.75 * len(rows))
        for row, line in zip(rows, axes, strict=True):
            for axis, scale in zip(line, scales, strict=True):
                for name, color, values in row.curves:
                    axis.plot(row.time * scale, values, color=color, label=name or "_")
            line[0].set_ylabel(row.label)
        handles = [
            line for axis in axes[:, -1] for line in axis.lines if line.get_label()[:1] != "_"
        ]
        if handles:
            # On the left, where a phone shows it without scrolling.
            drawn.legend(handles=handles, loc="outside upper left", ncols=len(handles))
        return drawn


def _panels(
    result: ResultRecord, heights: list[float], height: float
) -> "tuple[Figure, NDArray[np.object_], list[float]]":
    """Return a figure, its axes (len(heights), n_windows), and per window its units per second."""
    from matplotlib.ticker import MaxNLocator

    spans = windows(result.scene, float(result.time[-1]))
    widths = [1.0] * (len(spans) - 1) + [1.5]
    drawn = figure(WIDE, height)
    axes = drawn.subplots(
        len(heights), len(spans), sharex="col", sharey="row", squeeze=False,
        width_ratios=widths, height_ratios=heights,
    )  # fmt: skip
    scales = []
    for (title, start, stop), column in zip(spans, axes.T, strict=True):
        scale, unit = (1e3, "ms") if stop - start < SHORT else (1.0, "s")
        scales.append(scale)
        column[0].set(title=title, xlim=(start * scale, stop * scale))
        column[-1].set_xlabel(f"time / {unit}")
        if len(scales) < len(spans):
            column[-1].xaxis.set_major_locator(MaxNLocator(5, prune="upper"))
    return drawn, axes, scales


def force(result: ResultRecord) -> "Figure":
    """Draw force and depth against time, and what a record has beside its motion."""
    forces, depths = [Curve("", INK, result.response.force)], [Curve("", STEEL, result.depth)]
    motion = result.scene.motion
    measured = motion.beside(result.time)
    if measured is not None:
        compared = depths if motion.by_force else forces
        compared[:] = [compared[0]._replace(label="answer"), Curve("measured", RECORD, measured)]
    rows = Row("force / N", result.time, forces), Row("depth / mm", result.time, depths)
    return signals(result, rows)


def contact(result: ResultRecord) -> "Figure":
    """Draw contact area and centroid against time."""
    rows = []
    if result.contact_area is not None:
        area = Curve("", INK, result.contact_area)
        rows.append(Row("contact area / mm²", result.time, [area]))
    if result.centroid is not None:
        x, y = result.centroid.T
        curves = [Curve("x (distal)", "#0072B2", x), Curve("y (radial)", "#E69F00", y)]
        rows.append(Row("centroid / mm", result.time, curves))
    return signals(result, rows)


def of_each(types: Sequence[str]) -> dict[str, Integers]:
    """Return the indices of each type among units or sites, in the order of TYPES."""
    named = np.array(types)
    return {kind: np.flatnonzero(named == kind) for kind in TYPES if kind in types}


def strongest(values: Floats, types: Sequence[str]) -> list[int]:
    """Return for each of the types the column of values (n_t, n_types) with the largest size."""
    top = np.abs(values).max(axis=0)
    return [int(which[np.argmax(top[which])]) for which in of_each(types).values()]


def site_strain(result: ResultRecord) -> "Figure":
    """Draw the principal strains at the end organs against time.

    Of a population the most strained end organ of each type is drawn.
    """
    assert result.strain is not None
    assert result.sites is not None
    sites = result.sites
    low, high = (100 * each for each in result.principal)
    shown: list[int] = list(range(len(sites.types)))
    if sites.unit is not None:
        shown = strongest(low, sites.types)
    labels = [f"{sites.types[i]}, {sites.depths[i]:g} mm" for i in shown]
    types = [sites.types[i] for i in shown]
    compressive, tensile = np.maximum(0, -low), np.maximum(0, high)
    rows = [
        Row("compressive strain / %", result.time, _curves(labels, types, compressive[:, shown])),
        Row("tensile strain / %", result.time, _curves(None, types, tensile[:, shown])),
    ]
    return signals(result, rows)


def _curves(labels: list[str] | None, types: Sequence[str], values: Array) -> list[Curve]:
    """Return the columns of values (n_t, n_types) as curves in the colors of their types."""
    named, colors = labels or [""] * len(types), [COLORS.get(kind, INK) for kind in types]
    return list(map(Curve, named, colors, values.T))


def currents(result: ResultRecord) -> "Figure":
    """Draw the input of the end organs and the generator current of the units against time.

    Of more than FEW units the one of each type with the largest current is drawn.
    """
    spikes = result.spikes
    assert spikes is not None
    shown: list[int] = list(range(len(spikes)))
    if len(spikes) > FEW:
        shown = strongest(spikes.current, spikes.types)
    names, types = [spikes.names[i] for i in shown], [spikes.types[i] for i in shown]
    rows = [
        Row("end-organ input / mm", spikes.time, _curves(names, types, spikes.x_in[:, shown])),
        Row("current / µA/cm²", spikes.time, _curves(None, types, spikes.current[:, shown])),
    ]
    return signals(result, rows)


def spikes(result: ResultRecord) -> "Figure":
    """Draw the spike raster, and below it the instantaneous rate of units that fired twice."""
    trains = result.spikes
    assert trains is not None
    end = float(result.time[-1])
    colors = [COLORS.get(kind, INK) for kind in trains.types]
    firing = [unit for unit, times in enumerate(trains.times) if len(times) > 1]
    heights = [0.24 * len(trains) + 0.15] + [1.0] * len(firing)
    with style():
        drawn, axes, scales = _panels(result, heights, 0.8 + sum(heights))
        for line, scale in zip(axes.T, scales, strict=True):
            times = [t * scale for t in trains.times]
            line[0].eventplot(times, colors=colors, linelengths=0.8, linewidths=0.9)
            line[0].grid(visible=False)
            for unit, axis in zip(firing, line[1:], strict=True):
                _draw_rate(axis, trains.times[unit], end, colors[unit], scale)
        axes[0, 0].set_yticks(range(len(trains)), trains.names)
        axes[0, 0].set_ylim(len(trains) - 0.4, -0.6)
        for unit, axis in zip(firing, axes[1:, 0], strict=True):
            axis.set_ylabel(f"{trains.names[unit]}\nrate / Hz")
            axis.set_ylim(bottom=0)
        return drawn


def _draw_rate(axis: "Axes", times: Array, end: float, color: str, scale: float) -> None:
    """Draw the rate as steps: 1 / interval during each interval, zero outside of them."""
    edges = np.concatenate([[0.0], times, [max(end, times[-1])]])
    rates = np.concatenate([[0.0], 1 / np.diff(times), [0.0]])
    axis.stairs(rates, edges * scale, color=color, fill=True, alpha=0.25)
    axis.stairs(rates, edges * scale, color=color, linewidth=1.1)


def stages(result: ResultRecord) -> "Figure":
    """Draw the wall time of every stage of the computation as bars."""
    names, seconds = list(result.seconds), list(result.seconds.values())
    with style():
        drawn = figure(WIDE, 0.6 + 0.26 * len(names))
        axis = drawn.subplots()
        bars = axis.barh(names, seconds, color="#7aa6c2", height=0.66)
        texts = [f" {value:.3g} s" if value >= 1e-3 else " < 1 ms" for value in seconds]
        axis.bar_label(bars, texts, color=INK)
        axis.invert_yaxis()
        axis.margins(x=0.12)
        axis.set_xlabel("wall time / s")
        axis.grid(visible=False, axis="y")
        return drawn


def harmonic(answer: Harmonic, types: tuple[str, ...]) -> "Figure":
    """Draw stiffness, impedance, strain per mm at end organs of `types`, and energy lost."""
    with style():
        drawn = figure(8.4, 4.6)
        (stiffness, phase), (strain, lost) = drawn.subplots(2, 2, sharex=True)
        frequency = answer.frequency
        stiffness.plot(frequency, np.abs(answer.stiffness), color=INK)
        stiffness.set_ylabel("dynamic stiffness / (N/mm)")
        phase.plot(frequency, np.degrees(np.angle(answer.impedance)), color=INK)
        phase.set_ylabel("phase of the impedance / °")
        for kind, members in of_each(types).items():
            largest = np.abs(answer.strain[:, members]).max(axis=(1, 2, 3))
            strain.plot(frequency, largest, label=kind)
        if types:
            strain.legend()
        strain.set_ylabel("largest strain / (1/mm)")
        lost.plot(frequency, answer.dissipated_energy(0.01), color=STEEL)
        lost.set_ylabel("lost per cycle of 10 µm / µJ")
        for axis in (strain, lost):
            axis.set_xlabel("frequency / Hz")
        for scale in (stiffness.xaxis, stiffness.yaxis, strain.yaxis, lost.yaxis):
            _logarithmic(scale)
    return drawn


def _logarithmic(axis: "Axis") -> None:
    """Make an axis logarithmic, labeled at 1, 2 and 5 of decades; linear from 0 if narrow."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_data_interval()
    name = "x" if axis is axis.axes.xaxis else "y"
    # An axis is logarithmic where its values span a factor of four.
    if not 0 < 4.0 * low < high:
        axis.axes.set(**{f"{name}lim": (0, 1.1 * high)})
        return
    axis.axes.set(**{f"{name}scale": "log"})
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
