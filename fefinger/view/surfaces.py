"""Surfaces of the finger for pictures in space: skin, subcutaneous tissue and bone, cut or whole.

A piece is made once: its vertices lie on edges of the mesh, with which they move. Filters of VTK
return places without edges and weights, and would have to cut every frame anew.
"""

from dataclasses import dataclass, replace

import numpy as np

from fefinger.geometry import finger_mesh
from fefinger.geometry.finger_mesh import BONE, SKIN, SUBCUTANEOUS, inside_weights, volumes
from fefinger.results.records import Fields
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.view import frames


NAMES = {SKIN: "skin", SUBCUTANEOUS: "subcutaneous tissue", BONE: "bone"}
PAD, FRONT = "pad", "other half"
SOFT = (NAMES[SKIN], NAMES[SUBCUTANEOUS], PAD, FRONT)
"""Pieces that have the colors of a field."""


@dataclass(frozen=True)
class Piece(frames.EdgePoints):
    """A surface of one tissue: triangles (n_tri, 3) of its points; `flat`: a face of the cut."""

    name: str
    triangles: Integers
    flat: bool = False


def cut_open(fields: Fields, *, inner: bool = True) -> tuple[Piece, ...]:
    """Return the half behind the medial plane: the surface of each tissue, and its face in the cut.

    The part of the skin that touches the object at any time is a piece of its own, the pad. Without
    `inner` the faces between two tissues are left out, which the skin and the cut hide.
    """
    cut = frames.cut(fields.points, fields.cells, fields.region)
    places = cut.at(fields.points)
    touches = np.asarray((fields.pressure > 0).any(axis=0))
    pieces = []
    for region, (faces, outer) in _boundaries(fields).items():
        name = NAMES[region]
        if not inner:
            faces, outer = faces[outer], outer[outer]
        if region == SKIN:
            pad = outer & touches[faces].any(axis=1)
            pieces.append(_clipped(PAD, fields.points, faces[pad]))
            faces = faces[~pad]
        pieces.append(_clipped(name, fields.points, faces))
        face = cut.triangles[cut.region == region]
        a, b, c = places[face].transpose(1, 0, 2)
        inward = np.cross(b - a, c - a)[:, 1] > 0  # faces point to -y, out of the half finger
        face = np.where(inward[:, None], face[:, [0, 2, 1]], face)
        pieces.append(_compact(name, cut.edges, cut.weight, face, flat=True))
    return tuple(piece for piece in pieces if len(piece.triangles))


def other_half(fields: Fields) -> tuple[Piece, ...]:
    """Return the outer skin before the medial plane, which `cut_open` leaves out."""
    mirrored = replace(fields, points=finger_mesh.image(fields.points))
    return tuple(
        replace(piece, name=FRONT, triangles=piece.triangles[:, ::-1])
        for piece in cut_open(mirrored, inner=False)
        if piece.name in (NAMES[SKIN], PAD) and not piece.flat
    )


def outlines(fields: Fields) -> Piece:
    """Return the lines that bound the regions of the medial section; `triangles` are (k, 2)."""
    cut = frames.cut(fields.points, fields.cells, fields.region)
    return Piece(cut.edges, cut.weight, "outlines", cut.outlines())


def entire(fields: Fields) -> tuple[Piece, ...]:
    """Return the outer surface of the whole finger as skin, and the bone inside of it."""
    points = np.column_stack([np.arange(len(fields.points))] * 2)
    boundaries = _boundaries(fields)
    outside = np.concatenate([faces[outer] for faces, outer in boundaries.values()])
    parts = {"skin": outside, "bone": boundaries[BONE][0]}
    pieces = [_compact(name, points, np.zeros(len(points)), faces) for name, faces in parts.items()]
    return tuple(piece for piece in pieces if len(piece.triangles))


def _boundaries(fields: Fields) -> dict[int, tuple[Integers, Flags]]:
    """Return per region the triangles (n_tri, 3) around it, and which are on the finger's surface.

    Triangles point outward.
    """
    # Cells of a mirrored mesh have negative volumes.
    inverted = volumes(fields.points, fields.cells) < 0
    cells = np.where(inverted[:, None], fields.cells[:, [0, 2, 1, 3]], fields.cells)
    faces, inner, outer = finger_mesh.interfaces(cells, fields.region)
    around = {}
    for region in NAMES:
        within, beyond = inner == region, outer == region
        triangles = np.concatenate([faces[within], faces[beyond][:, ::-1]])
        outside = np.concatenate([outer[within] == 0, np.zeros(beyond.sum(), bool)])
        around[region] = triangles, outside
    return around


def _clipped(name: str, points: Array, faces: Integers) -> Piece:
    """Return the part of the faces behind the medial plane, without faces in the plane."""
    y = points[:, 1]
    inside = y >= -1e-9 * np.ptp(points)
    strictly = y > 1e-9 * np.ptp(points)
    faces = faces[strictly[faces].any(axis=1)]
    count = inside[faces].sum(axis=1)
    pairs = [np.repeat(faces[count == 3][:, :, None], 2, axis=2)]
    for number in (1, 2):
        hit = faces[count == number]
        first = np.argmax(inside[hit] == (number == 1), axis=1)  # the corner on a side of its own
        a, b, c = (hit[np.arange(len(hit)), (first + k) % 3] for k in range(3))
        corners = [((a, a), (a, b), (a, c))]
        if number == 2:
            corners = [((b, b), (c, c), (a, b)), ((c, c), (a, c), (a, b))]
        pairs += [np.array(triangle).transpose(2, 0, 1).reshape(-1, 3, 2) for triangle in corners]
    edges = np.sort(np.concatenate(pairs).reshape(-1, 2), axis=1)
    y0, y1 = y[edges].T
    same = edges[:, 0] == edges[:, 1]
    weight = np.where(same, 0.0, -y0 / np.where(same, 1.0, y1 - y0))
    return _compact(name, edges, weight, np.arange(len(edges)).reshape(-1, 3))


def _compact(
    name: str, edges: Integers, weight: Array, triangles: Integers, *, flat: bool = False
) -> Piece:
    """Return a piece of the vertices that its triangles use, without duplicates."""
    used = triangles.ravel()
    unique, first, vertex = np.unique(edges[used], axis=0, return_index=True, return_inverse=True)
    return Piece(unique, weight[used][first], name, vertex.reshape(-1, 3), flat)


@dataclass(frozen=True)
class Followed:
    """Material points (n, 3) that move with corners (n, 4) of their cells by weights (n, 4).

    mirrored (n,): the point lies in the half that is not meshed.
    """

    points: Array
    corners: Integers
    weight: Array
    mirrored: Flags

    def moved(self, displacement: Array) -> Array:
        """Return the displaced points (n, 3) for a displacement of the mesh (n_points, 3)."""
        shift = np.einsum("nk,nkj->nj", self.weight, displacement[self.corners])
        shift[self.mirrored, 1] *= -1.0
        return np.asarray(self.points + shift)


def follow(fields: Fields, points: Array) -> Followed:
    """Find the cells around points (n, 3) mm; on half a mesh, around the mirror images of points.

    A point outside of the mesh follows the nearest place of the nearest cell.
    """
    mirrored = (points[:, 1] < 0) & frames.is_half(fields.points)
    place = np.where(mirrored[:, None], finger_mesh.image(points), points)
    cell, weight = inside_weights(fields.points[fields.cells], place)
    return Followed(points, fields.cells[cell], weight, mirrored)
