"""What a tactile finger is given and read by: poses of objects, and a grid of taxels."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fefinger.contact.pad_worlds import Pad
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import Flat
from fefinger.shapes import Shape
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import (
    HUGE,
    InputError,
    instance,
    number,
    numbers,
    set_integer,
    shown,
)


@dataclass(frozen=True)
class TaxelGrid:
    """A grid of taxels over the pad, rows along x (distal) and columns along y.

    pitch mm; center (2,) mm of the grid: beneath the middle of the pad by default. The skin beside
    the grid belongs to the nearest taxel, so that no force is lost.
    """

    rows: int
    columns: int
    pitch: float = 1.6
    center: tuple[float, float] = (-4.0, 0.0)

    def __post_init__(self) -> None:
        """Check the numbers."""
        most = 1000  # along a side: a hundred in a millimeter
        set_integer(self, "taxels.rows", at_least=1, at_most=most)
        set_integer(self, "taxels.columns", at_least=1, at_most=most)
        numbers("taxels.center", self.center, count=2, unit="mm")
        number("taxels.pitch", self.pitch, above=0, unit="mm")

    @property
    def places(self) -> Array:
        """Middle (rows * columns, 2) mm of each taxel, column by column within a row."""
        x, y = (
            middle + self.pitch * (np.arange(n) - (n - 1) / 2)
            for middle, n in zip(self.center, (self.rows, self.columns), strict=True)
        )
        return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)

    def weights(self, pad: Pad) -> sparse.csr_matrix:
        """Return N/kPa (n_taxels, n) of unit tractions: integrals of their hats over a taxel."""
        counts = self.rows, self.columns
        start = self.places[0]
        at = np.rint((pad.places[..., :2] - start) / self.pitch).astype(int)
        row, column = (np.clip(at[..., k], 0, counts[k] - 1) for k in (0, 1))
        taxel = np.broadcast_to((row * self.columns + column)[:, None], pad.hats.shape)
        owner = np.broadcast_to(pad.owner[:, :, None], pad.hats.shape)
        owned = owner >= 0
        entries = 1e-3 * pad.hats[owned], (taxel[owned], owner[owned])
        return sparse.csr_matrix(entries, shape=(self.rows * self.columns, len(pad.areas)))


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


def poses(objects: Sequence[Pose], worlds: int, field: str = "objects") -> Poses:
    """Return the poses of objects in all worlds; InputError of `field` for what is none."""
    shapes: list[Shape] = []
    instance(field, objects, Sequence, "a list of (shape, rotation, place)")
    count, leading = worlds, worlds > 1
    rotation, place = np.empty((count, len(objects), 3, 3)), np.empty((count, len(objects), 3))
    for b, each in enumerate(objects):
        try:
            shape, turn, at = each
        except (TypeError, ValueError) as error:
            raise InputError(
                f"{field}: expected (shape, rotation, place) of each, received {shown(each)}"
            ) from error
        if not isinstance(shape, Shape):
            raise InputError(
                f"{field}: expected a shape such as ff.shapes.Sphere(10), received {shown(shape)}"
            )
        shapes.append(shape)
        turned = _array(f"{field}: expected a rotation", turn, (3, 3), b, count)
        there = _array(f"{field}: expected a place", at, (3,), b, count)
        leading |= turned.ndim == 3 or there.ndim == 2
        rotation[:, b], place[:, b] = turned, there
    if not (np.abs(place) <= HUGE).all():
        raise InputError(
            f"{field}: expected finite places in mm, at most {HUGE:g}, received others"
        )
    # R' R - 1 of a rotation matrix that was written in single precision is 1e-7.
    within = (np.abs(rotation) <= 2.0).all()
    off = np.abs(np.swapaxes(rotation, -1, -2) @ rotation - np.eye(3)) if within else np.inf
    if not np.all(off <= 1e-6) or (np.linalg.det(rotation) < 0).any():
        raise InputError(
            f"{field}: expected rotation matrices, with R' R = 1 and determinant 1, received "
            "another; give columns that are the object's axes in the frame of the finger"
        )
    return Poses(tuple(shapes), rotation, place, leading)


def _array(expected: str, given: object, shape: tuple[int, ...], number: int, worlds: int) -> Array:
    """Return a rotation or a place of an object, (*shape) or (worlds, *shape)."""
    array: Array = np.empty(0)
    with suppress(TypeError, ValueError, OverflowError):
        array = np.asarray(given, float)
    if array.shape not in {shape, (worlds, *shape)}:
        received = f"shape {array.shape}" if array.size else shown(given)
        raise InputError(
            f"{expected} {shape} or {(worlds, *shape)} of object {number}, received {received}"
        )
    return array


class TouchState(NamedTuple):
    """State of all worlds of a tactile finger, some 30 kB each."""

    arrays: tuple[Array | Flags, ...]


def under(angle: float) -> Array:
    """Return the rotation (3, 3) that turns z to the normal of a plate, at an angle in degrees."""
    z = direction(Flat(angle))
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
