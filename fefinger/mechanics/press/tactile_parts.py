"""What a tactile finger is given and read by: poses of objects, and a grid of taxels."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fefinger.contact.pad_worlds import Pad
from fefinger.shapes import Shape
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, integer, number


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
        integer("taxels.rows", self.rows, at_least=1)
        integer("taxels.columns", self.columns, at_least=1)
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
