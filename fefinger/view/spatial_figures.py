"""Figures over place: pressure, spikes and receptive fields of units, and an object that slides.

`figures` draws the few units of an ordinary scene against time.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.profiles import frame
from fefinger.neural.statistics import mean_rates
from fefinger.results.records import Lateral, Pad
from fefinger.results.result_record import ResultRecord
from fefinger.support.arrays import Array, Integers
from fefinger.view import quantities
from fefinger.view.figures import (
    COLORS,
    INK,
    STEEL,
    WIDE,
    figure,
    of_each,
    style,
)
from fefinger.view.frames import pose


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from fefinger.neural.trains import SpikeTrains


PLACE_BIN = 0.5  # mm of a rate along the object
LINES = 5  # scan lines with curves of their own


def _trains(result: ResultRecord) -> "SpikeTrains":
    assert result.spikes is not None
    return result.spikes


def raster(result: ResultRecord) -> "Figure":
    """Draw the spikes of a population by type, units nearest to first touch on top, and rates."""
    trains = _trains(result)
    kinds, end = of_each(trains.types), trains.t_stop
    edges = np.linspace(trains.t_start, end, 61)  # 60 bins of the histogram
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


def rate_map(result: ResultRecord) -> "Figure":
    """Draw the places of the units seen from below, colored by their rate over the whole time."""
    trains = _trains(result)
    assert trains.positions is not None
    kinds, rates = of_each(trains.types), mean_rates(trains)
    across = seen = trains.positions[:, :2]
    pressure = None
    least = 0.02  # share of the highest pressure from which on the pad is drawn as pressed
    if result.pad is not None and result.pressure is not None:
        pressure = result.pressure[result.peak]
        pressed = result.pad.points[pressure > least * pressure.max(), :2]
        seen = np.concatenate([across, pressed])
    low, high = seen.min(axis=0) - 0.8, seen.max(axis=0) + 0.8
    with style():
        drawn = figure(WIDE, 2.1 + 3.2 / len(kinds))
        axes = drawn.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
        for axis, (kind, which) in zip(axes, kinds.items(), strict=True):
            if result.pad is not None and pressure is not None and pressure.max() > 0:
                levels = np.linspace(least, 1.0, 6) * pressure.max()
                corners = *result.pad.points[:, :2].T, palmar_triangles(result.pad)
                axis.tricontourf(*corners, pressure, levels=levels, cmap="Greys", alpha=0.35)
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
) -> "Figure":
    """Draw the impulses of units against the place of the object, with the units' end organs.

    places (n, 2) mm: some of a square grid about 0, 0 with a `spacing` in mm; by type, impulses
    (n,) and places of the end organs (n_organs, 2) mm.
    """
    steps = np.round(places / spacing).astype(int)
    most = int(np.abs(steps).max())
    edge = (most + 0.5) * spacing
    column, row = steps.T + most
    with style():
        drawn = figure(WIDE, 2.1 + 3.2 / len(impulses))
        axes = drawn.subplots(1, len(impulses), sharey=True, squeeze=False)[0]
        for axis, (kind, counts) in zip(axes, impulses.items(), strict=True):
            square = np.full((2 * most + 1, 2 * most + 1), np.nan)
            square[row, column] = counts
            shown = axis.imshow(
                square, origin="lower", extent=(-edge, edge) * 2, cmap="viridis", vmin=0
            )
            axis.plot(*organs[kind].T, "o", ms=4, mfc="none", color="white")
            axis.set(xlabel="x (distal) / mm", title=f"{kind}: end organs as circles")
            axis.grid(visible=False)
            drawn.colorbar(shown, ax=axis, label="impulses", shrink=0.8)
        axes[0].set_ylabel("y (radial) / mm")
        return drawn


def over_object(result: ResultRecord) -> tuple[Array, Array]:
    """Return the places of the units on the object before it moves, and their path over it.

    Places (n_units, 2) and path (n_t, 2), in mm of the object's own x and y.
    """
    trains = _trains(result)
    assert trains.positions is not None
    assert result.lateral is not None
    first = pose(result, 0.0)
    across = frame(first.axis)[:2]
    turn = first.frame[:2] @ across.T
    return (trains.positions - first.origin) @ across.T @ turn.T, -result.lateral.shift @ turn.T


def places(result: ResultRecord, units: Integers) -> tuple[Array, Array]:
    """Return the places (n_spikes, 2) mm on the object of all spikes of `units`, and their times.

    Times in s are at the end organs, before the conduction delays: the object is then where it made
    the unit fire.
    """
    start, path = over_object(result)
    times = [_trains(result).at_end_organs(i) for i in units.tolist()]
    along = np.repeat(start[units], [len(each) for each in times], axis=0)
    every = np.concatenate([np.empty(0), *times])
    moved = np.column_stack([np.interp(every, result.time, path[:, k]) for k in (0, 1)])
    return along + moved, every


def events(result: ResultRecord) -> "Figure":
    """Draw the spikes of each type at their places on the object, over its heights."""
    trains = _trains(result)
    kinds = of_each(trains.types)
    start, path = over_object(result)
    moving = result.time >= trains.t_start
    beyond = 1.0  # mm of the object shown beyond the spikes
    low = start.min(axis=0) + path[moving].min(axis=0) - beyond
    high = start.max(axis=0) + path[moving].max(axis=0) + beyond
    # Pixels of 0.1 mm of the object.
    x, y = (np.arange(low[k], high[k], 0.1) for k in (0, 1))
    heights = result.scene.indenter.profile.rise(np.stack(np.meshgrid(x, y), axis=-1))
    heights = np.where(np.isfinite(heights), heights, np.nan)
    ratio = float((high[1] - low[1]) / (high[0] - low[0]))
    with style():
        drawn = figure(WIDE, min(len(kinds) * (0.45 + WIDE * ratio), 14.0) + 0.3)
        axes = drawn.subplots(len(kinds), 1, sharex=True, squeeze=False)[:, 0]
        for axis, (kind, which) in zip(axes, kinds.items(), strict=True):
            shown = (low[0], high[0], low[1], high[1])
            axis.imshow(heights, extent=shown, origin="lower", cmap="Greys", alpha=0.35)
            spots, _ = places(result, which)
            units = f"{len(which)} unit{'s' if len(which) > 1 else ''}"
            axis.plot(*spots.T, ".", ms=2.2, color=COLORS.get(kind, INK), rasterized=True)
            axis.set(ylabel="y / mm", title=f"{kind}: {len(spots)} spikes of {units}")
            axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
            axis.grid(visible=False)
        axes[-1].set_xlabel("x on the object / mm")
        return drawn


def scan_lines(result: ResultRecord) -> "Figure":
    """Draw the rate of each type along the object: of units on some scan lines, and of all."""
    kinds = of_each(_trains(result).types)
    with style():
        drawn = figure(WIDE, 0.6 + 1.8 * len(kinds))
        axes = drawn.subplots(len(kinds), 1, sharex=True, squeeze=False)[:, 0]
        for axis, (kind, which) in zip(axes, kinds.items(), strict=True):
            for line, units in lines(result, which).items():
                edges, rate = rates(result, units)
                axis.stairs(rate, edges, lw=0.8, alpha=0.6, label=f"{line:.2g} mm")
            edges, rate = rates(result, which)
            axis.stairs(rate, edges, color=COLORS.get(kind, INK), lw=1.8, label="all")
            axis.set_ylabel(f"{kind}\nrate / Hz")
            # Above the axes: rates reach the top of them all along the path.
            place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.0}
            axis.legend(ncols=LINES + 1, fontsize=7, **place)
        axes[-1].set_xlabel("place along the path on the object / mm")
        return drawn


def lines(result: ResultRecord, units: Integers) -> dict[float, Integers]:
    """Return the units on up to LINES scan lines, by their place across the path in mm."""
    start, path = over_object(result)
    x, y = _heading(path)
    across = np.round(start[units] @ np.array([-y, x]), 3) + 0.0  # no -0.0
    levels = np.unique(across)
    chosen = levels[np.unique(np.linspace(0, len(levels) - 1, LINES).round().astype(int))]
    return {float(level): units[np.abs(across - level) < 1e-3] for level in chosen.tolist()}


def _heading(path: Array) -> Array:
    """Return the unit vector (2,) toward the farthest place of a path (n_t, 2); x without one."""
    away = path - path[0]
    far = away[int(np.argmax(np.hypot(*away.T)))]
    length = float(np.hypot(*far))
    return far / length if length > 0 else np.array([1.0, 0.0])


def rates(result: ResultRecord, units: Integers) -> tuple[Array, Array]:
    """Return edges (n + 1,) mm of bins along the path on the object, and mean rates (n,) Hz.

    A rate is the number of spikes in a bin over the time that the units have spent there while the
    object moved.
    """
    start, path = over_object(result)
    heading, steps = _heading(path), np.diff(result.time)
    middle = (result.time[1:] + result.time[:-1]) / 2
    speed = np.hypot(*np.diff(path, axis=0).T) / np.where(steps > 0, steps, np.inf)
    counted = middle >= _trains(result).t_start
    # The object stands at less than a thousandth of its largest speed.
    counted &= speed > 1e-3 * speed.max(initial=0.0)
    along = (path[1:] + path[:-1]) @ heading / 2
    every = ((start[units] @ heading)[:, None] + along[counted]).ravel()
    if every.size == 0:
        return np.array([0.0, PLACE_BIN]), np.zeros(1)
    first, last = np.floor(every.min() / PLACE_BIN), np.ceil(every.max() / PLACE_BIN)
    edges = np.arange(first, last + 1) * PLACE_BIN
    spent = np.histogram(every, edges, weights=np.tile(steps[counted], len(units)))[0]
    spots, times = places(result, units)
    at = np.clip(np.searchsorted(result.time, times, side="right") - 1, 0, len(counted) - 1)
    count = np.histogram(spots[counted[at]] @ heading, edges)[0]
    return edges, np.divide(count, spent, out=np.zeros(len(spent)), where=spent > 0)


def sideways(result: ResultRecord) -> "Figure":
    """Draw the path of the object, the force along the plate and, with friction, stick and work."""
    lateral = result.lateral
    assert lateral is not None
    gripping = lateral.stick_area is not None
    with style():
        drawn = figure(WIDE, 4.6 if gripping else 3.2)
        axes = drawn.subplots(3 if gripping else 2, 1, sharex=True, squeeze=False)[:, 0]
        names, shades = ("distal", "radial"), (COLORS["SAI"], COLORS["FAI"])
        for k, (name, shade) in enumerate(zip(names, shades, strict=True)):
            axes[0].plot(result.time, lateral.shift[:, k], color=shade, label=name)
            axes[1].plot(result.time, lateral.force[:, k], color=shade, label=name)
        axes[0].set_ylabel("object moved\n/ mm")
        axes[1].set_ylabel("force along\nthe plate / N")
        axes[0].legend(ncols=2)
        if gripping:
            _draw_grip(axes[2], result, lateral)
        axes[-1].set_xlabel("time / s")
        return drawn


def _draw_grip(axis: "Axes", result: ResultRecord, lateral: Lateral) -> None:
    """Draw the part of the contact that sticks, and the work of friction."""
    assert lateral.stick_area is not None
    assert lateral.work is not None
    if result.pad is not None and result.pressure is not None:
        area = (result.pressure > 0) @ result.pad.areas
        part = np.divide(lateral.stick_area, area, out=np.full(len(area), np.nan), where=area > 0)
        axis.plot(result.time, part, color=INK)
        axis.set_ylabel("part of the contact\nthat sticks")
        axis.set_ylim(-0.05, 1.05)
    twin = axis.twinx()
    twin.plot(result.time, lateral.work, color=STEEL)
    twin.set_ylabel("work lost / mJ", color=STEEL)
    twin.grid(visible=False)


def pressure_map(result: ResultRecord) -> "Figure":
    """Draw the pressure on the pad and its centroid at the peak of the press, seen from below."""
    from matplotlib.tri import Triangulation

    assert result.pad is not None
    assert result.pressure is not None
    step = result.peak
    pressure, pad = result.pressure[step], result.pad
    loaded = np.flatnonzero(pressure > 0)
    near = pad.points[loaded if loaded.size else slice(None)]
    low, high = near.min(axis=0) - 2.0, near.max(axis=0) + 2.0
    with style():
        drawn = figure(5.4, 4.6)
        axis = drawn.subplots()
        pad_mesh = Triangulation(pad.points[:, 0], pad.points[:, 1], palmar_triangles(pad))
        drawn_map = axis.tripcolor(
            pad_mesh, pressure, shading="gouraud", rasterized=True,
            cmap=quantities.SKIN_DEEP, vmin=0, vmax=max(pressure.max(), 1e-9),
        )  # fmt: skip
        # The lines of a grid would be one gray.
        if result.meshed:
            axis.triplot(pad_mesh, color=STEEL, linewidth=0.25, alpha=0.5)
        if result.centroid is not None:
            place, color = result.centroid[step], "#0072B2"
            for width, shade in ((4.5, "white"), (2.0, color)):
                axis.plot(*place, marker="+", ms=13, mew=width, color=shade)
            box = {"fc": "white", "ec": "none", "alpha": 0.75, "pad": 1.5}
            axis.annotate(
                "centroid", place, (8, 8), textcoords="offset points", color=color, bbox=box
            )
        axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axis.set(xlabel="x (distal) / mm", ylabel="y (radial) / mm")
        axis.set_title(
            f"t = {result.time[step]:.4g} s: at most {pressure.max():.3g} kPa at "
            f"{result.one_point}, force {result.response.force[step]:.3g} N"
        )
        drawn.colorbar(drawn_map, label="contact pressure / kPa", shrink=0.85)
        return drawn


def palmar_triangles(pad: Pad) -> Integers:
    """Return the triangles (k, 3) of the pad that are seen from below."""
    return pad.triangles[(pad.normals[pad.triangles][:, :, 2] < 0).all(axis=1)]
