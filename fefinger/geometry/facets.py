"""Faces of a tetrahedral mesh: which are shared, which are boundary, and what they are called."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import BONE, faces


Index = NDArray[np.int64]

FLAT = 0.9
"""Smallest cosine between a facet and the plane it is said to lie in."""


def interfaces(cells: Index, region: NDArray[np.int8]) -> tuple[Index, Index, Index]:
    """Return the faces where the region changes: (f, 3) outward, and the regions on both sides.

    Boundary faces come once with outer region 0; a face between two regions comes once, seen from
    the region of the smaller number (the outer tissue), whose outward normal it carries.
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


def parts(cells: Index) -> int:
    """Return in how many parts the cells fall that hang together by faces."""
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
    points: NDArray[np.float64],
    cells: Index,
    region: NDArray[np.int8],
    *,
    cut: float,
    tolerance: float,
    level: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> dict[str, Index]:
    """Return the named facets, the outer skin with the nail still as "pad", and the two interfaces.

    "skin-subcutaneous" is the interface of the tissues. A face within `tolerance` mm of a plane
    belongs to that plane if it is parallel to it or reaches under the skin, whose signed distance
    is `level`.
    """
    found, inner, outer = interfaces(cells, region)
    corners = points[found]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    boundary = outer == 0
    deep = level(corners.reshape(-1, 3)).reshape(-1, 3).min(axis=1) < -2.0 * tolerance
    medial = boundary & (np.abs(corners[:, :, 1]).max(1) < tolerance)
    medial &= deep | (normal[:, 1] < -FLAT)
    at_cut = boundary & ~medial & (np.abs(corners[:, :, 0] - cut).max(1) < tolerance)
    at_cut &= deep | (normal[:, 0] < -FLAT)
    return {
        "pad": found[boundary & ~medial & ~at_cut],
        "cut": found[at_cut & (inner != BONE)],
        "bone-cut": found[at_cut & (inner == BONE)],
        "medial": found[medial],
        "bone": found[~boundary & (outer == BONE)],
        "skin-subcutaneous": found[~boundary & (outer != BONE)],
    }
