"""Marks of end organs and units in pictures: positions, labels, rates."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from fefinger.neural.trains import FEW, SpikeTrains
from fefinger.results.records import Sites
from fefinger.results.result_record import ResultRecord
from fefinger.support.arrays import Array, Integers
from fefinger.view import quantities, surfaces


OFF_PLANE = 0.5  # mm from the cut within which end organs of a population are marked


@dataclass(frozen=True)
class Marks:
    """Marks that follow the mesh, with the type and label of each, and the unit it belongs to.

    Of marks with the same label all but the most distal one have an empty one. `trains`: what the
    units fire, or None.
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
    return _marks(result, sites, sites.points[chosen], chosen, _units(sites)[chosen])


def on_skin(result: ResultRecord) -> Marks | None:
    """Return a mark per unit of a population, on the skin above the middle of its end organs."""
    sites = result.sites
    if sites is None or len(sites.types) <= FEW:
        return None
    above = sites.points + sites.depths[:, None] * sites.normals
    units, first, unit, count = np.unique(
        _units(sites), return_index=True, return_inverse=True, return_counts=True
    )
    places = np.stack([np.bincount(unit, above[:, k]) / count for k in range(3)], axis=1)
    return _marks(result, sites, places, first, units)


def leader_order(marks: Array, ends: Array) -> list[int]:
    """Return the mark (n, 2) that each end (n, 2) of a leader belongs to, so that none cross.

    Two leaders that cross swap their ends, which makes them shorter together, so that this ends.
    """
    order = np.argsort(-marks[:, 1], kind="stable").tolist()
    pairs = list(combinations(range(len(order)), 2))
    swapped = True
    while swapped:
        swapped = False
        for i, j in pairs:
            if _cross(marks[order[i]], ends[i], marks[order[j]], ends[j]):
                order[i], order[j] = order[j], order[i]
                swapped = True
    return order


def _cross(a: Array, b: Array, c: Array, d: Array) -> bool:
    """Whether the segments from a to b and from c to d (2,) cross within both."""

    def side(p: Array, q: Array, r: Array) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0


def highest_rate(result: ResultRecord) -> float:
    """Return the highest rate in Hz of any unit at any of the stored times."""
    if result.spikes is None:
        return 0.0
    times = quantities.fields_of(result).times
    return max(float(result.spikes.rate(unit, times).max()) for unit in range(len(result.spikes)))


def _units(sites: Sites) -> Integers:
    """Return the unit of each site (n_sites,); one each where they are not of a population."""
    return np.arange(len(sites.types)) if sites.unit is None else sites.unit


def _marks(
    result: ResultRecord, sites: Sites, points: Array, chosen: Integers, units: Integers
) -> Marks | None:
    """Return marks at points (n, 3) with the types and depths of chosen sites (n,), if any."""
    if not len(points):
        return None
    types = tuple(sites.types[i] for i in chosen)
    labels = [f"{kind} {sites.depths[i]:g} mm" for kind, i in zip(types, chosen, strict=True)]
    shown = {labels[i]: i for i in np.argsort(points[:, 0], kind="stable").tolist()}
    first = tuple(label if shown[label] == i else "" for i, label in enumerate(labels))
    followed = surfaces.follow(quantities.fields_of(result), points)
    return Marks(followed, types, first, units, result.spikes)
