"""Poses of the objects that a tactile finger feels, checked."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fefinger.shapes import Shape
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


Pose = tuple[Shape, ArrayLike, ArrayLike]
"""An object, its rotation (3, 3) and its place (3,) mm in the frame of the finger."""


class Poses(NamedTuple):
    """Objects, rotations (worlds, bodies, 3, 3) and places (worlds, bodies, 3) mm.

    leading: whether readings have an axis of worlds.
    """

    shapes: tuple[Shape, ...]
    rotation: Array
    place: Array
    leading: bool


def poses(objects: Sequence[Pose], worlds: int) -> Poses:
    """Return the poses of objects in all worlds; InputError for what is none."""
    shapes: list[Shape] = []
    count, leading = worlds, worlds > 1
    rotation, place = np.empty((count, len(objects), 3, 3)), np.empty((count, len(objects), 3))
    for b, each in enumerate(objects):
        try:
            shape, turn, at = each
        except (TypeError, ValueError) as error:
            raise InputError(
                f"objects: expected (shape, rotation, place) of each, received {each!r}"
            ) from error
        if not isinstance(shape, Shape):
            raise InputError(
                f"objects: expected a shape such as ff.shapes.Sphere(10), received {shape!r}"
            )
        shapes.append(shape)
        turned, there = np.asarray(turn, float), np.asarray(at, float)
        for name, array, wanted in (("rotation", turned, (3, 3)), ("place", there, (3,))):
            if array.shape not in {wanted, (count, *wanted)}:
                raise InputError(
                    f"objects: expected a {name} {wanted} or {(count, *wanted)} of object {b}, "
                    f"received an array of shape {array.shape}"
                )
        leading |= turned.ndim == 3 or there.ndim == 2
        rotation[:, b], place[:, b] = turned, there
    if not np.isfinite(place).all():
        raise InputError("objects: expected finite places in mm, received nan or inf")
    off = np.abs(np.einsum("wbki,wbkj->wbij", rotation, rotation) - np.eye(3))
    # R' R - 1 of a rotation matrix that was written in single precision is 1e-7.
    if not (off <= 1e-6).all() or (np.linalg.det(rotation) < 0).any():
        raise InputError(
            "objects: expected rotation matrices, with R' R = 1 and determinant 1, received "
            "another; give columns that are the object's axes in the frame of the finger"
        )
    return Poses(tuple(shapes), rotation, place, leading)
