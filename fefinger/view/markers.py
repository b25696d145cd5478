"""Marks of end organs and units in pictures: positions, labels, rates."""

from dataclasses import dataclass

import numpy as np

from fefinger.neural.train_record import FEW
from fefinger.neural.trains import SpikeTrains
from fefinger.results.result_record import ResultRecord
from fefinger.support.arrays import Array, Integers
from fefinger.view import quantities, surfaces


OFF_PLANE = 0.5  # mm from the cut within which end organs of a population are marked


@dataclass(frozen=True)
class Marks:
    """Marks that follow the mesh, with the type and label of each, and the unit it belongs to.

    `trains`: what the units fire, or None.
    """

    followed: surfaces.Followed
    types: tuple[str, ...]
    labels: tuple[str, ...]
    units: Integers
    trains: SpikeTrains | None

    def rates(self, time: float) -> Array:
        """Return the rate in Hz of the unit of each mark at a time in s; needs `trains`."""
        assert self.trains is not None
        return np.array([float(self.trains.rate(int(unit), time)) for unit in self.units])


def in_section(result: ResultRecord) -> Marks | None:
    """Return a mark per end organ, of a population of those within OFF_PLANE of the cut."""
    sites = result.sites
    if sites is None:
        return None
    chosen = np.arange(len(sites.types))
    if len(chosen) > FEW:
        chosen = np.flatnonzero(np.abs(sites.points[:, 1]) <= OFF_PLANE)
    unit = np.arange(len(sites.types)) if sites.unit is None else sites.unit
    return _marks(result, sites.points[chosen], chosen, unit[chosen])


def on_skin(result: ResultRecord) -> Marks | None:
    """Return a mark per unit of a population, on the skin above the middle of its end organs."""
    sites = result.sites
    if sites is None or len(sites.types) <= FEW:
        return None
    unit = np.arange(len(sites.types)) if sites.unit is None else sites.unit
    above = sites.points + sites.depths[:, None] * sites.normals
    units, first, count = np.unique(unit, return_index=True, return_counts=True)
    inverse = np.searchsorted(units, unit)
    places = np.stack([np.bincount(inverse, above[:, k]) / count for k in range(3)], axis=1)
    return _marks(result, places, first, units)


def highest_rate(result: ResultRecord) -> float:
    """Return the highest rate in Hz of any unit at any of the stored times."""
    if result.spikes is None:
        return 0.0
    times = quantities.fields_of(result).times
    return max(float(result.spikes.rate(unit, times).max()) for unit in range(len(result.spikes)))


def _marks(result: ResultRecord, points: Array, sites: Integers, units: Integers) -> Marks | None:
    all_sites = result.sites
    assert all_sites is not None
    if not len(points):
        return None
    return Marks(
        followed=surfaces.follow(quantities.fields_of(result), points),
        types=tuple(all_sites.types[i] for i in sites),
        labels=tuple(f"{all_sites.types[i]} {all_sites.depths[i]:g} mm" for i in sites),
        units=units,
        trains=result.spikes,
    )
