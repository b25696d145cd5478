"""Embossed dots that are scanned over a population: rates against the spacing of the dots.

The scene `slide-dots` at the spacings of the recordings, under the fingertip of a macaque that the
afferents were fitted with: nothing here is fitted. As in the recordings, a unit has several end
organs, and has been scanned for minutes. `data/dots_scanned.csv` says where the recorded rates are
from.
"""

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files

import numpy as np
from fefinger.validation.afferents import experiments

from fefinger.mechanics import condensed
from fefinger.neural.drives import driven_displacements
from fefinger.neural.recorded import fitted, simulate_recorded
from fefinger.neural.variation import Variation
from fefinger.results.records import Sites
from fefinger.scene import builtin
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array


SPACINGS = (1.41, 1.97, 2.99, 3.96, 4.91, 5.87)
"""mm, of those that were recorded, as far as dots of this width fit."""

DIAMETER = 0.7  # mm, of the dots at half their height

DISTANCE = 24.0  # mm, of which each spacing has some four periods and more

BEFORE = 60.0  # s of the scan before the recording, some three time constants of adaptation of SAI

SILENT = 1.0  # impulses/s below which a range of rates is not taken over their mean

SEED = 1  # of the gains and the noise of the units


@cache
def recorded() -> dict[str, tuple[Array, Array]]:
    """Return spacings (n,) mm and recorded rates (n,) Hz by type."""
    text = (files(__package__) / "data" / "dots_scanned.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    types = dict.fromkeys(row["type"] for row in rows)
    return {
        kind: (
            np.array([float(row["spacing_mm"]) for row in rows if row["type"] == kind]),
            np.array([float(row["rate_Hz"]) for row in rows if row["type"] == kind]),
        )
        for kind in types
    }


Scan = Callable[..., tuple[dict[str, float], dict[str, tuple[float, float]]]]
"""From spacing and diameter in mm: rates in Hz, mean and deviation in time of strain, by type."""


@cache
def computed(scan: Scan) -> dict[str, Array]:
    """Return the mean rates (n,) Hz of the units of each type at SPACINGS."""
    return {kind: np.array([scan(each)[0][kind] for each in SPACINGS]) for kind in recorded()}


def variation(scan: Scan, kind: str) -> tuple[Array, Array]:
    """Return mean and deviation in time (n,) of the strain of a type at SPACINGS."""
    mean, deviation = np.array([scan(each)[1][kind] for each in SPACINGS]).T
    return mean, deviation


def scene(spacing: float, diameter: float) -> Scene:
    """Scene of dots of a spacing and a diameter in mm, scanned on the fingertip of a macaque."""
    changes = {
        "indenter.spacing": spacing,
        "indenter.diameter": diameter,
        "motion.distance": DISTANCE,
        "ask.depths": {"SAI": experiments.DEPTHS["SAI"]},
        "ask.pressure": False,
        "ask.population.radius": 2.0,
    }
    return replace(builtin.load("slide-dots", changes), finger=experiments.MACAQUE)


@cache
def scanned(
    spacing: float, diameter: float = DIAMETER
) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
    """Return rates in Hz, and mean and deviation of strain, over dots.

    By type, of all units; the strain is the largest compression at the end organs, and its
    deviation that in time.
    """
    asked = scene(spacing, diameter)
    speed = float(asked.to_dict()["motion"]["speed"])
    response = condensed.respond(asked)
    assert response.strain is not None
    assert response.sites is not None
    scan = response.time >= asked.motion.recorded_from
    time, strain, sites = response.time[scan], response.strain[scan], response.sites
    rates = fired(sites, time - time[0], inputs(strain, sites), spacing / speed)
    return rates, variations(strain, sites)


def inputs(strain: Array, sites: Sites) -> Array:
    """Return the inputs (n_t, n_organs) in mm of the fitted units under a strain."""
    units = fitted()
    drives, lengths = (
        {kind: getattr(unit, name) for kind, unit in units.items()} for name in ("drive", "length")
    )
    return driven_displacements(strain, sites.normals, sites.types, drives, lengths)


def variations(strain: Array, sites: Sites) -> dict[str, tuple[float, float]]:
    """Return mean and deviation in time of the largest compression at end organs, by type."""
    pressed, types = -np.linalg.eigvalsh(strain)[..., 0], np.array(sites.types)
    return {
        kind: (float(each.mean()), float(each.std(axis=0).mean()))
        for kind in dict.fromkeys(sites.types)
        for each in (pressed[:, types == kind],)
    }


def fired(
    sites: Sites, time: Array, inputs: Array, period: float, seed: int = SEED
) -> dict[str, float]:
    """Return the mean rates in Hz by type in a pass of a scan that has gone on for BEFORE s.

    time (n_t,) s from 0 on and inputs (n_t, n_organs) mm of a pass over dots that come every
    `period` s. The passes before are the whole periods of it again and again, at every fifth time.
    """
    assert sites.unit is not None
    long = period * math.floor(time[-1] / period)
    again = time < long
    before, passed = time[again][::5], inputs[again][::5]
    count = math.ceil(BEFORE / long)
    starts = long * np.arange(-count, 0)
    whole = np.concatenate([np.add.outer(starts, before).ravel(), time])
    first = np.searchsorted(sites.unit, np.arange(sites.unit[-1] + 1))
    types = np.array(sites.types)[first]
    trains = simulate_recorded(
        whole,
        np.concatenate([np.tile(passed, (count, 1)), inputs]),
        types=tuple(types),
        unit=sites.unit,
        variation=Variation(seed=seed, spread=None, noise=None),
        check=False,
    )
    counts = np.array([np.count_nonzero(each >= 0.0) for each in trains.times])
    return {str(kind): float(counts[types == kind].mean() / time[-1]) for kind in set(types)}


@dataclass(frozen=True)
class Comparison:
    """Computed rates against recorded ones: their median ratio, their correlation over spacing.

    modulation: the range of the computed rates over their mean, over the same of the recorded ones;
    best: the spacing in mm with most spikes.
    """

    ratio: float
    correlation: float
    modulation: float
    best: float


def strain_against_recorded(scan: Scan, kind: str) -> tuple[float, float]:
    """Return the correlations of mean and deviation of the strain with the recorded rates."""
    rates = np.interp(SPACINGS, *recorded()[kind])
    mean, deviation = (float(np.corrcoef(rates, each)[0, 1]) for each in variation(scan, kind))
    return mean, deviation


def against_recorded(scan: Scan, kind: str) -> Comparison:
    """Compare the rates of a type with recorded ones, interpolated over spacing."""
    places, rates = recorded()[kind]
    recorded_rates, computed_rates = np.interp(SPACINGS, places, rates), computed(scan)[kind]
    both = np.corrcoef(recorded_rates, computed_rates)[0, 1] if np.ptp(computed_rates) > 0 else 0.0
    ranges = [np.ptp(each) / max(each.mean(), SILENT) for each in (computed_rates, recorded_rates)]
    return Comparison(
        ratio=float(np.median(computed_rates / recorded_rates)),
        correlation=float(both),
        modulation=float(ranges[0] / ranges[1]),
        best=SPACINGS[int(np.argmax(computed_rates))],
    )
