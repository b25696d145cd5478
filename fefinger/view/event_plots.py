"""Figures of a finger that slides: spikes on the object, rates along it, friction."""

from typing import Any

import numpy as np

from fefinger.geometry.profiles import frame
from fefinger.results.records import Lateral
from fefinger.results.result_record import ResultRecord
from fefinger.support.arrays import Array, Integers
from fefinger.view.figures import COLORS, INK, STEEL, WIDE, figure, of_each, style
from fefinger.view.indenter_pose import pose


BEYOND = 1.0  # mm of the object shown beyond the spikes
PIXEL = 0.1  # mm
BIN = 0.5  # mm of a rate along the object
LINES = 5  # scan lines with curves of their own
STANDSTILL = 1e-3  # part of the largest speed below which the object stands


def over_object(result: ResultRecord) -> tuple[Array, Array]:
    """Return the places of the units on the object at rest, and their displacement in time.

    Places (n, 2) and (n_t, 2) mm in the object's own x and y.
    """
    trains, lateral = result.spikes, result.lateral
    assert trains is not None
    assert trains.positions is not None
    assert lateral is not None
    first = pose(result, 0.0)
    across = frame(first.axis)[:2]
    turn = first.frame[:2] @ across.T
    places = (trains.positions - first.origin) @ across.T @ turn.T
    return places, -lateral.shift @ turn.T


def places(result: ResultRecord, units: Integers) -> tuple[Array, Array]:
    """Return the places (n_spikes, 2) mm on the object of all spikes of units, and their times.

    Times in s at the end organs, before the conduction delays: that is when the object is where it
    made the unit fire.
    """
    trains = result.spikes
    assert trains is not None
    start, path = over_object(result)
    times = [trains.at_end_organs(i) for i in units.tolist()]
    along = np.concatenate(
        [np.repeat(start[i : i + 1], len(t), 0) for i, t in zip(units, times, strict=True)]
    )
    every = np.concatenate([np.empty(0), *times])
    moved = np.column_stack([np.interp(every, result.time, path[:, k]) for k in (0, 1)])
    return along + moved, every


def events(result: ResultRecord) -> Any:
    """Draw the spikes of each type at their places on the object, over its heights."""
    trains = result.spikes
    assert trains is not None
    kinds = of_each(trains.types)
    start, path = over_object(result)
    moving = result.time >= trains.t_start
    low = start.min(axis=0) + path[moving].min(axis=0) - BEYOND
    high = start.max(axis=0) + path[moving].max(axis=0) + BEYOND
    x, y = (np.arange(low[k], high[k], PIXEL) for k in (0, 1))
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


def scan_lines(result: ResultRecord) -> Any:
    """Draw the rate of each type along the object, on scan lines and in the mean of all of them."""
    trains = result.spikes
    assert trains is not None
    kinds = of_each(trains.types)
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


def lines(result: ResultRecord, which: Integers) -> dict[float, Integers]:
    """Return the units of up to LINES scan lines, by their place across the path in mm."""
    start, path = over_object(result)
    x, y = _heading(path)
    across = np.round(start[which] @ np.array([-y, x]), 3) + 0.0  # no -0.0
    levels = np.unique(across)
    chosen = levels[np.unique(np.linspace(0, len(levels) - 1, LINES).round().astype(int))]
    return {float(level): which[np.abs(across - level) < 1e-3] for level in chosen.tolist()}


def _heading(path: Array) -> Array:
    """Return the unit vector (2,) to the farthest place of a path; that of x where it stands."""
    away = path - path[0]
    far = away[int(np.argmax(np.hypot(*away.T)))]
    length = float(np.hypot(*far))
    return far / length if length > 0 else np.array([1.0, 0.0])


def rates(result: ResultRecord, units: Integers) -> tuple[Array, Array]:
    """Return edges (n + 1,) mm of bins along the path on the object, and mean rates (n,) Hz.

    Spikes over the time that the units have spent in a bin while the object moved.
    """
    trains = result.spikes
    assert trains is not None
    start, path = over_object(result)
    heading = _heading(path)
    steps = np.diff(result.time)
    middle = (result.time[1:] + result.time[:-1]) / 2
    speed = np.hypot(*np.diff(path, axis=0).T) / np.where(steps > 0, steps, np.inf)
    counted = (middle >= trains.t_start) & (speed > STANDSTILL * speed.max(initial=0.0))
    along = (path[1:] + path[:-1]) @ heading / 2
    offset = start[units] @ heading
    every = (offset[:, None] + along[counted]).ravel()
    if every.size == 0:
        return np.array([0.0, BIN]), np.zeros(1)
    edges = np.arange(np.floor(every.min() / BIN), np.ceil(every.max() / BIN) + 1) * BIN
    spent = np.histogram(every, edges, weights=np.tile(steps[counted], len(units)))[0]
    spots, times = places(result, units)
    at = np.clip(np.searchsorted(result.time, times, side="right") - 1, 0, len(counted) - 1)
    count = np.histogram(spots[counted[at]] @ heading, edges)[0]
    return edges, np.divide(count, spent, out=np.zeros(len(spent)), where=spent > 0)


def sideways(result: ResultRecord) -> Any:
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
            _grip(axes[2], result, lateral)
        axes[-1].set_xlabel("time / s")
        return drawn


def _grip(axis: Any, result: ResultRecord, lateral: Lateral) -> None:
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
