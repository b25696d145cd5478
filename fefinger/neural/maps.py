"""Spatial responses of a population: rate profiles and receptive fields."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.populations import Surface
from fefinger.neural.statistics import mean_rates
from fefinger.neural.trains import SpikeTrains
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, number
from fefinger.support.vocabulary import TYPES


def rate_profile(
    trains: SpikeTrains, direction: ArrayLike, start: float, stop: float, kind: str
) -> tuple[Array, Array]:
    """Return places in mm along a direction (3,) and mean rates in Hz of the units of a type.

    Ascending along the direction. InputError without positions or without units of the type.
    """
    along = np.asarray(direction, float)
    if trains.positions is None or along.shape != (3,) or not np.linalg.norm(along) > 0:
        msg = "rate_profile: expected trains with positions and a direction (3,) that is not zero"
        raise InputError(msg)
    of_kind = np.array([name == choice("kind", kind, TYPES) for name in trains.types])
    if not of_kind.any():
        msg = f"kind: expected a type among {', '.join(sorted(set(trains.types)))}, received {kind}"
        raise InputError(msg)
    place = trains.positions[of_kind] @ (along / np.linalg.norm(along))
    order = np.argsort(place, kind="stable")
    return place[order], mean_rates(trains, start, stop)[of_kind][order]


@dataclass(frozen=True)
class ReceptiveField:
    """Receptive field of a unit.

    center (3,) mm: mean of the probe points, weighted by the response. area mm²: area of the probes
    with at least `share` of the largest response. diameter mm: that of a circle of this area. peak:
    the largest response. A unit that no probe excites has area 0 and a center of nan.
    """

    center: Array
    area: float
    diameter: float
    peak: float


def receptive_fields(
    probes: Surface, responses: ArrayLike, *, share: float = 0.5
) -> tuple[ReceptiveField, ...]:
    """Receptive field of each unit from its responses to probes at points of the skin.

    responses: (n_probes, n_units), 0 or more, such as spike counts. InputError where they do not
    fit the probes.
    """
    share = number("share", share, above=0.0, at_most=1.0)
    values = np.asarray(responses, float)
    if values.ndim != 2 or len(values) != len(probes.points) or not np.all(values >= 0.0):
        msg = (
            f"responses: expected ({len(probes.points)}, n_units) of 0 or more, one row per probe, "
            f"received {values.shape}"
        )
        raise InputError(msg)
    fields = []
    for column in values.T:
        weight, peak = column * probes.areas, float(column.max())
        if peak == 0.0:
            fields.append(ReceptiveField(np.full(3, np.nan), 0.0, 0.0, 0.0))
            continue
        area = float(probes.areas[column >= share * peak].sum())
        center = weight @ probes.points / weight.sum()
        fields.append(ReceptiveField(center, area, 2.0 * float(np.sqrt(area / np.pi)), peak))
    return tuple(fields)
