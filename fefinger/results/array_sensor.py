"""The tactile array of the thesis under a plate: what it would read of any response."""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.results.pressure import cuts, net
from fefinger.scene.indenter import Indenter, direction
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.results.records import Array, Pad, ResultRecord
    from fefinger.theory.array.sensor import ArraySensor, Reading


def read(
    result: "ResultRecord", sensor: "ArraySensor | None" = None, *, seed: int | None = None
) -> "Reading":
    """Return the readings of an array on the plate, with its middle under the center of pressure.

    The array is aligned when the force is largest, as in section 3.2.1 of the thesis; its x points
    distally along the plate, its y sideways. `seed` starts the noise; None leaves it out.

    Raises
    ------
    InputError
        Without a plate or a pressure, or on a pad too coarse for the elements.
    """
    from fefinger.theory.array.sensor import ArraySensor

    pad, pressure = result.pad, result.pressure
    if pad is None or pressure is None:
        msg = "ask.pressure: expected true, because the array reads the pressure on the pad"
        raise InputError(msg)
    points = on_plate(result)
    heaviest = pressure[int(np.argmax(pressure @ pad.areas))] * pad.areas
    if heaviest.sum() <= 0:
        msg = "motion: expected contact, but there is no pressure to align the array by"
        raise InputError(msg)
    points = points - heaviest @ points / heaviest.sum()
    sensor = sensor or ArraySensor()
    try:
        felt = pressure @ response(sensor, pad, points).T
        return sensor.scan(result.time, felt, seed=seed)
    except ValueError as error:
        msg = f"sensor: {error}"
        raise InputError(msg) from None


def response(sensor: "ArraySensor", pad: "Pad", places: "Array") -> "Array":
    """Return the matrix (n_elements, n_pad) from pressures on the pad to what the elements feel.

    places (n_pad, 2) mm are the points of the pad in the plane of the array. The pressure is taken
    as linear between them.

    Raises
    ------
    ValueError
        If the triangles of the pad are too large for the elements.
    """
    fine = net(pad, cuts(pad, sensor.sigma))
    areas = np.asarray(fine.loads.sum(axis=1)).ravel()
    kept = areas > 0
    weights = sensor.weights((fine.between @ places)[kept], areas[kept]) / areas[kept]
    return np.asarray(weights @ fine.loads[kept])


def on_plate(result: "ResultRecord") -> "Array":
    """Return the points of the pad (n, 2) mm as the plate sees them: distal, sideways."""
    assert result.pad is not None
    return plane(result.scene.indenter, result.pad.points)


def plane(indenter: Indenter, points: "Array") -> "Array":
    """Return points (n, 3) mm as the plate sees them, (n, 2) mm: distal, sideways.

    Raises
    ------
    InputError
        For an indenter that is no plate.
    """
    if indenter.flat is None:
        msg = f"indenter: expected a plate to put the array on, received a {indenter.kind}"
        raise InputError(msg)
    axis = direction(indenter.flat)
    distal = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
    distal /= np.linalg.norm(distal)
    return np.asarray(points @ np.stack([distal, np.cross(axis, distal)], axis=1))
