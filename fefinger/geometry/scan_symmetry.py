"""Plane of symmetry of the surface of a fingertip, and its back: axes turned by them."""

from typing import Any

import numpy as np

from fefinger.support.arrays import Array


REACH = 1.6
"""Distance from the tip, over the width, up to which a surface is compared with a fingertip."""

OUTLIER = 0.15
"""Distance from the fitted fingertip, over its width, from which a point is none of it."""

BACK = (0.5, 1.35)
"""Range of the distance from the tip, over the width, in which the back is to be level."""

UP, MIDDLE = 0.7, 0.2
"""Least z of a normal of the back, and largest |y| of it over the width."""


def symmetric(
    points: Array, normals: Array, axes: Array, origin: Array, width: float
) -> tuple[Array, Array]:
    """Turn axes (3, 3) and move the origin so that y = 0 is the surface's plane of symmetry."""
    image, normal, off = mirrored(points, normals, axes, origin, width)
    # The image turned by twice the yaw and roll of the plane, and moved by twice its distance.
    turns = np.cross(image, normal)
    matrix = np.column_stack([turns[:, 0], turns[:, 2], normal[:, 1]])
    weight = 1.0 / np.maximum(np.abs(off), 0.02 * width)
    twice = np.linalg.lstsq(matrix * weight[:, None], off * weight, rcond=None)[0]
    roll, yaw, aside = twice / 2.0
    return turned(axes, [roll, 0.0, yaw]), origin + axes.T @ [0.0, aside, 0.0]


def mirrored(
    points: Array, normals: Array, axes: Array, origin: Array, width: float
) -> tuple[Array, Array, Array]:
    """Mirror images (n, 3) of points in y = 0 that are near the surface, and its normals there.

    Also return the distances (n,) of the surface from them, along the normals.
    """
    from scipy.spatial import cKDTree

    seen = (points - origin) @ axes[0] > -REACH * width
    here, facing = (points[seen] - origin) @ axes.T, normals[seen] @ axes.T
    skin = facing[:, 0] > -0.7
    here, facing = here[skin], facing[skin]
    image = here * [1.0, -1.0, 1.0]
    distance, near = cKDTree(here).query(image)
    fits = (distance < OUTLIER * width) & (facing[near] @ [1, 0, 0] > -0.7)
    image, near = image[fits], near[fits]
    return image, facing[near], np.einsum("ij,ij->i", here[near] - image, facing[near])


def leveled(points: Array, normals: Array, axes: Array, origin: Array, width: float) -> Array:
    """Turn axes (3, 3) about y so that the back is level."""
    from scipy.optimize import least_squares

    local, facing = (points - origin) @ axes.T / width, normals @ axes.T
    tip = float(local[:, 0].max())
    behind = tip - local[:, 0]
    seen = (behind > BACK[0]) & (behind < BACK[1])
    seen &= (np.abs(local[:, 1]) < MIDDLE) & (facing[:, 2] > UP)
    x, y, z = local[seen].T
    if len(x) < 10:
        return axes
    terms = np.stack([np.ones_like(x), x, y**2], axis=1)
    fit = least_squares(lambda c: terms @ c - z, np.zeros(3), loss="soft_l1", f_scale=0.02)
    return turned(axes, [0.0, -np.arctan(fit.x[1]), 0.0])


def turned(axes: Array, by: Any) -> Array:
    """Turn axes (3, 3) in rows by a vector (3,) of angles about themselves."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(by).as_matrix().T @ axes)
