"""Readings of the array of Pawluk (1997) through time: scanned element by element, with noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.calibration.array_sensor import ArraySensor, plane, reading_matrix
from fefinger.results.result_record import ResultRecord
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError
from fefinger.theory.contact import elastic


@dataclass(frozen=True)
class Reading:
    """Readings of the array: consecutive frames, each scanned element by element.

    time (n_frames, n) s of each reading; pressure (n_frames, n) kPa.
    """

    time: Array
    pressure: Array


def scan(
    sensor: ArraySensor,
    time: ArrayLike,
    element_pressure: ArrayLike,
    *,
    seed: int | None = None,
) -> Reading:
    """Simulate readings of the pressure (n_t, n) in kPa on the elements at times (n_t,) s.

    The pressure is linear between the times and read from `time[0]` on; only whole frames are
    returned. `seed` is that of the noise; None: without noise.

    Raises ValueError for shapes that do not match, times that do not increase, or less than one
    frame.
    """
    time = elastic.numbers("time", "times", time)
    element_pressure = elastic.numbers("element_pressure", "pressures", element_pressure)
    if element_pressure.shape[:1] != time.shape or not (np.diff(time) > 0).all():
        msg = f"time: expected {len(element_pressure)} rising times, received {time.shape}"
        raise ValueError(msg)
    span = time[-1] - time[0] - sensor.delays[-1]
    if span < 0:
        msg = f"time: expected at least one frame of {1 / sensor.rate:g} s, received less"
        raise ValueError(msg)
    starts = time[0] + np.arange(int(span * sensor.rate + 1e-9) + 1) / sensor.rate
    at = starts[:, None] + sensor.delays
    columns = zip(at.T, element_pressure.T, strict=True)
    read = np.stack([np.interp(when, time, value) for when, value in columns], axis=1)
    if seed is not None:
        read = read + np.random.default_rng(seed).normal(0.0, sensor.noise, read.shape)
    return Reading(at, read)


def read(
    result: ResultRecord, sensor: ArraySensor | None = None, *, seed: int | None = None
) -> Reading:
    """Simulate the readings of an array on the plate, whose center is the center of pressure.

    The array is centered at the largest force, as in section 3.2.1 of Pawluk (1997); its x axis
    points distally along the plate, y sideways. `seed` draws the noise; None simulates none.

    Raises InputError without a plate or a pressure, or on a pad too coarse for the elements.
    """
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
        element_pressure = pressure @ reading_matrix(sensor, pad, points).T
        return scan(sensor, result.time, element_pressure, seed=seed)
    except ValueError as error:
        raise InputError(f"sensor: {error}") from None


def triangles(sensor: ArraySensor) -> Integers:
    """Two triangles (m, 3) per square of four elements, for isobars."""
    corner = np.arange(sensor.elements**2).reshape(sensor.elements, sensor.elements)
    a, b = corner[:-1, :-1].ravel(), corner[:-1, 1:].ravel()
    c, d = corner[1:, :-1].ravel(), corner[1:, 1:].ravel()
    return np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
