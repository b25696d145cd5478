"""Which measure of the strain could drive SAI: every drive, on the experiments, without a unit.

Under the middle of a round object, or of an array of probes, the strain of nearly incompressible
skin is -e along the normal and e / 2 across: each measure is then a multiple of e, and none can
change how spheres, pins, plates and arrays compare. Measures differ beside the middle alone; what
else there is to choose is the depth of the end organs.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from fefinger.validation.afferents import data, experiments, patterns, predicted
from fefinger.validation.afferents.vibration import determination
from scipy.optimize import isotonic_regression

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
