"""Frame of the mesh: the plate at 30 degrees that defines its origin, and the pad's radii there.

The origin P30 of every finger is the point that this plate touches first.
"""

import numpy as np

from fefinger.support.arrays import Array


PLATE = np.radians(30.0)
PLATE_NORMAL = np.array([np.sin(PLATE), 0.0, -np.cos(PLATE)])
"""Outward pad normal at P30."""

ALONG = np.array([np.cos(PLATE), 0.0, np.sin(PLATE)])
"""Direction along the pad at P30, toward the tip."""

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
    along, across = np.diag(curvature(points, np.stack([ALONG, [0.0, 1.0, 0.0]]), -PLATE_NORMAL))
    return float(1.0 / along), float(1.0 / across)


def curvature(points: Array, across: Array, inward: Array) -> Array:
    """Return the second derivatives (2, 2) 1/mm of the quadric fitted within 2 mm of the origin.

    points (n, 3) mm of a surface, whose height along `inward` (3,) is a function of u and v along
    the rows of `across` (2, 3). NaN where there are fewer than 6 points.
    """
    near = points[np.linalg.norm(points, axis=1) < FIT_RADIUS]
    if len(near) < 6:
        return np.full((2, 2), np.nan)
    u, v = across @ near.T
    terms = [u**2 / 2, v**2 / 2, u * v, u, v, np.ones(len(u))]
    fit = np.linalg.lstsq(np.stack(terms, axis=1), near @ inward, rcond=None)[0]
    return np.array([[fit[0], fit[2]], [fit[2], fit[1]]])
