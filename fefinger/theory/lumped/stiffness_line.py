"""The line of the thesis through the stiffness of a ramp against its force, and the first touch.

Of the ramp alone, taken for instantaneous (Pawluk 1997, section 2.4.1, Eq. 2.1 and 2.4).
"""

import numpy as np
from numpy.typing import NDArray

from fefinger.theory.lumped.confidence import covariance as covariance_of
from fefinger.theory.lumped.ramp_hold import (
    RAMP_POINTS,
    SMOOTHING,
    RampHold,
    accounted,
    derivative,
    smooth,
)
from fefinger.theory.lumped.spring import Spring


Array = NDArray[np.float64]

STEADY = 0.8  # part of the median speed of the ramp below which the indenter starts or stops
CUT = SMOOTHING // 2 + 1  # samples before the hold into which smoothing carries it


def stiffness_line(record: RampHold) -> tuple[float, float, Array, float]:
    """Return m, b, their covariance (2, 2) and the variance accounted for (Eq. 2.4)."""
    part, each = _steady(record), -(-(record.beyond - record.touch) // RAMP_POINTS)
    width = SMOOTHING * each | 1
    steady = slice(part.start, part.stop - (width - SMOOTHING) // 2, each)
    x, f = (smooth(values, width)[steady] for values in (record.position, record.force))
    k, f = derivative(x, f), f[2:-2]
    design = np.column_stack([f, np.ones_like(f)])
    (m, b), *_ = np.linalg.lstsq(design, k, rcond=None)
    if not min(m, b) > 0:
        msg = (
            f"stiffness against force: expected a rising line above 0, found m = {m:.3g} 1/mm and "
            f"b = {b:.3g} N/mm; is the force 0 before touch, is this a ramp into a finger, sampled "
            f"fast enough, and is its noise, {record.force_noise:.2g} N, small enough for slopes?"
        )
        raise ValueError(msg)
    rest = k - design @ (m, b)
    covariance = np.linalg.inv(design.T @ design) * (rest @ rest) / (len(k) - 2)
    return float(m), float(b), covariance, accounted(k, k - rest)


def _steady(record: RampHold) -> slice:
    """Return the part of the ramp in contact between the corners, where the speed is steady."""
    part = slice(record.touch, record.beyond - CUT)
    if part.stop - part.start < SMOOTHING:
        msg = (
            f"ramp: expected {SMOOTHING + CUT} samples or more from touch until the indenter is as "
            f"far in as in the hold, found {record.beyond - record.touch}; sample faster, or ramp "
            "so that it goes less beyond the hold"
        )
        raise ValueError(msg)
    speed = np.gradient(smooth(smooth(record.position)), record.time)[part]
    fast = np.flatnonzero(speed >= STEADY * np.median(speed))
    return slice(part.start + int(fast[0]), part.start + int(fast[-1]) + 1)


def touch(
    record: RampHold, m: float, b: float, covariance: Array
) -> tuple[float, float, tuple[str, ...]]:
    """Return x0 by least squares of Eq. 2.1 on the ramp with m and b kept, and its deviation.

    Most of it is that of m and b, by their `covariance`. And a sentence where the search was not
    done.
    """
    from scipy.optimize import least_squares

    x, f = record.position[: record.beyond], record.force[: record.beyond]
    start = float(x[record.touch :].min())

    def residual(x0: Array) -> Array:
        return Spring(b, m, float(x0[0])).force(x) - f

    found = least_squares(residual, [start], x_scale="jac")
    spring, by_x0 = Spring(b, m, float(found.x[0])), found.jac[:, 0]
    pressed, y = spring.force(x), spring.depth(x)
    by_line = np.stack([(b * y * np.exp(m * y) - pressed) / m, pressed / b], axis=1)
    moved = by_x0 @ by_line / (by_x0 @ by_x0)
    own = covariance_of(found.jac, found.fun)[0, 0]
    spread = float(np.sqrt(own + moved @ covariance @ moved))
    said = f"x0 = {found.x[0]:.4g} mm had not settled after {found.nfev} evaluations"
    return float(found.x[0]), spread, () if found.success else (said,)
