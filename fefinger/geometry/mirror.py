"""Mirror images in the medial plane y = 0, and whole bodies put together from their halves.

A half body has y >= 0. Points and vectors change the sign of y; of a tensor the components with
one y change theirs, in a (3, 3) tensor as among the six xx, yy, zz, xy, yz, xz.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError


SIGNS = np.array([1.0, -1.0, 1.0])
"""Factors of a reflection on the components of a vector."""

TENSOR_SIGNS = np.outer(SIGNS, SIGNS)
"""Factors of a reflection on the components (3, 3) of a tensor."""

VOIGT_SIGNS = np.array([1.0, 1.0, 1.0, -1.0, -1.0, 1.0])
"""Factors of a reflection on the components xx, yy, zz, xy, yz, xz of a symmetric tensor."""

ROUNDING = 1e-9
"""Distance from the plane, over the largest coordinate, that is rounding."""

DOUBLED = ("n_cells", "nail_area")
"""Quality figures that double exactly; the number of points is counted again."""


def image(vectors: Array) -> Array:
    """Return the mirror images of points or vectors (..., 3)."""
    return vectors * SIGNS


def to_half(points: Array) -> Array:
    """Map points (n, 3) of a whole body into its half y >= 0.

    Those within rounding of the plane are put on it.
    """
    half = points.copy()
    half[:, 1] = np.abs(points[:, 1])
    half[half[:, 1] < ROUNDING * np.abs(points).max(initial=0.0), 1] = 0.0
    return half


def from_half(tensors: Array, points: Array) -> Array:
    """Return tensors (..., n, 3, 3) at points (n, 3), given those at their places `to_half`."""
    whole = tensors.copy()
    whole[..., points[:, 1] < 0.0, :, :] *= TENSOR_SIGNS
    return whole


@dataclass(frozen=True)
class Halves:
    """Numbering of the points of a whole body: the points of its half, then their mirror images.

    aside (m,): the points off the plane; twin (n,): the number of the image of each of n points; a
    point on the plane is its own image.
    """

    aside: Integers
    twin: Integers

    @classmethod
    def of(cls, points: Array, tolerance: float = 0.0) -> "Halves":
        """Return the numbering of points (n, 3), on the plane up to y = `tolerance` mm."""
        aside = np.flatnonzero(points[:, 1] > tolerance)
        twin = np.arange(len(points))
        twin[aside] = len(points) + np.arange(len(aside))
        return cls(aside, twin)

    @property
    def origin(self) -> Integers:
        """Index in the half of every point of the whole, or of the point that it mirrors."""
        return np.concatenate([np.arange(len(self.twin)), self.aside])

    def values(self, values: Array, axis: int = 0) -> Array:
        """Return values of the whole: even ones, the same at a point and at its image."""
        return np.asarray(np.take(values, self.origin, axis=axis))

    def vectors(self, vectors: Array) -> Array:
        """Return points or vectors (..., n, 3) of the whole."""
        return np.concatenate([vectors, image(vectors[..., self.aside, :])], axis=-2)

    def voigt(self, tensors: Array) -> Array:
        """Return symmetric tensors (..., n, 6) of the whole."""
        return np.concatenate([tensors, tensors[..., self.aside, :] * VOIGT_SIGNS], axis=-2)

    def shares(self, shares: Array) -> Array:
        """Return shares of points in a sum over the whole, as areas (n,): doubled on the plane."""
        doubled = np.where(self.twin == np.arange(len(self.twin)), 2.0 * shares, shares)
        return np.concatenate([doubled, shares[self.aside]])

    def cells(self, cells: Integers) -> Integers:
        """Return the tetrahedra of the whole, (2 m, 4): an image has two vertices changed."""
        return np.concatenate([cells, self.twin[cells][:, [0, 2, 1, 3]]])

    def triangles(self, triangles: Integers) -> Integers:
        """Return the triangles of the whole, (2 m, 3), turned the same way round."""
        return np.concatenate([triangles, self.twin[triangles][:, [0, 2, 1]]])


def whole(half: FingerMesh) -> FingerMesh:
    """Return the whole finger: the half and its mirror image, sharing the vertices of y = 0.

    The mirror images follow the n vertices of the half; a whole mesh has no "medial" facets.
    Raises InputError for a mesh that is whole already.
    """
    if not half.half:
        raise InputError(f"mesh: expected a half finger, received the whole finger {half.name!r}")
    halves = Halves.of(half.points)
    facets = {
        name: halves.triangles(part) for name, part in half.facets.items() if name != "medial"
    }
    return replace(
        half,
        points=halves.vectors(half.points),
        cells=halves.cells(half.cells),
        region=np.concatenate([half.region, half.region]),
        facets=facets,
        pad_normals=halves.vectors(half.pad_normals),
        half=False,
        quality=_quality(half, len(halves.origin)),
    )


def _quality(half: FingerMesh, n_points: int) -> dict[str, Any]:
    """Quality figures of the whole mesh, from the quality of the half."""
    quality = dict(half.quality)
    for key in DOUBLED:
        if key in quality:
            quality[key] = 2 * quality[key]
    for key in ("volumes", "surface_volumes"):
        if key in quality:
            quality[key] = {name: 2.0 * value for name, value in quality[key].items()}
    for key in ("soft_vertices", "taylor_hood_unknowns", "n_pad_vertices"):
        quality.pop(key, None)
    quality["n_points"] = n_points
    return quality
