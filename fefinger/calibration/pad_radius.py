"""Pad radius of a finger by the fit of Pawluk (1997) to measured and simulated frames.

Pawluk (1997) fits R, m and c0 b of a half-space to the frames of a slow press (section 3.4.2). A
finger with a bone has no such parameters, but the same fit can be made of its simulated frames. The
longitudinal pad radius is the one for which that fit returns the R of the measured frames.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fefinger.calibration.array_sensor import ArraySensor, Frames, aligned, fit_fingerpad
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.targets import RADII
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError
from fefinger.theory.relaxation import Prony, hereditary_integral


SLOW = 0.2
"""mm/s of the slow presses with the array (section 3.2.2)."""

HEAVIEST = 2.3
"""N, the largest force at which the thesis shows a profile (Figure 3-4)."""

LEVELS = 20
"""Number of fitted frames, evenly spaced over the depth."""

ROUNDING = 0.5 / np.sqrt(3.0)
"""Standard deviation in mm of an R that is printed to the mm."""


WITHIN = 1.15
"""Largest ratio of the next pad radius to the range of those pressed so far."""

LEAST = 1.0
"""Smallest exponent of a fitted R as a power of the pad radius: that of Hertz's contact.

On a finger with a flat pad it is 1.5 to 2.6; smaller values are mesh errors of two radii close to
each other.
"""

DETERMINED = 0.6
"""Exponent below which the frames do not determine the pad radius: with a round tip and stiff skin
it is 0.2 to 1, as tip and bone decide how wide the pressure is."""


@dataclass(frozen=True)
class PadFit:
    """The thesis's fit of frames: R mm, m 1/mm, c0 b kPa/mm, and its relative squared error."""

    radius: float
    m: float
    c0_b: float
    error: float


def slow_press(law: ForceLaw, heaviest: float = HEAVIEST) -> Array:
    """Depths (n,) mm of a slow press to `heaviest` N, or to the end of the curve."""
    depth = np.linspace(0.0, law.curve.deepest, 400)
    force = slow(law.prony, depth, law.relaxed(depth))
    last = min(int(np.searchsorted(force, heaviest)) + 1, len(depth))
    return np.linspace(0.0, float(depth[last - 1]), 200)


def heaviest(law: ForceLaw) -> float:
    """Force in N of a slow press at the end of the curve."""
    depth = np.linspace(0.0, law.curve.deepest, 400)
    return float(slow(law.prony, depth, law.relaxed(depth))[-1])


def slow(prony: Prony, depth: Array, relaxed: Array) -> Array:
    """Convert relaxed values (n, ...) at depths (n,) mm to those on a ramp at 0.2 mm/s."""
    return hereditary_integral(prony, depth / SLOW, relaxed) / prony.long_time


def simulated(law: ForceLaw, *, seed: int | None = None, heaviest: float = HEAVIEST) -> Frames:
    """Simulate frames of the array on a slow press; `seed` of its noise, None for no noise."""
    sensor = ArraySensor()
    depth = slow_press(law, heaviest)
    readings = slow(law.prony, depth, law.array_pressure(depth))
    chosen = np.linspace(0, len(depth) - 1, LEVELS + 1).astype(int)[1:]
    readings = readings[chosen]
    if seed is not None:
        noise = np.random.default_rng(seed).normal(0.0, sensor.noise, readings.shape)
        readings = readings + noise
    reached = np.repeat(depth[chosen][:, None], readings.shape[1], axis=1)
    return aligned(reached, readings, sensor)


def thesis_fit(frames: Frames) -> PadFit:
    """Fit frames by the procedure of the thesis (Eq. 3.17).

    Raises ConvergenceError if the fit does not converge.
    """
    try:
        fit = fit_fingerpad(frames.depth, frames.pressure, frames.distance)
    except ValueError as error:
        raise ConvergenceError(
            f"frames: expected the fit of Eq. 3.17 to converge, it did not ({error}); check that "
            "their position is in mm from touch"
        ) from None
    values = fit.parameters
    return PadFit(values["radius"], values["m"], values["c0_b"], fit.error)


def radius_for(
    wanted: float, radii: Sequence[float], fitted: Sequence[float]
) -> tuple[float, float]:
    """Interpolate the pad radius in mm at which the thesis's fit gives `wanted`, and its exponent.

    The logarithm of the fitted R is linear in log pad radius, by least squares through the
    tried `radii`; its slope is the exponent. Where it is below DETERMINED the first radius that
    was tried remains.
    """
    x, y = np.log(radii), np.log(fitted)
    slope, start = np.polyfit(x, y, 1)
    if slope < DETERMINED:
        return radii[0], float(slope)
    radius = float(np.clip(np.exp((np.log(wanted) - start) / slope), *RADII))
    return radius, float(slope)


def nearer(
    wanted: float, radii: Sequence[float], fitted: Sequence[float], power: float = LEAST
) -> float:
    """Choose the next pad radius in mm to press, for the thesis's fit to give `wanted`.

    Interpolates between the nearest two of `radii` whose fitted R bracket it; else extrapolates
    from the nearest one with the exponent `power`, at least LEAST, and at most WITHIN beyond all.
    """
    tried = sorted(zip(fitted, radii, strict=True))
    below = [each for each in tried if each[0] <= wanted]
    above = [each for each in tried if each[0] > wanted]
    if below and above:
        (low, start), (high, end) = below[-1], above[0]
        part = math.log(wanted / low) / math.log(high / low)
        return start * (end / start) ** part
    closest, nearest = below[-1] if below else above[0]
    radius = nearest * (wanted / closest) ** (1 / max(power, LEAST))
    return float(np.clip(radius, min(radii) / WITHIN, max(radii) * WITHIN))


def scatter(law: ForceLaw) -> float:
    """Simulate the standard deviation of the fitted R in mm due to the noise of the array."""
    seeds = 5  # number of noisy simulations for the scatter of a fitted R
    fits = [thesis_fit(simulated(law, seed=seed)).radius for seed in range(seeds)]
    return float(np.std(fits, ddof=1))
