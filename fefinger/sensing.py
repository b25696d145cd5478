"""The tactile array of the thesis under a plate: what it would read of any response."""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.checks import InputError
from fefinger.scene import Flat, Indenter


if TYPE_CHECKING:
    from fefinger.records import Array, Result
    from fefinger.theory.sensor import ArraySensor, Reading


def read(
    result: "Result", sensor: "ArraySensor | None" = None, *, seed: int | None = None
) -> "Reading":
    """Return the readings of an array on the plate, with its middle under the center of pressure.

    The array is aligned when the force is largest, as in section 3.2.1 of the thesis; its x points
    distally along the plate, its y sideways. `seed` starts the noise; None leaves it out.

    Raises
    ------
    InputError
        Without a plate or a pressure, or on a pad too coarse for the elements.
    """
    from fefinger.theory.sensor import ArraySensor

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
        return sensor.read(result.time, points, pad.areas, pressure, seed=seed)
    except ValueError as error:
        msg = f"sensor: {error}"
        raise InputError(msg) from None


def on_plate(result: "Result") -> "Array":
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
    from fefinger.mechanics._touch import direction

    if not isinstance(indenter, Flat):
        msg = f"indenter: expected a plate to put the array on, received a {indenter.kind}"
        raise InputError(msg)
    axis = direction(indenter)
    distal = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
    distal /= np.linalg.norm(distal)
    return np.asarray(points @ np.stack([distal, np.cross(axis, distal)], axis=1))
