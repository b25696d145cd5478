"""Last steps of every mesh builder: constraints of the vertices, bone volume, mesh record."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import FACETS, FingerMesh, volumes
from fefinger.mesh import smooth
from fefinger.mesh.finger_shape import Shape
from fefinger.mesh.quality import measure
from fefinger.mesh.recipe import Recipe
from fefinger.support.arrays import Array, Flags, Integers


ON_SHELLS = ("pad", "skin-subcutaneous", "bone")
"""Facet sets on the outer surfaces of skin, subcutaneous tissue and bone; the nail is pad here."""

TRIAL = 0.01
"""Offset in mm of the bone's surface from which its volume is extrapolated."""


def supports(shape: Shape, count: int, facets: Mapping[str, Integers]) -> smooth.Supports:
    """Constraints of each vertex: the surface of a shell, the medial plane, the cut."""
    on = np.full(count, -1)
    for number, name in enumerate(ON_SHELLS):
        on[np.unique(facets[name])] = number
    free = np.ones((count, 3), dtype=bool)
    free[np.unique(facets["medial"]), 1] = False
    free[np.unique(np.concatenate([facets["cut"], facets["bone-cut"]])), 0] = False
    return smooth.Supports(on, free, shape.shells)


def bone_of_volume(
    shape: Shape, points: Array, bone: Integers, free: Flags, volume: float
) -> Array:
    """Offset the bone's surface so that its cells (m, 4) have the volume, mm^3.

    The bone is thin and strongly curved: facets with vertices on it would lose 2 to 3 %.
    `free` (n, 3): the coordinates that may change; all are False beside the surface of the bone.
    """
    on = free.any(axis=1)
    moves = np.zeros_like(points)
    moves[on] = shape.bone.normals(points[on]) * free[on]
    present, trial = (volumes(points + step * moves, bone).sum() for step in (0.0, TRIAL))
    return points + TRIAL * (volume - present) / (trial - present) * moves


def record(
    shape: Shape,
    recipe: Recipe,
    points: Array,
    cells: Integers,
    region: NDArray[np.int8],
    facets: Mapping[str, Integers],
    *,
    name: str,
) -> FingerMesh:
    """Make the mesh record, with smooth normals and measured quality; facets as in FACETS."""
    sets = {key: facets[key] for key in FACETS}
    pad = np.unique(sets["pad"])
    gap = float(np.abs(shape.skin.level(points[pad])).max())
    normals = np.zeros_like(points)
    normals[pad] = shape.skin.normals(points[pad])
    mesh = FingerMesh(
        points, cells, region, sets, normals, half=True, name=name, recipe=recipe.to_dict()
    )
    quality = measure(mesh, radii=shape.radii, surface_volumes=shape.volumes, gap=gap)
    if shape.notes:
        quality["notes"] = list(shape.notes)
    return replace(mesh, quality=quality)
