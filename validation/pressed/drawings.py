"""Figures of suite `pressed`."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from fefinger.validation.panels import label_outside, panels

from fefinger.view.figures import INK, STEEL


SIZE = (8.0, 5.0)  # inches

FACES = ("none", STEEL, INK, "#009E73", "#D55E00", "#CC79A7")
"""Fill of the marks of each set of scenes."""

DEPTHS = np.linspace(0.02, 0.24, 111)
"""Depths over the thickness at which the stated errors are drawn."""


def errors(
    sets: Mapping[str, Mapping[str, Any]],
    stated: Mapping[tuple[str, str], Callable[[float], float]],
) -> Any:
    """Draw the errors of sets of scenes over depth / thickness, and the stated errors."""
    drawn, axes = panels(*SIZE, 2, 3, sharex=True)
    for axis, ((phase, quantity), limit) in zip(axes.ravel(), stated.items(), strict=True):
        for (name, rows), face in zip(sets.items(), FACES, strict=True):
            shown = [row for row in rows.values() if quantity in row.get(phase, {})]
            axis.plot(
                [row["part"] for row in shown],
                [100 * row[phase][quantity] for row in shown],
                "o",
                ms=4,
                mfc=face,
                mec=STEEL,
                label=name,
            )
        axis.plot(DEPTHS, [100 * limit(part) for part in DEPTHS], color=INK, lw=0.8, ls="--")
        axis.set_title(f"{quantity}, {phase}")
        axis.set_ylim(bottom=0)
    label_outside(axes, "depth / thickness", "error / %")
    axes[0, 0].legend()
    return drawn
