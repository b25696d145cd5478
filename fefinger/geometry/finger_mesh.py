"""Mesh of a finger as plain arrays, with volumes, faces, edges and boundaries."""

from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.support.arrays import Array, Integers


SKIN, SUBCUTANEOUS, BONE = 1, 2, 3
REGIONS = {"skin": SKIN, "subcutaneous": SUBCUTANEOUS, "bone": BONE}

FACETS = ("pad", "nail", "cut", "bone", "medial", "bone-cut")
"""Names of the facet sets: every boundary facet is in one of them, and "bone" is an interface."""


@dataclass(frozen=True)
class FingerMesh:
    """Tetrahedra of a finger or of its half y >= 0; frame x distal, y radial, z dorsal, in mm.

    The origin is the mesh vertex that a plate at 30 degrees touches first.

    Attributes
    ----------
    points : (n, 3) vertices, mm.
    cells : (m, 4) vertex indices, positively oriented.
    region : (m,) 1 skin, 2 subcutaneous tissue, 3 bone.
    facets : name -> (k, 3) vertex indices, normals pointing out of the soft tissue ("medial" and
        "bone-cut": out of the finger). "pad": outer skin but for nail and cut; "nail": skin
        under the nail; "cut": soft tissue at the proximal cut; "bone": interface of soft tissue
        and bone; "medial": plane y = 0 of a half; "bone-cut": bone at the proximal cut.
    pad_normals : (n, 3) unit outward normals of the smooth surface at pad vertices, else zero.
    half : whether only y >= 0 is meshed.
    name : subject and resolution, such as "ah-standard".
    recipe : dimensions and resolution that the mesh was built from.
    quality : measured figures, see `fefinger.mesh.quality`.
    source_sha256 : hash of the file that it was read from, empty if it was built in memory.

    """

    points: Array
    cells: Integers
    region: NDArray[np.int8]
    facets: dict[str, Integers]
    pad_normals: Array
    half: bool
    name: str = "finger"
    recipe: dict[str, Any] = field(default_factory=dict)
    quality: dict[str, Any] = field(default_factory=dict)
    source_sha256: str = ""

    @property
    def fingerprint(self) -> str:
        """SHA-256 of the geometry: points, cells and regions."""
        import hashlib

        parts = (self.points, self.cells, self.region)
        return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()


def volumes(points: Array, cells: Integers) -> Array:
    """Return the signed volume of each tetrahedron, (m,) mm^3."""
    corners = points[cells]
    edges = corners[:, 1:] - corners[:, :1]
    return np.asarray(np.einsum("ij,ij->i", np.cross(edges[:, 0], edges[:, 1]), edges[:, 2]) / 6.0)


def faces(cells: Integers) -> Integers:
    """Return the four outward faces of each positive tetrahedron, (m, 4, 3)."""
    return cells[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]]


def edges(simplices: Integers) -> Integers:
    """Return the edges of triangles or tetrahedra (m, k) once each, (e, 2) ascending."""
    pairs = simplices[:, list(combinations(range(simplices.shape[1]), 2))].reshape(-1, 2)
    return np.unique(np.sort(pairs, axis=1), axis=0)


def boundary_edges(triangles: Integers) -> Integers:
    """Return the edges (k, 2) that only one of the triangles (n, 3) has, ascending."""
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2), axis=1)
    edges, count = np.unique(pairs, axis=0, return_counts=True)
    return np.asarray(edges[count == 1])


def triangle_areas(corners: Array) -> Array:
    """Return the areas (...) mm^2 of triangles of corners (..., 3, 3) mm."""
    sides = corners[..., 1:, :] - corners[..., :1, :]
    return np.asarray(np.linalg.norm(np.cross(sides[..., 0, :], sides[..., 1, :]), axis=-1) / 2.0)
