"""Frame of the mesh: the plate at 30 degrees that defines its origin, and the pad's radii there.

The origin P30 of every finger is the point that this plate touches first.
"""

import numpy as np

from fefinger.support.arrays import Array


PLATE = np.radians(30.0)
PLATE_NORMAL = np.array([np.sin(PLATE), 0.0, -np.cos(PLATE)])
"""Outward pad normal at P30."""

ALONG = np.array([np.cos(PLATE), 0.0, np.sin(PLATE)])
"""Direction along the pad at P30, towards the tip."""

PATCH_CENTER = np.array([-1.8, 0.0, -0.7])
PATCH_RADIUS = 5.0
"""Ball in mm that contains the contact with the plate: it extends toward the flatter pad."""

FIT_RADIUS = 2.0
"""Radius in mm around P30 within which the quadric is fitted."""


def fitted_radii(points: Array) -> tuple[float, float]:
    """Return the normal curvature radii (R', R'') mm of a surface through points at the origin.

    The surface must touch the 30-degree plate there; points farther than 2 mm are left out.
    Least squares of height = c0 + c1 u + c2 v + u^2/(2 R') + v^2/(2 R'') + c5 u v along the
    inward normal, with u along the finger and v across it.
    """
    near = points[np.linalg.norm(points, axis=1) < FIT_RADIUS]
    if len(near) < 6:
        return float("nan"), float("nan")
    along = near @ ALONG
    across, height = near[:, 1], -near @ PLATE_NORMAL
    terms = [along**2 / 2, across**2 / 2, along * across, along, across, np.ones(len(near))]
    fit = np.linalg.lstsq(np.stack(terms, axis=1), height, rcond=None)[0]
    return float(1.0 / fit[0]), float(1.0 / fit[1])
