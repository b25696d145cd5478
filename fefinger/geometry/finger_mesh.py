"""Mesh of a finger as plain arrays: volumes, faces, boundaries, where a point lies, and its mirror.

A half body has y >= 0. Mirrored in y = 0, points and vectors change the sign of y; of a tensor the
components with one y change theirs, in a (3, 3) tensor as among the six xx, yy, zz, xy, yz, xz.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError


SKIN, SUBCUTANEOUS, BONE = 1, 2, 3  # regions of a mesh, as stored in files
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
    quality : measured figures, see `fefinger.mesh.mesh_record`.
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
    flat = 0.9  # smallest cosine between the normals of a facet and of the plane it is assigned to
    medial &= deep | (normal[:, 1] < -flat)
    at_cut = boundary & ~medial & (np.abs(corners[:, :, 0] - cut).max(1) < tolerance)
    at_cut &= deep | (normal[:, 0] < -flat)
    return {
        "pad": boundary_faces[boundary & ~medial & ~at_cut],
        "cut": boundary_faces[at_cut & (inner != BONE)],
        "bone-cut": boundary_faces[at_cut & (inner == BONE)],
        "medial": boundary_faces[medial],
        "bone": boundary_faces[~boundary & (outer == BONE)],
        "skin-subcutaneous": boundary_faces[~boundary & (outer != BONE)],
    }


def barycentric(corners: Array, points: Array) -> Array:
    """Return the weights (..., d + 1) of simplex corners (..., d + 1, d) that give points (..., d).

    They sum to 1 and are 0 or more inside. A simplex without a volume has none: -inf.
    """
    first = corners[..., 0, :]
    sides = np.swapaxes(corners[..., 1:, :] - first[..., None, :], -1, -2)
    volume = np.linalg.det(sides)
    flat = volume == 0.0
    sides = np.where(flat[..., None, None], np.eye(sides.shape[-1]), sides)
    others = np.linalg.solve(sides, (points - first)[..., None])[..., 0]
    weights = np.concatenate([1 - others.sum(axis=-1, keepdims=True), others], axis=-1)
    return np.where(flat[..., None], -np.inf, weights)


def around(
    corners: Array, points: Array, *, margin: float = 0.0
) -> Iterator[tuple[Integers, Array]]:
    """Yield, for each of the points (n, d), the simplices (k,) near it and its weights (k, d + 1).

    A simplex (of m with corners (m, d + 1, d)) is near, and may hold the point, if the point lies
    in the sphere about its center, enlarged by the share `margin`.
    """
    centers = corners.mean(axis=1)
    radii = np.linalg.norm(corners - centers[:, None], axis=2).max(axis=1)
    reach = ((1 + margin) * radii) ** 2
    for point in points:
        apart = centers - point
        near = np.flatnonzero(np.einsum("ij,ij->i", apart, apart) <= reach)
        yield near, barycentric(corners[near], point)


def locate(corners: Array, points: Array, *, nearest: int | None = None) -> tuple[Integers, Array]:
    """Return the simplex (n,) that holds each of the points (n, d), or comes closest, and weights.

    corners (m, d + 1, d); the weights (n, d + 1) of its corners have one below 0 for a point that
    none holds. `nearest`: only so many simplices are looked at, those with the nearest centers.
    """
    count = min(nearest or len(corners), len(corners))
    near = np.broadcast_to(np.arange(count), (len(points), count))
    if count < len(corners):
        from scipy.spatial import cKDTree

        near = cKDTree(corners.mean(axis=1)).query(points, np.arange(1, count + 1))[1]
    weights = barycentric(corners[near], points[:, None])
    best = np.argmax(weights.min(axis=-1), axis=1)
    rows = np.arange(len(points))
    return near[rows, best], weights[rows, best]


def inside_weights(corners: Array, points: Array) -> tuple[Integers, Array]:
    """Return the simplex (n,) of each of the points (n, d), as `locate`, with weights of 0 or more.

    A point that no simplex holds gets weights in the simplex that comes closest.
    """
    simplex, weights = locate(corners, points, nearest=24)
    weights = np.maximum(weights, 0.0)
    return simplex, weights / weights.sum(axis=1, keepdims=True)


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
