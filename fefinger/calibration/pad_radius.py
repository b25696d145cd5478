"""The pad radius by the thesis's own fit: what it finds in the frames of the array is to agree.

The thesis fits R, m and c0 b of a half-space to the frames of a slow press (section 3.4.2). A
finger with a bone has no such numbers; the same fit of its simulated frames has. The longitudinal
pad radius is the one with which that fit returns the R of the measured frames.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fefinger.calibration.curve import Curve
from fefinger.calibration.force import RADII
from fefinger.calibration.targets import Frames, aligned
from fefinger.scene import library
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.theory.array.sensor import ArraySensor, blurred
from fefinger.theory.array.sensor_fit import fit_fingerpad
from fefinger.theory.fingerpad import Fingerpad
from fefinger.theory.relaxation import Prony, hereditary_integral


Array = NDArray[np.float64]

SLOW = 0.2
"""mm/s of the slow presses with the array (section 3.2.2)."""

HEAVIEST = 2.3
"""N, the largest force at which the thesis shows a profile (Figure 3-4)."""

LEVELS = 20
"""Frames that are fitted, evenly over the depth."""

SEEDS = 5
"""Simulated frames with noise from which the scatter of a fitted R is taken."""

ROUNDING = 0.5 / np.sqrt(3.0)
"""Standard deviation in mm of an R that is printed to the mm."""


WITHIN = 1.15
"""Factor beyond the pad radii that were pressed up to which the next one may be."""

LEAST = 1.0
"""Least power of the pad radius that a fitted R is taken to grow with: that of Hertz's contact. On
a finger it is more (1.5 to 2.6); less is what a mesh makes of two radii that are near each other.
"""


@dataclass(frozen=True)
class PadFit:
    """The thesis's fit of frames: R mm, m 1/mm, c0 b kPa/mm, and its squared error, a fraction."""

    radius: float
    m: float
    c0_b: float
    error: float


def slow_press(curve: Curve, factor: float, prony: Prony, heaviest: float = HEAVIEST) -> Array:
    """Return the depths (n,) mm of a slow press to `heaviest` N, or as deep as the curve goes."""
    depth = np.linspace(0.0, curve.deepest, 400)
    force = slow(prony, depth, factor * curve.force(depth))
    last = min(int(np.searchsorted(force, heaviest)) + 1, len(depth))
    return np.linspace(0.0, float(depth[last - 1]), 200)


def heaviest(curve: Curve, factor: float, prony: Prony) -> float:
    """Return the force in N that a slow press reaches where the curve ends."""
    depth = np.linspace(0.0, curve.deepest, 400)
    return float(slow(prony, depth, factor * curve.force(depth))[-1])


def slow(prony: Prony, depth: Array, relaxed: Array) -> Array:
    """Return what relaxed values (n, ...) at depths (n,) mm are on a ramp at 0.2 mm/s."""
    return hereditary_integral(prony, depth / SLOW, relaxed) / prony.long_time


def simulated(
    curve: Curve,
    factor: float,
    prony: Prony,
    *,
    seed: int | None = None,
    heaviest: float = HEAVIEST,
) -> Frames:
    """Return frames of the array on a slow press; `seed` starts its noise, None leaves it out."""
    sensor = ArraySensor()
    depth = slow_press(curve, factor, prony, heaviest)
    felt = slow(prony, depth, factor * curve.felt(depth))
    chosen = np.linspace(0, len(depth) - 1, LEVELS + 1).astype(int)[1:]
    felt = felt[chosen]
    if seed is not None:
        felt = felt + np.random.default_rng(seed).normal(0.0, sensor.noise, felt.shape)
    reached = np.repeat(depth[chosen][:, None], felt.shape[1], axis=1)
    return aligned(reached, felt, sensor)


def thesis_fit(frames: Frames) -> PadFit:
    """Return the thesis's fit of frames.

    Raises
    ------
    ConvergenceError
        If its search does not end.
    """
    try:
        found = fit_fingerpad(frames.depth, frames.pressure, frames.distance)
    except ValueError as error:
        msg = (
            f"frames: the fit of Eq. 3.17 did not end ({error}); check that their position is in "
            "mm from touch"
        )
        raise ConvergenceError(msg) from None
    values = found.parameters
    return PadFit(values["radius"], values["m"], values["c0_b"], found.error)


def radius_for(
    wanted: float, radii: Sequence[float], found: Sequence[float]
) -> tuple[float, float]:
    """Return the pad radius in mm at which the thesis's fit gives `wanted`, and the power of it.

    The logarithm of the fitted R is a straight line in that of the pad radius, by least squares
    through the `radii` that were tried; its slope is the power.

    Raises
    ------
    InputError
        If the fitted R does not grow with the pad radius.
    """
    x, y = np.log(radii), np.log(found)
    slope, start = np.polyfit(x, y, 1)
    if not slope > 0:
        msg = (
            f"pad_radius: expected the fitted R to grow with it, found {np.round(found, 2)} mm at "
            f"{np.round(radii, 2)} mm; the frames do not tell the shape of this pad"
        )
        raise InputError(msg)
    radius = float(np.clip(np.exp((np.log(wanted) - start) / slope), *RADII))
    return radius, float(slope)


def nearer(
    wanted: float, radii: Sequence[float], found: Sequence[float], power: float = LEAST
) -> float:
    """Return the pad radius in mm to be pressed next, for the thesis's fit to give `wanted`.

    Between the nearest two of `radii` whose fitted R hold it between them; else on from the nearest
    one, by the `power` or LEAST, and no farther than WITHIN beyond all.
    """
    tried = sorted(zip(found, radii, strict=True))
    below = [each for each in tried if each[0] <= wanted]
    above = [each for each in tried if each[0] > wanted]
    if below and above:
        (low, start), (high, end) = below[-1], above[0]
        part = math.log(wanted / low) / math.log(high / low)
        return start * (end / start) ** part
    fitted, nearest = below[-1] if below else above[0]
    radius = nearest * (wanted / fitted) ** (1 / max(power, LEAST))
    return float(np.clip(radius, min(radii) / WITHIN, max(radii) * WITHIN))


def scatter(curve: Curve, factor: float, prony: Prony) -> float:
    """Return the standard deviation of the fitted R in mm that the noise of the array makes."""
    fits = [thesis_fit(simulated(curve, factor, prony, seed=seed)).radius for seed in range(SEEDS)]
    return float(np.std(fits, ddof=1))


def printed(subject: str) -> PadFit:
    """Return the row of Table 3.2 of a subject."""
    row = library.pawluk_quasistatic()[subject]
    return PadFit(row.radius, row.m, row.b, float("nan"))


@dataclass(frozen=True)
class Profile:
    """Pressure in kPa that the array feels, against the `distance` in mm, at one force in N.

    `finger` is the calibrated one, `thesis` the half-space of Table 3.2; `force` is what the press
    reached, at most what was asked.
    """

    force: float
    distance: Array
    finger: Array
    thesis: Array


def profile(curve: Curve, factor: float, prony: Prony, subject: str, force: float) -> Profile:
    """Return the profiles of finger and thesis at a force in N of a slow press.

    As deep as the curve goes; both are then at the force that is reached there.
    """
    sensor = ArraySensor()
    depth = slow_press(curve, factor, prony, force)
    felt = slow(prony, depth, factor * curve.felt(depth))[-1]
    reached = float(slow(prony, depth, factor * curve.force(depth))[-1])
    frames = aligned(np.zeros((1, len(felt))), felt[None], sensor)
    row = library.pawluk_quasistatic()[subject]
    pad = Fingerpad(row.radius, row.m, row.b, library.pawluk_relaxation()[subject])
    deep = float(pad.depth_at(1e3 * reached, relaxed=True))
    theirs = blurred(
        lambda r: pad.relaxed_pressure(r, deep), float(pad.contact_radius(deep)), frames.distance
    )
    signed = frames.distance * np.where(sensor.positions[:, 0] < 0, -1.0, 1.0)
    order = np.argsort(signed)
    return Profile(reached, signed[order], felt[order], theirs[order])
