"""Faces of a tetrahedral mesh: interfaces of regions, boundary, and the named facet sets."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import BONE, faces
from fefinger.support.arrays import Array, Integers


FLAT = 0.9
"""Smallest cosine between the normals of a facet and of the plane it is assigned to."""


def interfaces(cells: Integers, region: NDArray[np.int8]) -> tuple[Integers, Integers, Integers]:
    """Faces where the region changes: (f, 3) outward, and the regions on both sides.

    Boundary faces have the outer region 0. A face between two regions appears once, with the
    outward normal of the region of the smaller number (the outer tissue).
    """
    all_faces = faces(cells).reshape(-1, 3)
    owner = np.repeat(region.astype(np.int64), 4)
    _, inverse, count = np.unique(
        np.sort(all_faces, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    inverse = inverse.ravel()
    total = np.bincount(inverse, weights=owner).astype(np.int64)
    other = np.where(count[inverse] == 2, total[inverse] - owner, 0)
    keep = (other == 0) | (owner < other)
    return all_faces[keep], owner[keep], other[keep]


def parts(cells: Integers) -> int:
    """Count the parts of a mesh whose cells are connected by faces."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not len(cells):
        return 0
    every = np.sort(faces(cells).reshape(-1, 3), axis=1)
    _, face = np.unique(every, axis=0, return_inverse=True)
    owner = np.repeat(np.arange(len(cells)), 4)
    links = coo_array((np.ones(len(owner)), (owner, face.ravel())))
    return int(connected_components(links @ links.T, directed=False)[0])


def facet_sets(
    points: Array,
    cells: Integers,
    region: NDArray[np.int8],
    *,
    cut: float,
    tolerance: float,
    level: Callable[[Array], Array],
) -> dict[str, Integers]:
    """Sort boundary and interface faces into named sets; "pad" is all of the outer skin.

    "skin-subcutaneous" is the interface of the tissues; the nail is separated from "pad" later. A
    face within `tolerance` mm of a plane belongs to that plane if it is parallel to it or extends
    below the skin, whose signed distance is `level`.
    """
    boundary_faces, inner, outer = interfaces(cells, region)
    corners = points[boundary_faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    boundary = outer == 0
    deep = level(corners.reshape(-1, 3)).reshape(-1, 3).min(axis=1) < -2.0 * tolerance
    medial = boundary & (np.abs(corners[:, :, 1]).max(1) < tolerance)
    medial &= deep | (normal[:, 1] < -FLAT)
    at_cut = boundary & ~medial & (np.abs(corners[:, :, 0] - cut).max(1) < tolerance)
    at_cut &= deep | (normal[:, 0] < -FLAT)
    return {
        "pad": boundary_faces[boundary & ~medial & ~at_cut],
        "cut": boundary_faces[at_cut & (inner != BONE)],
        "bone-cut": boundary_faces[at_cut & (inner == BONE)],
        "medial": boundary_faces[medial],
        "bone": boundary_faces[~boundary & (outer == BONE)],
        "skin-subcutaneous": boundary_faces[~boundary & (outer != BONE)],
    }
