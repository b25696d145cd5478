"""Measure what ridges of the skin add to rates over scanned dots, and how sure that is.

Run as `python -m fefinger.validation.evidence.ridges reports`: some four minutes. Nothing is
fitted: units, dots and the finger are those of the suite `friction`.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.friction import dots, layers
from fefinger.validation.provenance import save

from fefinger.scene.ridges import Ridges
from fefinger.support.arrays import Array


REPORT = "ridges.json"

AT = 2.99
"""Spacing in mm of the dots at which pitch, height and grid are varied: most FAII are recorded."""

VARIED = {
    "pitch 0.35 mm": Ridges(pitch=0.35),
    "pitch 0.55 mm": Ridges(pitch=0.55),
    "height 0.05 mm": Ridges(height=0.05),
    "height 0.2 mm": Ridges(height=0.2),
    "concentric": Ridges(shape="concentric"),
}

POINTS, SPACING = 384, 0.04
"""Grid points on a side under ridges, and their distance in mm, as `layered` chooses it."""

FINER, PART = 1.5, 1 / 3
"""Factor on the grid points, and part of a point by which the start is moved."""


@contextmanager
def grid(points: int, spacing: float) -> Iterator[None]:
    """Solve on another grid meanwhile."""
    before = layers.POINTS, layers.SPACING
    layers.POINTS, layers.SPACING = points, spacing
    layers.fine.cache_clear()
    layers.scanned.cache_clear()
    yield
    layers.POINTS, layers.SPACING = before
    layers.fine.cache_clear()
    layers.scanned.cache_clear()


def rates(spacing: float, ridges: Ridges | None, start: float = 0.0) -> dict[str, float]:
    """Return the rates in Hz by type over dots; `start` mm: where they begin."""
    fired, _ = layers.scanned(spacing, ridges=ridges, start=start)
    return {kind: float(rate) for kind, rate in fired.items()}


def of_spacings(ridges: Ridges | None) -> dict[str, list[float]]:
    """Return the rates of each type at the spacings of the recordings."""
    each = [rates(spacing, ridges) for spacing in dots.SPACINGS]
    return {kind: [one[kind] for one in each] for kind in dots.recorded()}


def line(ridges: Ridges | None) -> dict[str, float]:
    """Return how the input of FAII swings in mm at speed over pitch, and at the dots' frequency.

    Root mean squares over time, means over end organs.
    """
    scene = dots.scene(AT, dots.DIAMETER)
    organs = layers.sites(scene)
    speed = float(scene.to_dict()["motion"]["speed"])
    inputs = dots.inputs(layers.strains(scene, organs, ridges), organs)
    deep: Array = inputs[:, np.array(organs.types) == "FAII"]
    waves = np.sqrt(2) * np.abs(np.fft.rfft(deep, axis=0)).mean(axis=1) / len(deep)
    frequency = speed / AT * np.arange(len(waves))
    near = np.abs(frequency - speed / Ridges().pitch) < speed / AT
    return {"at_speed_over_pitch": float(waves[near].max()), "at_dots": float(waves[1])}


def on_grid() -> dict[str, Any]:
    """Return what is measured on the grid of ridges."""
    with grid(POINTS, SPACING):
        return {
            "ridges_Hz": of_spacings(Ridges()),
            "varied_Hz": {name: rates(AT, each) for name, each in VARIED.items()},
            "moved_by_part_of_a_point_Hz": rates(AT, Ridges(), start=PART * SPACING),
            "FAII_input_mm": {"smooth": line(None), "ridges": line(Ridges())},
        }


def on_other_grid(factor: float) -> dict[str, float]:
    """Return the rates on a grid with so many times the points."""
    with grid(2 * round(POINTS * factor / 2), SPACING / factor):
        return rates(AT, Ridges())


def report() -> dict[str, Any]:
    """Return the report."""
    places = np.array(dots.SPACINGS)
    recorded = {kind: np.interp(places, *at).tolist() for kind, at in dots.recorded().items()}
    return {
        "spacing_mm": list(dots.SPACINGS),
        "recorded_Hz": recorded,
        "smooth_Hz": of_spacings(None),
        "varied_at_mm": AT,
        "finer_grid_Hz": on_other_grid(FINER),
        "coarser_grid_Hz": on_other_grid(1 / FINER),
        **on_grid(),
    }


if __name__ == "__main__":
    save(Path(sys.argv[1]) / REPORT, report())
