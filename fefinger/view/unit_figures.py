"""Figures of many afferent units: raster, map of rates on the pad, receptive fields.

Siblings of `figures.py`, which draws the few units of an ordinary scene one by one.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fefinger.neural.statistics import mean_rates
from fefinger.results.result_record import ResultRecord
from fefinger.support.arrays import Array, Integers
from fefinger.view.figures import (
    COLORS,
    INK,
    STEEL,
    WIDE,
    figure,
    of_each,
    palmar_triangles,
    style,
)


BIN = 60  # bins of the histogram over the whole time

LEAST = 0.02
"""Share of the highest pressure from which on the pad is drawn as pressed."""


def raster(result: ResultRecord) -> Any:
    """Draw the spikes of a population by type, nearest to the first touch on top, and its rates."""
    trains = result.spikes
    assert trains is not None
    kinds, end = of_each(trains.types), trains.t_stop
    edges = np.linspace(trains.t_start, end, BIN + 1)
    with style():
        drawn = figure(WIDE, 1.2 + 1.3 * len(kinds) + 1.6)
        heights = [max(0.8, len(which) / len(trains) * len(kinds)) for which in kinds.values()]
        axes = drawn.subplots(
            len(kinds) + 2, 1, sharex=True, height_ratios=[*heights, 0.9, 0.6], squeeze=False
        )[:, 0]
        for axis, (kind, which) in zip(axes, kinds.items(), strict=False):
            color = COLORS.get(kind, INK)
            if trains.positions is not None:
                away = np.linalg.norm(trains.positions[which], axis=1)
                which = which[np.argsort(away, kind="stable")]
            rows = [trains.times[i] for i in which]
            axis.eventplot(rows, colors=color, linelengths=1.0, linewidths=1.0)
            axis.set(ylabel=f"{kind}\n{len(which)} units", yticks=[], ylim=(len(which) - 0.5, -0.5))
            axis.grid(visible=False)
            counts = np.histogram(np.concatenate([np.empty(0), *rows]), edges)[0]
            axes[-2].stairs(counts / (len(which) * np.diff(edges)), edges, color=color, label=kind)
        axes[-2].set_ylabel("mean rate\n/ Hz")
        axes[-2].legend(ncols=len(kinds), loc="upper right")
        axes[-1].plot(result.time, result.depth, color=STEEL)
        axes[-1].set(ylabel="depth\n/ mm", xlabel="time / s", xlim=(trains.t_start, end))
        return drawn


def rate_map(result: ResultRecord) -> Any:
    """Draw the places of the units seen from below, colored by their rate over the whole time."""
    trains = result.spikes
    assert trains is not None
    assert trains.positions is not None
    kinds = of_each(trains.types)
    rates = mean_rates(trains)
    across = trains.positions[:, :2]
    seen = np.concatenate([across, _pressed(result)])
    low, high = seen.min(axis=0) - 0.8, seen.max(axis=0) + 0.8
    with style():
        drawn = figure(WIDE, 2.1 + 3.2 / len(kinds))
        axes = drawn.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
        for axis, (kind, which) in zip(axes, kinds.items(), strict=True):
            _outline(axis, result)
            top = max(float(rates[which].max()), 1e-9)
            dots = axis.scatter(
                *across[which].T, c=rates[which], s=22, cmap="viridis", vmin=0.0, vmax=top, zorder=3
            )
            axis.set(xlabel="x (distal) / mm", title=f"{kind}: {len(which)} units", aspect="equal")
            axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
            drawn.colorbar(dots, ax=axis, label="rate / Hz", shrink=0.8)
        axes[0].set_ylabel("y (radial) / mm")
        return drawn


def receptive_fields(
    places: Array, spacing: float, impulses: Mapping[str, Integers], organs: Mapping[str, Array]
) -> Any:
    """Draw impulses (n,) of units by the place (n, 2) mm of the object, and their end organs.

    The places are some of those of a square grid about 0, 0, `spacing` mm apart.
    """
    steps = np.round(places / spacing).astype(int)
    most = int(np.abs(steps).max())
    extent = (-(most + 0.5) * spacing, (most + 0.5) * spacing) * 2
    column, row = steps.T + most
    with style():
        drawn = figure(WIDE, 2.1 + 3.2 / len(impulses))
        axes = drawn.subplots(1, len(impulses), sharey=True, squeeze=False)[0]
        for axis, (kind, counts) in zip(axes, impulses.items(), strict=True):
            square = np.full((2 * most + 1, 2 * most + 1), np.nan)
            square[row, column] = counts
            shown = axis.imshow(square, origin="lower", extent=extent, cmap="viridis", vmin=0)
            axis.plot(*organs[kind].T, "o", ms=4, mfc="none", color="white")
            axis.set(xlabel="x (distal) / mm", title=f"{kind}: end organs as circles")
            axis.grid(visible=False)
            drawn.colorbar(shown, ax=axis, label="impulses", shrink=0.8)
        axes[0].set_ylabel("y (radial) / mm")
        return drawn


def _pressed(result: ResultRecord) -> Array:
    """Return the places x, y (n, 2) mm of the pad that are pressed at the peak of the press."""
    if result.pad is None or result.pressure is None:
        return np.zeros((0, 2))
    pressure = result.pressure[result.peak]
    return result.pad.points[pressure > LEAST * pressure.max(), :2]


def _outline(axis: Any, result: ResultRecord) -> None:
    """Draw where the pad is pressed at the peak of the press."""
    if result.pad is None or result.pressure is None:
        return
    pressure = result.pressure[result.peak]
    if pressure.max() > 0:
        levels = np.linspace(LEAST, 1.0, 6) * pressure.max()
        corners = *result.pad.points[:, :2].T, palmar_triangles(result.pad)
        axis.tricontourf(*corners, pressure, levels=levels, cmap="Greys", alpha=0.35)
