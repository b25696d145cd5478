"""The finger in pieces for pictures in space: skin, subcutaneous tissue and bone, cut open or not.

numpy and scipy only. A piece is made once; its vertices lie on edges of the mesh, so that it
follows the finger through all frames.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry import mirror, section
from fefinger.geometry.boundary import boundary_faces
from fefinger.geometry.locate import locate
from fefinger.results.records import Array, Fields, Integers


NAMES = {1: "skin", 2: "subcutaneous tissue", 3: "bone"}
PAD = "pad"
NEAREST = 24  # cells that are looked at to find the one around a point


@dataclass(frozen=True)
class Piece:
    """A surface whose vertices lie at `weight` from the first to the second point of an edge.

    edges (n, 2) mesh points, weight (n,), triangles (k, 3); `flat`: it is a face of the cut.
    """

    name: str
    edges: Integers
    weight: Array
    triangles: Integers
    flat: bool = False

    def at(self, nodal: Array) -> Array:
        """Return values at the mesh points, (n_points, ...), at the vertices of the piece."""
        first, second = nodal[self.edges[:, 0]], nodal[self.edges[:, 1]]
        weight = self.weight.reshape(-1, *[1] * (nodal.ndim - 1))
        return np.asarray((1 - weight) * first + weight * second)


def cut_open(fields: Fields) -> tuple[Piece, ...]:
    """Return the half behind the medial plane: skin, subcutaneous tissue, bone, and the pad.

    A tissue has two pieces, its outer surface and its face in the cut. The pad is the outer skin
    that is ever touched; the skin is without it.
    """
    cut = section.cut(fields.points, fields.cells, fields.region)
    touched = np.asarray((fields.pressure > 0).any(axis=0))
    found = []
    for region, name in NAMES.items():
        if not (fields.region == region).any():
            continue
        faces = boundary_faces(fields.points, fields.cells[fields.region == region])
        if region == 1:
            outer = boundary_faces(fields.points, fields.cells[fields.region > 0])
            pad = _among(faces, outer) & touched[faces].any(axis=1)
            found.append(_clipped(PAD, fields.points, faces[pad]))
            faces = faces[~pad]
        found.append(_clipped(name, fields.points, faces))
        face = _turned(cut.at(fields.points), cut.triangles[cut.region == region])
        found.append(_compact(name, cut.edges, cut.weight, face, flat=True))
    return tuple(piece for piece in found if len(piece.triangles))


def outlines(fields: Fields) -> Piece:
    """Return the lines that bound the regions of the medial section; `triangles` are (k, 2)."""
    cut = section.cut(fields.points, fields.cells, fields.region)
    return Piece("outlines", cut.edges, cut.weight, cut.outlines())


def entire(fields: Fields) -> tuple[Piece, ...]:
    """Return the outer surface of all of the finger as skin, and the bone inside of it."""
    parts = {"skin": fields.region > 0, "bone": fields.region == section.BONE}
    found = []
    for name, cells in parts.items():
        faces = boundary_faces(fields.points, fields.cells[cells])
        corners = np.column_stack([np.arange(len(fields.points))] * 2)
        found.append(_compact(name, corners, np.zeros(len(corners)), faces))
    return tuple(piece for piece in found if len(piece.triangles))


def _among(faces: Integers, others: Integers) -> NDArray[np.bool_]:
    """Return which of the faces are among the others."""
    known = set(map(tuple, np.sort(others, axis=1).tolist()))
    return np.array([tuple(face) in known for face in np.sort(faces, axis=1).tolist()], bool)


def _clipped(name: str, points: Array, faces: Integers) -> Piece:
    """Return the part of the faces behind the medial plane; faces in the plane are left out."""
    y = points[:, 1]
    inside = y >= -1e-9 * np.ptp(points)
    strictly = y > 1e-9 * np.ptp(points)
    faces = faces[strictly[faces].any(axis=1)]
    count = inside[faces].sum(axis=1)
    pairs = [np.repeat(faces[count == 3][:, :, None], 2, axis=2)]
    for number in (1, 2):
        hit, odd = faces[count == number], number == 1
        first = np.argmax(inside[hit] == odd, axis=1)
        a, b, c = (hit[np.arange(len(hit)), (first + k) % 3] for k in range(3))
        if odd:
            corners = [((a, a), (a, b), (a, c))]
        else:
            corners = [((b, b), (c, c), (a, b)), ((c, c), (a, c), (a, b))]
        pairs += [np.array(triangle).transpose(2, 0, 1).reshape(-1, 3, 2) for triangle in corners]
    edges = np.sort(np.concatenate(pairs).reshape(-1, 2), axis=1)
    y0, y1 = y[edges].T
    same = edges[:, 0] == edges[:, 1]
    weight = np.where(same, 0.0, -y0 / np.where(same, 1.0, y1 - y0))
    return _compact(name, edges, weight, np.arange(len(edges)).reshape(-1, 3))


def _turned(places: Array, triangles: Integers) -> Integers:
    """Return triangles in the medial plane so that all look to -y, out of the half finger."""
    a, b, c = places[triangles].transpose(1, 0, 2)
    inward = np.cross(b - a, c - a)[:, 1] > 0
    return np.asarray(np.where(inward[:, None], triangles[:, [0, 2, 1]], triangles))


def _compact(
    name: str, edges: Integers, weight: Array, triangles: Integers, *, flat: bool = False
) -> Piece:
    """Return a piece with the vertices that its triangles use, each once."""
    used = triangles.ravel()
    kept, first, vertex = np.unique(edges[used], axis=0, return_index=True, return_inverse=True)
    return Piece(name, kept, weight[used][first], vertex.reshape(-1, 3), flat)


@dataclass(frozen=True)
class Followed:
    """Material points that follow the mesh: corners (n, 4) of their cells and weights (n, 4)."""

    points: Array
    corners: Integers
    weight: Array
    mirrored: NDArray[np.bool_]

    def moved(self, displacement: Array) -> Array:
        """Return where the points (n, 3) are with the displacement of the mesh (n_points, 3)."""
        shift = np.einsum("nk,nkj->nj", self.weight, displacement[self.corners])
        shift[self.mirrored, 1] *= -1.0
        return np.asarray(self.points + shift)


def follow(fields: Fields, points: Array) -> Followed:
    """Find the cells around material points; points beyond half a mesh follow their mirror image.

    A point outside of the mesh follows the nearest place of the cell that comes closest.
    """
    beyond = np.zeros(len(points), bool)
    if section.is_half(fields.points):
        beyond = points[:, 1] < 0
    place = np.where(beyond[:, None], mirror.image(points), points)
    cell, weight = locate(fields.points[fields.cells], place, nearest=NEAREST)
    weight = np.maximum(weight, 0.0)
    weight /= weight.sum(axis=1, keepdims=True)
    return Followed(points, fields.cells[cell], weight, beyond)
