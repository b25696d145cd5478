"""Which measure of the strain could drive SAI: every drive, on the experiments, without a unit.

Under the middle of a round object, or of an array of probes, the strain of nearly incompressible
skin is -e along the normal and e / 2 across: each measure is then a multiple of e, and none can
change how spheres, pins, plates and arrays compare. Measures differ beside the middle alone; what
else there is to choose is the depth of the end organs.

Of slow presses of the probe, the plateau was steady, or its depth changed by 15 % in the first 12 s
of a hold (J Neurosci 3:2652, abstract).
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from fefinger.validation.afferents import data, experiments, patterns, predicted
from fefinger.validation.afferents.vibration import Probed, determination
from scipy.optimize import isotonic_regression

from fefinger.neural.recorded import Recorded
from fefinger.scene.textured import Grating
from fefinger.support.arrays import Array
from fefinger.support.vocabulary import DRIVES


HELD = 0.06
"""Time in s from which spheres are held."""

CANDIDATES = (
    *((drive, experiments.DEPTHS["SAI"]) for drive in DRIVES),
    *(("compressive", depth) for depth in (0.3, 0.6, 0.8)),
)
"""Measures, and depths in mm of the end organs."""


@dataclass(frozen=True)
class Measured:
    """How a measure goes with recorded rates of SAI.

    rising: relative RMS error of rates under spheres about the best rising function of it; along
    R² over distance of the best straight line, fitted to those rates; trough: of that line between
    the edges of the bar, over its peaks; suppression: fall of the strain by each further probe.
    """

    rising: float
    distance: float
    trough: float
    suppression: float


def measured(drive: str, organ: float) -> Measured:
    """Measure a drive at end organs `organ` mm deep."""
    points = data.table("curvature_SAI")
    rates = points[:, 2]
    under = np.array([_held(c, force, np.zeros(1), drive, organ)[0] for force, c, _ in points])
    order = np.argsort(under)
    best = isotonic_regression(rates[order]).x
    line = np.polyfit(under, rates, 1, w=1.0 / rates)
    profile, computed = data.table("curvature_distance_SAI"), []
    for curvature, distance, _ in profile:
        around = np.abs(distance + np.array([0.0, -predicted.REACH, predicted.REACH]))
        computed.append(_held(curvature, 0.147, around, drive, organ).max())
    places = np.arange(-4.0, 4.01, 0.2)
    across = np.column_stack([places, np.zeros_like(places)])
    shape = patterns.heights(experiments.BAR.profile)
    bar = patterns.driven(shape, 1.0, across, drive=drive, organ=organ)
    return Measured(
        float(np.sqrt(np.mean((best / rates[order] - 1.0) ** 2))),
        determination(np.maximum(np.polyval(line, computed), 0.0), profile[:, 2]),
        predicted.edges(places, np.maximum(np.polyval(line, bar), 0.0)).ratio,
        predicted.strain_suppression(drive, organ, predicted.BACKGROUND),
    )


def _held(curvature: float, force: float, places: Array, drive: str, organ: float) -> Array:
    time, driven = experiments.under_sphere(curvature, force, places, drive=drive, organ=organ)
    return np.asarray(driven[time >= HELD].mean(axis=0))


@cache
def modulation(drive: str, organ: float, period: float) -> float:
    """Range of a drive over a grating pressed 1 mm deep, over the sum of its highest and lowest."""
    places = np.zeros((12, 2))
    places[:, 0] = period * np.arange(12) / 12
    shape = patterns.heights(Grating(period=period, ridge=period / 2, depth=0.4).profile)
    drives = patterns.driven(shape, 1.0, places, drive=drive, organ=organ)
    return float(np.ptp(drives) / (drives.max() + drives.min()))


def table() -> dict[str, object]:
    """Return the table of all candidates for the page."""
    rows = []
    for drive, organ in CANDIDATES:
        measures = measured(drive, organ)
        rows.append(
            (
                drive,
                f"{organ:g}",
                f"{100 * measures.rising:.2g} %",
                f"{measures.distance:.2f}",
                f"{measures.trough:.2f}",
                f"{measures.suppression:.2f}",
            )
        )
    return {
        "caption": "What could drive SAI, before any model of a unit: measures of the strain, by "
        "the depth of the end organs. RMS error of the rates under spheres about their best rising "
        "function; R² over distance of the straight line fitted to those rates; trough of the bar "
        "over its peaks by that line (recorded: 0.1); fall of the strain by each further probe "
        "(recorded: 0.24 of the response)",
        "heading": ("measure", "depth / mm", "spheres", "distance", "trough", "per probe"),
        "rows": rows,
    }


FALLS: dict[float, tuple[float, float]] = {
    0.0: (0.38, 0.36),
    -0.15: (0.47, 0.46),
    0.15: (0.26, 0.22),
}
"""Recorded falls at DEPTHS, by the part by which the depth changes in 12 s; the steady ones are
fitted, the others predicted."""

DEPTHS = (0.65, 1.3)
"""Depths in mm of the holds."""

LASTING = 12.0
"""Length in s of the hold that is looked at."""

SPEED = 0.4
"""Speed in mm/s of the presses before."""

TRIALS = 6
"""Repetitions of a hold, each with noise of its own."""


@cache
def driven(drift: float) -> tuple[Array, Array]:
    """Time (n_t,) s and drives (n_t, n) of SAI in holds at DEPTHS that drift by a part of them."""
    depths = np.linspace(0.0, 1.5, 31)
    below = experiments.pressed(
        experiments.PROBE,
        depths[1:],
        np.zeros(1),
        drive="compressive",
        organ=experiments.DEPTHS["SAI"],
    )[:, 0]
    deep = np.array(DEPTHS)
    time = np.linspace(0.0, deep.max() / SPEED + LASTING + 1.0, 1601)
    since = time[:, None] - deep / SPEED
    moved = np.minimum(SPEED * time[:, None], deep)
    moved = moved * (1.0 + drift * np.clip(since / LASTING, 0.0, 1.0))
    return time, np.interp(moved, depths, np.concatenate([[0.0], below]))


def falls(unit: Recorded, drift: float = 0.0) -> Array:
    """Falls (n,) of the rate of the unit in the first 12 s of the holds at DEPTHS."""
    time, drives = driven(drift)
    x = unit.length * np.repeat(drives, TRIALS, axis=1)
    times = Probed("SAI", unit, 0.0).fire(time, x, np.ones(x.shape[1]))
    out = []
    for i, depth in enumerate(DEPTHS):
        since = np.concatenate(times[i * TRIALS : (i + 1) * TRIALS]) - depth / SPEED
        first, late = (
            int(np.count_nonzero((since >= t) & (since < t + 1.0))) for t in (0.0, LASTING - 0.5)
        )
        out.append(1.0 - late / max(first, 1))
    return np.array(out)
