"""Figures of suite `human`: curves of the finger over what was measured on people."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from fefinger.validation.human.presses import PROFILES, REPORT
from fefinger.validation.panels import panels

from fefinger.mechanics.evidence.presses import read
from fefinger.results.records import Response
from fefinger.support.arrays import Array
from fefinger.view.figures import INK, STEEL, figure


WIDE, HIGH = 8.0, 3.2  # inches

AREA_AT_10, DEPTH_AT_5 = 0.60, 0.82


def figures(subjects: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure: loading, relaxation, deep presses, pressure along the finger."""
    yield (
        "Force against depth at 60 mm/s: `pressed` (line), and the law measured on the subject "
        "(dashed, Table 2.1 of Pawluk 1997).",
        _loading(subjects),
    )
    yield (
        "Force over its peak after a ramp at 60 mm/s: `pressed` (line) and the subject (dashed).",
        _relaxing(subjects),
    )
    yield (
        "Displacement over that at 5.2 N and contact area over that at 10 N, against force: the "
        "default finger and the one of mean size (lines), with the published ratios (points).",
        _deep(),
    )
    yield (
        "Pressure along the middle of the pad of the mean finger under held forces, means over 1 "
        "mm; dashed: the "
        "highest pressure and the contact radius of the source's model (Pawluk 1997, Table 3.2).",
        _profiles(),
    )


def _loading(subjects: Mapping[str, Any]) -> Any:
    drawn = figure(WIDE, HIGH)
    for axis, (name, (response, (depth, force))) in zip(
        drawn.subplots(1, len(subjects)), subjects.items(), strict=True
    ):
        up = slice(0, int(np.argmax(response.force)) + 1)
        axis.plot(response.depth[up], response.force[up], color=STEEL)
        axis.plot(depth[up], force[up], color=INK, ls="--", lw=0.9)
        axis.set_title(name)
        axis.set_xlabel("depth / mm")
    drawn.axes[0].set_ylabel("force / N")
    return drawn


def _relaxing(subjects: Mapping[str, Any]) -> Any:
    drawn = figure(WIDE, HIGH)
    pairs = zip(drawn.subplots(1, len(subjects), sharey=True), subjects.items(), strict=True)
    for axis, (name, (response, (_, force))) in pairs:
        _relaxing_one(axis, response, force)
        axis.set_title(name)
        axis.set_xlabel("time after the peak / s")
    drawn.axes[0].set_ylabel("force / peak")
    return drawn


def _relaxing_one(axis: Any, response: Response, force: Array) -> None:
    for values, look in ((response.force, {"color": STEEL}), (force, {"color": INK, "ls": "--"})):
        top = int(np.argmax(values))
        axis.semilogx(
            (response.time - response.time[top])[top + 1 :], values[top + 1 :] / values[top], **look
        )
    axis.set_ylim(0, 1)


def _deep() -> Any:
    drawn, (left, right) = panels(WIDE, HIGH, 1, 2)
    for look, (name, row) in zip(("-", ":"), read(REPORT)["deep"].items(), strict=True):
        if "refused" in row:
            continue
        force, depth, area = (np.array(row[key]) for key in ("force_N", "depth_mm", "area_mm2"))
        last = min(5.2, force[-1])
        left.plot(force, depth / np.interp(last, force, depth), look, color=STEEL, label=name)
        last = min(10.0, force[-1])
        right.plot(force, area / np.interp(last, force, area), look, color=STEEL, label=name)
    left.plot([1.0, 5.2], [DEPTH_AT_5, 1.0], "o", color=INK)
    right.plot([1.0, 10.0], [AREA_AT_10, 1.0], "o", color=INK)
    left.set_ylabel("displacement over that at 5.2 N")
    right.set_ylabel("contact area over that at 10 N")
    left.set_xlim(0, 6)
    for axis in (left, right):
        axis.set_xlabel("force / N")
        axis.legend()
    return drawn


def _means(x: Array, pressure: Array) -> tuple[Array, Array]:
    """Return the middles and the mean pressures (n,) of intervals of 1 mm."""
    cell = np.floor(x + 0.5)
    places = np.unique(cell)
    return places, np.array([pressure[cell == place].mean() for place in places])


def _profiles() -> Any:
    drawn = figure(WIDE, HIGH)
    pairs = zip(drawn.subplots(1, len(PROFILES)), PROFILES.items(), strict=True)
    for axis, (force, (_, radius, highest)) in pairs:
        row = read(REPORT)["held"][force]
        axis.plot(*_means(np.array(row["x_mm"]), np.array(row["pressure_kPa"])), color=STEEL)
        x = np.linspace(-radius, radius, 101)
        axis.plot(x, highest * np.sqrt(1 - (x / radius) ** 2), color=INK, ls="--", lw=0.9)
        axis.set_title(f"{force} N")
        axis.set_xlabel("x / mm, toward the tip")
        axis.set_xlim(-9, 9)
    drawn.axes[0].set_ylabel("pressure / kPa")
    return drawn
