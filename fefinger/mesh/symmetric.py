"""Mesh of a whole finger from its half, mirrored in the medial plane."""

from dataclasses import replace
from typing import Any

import numpy as np

from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.geometry.mirror import Halves
from fefinger.support.checks import InputError


DOUBLED = ("n_cells", "nail_area")
"""Quality figures that double exactly; the number of points is counted again."""


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
    quality["n_points"] = n_points
    return quality
