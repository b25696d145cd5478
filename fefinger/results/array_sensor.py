"""Simulated readings of the tactile array of Pawluk (1997) on the plate, from the pressure."""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.profiles import directions
from fefinger.results.pressure import cuts, net
from fefinger.results.records import Pad
from fefinger.results.result_record import ResultRecord
from fefinger.scene.indenter import Indenter, direction
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.theory.array.sensor import ArraySensor, Reading


def read(
    result: ResultRecord, sensor: "ArraySensor | None" = None, *, seed: int | None = None
) -> "Reading":
    """Simulate the readings of an array on the plate, whose center is the center of pressure.

    The array is centered at the largest force, as in section 3.2.1 of Pawluk (1997); its x axis
    points distally along the plate, y sideways. `seed` draws the noise; None simulates none.

    Raises InputError without a plate or a pressure, or on a pad too coarse for the elements.
    """
    from fefinger.theory.array.sensor import ArraySensor

    pad, pressure = result.pad, result.pressure
    if pad is None or pressure is None:
        msg = "ask.pressure: expected true for the array, which reads the pressure, received false"
        raise InputError(msg)
    points = plane(result.scene.indenter, pad.points)
    heaviest = pressure[int(np.argmax(pressure @ pad.areas))] * pad.areas
    if heaviest.sum() <= 0:
        msg = "motion: expected contact, by which the array is aligned, received none at any time"
        raise InputError(msg)
    points = points - heaviest @ points / heaviest.sum()
    sensor = sensor or ArraySensor()
    try:
        element_pressure = pressure @ response(sensor, pad, points).T
        return sensor.scan(result.time, element_pressure, seed=seed)
    except ValueError as error:
        raise InputError(f"sensor: {error}") from None


def response(sensor: "ArraySensor", pad: Pad, places: Array) -> Array:
    """Matrix (n_elements, n_pad) from pressures on the pad to pressures on the array's elements.

    places (n_pad, 2) mm: points of the pad in the plane of the array, between which the pressure
    varies linearly.

    Raises ValueError if the triangles of the pad are too large for the elements.
    """
    between, loads = net(pad, cuts(pad, sensor.sigma))
    areas = np.asarray(loads.sum(axis=1)).ravel()
    loaded = areas > 0
    weights = sensor.weights((between @ places)[loaded], areas[loaded]) / areas[loaded]
    return np.asarray(weights @ loads[loaded])


def plane(indenter: Indenter, points: Array) -> Array:
    """Project points (n, 3) mm onto the plane of the plate: (n, 2) mm, distal and sideways.

    Raises InputError for another indenter.
    """
    if indenter.flat is None:
        msg = f"indenter: expected a plate to put the array on, received a {indenter.kind}"
        raise InputError(msg)
    return np.asarray(points @ directions(direction(indenter.flat)).T)
