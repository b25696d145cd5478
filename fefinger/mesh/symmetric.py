"""Mesh of a whole finger from its half, mirrored in the medial plane."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.support.checks import InputError


DOUBLED = ("n_cells", "nail_area")
"""Quality figures that double exactly; the number of points is counted again."""


def whole(half: FingerMesh) -> FingerMesh:
    """Return the whole finger: the half and its mirror image, sharing the vertices of y = 0.

    The mirror images follow the n vertices of the half; a whole mesh has no "medial" facets.
    Raises InputError for a mesh that is whole already.
    """
    if not half.half:
        message = f"mesh: expected a half finger, received the whole finger {half.name!r}"
        raise InputError(message)
    count = len(half.points)
    twin = np.arange(count)
    aside = half.points[:, 1] != 0.0
    twin[aside] = count + np.arange(int(aside.sum()))
    mirror = np.array([1.0, -1.0, 1.0])
    facets = {
        name: np.concatenate([part, twin[part][:, [0, 2, 1]]])
        for name, part in half.facets.items()
        if name != "medial"
    }
    return replace(
        half,
        points=np.concatenate([half.points, half.points[aside] * mirror]),
        cells=np.concatenate([half.cells, twin[half.cells][:, [0, 2, 1, 3]]]),
        region=np.concatenate([half.region, half.region]),
        facets=facets,
        pad_normals=np.concatenate([half.pad_normals, half.pad_normals[aside] * mirror]),
        half=False,
        quality=_quality(half, twin),
    )


def _quality(half: FingerMesh, twin: NDArray[np.int64]) -> dict[str, Any]:
    """Quality figures of the whole mesh from those of the half."""
    quality = dict(half.quality)
    for key in DOUBLED:
        if key in quality:
            quality[key] = 2 * quality[key]
    for key in ("volumes", "surface_volumes"):
        if key in quality:
            quality[key] = {name: 2.0 * value for name, value in quality[key].items()}
    for key in ("soft_vertices", "taylor_hood_unknowns", "n_pad_vertices"):
        quality.pop(key, None)
    quality["n_points"] = int(twin.max()) + 1
    return quality
