"""Figures of the trade-off: fronts of cost and error, numerical against model error, held out."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from fefinger.validation.tradeoff.held_out import ENOUGH
from fefinger.validation.tradeoff.study import front

from fefinger.results.candidate import Candidate
from fefinger.view.figures import INK, STEEL, WIDE, figure, style


COLORS = {
    "lumped": "#AA4499",
    "hertz": "#E69F00",
    "layered": "#009E73",
    "condensed": "#56B4E9",
    "pressed": "#332288",
    "linear": "#0072B2",
    "solid": "#D55E00",
}
MARKERS = {"coarse": "o", "standard": "s", "identified": "P", "": "X"}
LEAST = 1e-4
"""Errors below it are drawn at it."""

QUANTITIES = {
    "pressure": "highest pressure",
    "taxels": "pressure on taxels",
    "area": "contact area",
    "strain": "strain at end organs",
}


def figures(data: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure."""
    with style():
        yield _front_caption(), _front(data)
        yield _fronts_caption(), _fronts(data)
        yield _others_caption(), _others(data)
        yield _spikes_caption(), _spikes(data)
        yield _split_caption(), _split(data)
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


def _scatter(axes: Any, points: dict[str, tuple[float, float]]) -> None:
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
    names["identified"] = "no mesh, identified"
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


def _front_caption() -> str:
    return (
        "The front of error and time: error of the force in the held-out scenes against the "
        "expected time of a first answer, medians of each candidate with the quarters on either "
        "side; scenes of published tissue (left), which all mechanics answer, and of calibrated "
        "fingers (right). Gray line: Pareto front of the medians."
    )


def _front(data: dict[str, Any]) -> Any:
    drawn = figure(WIDE, 3.6)
    for axis, published in zip(drawn.subplots(1, 2, sharey=True), (True, False), strict=True):
        rows: dict[str, list[tuple[float, float]]] = {}
        for key, each in data["held_out"].items():
            if ("published" in key) == published:
                for name, row in each["candidates"].items():
                    found = rows.setdefault(name, [])
                    found.append((row["seconds"], max(row["actual"]["force"], LEAST)))
        medians = {name: tuple(np.median(found, axis=0)) for name, found in rows.items()}
        for name, found in rows.items():
            low, middle, high = np.quantile(np.array(found)[:, 1], [0.25, 0.5, 0.75])
            color = COLORS[Candidate.of(name).mechanics]
            axis.errorbar(
                medians[name][0], middle, [[middle - low], [high - middle]], color=color, lw=0.8
            )
        _scatter(axis, medians)
        axis.set(
            title="published tissue" if published else "calibrated fingers",
            xlabel="expected time of a first answer / s",
        )
    drawn.axes[0].set_ylabel("error of the force")
    _legend(drawn)
    return drawn


def _fronts_caption() -> str:
    return (
        "Largest error of the force over time, relative to its peak, against the expected time of "
        "a press, for each base scene; gray line: Pareto front. The reference is solid "
        "extrapolated over its meshes; the dashed line is the uncertainty of the reference. lumped "
        "is identified from the press of the plate."
    )


def _fronts(data: dict[str, Any]) -> Any:
    rows = data["scenes"]
    drawn, axes = _per_scene(len(rows), "error of the force")
    for axis, (name, row) in zip(axes, rows.items(), strict=False):
        points = {
            key: (each["expected_s"], each["force"]) for key, each in row["candidates"].items()
        }
        _scatter(axis, points)
        axis.axhline(max(row["bars"]["force"], LEAST), color=INK, linewidth=0.8, linestyle="--")
        axis.set_title(name)
    return drawn


def _per_scene(count: int, quantity: str) -> tuple[Any, Any]:
    """Return a figure with a legend, and its axes of a quantity over time for each base scene."""
    drawn = figure(WIDE, 5.2)
    axes = drawn.subplots(2, 4, sharex=True, sharey=True).ravel()
    for axis in axes[count:]:
        axis.set_axis_off()
    for axis in axes[4:]:
        axis.set_xlabel("expected time / s")
    for axis in (axes[0], axes[4]):
        axis.set_ylabel(quantity)
    axes[3].xaxis.set_tick_params(labelbottom=True)
    _legend(drawn)
    return drawn, axes


def _others_caption() -> str:
    return (
        "Errors of other quantities in two presses at their full depth: highest pressure over 1 "
        "mm², forces on taxels of 1 mm around the centroid (L2), contact area, strain at the four "
        "central end organs. Dashed: uncertainty of the reference."
    )


def _others(data: dict[str, Any]) -> Any:
    drawn = figure(WIDE, 5.2)
    grid = drawn.subplots(2, 4, sharex=True, sharey=True)
    for line, name in zip(grid, ("flat-30", "sphere-10"), strict=True):
        rows = data["presses"][name]
        bars = data["rules"]["presses"][name]["bars"]
        for axis, (key, title) in zip(line, QUANTITIES.items(), strict=True):
            points = {
                candidate: (row["expected_s"], row["total"][key])
                for candidate, row in rows.items()
                if key in row["total"]
            }
            _scatter(axis, points)
            axis.axhline(max(bars[key][-1], LEAST), color=INK, linewidth=0.8, linestyle="--")
            axis.set_title(f"{name}: {title}", fontsize=8)
        line[0].set_ylabel("error")
    for axis in grid[1]:
        axis.set_xlabel("expected time / s")
    _legend(drawn)
    return drawn


def _spikes_caption() -> str:
    return (
        "Spikes of the four central afferents: distance of Victor and Purpura from those of the "
        "reference, per spike, where moving a spike by 1 ms costs as much as losing one."
    )


def _spikes(data: dict[str, Any]) -> Any:
    rows = data["scenes"]
    drawn, axes = _per_scene(len(rows), "distance per spike")
    for axis, (name, row) in zip(axes, rows.items(), strict=False):
        points = {
            key: (each["expected_s"], max(each["spikes"]["distance"], 1e-3))
            for key, each in row["candidates"].items()
            if "spikes" in each
        }
        _scatter(axis, points)
        axis.set_title(f"{name}: {sum(row['spikes'].values())} spikes", fontsize=8)
    return drawn


def _split_caption() -> str:
    return (
        "Numerical error of the force (dark: mesh, relative to the converged value of the same "
        "mechanics) and model error (light: that converged value relative to solid) at the full "
        "depth of each base press. hertz and layered both with tissue parameters and as identified "
        "from the plate at 30 degrees."
    )


def _split(data: dict[str, Any]) -> Any:
    presses = data["presses"]
    drawn = figure(WIDE, 5.2)
    axes = drawn.subplots(2, len(presses) // 2, sharey=True, sharex=True).ravel()
    names = list(dict.fromkeys(key for rows in presses.values() for key in rows))
    for axis, (press, rows) in zip(axes, presses.items(), strict=True):
        for place, name in enumerate(names):
            if name not in rows:
                continue
            numerical = rows[name]["numerical"]["force"]
            model = rows[name]["model"]["force"]
            color = COLORS[Candidate.of(name).mechanics]
            axis.barh(place - 0.2, max(numerical, LEAST), 0.36, left=LEAST / 2, color=color)
            axis.barh(place + 0.2, max(model, LEAST), 0.36, left=LEAST / 2, color=color, alpha=0.4)
        deepest = data["rules"]["presses"][press]["depth_mm"][-1]
        axis.set(xscale="log", title=f"{press}, {deepest:g} mm", xlim=(LEAST, 3))
        axis.set_yticks(range(len(names)), labels=names)
        axis.invert_yaxis()
    for axis in axes[len(axes) // 2 :]:
        axis.set_xlabel("error of the force")
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
    drawn = figure(WIDE, 5.2)
    grid = drawn.subplots(2, 2, sharex=True, sharey=True)
    for axis, (quantity, title) in zip(grid.ravel(), _NAMES.items(), strict=True):
        for each in data["held_out"].values():
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
                    color=COLORS[Candidate.of(name).mechanics],
                    markeredgecolor=INK if picked else "none",
                    linestyle="none",
                    zorder=2 if picked else 1,
                )
        axis.plot([LEAST, 3], [LEAST, 3], color=STEEL, linewidth=1)
        axis.set(
            xscale="log", yscale="log", title=f"{title}: candidates (small), choices (outlined)"
        )
    for axis in grid[1]:
        axis.set_xlabel("stated error")
    for axis in grid[:, 0]:
        axis.set_ylabel("actual error")
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
    drawn = figure(WIDE, 3.2)
    left, right = drawn.subplots(1, 2)
    ratios = np.sort([e["ratio"] for e in data["held_out"].values() if e["ratio"] is not None])
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
