"""Elliptic Hertz contact for comparison with a study: half-space with the skin's curvatures."""

from typing import Any

import numpy as np

from fefinger.mesh.first_touch import FirstTouch
from fefinger.result import Result
from fefinger.results.pressure import SPREAD
from fefinger.studies.times import SAME, until
from fefinger.support.arrays import Array
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.contact.elliptic import LONGEST, Elliptic
from fefinger.theory.relaxation import hereditary_integral


NODES = 64, 32
"""Gauss points along the radius and over a quarter turn; more points change the mean by less than
1e-6 for half axes of up to 50 mm."""


def hertz(result: Result, touch: FirstTouch, where: float) -> dict[str, Any]:
    """Make the columns of elliptic Hertz contact with the curvatures at first touch.

    The depth over time is that of the result. The half-space has the mean compliance of skin and
    pulp and relaxes as the finger does: its instantaneous modulus is the relaxed one over
    G(infinity). There are no columns for a concave skin, an object that is neither plate nor
    sphere, or once the contact has shrunk.
    """
    from fefinger.mechanics.hertz import tissue

    scene, indenter = result.scene, result.scene.indenter
    if indenter.flat is None and indenter.ball_radius is None:
        return {}
    curvature = 1 / indenter.ball_radius if indenter.ball_radius is not None else 0.0
    (low, high), axes = np.linalg.eigh(touch.curvature + curvature * np.eye(2))
    depth = until(result.depth, where)
    if low <= 0 or high / low > LONGEST or (np.diff(depth) < -SAME * depth.max()).any():
        return {}
    unit = Elliptic(1 / low, 1 / high, 1 / high, *tissue(scene.finger))
    time, part = until(result.time, where), np.maximum(depth, 0.0) * high
    mean = np.sqrt(part) * share(np.sqrt(part)[:, None] * unit.semi_axes)
    prony = scene.finger.prony
    force, peak, highest = (
        hereditary_integral(prony, time, elastic)[-1] / prony.long_time
        for elastic in (part**1.5, np.sqrt(part), mean)
    )
    distal, side = (1 / (k + curvature) for k in np.diag(touch.curvature))
    return {
        "hertz_radius_distal_mm": float(distal),
        "hertz_radius_side_mm": float(side),
        "hertz_force_N": float(force * unit.force) * NEWTON_PER_MILLINEWTON,
        "hertz_contact_area_mm2": float(part[-1] * unit.area),
        "hertz_highest_pressure_1mm2_kPa": float(highest * unit.peak_pressure),
        "hertz_peak_pressure_kPa": float(peak * unit.peak_pressure),
        "hertz_ellipticity": round(1 - unit.axis_ratio, 12),
        "hertz_long_axis_deg": float((np.degrees(np.arctan2(*axes[::-1, 0])) + 90) % 180 - 90),
    }


def share(semi_axes: Array) -> Array:
    """Mean pressure over 1 mm² about the center, over the peak pressure, for axes (n, 2) in mm.

    The mean is weighted by the Gaussian of `pressures.peaks`.
    """
    (s, ds), (t, dt) = (np.polynomial.legendre.leggauss(count) for count in NODES)
    near, turn = (s + 1) / 2, np.pi / 4 * (t + 1)  # dense about the middle; the angle
    height = 1 - near**2  # pressure over its peak
    weights = np.outer(height**2 * near * ds, np.pi * dt)  # four quarters
    a, b = semi_axes.T
    across = (np.outer(a, np.cos(turn)) ** 2 + np.outer(b, np.sin(turn)) ** 2) / (2 * SPREAD**2)
    falls = np.exp(-(1 - height[:, None] ** 2) * across[:, None, :])
    return np.asarray(a * b * np.einsum("nst,st->n", falls, weights) / (2 * np.pi * SPREAD**2))
