"""Figures of suite `afferents`: every fitted and predicted curve over the published points."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from fefinger.validation.afferents import data, measures, predicted
from fefinger.validation.afferents.fit import FREE
from fefinger.validation.afferents.vibration import Probed
from fefinger.validation.panels import panel, panels

from fefinger.neural.recorded import BOUNDS
from fefinger.scene import builtin
from fefinger.studies.receptive_field import receptive_field
from fefinger.support.arrays import Array
from fefinger.view.figures import COLORS, INK, STEEL, figure


KINDS = ("SAI", "FAI", "FAII")

INSENSITIVE = 1e-9
"""Standard error over the value, below which no residual depends on a parameter."""


def figures(probed: Callable[[str], Probed], under_spheres: Array) -> Iterator[tuple[str, Any]]:
    """Yield caption and figure of all curves."""
    yield (
        "Fitted: mean rate against amplitude. Points: recorded means over units; lines: the mean "
        "of the population (thick) and the median unit alone (thin)",
        _rates(probed),
    )
    yield (
        "Fitted: thresholds of single units (points, shapes alone were fitted) and of the median "
        "unit without noise (lines, moved to the mean of the points; the factor is stated)",
        _thresholds(probed),
    )
    yield (
        "Fitted: SAI impulses in the first second under spheres at 10, 15 and 20 gf (points: "
        "recorded; lines: computed)",
        _spheres(under_spheres),
    )
    yield (
        "Predicted: SAI by curvature and distance at 15 gf. Lines: units with end organs within "
        "1 mm, which the best of them drives",
        _distances(),
    )
    yield (
        "Predicted: SAI across a bar 3 mm wide, 1 mm deep (gray: recorded; dark: computed, one "
        "end organ)",
        _bar(),
    )
    yield (
        "Predicted: SAI in the hold of pins 1 mm (blue) and 2 mm wide (dark), of the median unit "
        "and of one whose gain puts the wide pin in the middle of the band at 1.5 mm (dashed); "
        "pale: bands of four models of TouchSim under the same pins",
        _pins(),
    )
    yield (
        "Predicted: impulses under one to seven probes that rise by 0.1 mm out of an array 1.6 mm "
        "deep, over those under one. Lines: recorded means of -24 and -12 % by each further probe",
        _surround(),
    )
    yield (
        "Predicted: receptive fields of one unit of SAI and FAI: impulses as a pin 1 mm wide is "
        "pressed 1 mm at places around it, at small strain (`fefinger field`)",
        receptive_field(
            builtin.load("pin-hold", {"indenter.width": 1.0, "finger.tissue": "maeno1998"}),
            reach=3.0,
            spacing=1.0,
            mechanics="condensed",
        ).figure(),
    )
    yield (
        "Predicted: units under a pin 1 mm wide, pressed 0.7 mm at 20 mm/s, held for 1 s and "
        "withdrawn: eight units of each type with the fitted spread and noise",
        _rasters(),
    )


def _rates(probed: Callable[[str], Probed]) -> Any:
    drawn, axes = panels(9.6, 6.4, 3, 4, sharex="col")
    for row, kind in zip(axes, KINDS, strict=True):
        for axis, frequency in zip(row, data.FREQUENCIES, strict=True):
            amplitude, rates = data.rates(kind, frequency)
            axis.plot(1e3 * amplitude, rates, "o", ms=3, color=COLORS[kind])
            unit = probed(kind)
            axis.plot(1e3 * amplitude, unit.rates(frequency, amplitude), color=INK, lw=1.4)
            single = unit.rates(frequency, amplitude, single=True)
            axis.plot(1e3 * amplitude, single, color=STEEL, lw=0.7)
            axis.set_xscale("log")
            if kind == "SAI":
                axis.set_title(f"{frequency:g} Hz")
            if kind == "FAII":
                axis.set_xlabel("amplitude / um")
        row[0].set_ylabel(f"{kind} / Hz")
    return drawn


def _thresholds(probed: Callable[[str], Probed]) -> Any:
    drawn, axis = panel(6.2, 3.6, xlabel="frequency / Hz", ylabel="threshold / um")
    for kind in KINDS:
        frequency, amplitude = data.thresholds(kind)
        computed = probed(kind).thresholds(frequency)
        factor = float(np.exp(np.mean(np.log(amplitude / computed))))
        axis.loglog(frequency, 1e3 * amplitude, "o", ms=3, color=COLORS[kind])
        label = f"{kind}, times {factor:.2g}"
        axis.loglog(frequency, 1e3 * factor * computed, color=COLORS[kind], label=label)
    axis.legend()
    return drawn


def _spheres(computed: Array) -> Any:
    points = data.table("curvature_SAI")
    drawn, axis = panel(6.2, 3.6, xlabel="curvature / (1/m)", ylabel="impulses in 1 s")
    for force, shade in zip(np.unique(points[:, 0]), (0.7, 0.4, 0.0), strict=True):
        of = points[:, 0] == force
        color = (shade, shade, shade)
        axis.plot(points[of, 1], points[of, 2], "o", ms=4, color=color)
        axis.plot(points[of, 1], computed[of], color=color, label=f"{force:g} N")
    axis.legend()
    return drawn


def _distances() -> Any:
    points = data.table("curvature_distance_SAI")
    computed, recorded = predicted.spheres()
    drawn = figure(9.6, 2.6)
    curvatures = np.unique(points[:, 0])
    axes = drawn.subplots(1, len(curvatures), sharey=True)
    for axis, curvature in zip(axes, curvatures, strict=True):
        of = points[:, 0] == curvature
        axis.plot(points[of, 1], recorded[of], "o", ms=3, color=COLORS["SAI"])
        axis.plot(points[of, 1], computed[of], color=INK)
        axis.set_title(f"{curvature:g} 1/m")
        axis.set_xlabel("distance / mm")
    axes[0].set_ylabel("impulses in 1 s")
    return drawn


def _bar() -> Any:
    drawn, axis = panel(6.2, 3.6, xlabel="place from the middle of the bar / mm", ylabel="SAI / Hz")
    axis.plot(*predicted.bar_recorded(), color=STEEL, lw=1.0)
    axis.plot(*predicted.bar_profile(), color=INK)
    return drawn


def _pins() -> Any:
    drawn, axis = panel(6.2, 3.6, xlabel="depth / mm", ylabel="SAI, 0.3 to 0.9 s / Hz")
    for width, color in ((1.0, COLORS["SAI"]), (2.0, INK)):
        for depth, band in zip(predicted.PIN_DEPTHS, predicted.PIN_BANDS[width], strict=True):
            axis.plot([depth, depth], band, color=color, alpha=0.3, lw=6.0)
        for factor, dashes in ((1.0, "o-"), (predicted.pin_factor(), "o--")):
            rates = predicted.pin_hold(width, factor)
            label = f"{width:g} mm, gain times {factor:.2g}"
            axis.plot(predicted.PIN_DEPTHS, rates, dashes, color=color, label=label)
    axis.legend()
    return drawn


def _surround() -> Any:
    probes = np.arange(1, 8)
    drawn, axis = panel(6.2, 3.6)
    for kind, part in (("SAI", 0.24), ("FAI", 0.12)):
        counts = predicted.surround(kind)
        axis.plot(probes, counts / counts[0], "o", color=COLORS[kind], label=kind)
        axis.plot(probes, (1.0 - part) ** (probes - 1), color=COLORS[kind], lw=0.8)
    axis.set(xlabel="probes", ylabel="response over that to one", ylim=(0.0, 1.15))
    axis.legend()
    return drawn


def _rasters() -> Any:
    drawn, (top, axis) = panels(6.2, 3.6, 2, 1, sharex=True, height_ratios=(1, 3))
    time, depth = predicted.trapezoid(0.7, 20.0, 1.0)
    top.plot(time, depth, color=STEEL)
    top.set_ylabel("mm")
    row = 0
    for kind in KINDS:
        for times in predicted.population_under_pin(kind, time, depth):
            axis.plot(times, np.full(len(times), row), "|", ms=5, color=COLORS[kind])
            row += 1
    axis.set(xlabel="time / s", yticks=[3.5, 11.5, 19.5], yticklabels=KINDS)
    return drawn


def finding(record: dict[str, Any]) -> dict[str, Any]:
    """Return texts and a table of the parameters with their errors."""
    rows = []
    for name, bounds in BOUNDS.items():
        cells = []
        for kind in ("SAI", "SAII", "FAI", "FAII"):
            part = record["types"][kind][name]
            cells.append(f"{part['value']:.4g}{_error(part)}")
        rows.append((f"{name}: {bounds.meaning}", bounds.unit, *cells))
    return {
        "texts": (*TEXTS, _limited(record)),
        "tables": [
            {
                "caption": "Parameters of the family recorded, with standard errors where fitted; "
                "free: the data do not identify it, its error is as large as the value, or no "
                "residual depends on it",
                "heading": ("parameter", "unit", "SAI", "SAII", "FAI", "FAII"),
                "rows": rows,
            },
            measures.table(),
        ],
    }


def _error(part: dict[str, Any]) -> str:
    """Return the standard error of a parameter, where it was fitted."""
    value, error = part["value"], part["error"]
    if error is None:
        return ""
    return f" ± {error:.2g}" if INSENSITIVE * value < error < value else " (free)"


def _limited(record: dict[str, Any]) -> str:
    """Sentence on the fitted parameters that lie at a limit of the search."""
    lists = []
    for kind, ranges in FREE.items():
        values = {name: record["types"][kind][name]["value"] for name in ranges}
        near = [
            name
            for name, limits in ranges.items()
            if min(abs(np.log(values[name] / limit)) for limit in limits) < 0.02
        ]
        lists.append(f"{kind}: {', '.join(near) or 'none'}")
    return (
        "Fitted parameters at a limit of their search, within which the data do not hold them: "
        f"{'; '.join(lists)}."
    )


TEXTS = (
    "Use the family recorded for rates, timing and entrainment of afferents under probes, spheres, "
    "edges and vibration. Use the family thesis to reproduce the source document, or where a "
    "membrane model with its block and its kinetics is the question.",
    "Neither family has: SAII under a probe (recorded rests on stretch of hairy skin), slip, heat, "
    "or waves in the skin. Above some 40 Hz the tissue of the model does not damp, and no inertia "
    "moves it: a vibrating probe strains as a slow one does.",
    "Trust of recorded: timing and entrainment of FAI and FAII from 20 to 600 Hz, bursts at onset "
    "and release, SAI by curvature, force and distance, edges, and holds of pins. With care: "
    "absolute rates of SAI in a hold of a blunt object, which under a pin 2 mm wide are up to 1.5 "
    "times those of the fastest model of TouchSim. Not: FAII in ramps, at slip and far from "
    "the object, and the jitter, set by hand.",
    "Spheres are held with a force, and the strain under a force depends on the modulus: on "
    "maeno1998, three times as stiff at small forces as the four measured fingers, SAI units came "
    "out four times as sensitive as those of the models behind the bands of pins. On the tissue "
    "calibrated on those fingers, at finite strain, the 21 rates under spheres lie on one rising "
    "function of the strain within 1.1 % RMS. On maeno1998 no rising function comes nearer than "
    "12 %.",
    "Probes and pins are pressed at finite strain on that tissue too. At small strain, on tissue "
    "that does not stiffen, the end organ of SAI under a pin 1 mm wide is strained 1.4 to 1.9 "
    "times as much, under the sphere of 2.94 mm and a plate 0.5 to 0.7 times. Units whose gains "
    "came from vibrations of the pin at small strain and from spheres at finite strain had a "
    "static gain twice too large beside the dynamic one: they fired two to four times as much as "
    "those models in holds of that pin, and a third as much as recorded units over scanned dots, "
    "where strains at small and at finite strain differ by 15 % alone.",
    "What else could drive SAI is in the table of measures. Under the middle of a round object the "
    "strain of nearly incompressible skin is -e along the normal and e / 2 across: every measure "
    "is a multiple of e, so that none changes how spheres, pins, plates and arrays of probes "
    "compare. Beside the middle energy and von Mises strain are as good as compression; tensile "
    "strain has the deeper trough, and the larger error under spheres. None is better as a whole. "
    "A drive less 0.3 to 0.9 of the mean strain a millimeter around it was tried: it suppresses "
    "more, and fires under the pin 2 mm wide the less, the deeper that goes. Suppression by "
    "neighbors and rates over scanned dots, which seemed to ask for it, come with the probes "
    "separate, and with units that have several end organs and have adapted to the scan.",
    "In an earlier fit, with pins at small strain: end organs 0.4 and 0.6 mm deep, each fitted "
    "anew: 13 and 15 % RMS under spheres, a trough of the bar of 0.24 and 0.43, and 22 and 33 Hz "
    "under the pin 2 mm wide at 1 mm; 0.5 mm is between. The mean strain over a disc of 0.5, 1 or "
    "1.5 mm around an end organ: 14, 16 and 19 % RMS, 38, 58 and 52 Hz under that pin, a trough of "
    "0.43, 0.57 and 0.82. Linear tissue a fifth as stiff: strains above 1 under spheres.",
    "Here end organs are 0.45 mm deep, where fit, bar and pin agree best; its edges and that pin "
    "helped to choose among these depths. FAI and FAII weigh a retreat by at least 0.6 and 0.5 of "
    "an advance, so that they fire at slow releases too. It weighs the saturated current: "
    "strong vibrations keep FAII firing (600 Hz, 0.5 mm). Noise fades with the current of the "
    "generator: FA are silent in slow presses, however long. Of the current of SAI a third "
    "remains after minutes: in shallow holds they then fall silent, as under the resting probe of "
    "the vibrations.",
    "All experiments are pressed through the mechanics of the package on one macaque fingertip "
    "(10 mm wide, 8 mm thick, effective radius 10 mm, an estimate): pins and spheres by pressed, "
    "at finite strain on a coarse mesh (strain within 4 % of the standard one under spheres, 20 % "
    "under the pin 1 mm wide), the bar and the array of probes, finer than the elements of 0.6 mm, "
    "on the exact layers by Fourier transforms, at small strain "
    "(`validation/afferents/patterns.py`). The preload of the vibrating probe and the rest of the "
    "array count as held for two minutes, after which SAI units have adapted to it.",
    "The array of probes has 73 sites on 50 mm² (Vega-Bermudez & Johnson 1999), with the skin free "
    "between them; that a probe is 0.5 mm wide is an estimate. Probes 0.3 and 0.7 mm wide take "
    "0.18 and 0.30 of the strain of SAI away, each further one; a grid twice as fine changes that "
    "by 0.005.",
)
