"""Line fit of stiffness against force on a ramp, and position of first touch.

The method of the thesis, which treats the ramp as instantaneous (Pawluk 1997, section 2.4.1, Eq.
2.1 and 2.4).
"""

import numpy as np

from fefinger.theory.contact.elastic import Array
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


STEADY = 0.8  # fraction of the median speed below which the indenter starts or stops
CUT = SMOOTHING // 2 + 1  # samples before the hold that smoothing mixes with it


def stiffness_line(record: RampHold) -> tuple[float, float, Array, float]:
    """Fit m and b of Eq. 2.4; also return their covariance (2, 2) and variance accounted for."""
    part, each = _steady(record), -(-(record.beyond - record.touch) // RAMP_POINTS)
    # | 1 makes it odd, and the window symmetric; a wider one mixes more of the corner in.
    width = SMOOTHING * each | 1
    steady = slice(part.start, part.stop - (width - SMOOTHING) // 2, each)
    x, f = (smooth(values, width)[steady] for values in (record.position, record.force))
    k, f = derivative(x, f), f[2:-2]
    design = np.column_stack([f, np.ones_like(f)])
    (m, b), *_ = np.linalg.lstsq(design, k, rcond=None)
    if not min(m, b) > 0:
        raise ValueError(
            f"stiffness against force: expected a rising line above 0, received m = {m:.3g} 1/mm "
            f"and b = {b:.3g} N/mm; check that the force is 0 before touch, the ramp sampled fast "
            f"enough, and that noise ({record.force_noise:.2g} N) is small enough for slopes"
        )
    rest = k - design @ (m, b)
    covariance = np.linalg.inv(design.T @ design) * (rest @ rest) / (len(k) - 2)
    return float(m), float(b), covariance, accounted(k, k - rest)


def _steady(record: RampHold) -> slice:
    """Find the samples of the ramp in contact with steady speed, between the corners."""
    part = slice(record.touch, record.beyond - CUT)
    if part.stop - part.start < SMOOTHING:
        raise ValueError(
            f"ramp: expected {SMOOTHING + CUT} samples or more from touch to the depth of the "
            f"hold, received {record.beyond - record.touch}; sample faster, or ramp with less "
            "overshoot"
        )
    speed = np.gradient(smooth(smooth(record.position)), record.time)[part]
    fast = np.flatnonzero(speed >= STEADY * np.median(speed))
    return slice(part.start + int(fast[0]), part.start + int(fast[-1]) + 1)


def touch(
    record: RampHold, m: float, b: float, covariance: Array
) -> tuple[float, float, tuple[str, ...]]:
    """Fit x0 of Eq. 2.1 to the ramp with m and b fixed: x0, standard deviation, and warnings.

    Most of the deviation is due to that of m and b, by their `covariance`. The warning is on a fit
    that did not converge.
    """
    from scipy.optimize import least_squares

    x, f = record.position[: record.beyond], record.force[: record.beyond]
    start = float(x[record.touch :].min())

    def residual(x0: Array) -> Array:
        return Spring(b, m, float(x0[0])).force(x) - f

    fit = least_squares(residual, [start], x_scale="jac")
    spring, by_x0 = Spring(b, m, float(fit.x[0])), fit.jac[:, 0]
    pressed, y = spring.force(x), spring.depth(x)
    by_line = np.stack([(b * y * np.exp(m * y) - pressed) / m, pressed / b], axis=1)
    by_m_and_b = by_x0 @ by_line / (by_x0 @ by_x0)
    variance = covariance_of(fit.jac, fit.fun)[0, 0]
    spread = float(np.sqrt(variance + by_m_and_b @ covariance @ by_m_and_b))
    warning = f"x0 = {fit.x[0]:.4g} mm had not converged after {fit.nfev} evaluations"
    return float(fit.x[0]), spread, () if fit.success else (warning,)
