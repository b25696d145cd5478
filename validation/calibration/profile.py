"""Pressure on the thesis's array: of a calibrated finger, and of the half-space of Table 3.2."""

from dataclasses import dataclass

import numpy as np
from fefinger.validation.oracles.fingerpad import Fingerpad

from fefinger.calibration import pad_radius as pad
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.targets import aligned
from fefinger.scene import pawluk1997
from fefinger.support.arrays import Array
from fefinger.theory.array.sensor import ArraySensor, blurred


@dataclass(frozen=True)
class PressureProfile:
    """Pressure in kPa on the array against the `distance` in mm, at one force in N.

    `finger` is the calibrated one, `thesis` the half-space of Table 3.2; `force` is the force that
    the press reached, at most the requested one.
    """

    force: float
    distance: Array
    finger: Array
    thesis: Array


def profile(law: ForceLaw, subject: str, force: float) -> PressureProfile:
    """Compute the pressure profiles of finger and thesis at a force in N of a slow press.

    If the curve ends before that force, both are at the force where it ends.
    """
    sensor = ArraySensor()
    depth = pad.slow_press(law, force)
    readings = pad.slow(law.prony, depth, law.array_pressure(depth))[-1]
    reached = float(pad.slow(law.prony, depth, law.relaxed(depth))[-1])
    frames = aligned(np.zeros((1, len(readings))), readings[None], sensor)
    row = pawluk1997.quasistatic()[subject]
    half_space = Fingerpad(row.radius, row.m, row.b, pawluk1997.relaxation()[subject])
    deep = float(half_space.depth_at(1e3 * reached, relaxed=True))
    theirs = blurred(
        lambda r: half_space.relaxed_pressure(r, deep),
        float(half_space.contact_radius(deep)),
        frames.distance,
    )
    signed = frames.distance * np.where(sensor.positions[:, 0] < 0, -1.0, 1.0)
    order = np.argsort(signed)
    return PressureProfile(reached, signed[order], readings[order], theirs[order])
