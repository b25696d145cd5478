"""Measure what ridges of the skin and friction add to rates over dots, and how sure that is.

Run as `python -m fefinger.validation.evidence.ridges reports`: some seven minutes. Nothing is
fitted: units, dots and the finger are those of the suite `friction`. A rate is the mean over draws
of the gains and the noise of the units, of which some ten of a type count: one draw alone moves the
rate of FAII by a third.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.friction import dots, layers
from fefinger.validation.provenance import save, short

from fefinger.scene.tissue import Ridges
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

FRICTION = 0.3
"""Coefficient of Coulomb, a convention: of wet skin that slides, as in the recordings."""

SPEEDS = (20.0, 60.0, 120.0)
"""mm/s; the strain is that of the same skin at all of them, as nothing relaxes."""

POINTS, SPACING = 384, 0.04
"""Grid points on a side under ridges, and their distance in mm, as `layered` chooses it."""

FINER, PART = 1.5, 1 / 3
"""Factor on the grid points, and part of a point by which the start is moved."""

DRAWS = (1, 2, 3)
"""Seeds of the gains and the noise of the units."""

Rates = dict[str, dict[str, float]]
"""Mean rate in Hz over DRAWS by type, and its standard deviation."""


@contextmanager
def grid(points: int, spacing: float) -> Iterator[None]:
    """Solve on another grid meanwhile."""
    before = layers.POINTS, layers.SPACING
    layers.POINTS, layers.SPACING = points, spacing
    layers.fine.cache_clear()
    yield
    layers.POINTS, layers.SPACING = before
    layers.fine.cache_clear()


class Scan:
    """Dots `spacing` mm apart under skin with or without ridges and friction; start: mm aside."""

    def __init__(
        self, spacing: float, ridges: Ridges | None, start: float = 0.0, friction: float = 0.0
    ) -> None:
        self.spacing, scene = spacing, dots.scene(spacing, dots.DIAMETER)
        self.speed = float(scene.to_dict()["motion"]["speed"])
        self.organs = layers.sites(scene)
        self.strain = layers.strains(scene, self.organs, ridges, start, friction)

    def rates(self, speed: float = 0.0) -> Rates:
        """Return the rates at a speed in mm/s, by default that of the recordings."""
        moved = speed or self.speed
        drawn = [
            layers.fired(self.organs, self.strain, self.spacing, moved, seed) for seed in DRAWS
        ]
        found = {kind: [each[kind] for each in drawn] for kind in drawn[0]}
        return {
            "mean": {kind: round(float(np.mean(each)), 3) for kind, each in found.items()},
            "deviation": {
                kind: round(float(np.std(each, ddof=1)), 3) for kind, each in found.items()
            },
        }

    def line(self) -> dict[str, float]:
        """Return how the input of FAII swings in mm at speed over pitch, and at that of the dots.

        Root mean squares over time, means over end organs.
        """
        inputs = dots.inputs(self.strain, self.organs)
        deep: Array = inputs[:, np.array(self.organs.types) == "FAII"]
        waves = np.sqrt(2) * np.abs(np.fft.rfft(deep, axis=0)).mean(axis=1) / len(deep)
        frequency = self.speed / self.spacing * np.arange(len(waves))
        near = np.abs(frequency - self.speed / Ridges().pitch) < self.speed / self.spacing
        return {"at_speed_over_pitch": float(waves[near].max()), "at_dots": float(waves[1])}


def of_spacings(ridges: Ridges | None, friction: float = 0.0) -> dict[str, Any]:
    """Return the rates of each type at the spacings of the recordings, and how they compare.

    ratio: computed over recorded; correlation over the spacings; modulation: the range of the rates
    over their mean, over the same of the recorded ones.
    """
    each = [Scan(spacing, ridges, friction=friction).rates() for spacing in dots.SPACINGS]
    places, out = np.array(dots.SPACINGS), dict[str, Any]()
    for kind, at in dots.recorded().items():
        rates, recorded = np.array([one["mean"][kind] for one in each]), np.interp(places, *at)
        ranges = [np.ptp(x) / max(x.mean(), dots.SILENT) for x in (rates, recorded)]
        out[kind] = {
            "Hz": short(rates),
            "deviation": short([one["deviation"][kind] for one in each]),
            "ratio": short(rates / recorded, 3),
            "correlation": round(float(np.corrcoef(rates, recorded)[0, 1]), 3),
            "modulation": round(float(ranges[0] / ranges[1]), 3),
        }
    return out


def at_one_spacing() -> dict[str, Any]:
    """Return what is measured at the spacing AT on the grid of ridges."""
    ridged, smooth = Scan(AT, Ridges()), Scan(AT, None)
    held = Scan(AT, Ridges(), friction=FRICTION)
    varied = {name: Scan(AT, each).rates() for name, each in VARIED.items()}
    lines = {"smooth": smooth, "ridges": ridged, "ridges and friction": held}
    return {
        "varied_Hz": varied,
        "moved_by_part_of_a_point_Hz": Scan(AT, Ridges(), start=PART * SPACING).rates(),
        "FAII_input_mm": {name: each.line() for name, each in lines.items()},
        "speeds_Hz": {f"{speed:g} mm/s": ridged.rates(speed) for speed in SPEEDS},
    }


def on_other_grid(factor: float) -> Rates:
    """Return the rates on a grid with so many times the points."""
    with grid(2 * round(POINTS * factor / 2), SPACING / factor):
        return Scan(AT, Ridges()).rates()


def report() -> dict[str, Any]:
    """Return the report."""
    places = np.array(dots.SPACINGS)
    recorded = {kind: short(np.interp(places, *at)) for kind, at in dots.recorded().items()}
    found: dict[str, Any] = {
        "spacing_mm": list(dots.SPACINGS),
        "recorded_Hz": recorded,
        "draws": list(DRAWS),
        "smooth": of_spacings(None),
        "varied_at_mm": AT,
    }
    with grid(POINTS, SPACING):
        found |= {"ridges": of_spacings(Ridges()), **at_one_spacing()}
        found |= {"friction": FRICTION, "ridges_and_friction": of_spacings(Ridges(), FRICTION)}
    return found | {
        "finer_grid_Hz": on_other_grid(FINER),
        "coarser_grid_Hz": on_other_grid(1 / FINER),
    }


if __name__ == "__main__":
    save(Path(sys.argv[1]) / REPORT, report())
