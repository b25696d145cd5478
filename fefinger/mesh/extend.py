"""Continuation of a finger behind its cut, for plates along it, and the first touch of a plate.

The section at the cut is extruded in layers that bend away from the palm, as behind a flexed joint:
first with the slope that the palm has at the cut, then along an arc. All vertices, cells and facets
of the mesh but its cut stay as they are, so that a press that does not come near the cut has the
same answer but for the stiffness of the tissue behind it.

Frame: x distal, y radial, z dorsal; lengths in mm.
"""

import hashlib
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.geometry.finger_mesh import BONE, FingerMesh, faces, interfaces, volumes
from fefinger.geometry.profiles import directions
from fefinger.mesh.finger_shape import (
    FIT_RADIUS,
    FOREMOST,
    SmoothSurface,
    curvature,
    foremost,
    palm,
)
from fefinger.mesh.recipe import Recipe
from fefinger.mesh.scan import shape_of
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError


Regions = NDArray[np.int8]

LENGTH, LAYERS = 9.0, 4
"""Length in mm of the continuation along x, and the number of its layers of cells."""

RADIUS = 30.0
"""Radius in mm of the arc by which it leaves the palm: every finger can then be pressed 2 mm."""

CONTINUATION = "continued"
"""Field of a mesh's recipe with the length of its continuation, if it has one."""

NOTE = (
    f"The finger was continued by {LENGTH:g} mm behind its proximal cut, bent away from the plate "
    f"with a radius of {RADIUS:g} mm: what lies behind the distal phalanx is not modeled otherwise."
)


def rise(slope: float, behind: Array | float) -> Array:
    """Rise in mm (z) of the section that lies `behind` mm behind the cut, for a palmar slope."""
    return np.asarray(slope * np.asarray(behind) + np.asarray(behind) ** 2 / (2.0 * RADIUS))


def palmar_slope(normal: Array) -> float:
    """Return the slope in the proximal direction of a palm with an outward normal (3,)."""
    return float(normal[0] / normal[2])


def extended(mesh: FingerMesh) -> FingerMesh:
    """Return a half finger with its continuation behind the cut.

    The new vertices have the last numbers. Raises InputError for a whole finger.
    """
    if not mesh.half:
        raise InputError(f"mesh: expected a half finger, received the whole finger {mesh.name!r}")
    section = np.concatenate([mesh.facets["cut"], mesh.facets["bone-cut"]])
    # The sections rise: diagonals from upper to lower vertices are the shorter ones.
    ring = np.unique(section)
    ring = ring[np.argsort(-mesh.points[ring, 2], kind="stable")]
    points, normals = _extruded(mesh, ring)
    cells, region = _prisms(mesh, section, ring, points)
    cells, region = np.concatenate([mesh.cells, cells]), np.concatenate([mesh.region, region])
    return replace(
        mesh,
        points=points,
        cells=cells,
        region=region,
        facets=_facets(mesh, points, cells, region),
        pad_normals=normals,
        recipe=mesh.recipe | {CONTINUATION: LENGTH},
        quality=mesh.quality | {"notes": [*mesh.quality.get("notes", ()), NOTE]},
        source_sha256=mesh.source_sha256 and continuation_source(mesh.source_sha256),
    )


def continuation_source(source: str) -> str:
    """Return the source hash of a continued mesh, from the hash of the mesh."""
    return hashlib.sha256(f"{source} {LENGTH} {LAYERS} {RADIUS}".encode()).hexdigest()


def _extruded(mesh: FingerMesh, ring: Integers) -> tuple[Array, Array]:
    """Return the vertices and the smooth pad normals of mesh and continuation, (n, 3) each."""
    pad = np.intersect1d(ring, mesh.facets["pad"])
    normals = mesh.pad_normals
    lowest = pad[np.argmin(mesh.points[pad, 2])]
    slope = palmar_slope(normals[lowest])
    places, turned = [mesh.points], [normals]
    for behind in LENGTH * np.arange(1, LAYERS + 1) / LAYERS:
        places.append(mesh.points[ring] + [-behind, 0.0, rise(slope, behind)])
        across = normals[ring] * [0.0, 1.0, 1.0]
        across[:, 0] = across[:, 2] * (slope + behind / RADIUS)
        size = np.linalg.norm(across, axis=1)
        turned.append(across / np.where(size > 0.0, size, 1.0)[:, None])
    return np.concatenate(places), np.concatenate(turned)


def _prisms(
    mesh: FingerMesh, section: Integers, ring: Integers, points: Array
) -> tuple[Integers, Regions]:
    """Divide the prisms behind the triangles of the section (k, 3) into tetrahedra, with regions.

    The diagonal of a side runs from the vertex that comes first in the ring to the later layer, so
    that neighbors agree.
    """
    number = np.empty(len(mesh.points), dtype=np.int64)
    number[ring] = np.arange(len(ring))
    rank = np.sort(number[section], axis=1)
    layers = [
        ring,
        *(len(mesh.points) + len(ring) * k + np.arange(len(ring)) for k in range(LAYERS)),
    ]
    parts = []
    for near, far in pairwise(layers):
        a, b, c = near[rank].T
        d, e, f = far[rank].T
        parts += [np.column_stack(cell) for cell in ((a, b, c, f), (a, b, e, f), (a, d, e, f))]
    cells = np.concatenate(parts)
    inverted = volumes(points, cells) < 0.0
    cells[inverted] = cells[inverted][:, [0, 2, 1, 3]]
    return cells, np.tile(_regions_before(mesh, section), 3 * LAYERS)


def _regions_before(mesh: FingerMesh, section: Integers) -> Regions:
    """Return the region of the cell that each of the triangles (k, 3) of a boundary belongs to."""
    count = len(mesh.points)

    def numbers(triangles: Integers) -> Integers:
        return np.sort(triangles, axis=-1) @ np.array([count**2, count, 1])

    every = numbers(faces(mesh.cells)).ravel()
    order = np.argsort(every)
    at = order[np.searchsorted(every, numbers(section), sorter=order)]
    return np.repeat(mesh.region, 4)[at]


def _facets(
    mesh: FingerMesh, points: Array, cells: Integers, region: Regions
) -> dict[str, Integers]:
    """Return the facet sets of mesh and continuation; the cut is the last layer."""
    triangles, inner, outer = interfaces(cells, region)
    added = (triangles >= len(mesh.points)).any(axis=1)
    triangles, inner, outer = triangles[added], inner[added], outer[added]
    outside = outer == 0
    medial = outside & np.all(points[triangles][:, :, 1] == 0.0, axis=1)
    last = outside & np.all(
        triangles >= len(points) - (len(points) - len(mesh.points)) // LAYERS, axis=1
    )
    side = outside & ~medial & ~last
    new = {
        "pad": side,
        "medial": medial,
        "bone": ~outside & (outer == BONE),
        "cut": last & (inner != BONE),
        "bone-cut": last & (inner == BONE),
    }
    kept = {name: part for name, part in mesh.facets.items() if name not in ("cut", "bone-cut")}
    return {
        name: np.concatenate([kept.get(name, np.empty((0, 3), dtype=np.int64)), triangles[chosen]])
        for name, chosen in new.items()
    } | {"nail": kept["nail"]}


COUNT, ZOOM, ROUNDS = 21, 0.25, 8
"""Points per side of a search patch, factor of its refinement, and number of refinements."""


@dataclass(frozen=True)
class FirstTouch:
    """First touch: point (3,) mm, curvature (2, 2) 1/mm along `directions(axis)`, convex positive.

    The curvature belongs to a quadric fitted within 2 mm.
    """

    point: Array
    curvature: Array


def first_touch(recipe: Recipe, axis: ArrayLike) -> FirstTouch:
    """Find where a plate that moves along `axis` (3,) first touches the smooth skin of a finger."""
    shape, axis = _shape(recipe), np.asarray(axis, float)
    across = directions(axis)
    x = np.linspace(shape.cut, FOREMOST, 200)[1:]
    y = np.linspace(-recipe.width / 3, recipe.width / 3, 41)
    point = foremost(shape.skin, palm(shape.skin, *map(np.ravel, np.meshgrid(x, y))), axis)
    reach = 1.0
    for _ in range(ROUNDS):
        point = foremost(shape.skin, _patch(shape.skin, point, across, reach), axis)
        reach *= ZOOM
    around = _patch(shape.skin, point, across, 1.5 * FIT_RADIUS) - point
    return FirstTouch(point, curvature(around, across, axis))


@lru_cache(maxsize=64)
def at_cut(
    recipe: Recipe, axis: tuple[float, float, float], *, with_continuation: bool = False
) -> float:
    """Distance in mm of the skin at the proximal cut from a plate at its first touch.

    `with_continuation`: at the end of the finger that `mesh.extend` continues behind the cut.
    """
    shape, travel = _shape(recipe), np.array(axis)
    y = np.linspace(-recipe.width / 3, recipe.width / 3, 41)
    skin = palm(shape.skin, shape.cut, y)
    if with_continuation:
        slope = palmar_slope(shape.skin.normals(skin[len(y) // 2 :][:1])[0])
        skin += np.array([-LENGTH, 0.0, float(rise(slope, LENGTH))])
    return float((skin @ travel).min() - first_touch(recipe, axis).point @ travel)


_shape = lru_cache(maxsize=8)(shape_of)


def _patch(skin: SmoothSurface, point: Array, across: Array, reach: float) -> Array:
    """Return points (n, 3) of the skin about a point of it."""
    line = np.linspace(-reach, reach, COUNT)
    places = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    return skin.project(point + places @ across)
