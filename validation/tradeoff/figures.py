"""Figures of the trade-off: fronts of cost and error, and what the planner made of them."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from fefinger.validation.panels import label_outside, panels
from fefinger.validation.tradeoff.held_out import ENOUGH

from fefinger.results.candidate import Candidate
from fefinger.support.arrays import Array
from fefinger.view.figures import INK, STEEL, WIDE, figure


COLORS = {
    "lumped": "#AA4499",
    "hertz": "#E69F00",
    "layered": "#009E73",
    "condensed": "#56B4E9",
    "pressed": "#332288",
    "linear": "#0072B2",
    "solid": "#D55E00",
}
MARKERS = {"coarse": "o", "standard": "s", "": "X"}
LEAST = 1e-4
"""Errors below it are drawn at it."""

OTHERS = {
    "pressure": "highest pressure",
    "area": "contact area",
    "strain": "strain at end organs",
    "spikes": "spikes",
}

Points = dict[str, tuple[float, float]]
"""Cost and error by candidate."""

FRONT = (
    "Pareto front of error and time: error of the force in the scenes, held out and of "
    "development, against the CPU time of a first answer; medians of each candidate with "
    "the quarters on either side. Scenes of published tissue (left), which all mechanics "
    "answer, and of calibrated fingers (right). Gray line: Pareto front of the medians."
)

OTHERS_CAPTION = (
    "Errors of other quantities in the scenes that `solid` answers, held out and of "
    "development: medians of each candidate. Highest pressure over 1 mm², contact area and "
    "strain at the end organs when the force is largest; missing and extra spikes of SAI, SAII "
    "and FAI, of all, against those of solid on the standard mesh."
)


def figures(data: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure."""
    yield FRONT, _front(data)
    yield OTHERS_CAPTION, _others(data)
    yield _held_caption(data), _held(data)
    yield _cost_caption(data), _cost(data)


def _point(axes: Any, candidate: str, cost: float, error: float) -> None:
    mechanics, how = Candidate.of(candidate).mechanics, Candidate.of(candidate).resolution or ""
    axes.plot(
        cost,
        max(error, LEAST),
        marker=MARKERS[how],
        color=COLORS[mechanics],
        markerfacecolor="none" if how == "coarse" else COLORS[mechanics],
        markersize=6,
        linestyle="none",
    )


def front(points: Points) -> list[str]:
    """Return the names of the points (cost, error) that no other beats in both, cheapest first."""
    order = sorted(points, key=lambda name: points[name])
    best, names = np.inf, []
    for name in order:
        if points[name][1] < best:
            best = points[name][1]
            names.append(name)
    return names


def _points(data: dict[str, Any], quantity: str, published: bool | None = None) -> dict[str, Array]:
    """Return CPU seconds and errors (n, 2) by candidate: of all scenes, or by their tissue."""
    points: dict[str, list[tuple[float, float]]] = {}
    for scene in data["taken"]:  # others were not timed
        rows = data["errors"][scene]
        if published is None or ("published" in scene) == published:
            for name, row in rows.items():
                if quantity in row:
                    point = data["taken"][scene][name], max(row[quantity], LEAST)
                    points.setdefault(name, []).append(point)
    return {name: np.array(each) for name, each in points.items()}


def _medians(points: dict[str, Array]) -> Points:
    return {name: tuple(np.median(each, axis=0).tolist()) for name, each in points.items()}


def _scatter(axes: Any, points: Points) -> None:
    """Draw (cost, error) of candidates and the line through those that nothing beats."""
    best = front(points)
    line = np.array([points[name] for name in best])
    axes.plot(line[:, 0], np.maximum(line[:, 1], LEAST), color=STEEL, linewidth=1, zorder=0)
    for name, (cost, error) in points.items():
        _point(axes, name, cost, error)
    axes.set(xscale="log", yscale="log")


def _legend(drawn: Any) -> None:
    from matplotlib.lines import Line2D

    lines = [
        Line2D([], [], color=color, marker="s", linestyle="none", label=name)
        for name, color in COLORS.items()
    ]
    names = {"coarse": "coarse mesh", "standard": "standard mesh", "": "no mesh"}
    lines += [
        Line2D(
            [],
            [],
            color=INK,
            marker=MARKERS[how],
            linestyle="none",
            label=text,
            markerfacecolor="none" if how == "coarse" else INK,
        )
        for how, text in names.items()
    ]
    drawn.legend(handles=lines, loc="outside upper center", ncols=5)


def _front(data: dict[str, Any]) -> Any:
    drawn = figure(WIDE, 3.6)
    for axis, published in zip(drawn.subplots(1, 2, sharey=True), (True, False), strict=True):
        scattered = _points(data, "force", published)
        medians = _medians(scattered)
        for name, points in scattered.items():
            low, middle, high = np.quantile(points[:, 1], [0.25, 0.5, 0.75])
            color = COLORS[Candidate.of(name).mechanics]
            axis.errorbar(
                medians[name][0], middle, [[middle - low], [high - middle]], color=color, lw=0.8
            )
        _scatter(axis, medians)
        axis.set(
            title="published tissue" if published else "calibrated fingers",
            xlabel="CPU time of a first answer / s",
        )
    drawn.axes[0].set_ylabel("error of the force")
    _legend(drawn)
    return drawn


def _others(data: dict[str, Any]) -> Any:
    drawn, grid = panels(WIDE, 5.2, 2, 2, sharex=True)
    for axis, (quantity, title) in zip(grid.ravel(), OTHERS.items(), strict=True):
        _scatter(axis, _medians(_points(data, quantity)))
        axis.set_title(title)
    label_outside(grid, "CPU time of a first answer / s", "error")
    _legend(drawn)
    return drawn


def _held_caption(data: dict[str, Any]) -> str:
    summary = data["summary"]
    shares = ", ".join(
        f"{_NAMES[name]} {100 * share:.0f} %"
        for name, share in summary["stated_kept_by_all_candidates"].items()
    )
    return (
        f"{summary['scenes']} scenes that took no part in deriving the rules: stated and actual "
        "errors of every candidate. Below the line the stated error is an upper bound; share of "
        f"such cases: {shares}."
    )


_NAMES = {
    "force": "force",
    "pressure": "highest pressure",
    "area": "contact area",
    "strain": "strain at end organs",
}


def _held(data: dict[str, Any]) -> Any:
    drawn, grid = panels(WIDE, 5.2, 2, 2, sharex=True, sharey=True)
    for axis, (quantity, title) in zip(grid.ravel(), _NAMES.items(), strict=True):
        for each in data["scenes"].values():
            for name, row in each["candidates"].items():
                stated = row["stated"].get(quantity)
                if stated is None:
                    continue
                picked = name == each["pick"]
                axis.plot(
                    stated,
                    max(row["actual"][quantity], LEAST),
                    marker="o",
                    markersize=6 if picked else 2.5,
                    rasterized=not picked,  # a thousand points would take half a megabyte
                    color=COLORS[Candidate.of(name).mechanics],
                    markeredgecolor=INK if picked else "none",
                    linestyle="none",
                    zorder=2 if picked else 1,
                )
        axis.plot([LEAST, 3], [LEAST, 3], color=STEEL, linewidth=1)
        axis.set(
            xscale="log", yscale="log", title=f"{title}: candidates (small), choices (outlined)"
        )
    label_outside(grid, "stated error", "actual error")
    _legend(drawn)
    return drawn


def _cost_caption(data: dict[str, Any]) -> str:
    summary = data["summary"]
    return (
        "Left: expected time of the choice over that of the cheapest candidate that meets the "
        f"tolerance; {100 * summary['within_1.2']:.0f} % of the ratios are at most {ENOUGH:g}, the "
        f"largest is {summary['worst_ratio']:.2g}; the ratio of the sums is "
        f"{summary['total_seconds_over_least']:.2g}. Right: the same share for a planner that "
        "knows all actual errors and states them too large by one factor; the cross is the actual "
        "planner, at the median ratio of stated to actual error of the cheapest sufficient "
        "candidate."
    )


def _cost(data: dict[str, Any]) -> Any:
    summary = data["summary"]
    drawn, (left, right) = panels(WIDE, 3.2, 1, 2)
    ratios = np.sort([e["ratio"] for e in data["scenes"].values() if e["ratio"] is not None])
    left.step(ratios, np.arange(1, len(ratios) + 1) / len(ratios), where="post", color=INK)
    left.axvline(ENOUGH, color=STEEL, linewidth=1)
    left.set(xscale="log", xlabel="time of the choice / least time", ylabel="share of the scenes")
    curve = {float(key): share for key, share in summary["oracle_within_1.2"].items()}
    right.plot(curve.keys(), curve.values(), color=STEEL, marker="o", markersize=4)
    right.plot(summary["stated_over_actual_of_the_cheapest"], summary["within_1.2"], "x", color=INK)
    right.set(xlabel="stated / actual error", ylabel=f"share within {ENOUGH:g} times the least")
    for axis in (left, right):
        axis.set_ylim(0, 1.02)
    return drawn
