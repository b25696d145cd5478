"""The pad: the whole of it, its border, and the indenter that is placed on it at first touch."""

from dataclasses import replace

import numpy as np

from fefinger.fem.body import Solid
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import Neighborhood, Patch, foremost, smooth_places
from fefinger.fem.elements.assembly import numbering
from fefinger.fem.elements.spaces import trace
from fefinger.geometry.finger_mesh import Halves, boundary_edges, locate, triangle_areas
from fefinger.results.records import Pad
from fefinger.scene.indenter import Indenter, direction
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError


BESIDE = np.array([0.0, 0.0, 1.0])
"""Travel of an object whose place is beside the pad, which has no normal there."""


def obstacle(indenter: Indenter, body: Solid) -> Obstacle:
    """Return the indenter at first touch on this body.

    One whose place `at` is beside the pad moves along z, as a plate along the bone does.

    InputError if it misses the pad, or the first touch lies on the border of the pad.
    """
    plate, at, roll = indenter.plate, indenter.place, indenter.turn
    if plate is not None:
        axis = direction(plate)
        origin = np.zeros(3)
        if plate != STANDARD.plate:  # The foremost vertex is up to 1.4 mm away, on a flat pad.
            origin = foremost(body.space.points, body.normals, body.pad, axis)
            origin = origin * (1.0, 0.0, 1.0) if body.half else origin
        placed = Obstacle(axis, origin, indenter.profile, roll)
        return _touching(placed, body, f"indenter.angle {plate.angle:g} degrees")
    found = (np.zeros(3), direction(STANDARD)) if at is None else _pad_point(body, at)
    if found is None:
        placed = Obstacle(BESIDE, np.append(at or (), 0.0), indenter.profile, roll)
        return _touching(placed, body, "indenter.at", beside=indenter.half_sides)
    origin, axis = found
    return _touching(Obstacle(axis, origin, indenter.profile, roll), body, "indenter.at")


def _touching(
    placed: Obstacle, body: Solid, field: str, *, beside: tuple[float, float] | None = None
) -> Obstacle:
    """Move the obstacle along its axis to first touch on the smooth surface of the pad.

    beside: its half sides mm where its foremost point is not on the pad.
    """
    surface = trace(body.space, body.pad)
    places = smooth_places(body.space.points, body.normals, surface)
    distance, _ = placed.gap(places)
    if beside is not None:  # the sides of a pin or a bar go on behind its rim
        across = np.abs((places - placed.origin) @ placed.frame[:2].T)
        distance = np.where((across <= beside).all(axis=-1), distance, np.inf)
    if not np.isfinite(distance).any():
        raise InputError(
            f"{field}: expected a place on the pad, received one that the indenter misses, or an "
            "indenter smaller than the facets there; take a larger one or a finer mesh "
            "(finger.resolution)"
        )
    first = np.unravel_index(int(np.argmin(distance)), distance.shape)
    corner = surface.triangles[first[0]]
    if np.isin(corner, border(body)).any():
        raise InputError(
            f"{field}: expected a first touch on the pad, received one on the border of the pad, "
            "where the finger is cut or the nail begins; choose another angle or place"
        )
    touched = None if beside is None else places[first]
    return replace(placed, origin=placed.origin + distance[first] * placed.axis, touched=touched)


def check_inside(body: Solid, pressed: Integers, depth: float) -> None:
    """Raise InputError where pressed pad vertices (n,) lie on the border, `depth` mm deep."""
    reached = body.space.points[pressed[np.isin(pressed, border(body))]]
    if len(reached) == 0:
        return
    length = float(np.ptp(body.space.points[:, 0]))
    # Part of the length of the finger within which the border of the pad is the proximal cut.
    on_the_cut = 1e-3
    at_cut = reached[:, 0].min() < body.space.points[:, 0].min() + on_the_cut * length
    what = "proximal cut, behind which there is no finger" if at_cut else "nail"
    raise InputError(
        f"motion: expected contact inside the pad, but at a depth of {depth:.3g} mm it reaches the "
        f"{what}; press less, or at another angle or place"
    )


def border(body: Solid) -> Integers:
    """Return the pad vertices on edges of only one pad triangle, the medial plane aside."""
    single = boundary_edges(body.pad)
    if body.half:
        medial = (np.abs(body.space.points[single][:, :, 1]) == 0).all(axis=1)
        single = single[~medial]
    return np.unique(single)


def _pad_point(body: Solid, at: tuple[float, float]) -> tuple[Array, Array] | None:
    """Return the point (3,) of the smooth palmar pad at x, y, and its inward normal (3,).

    None for a place beside the pad.
    """
    palmar = body.pad[body.normals[body.pad][:, :, 2].max(axis=1) < 0]
    (best,), (weights,) = locate(body.space.points[palmar][:, :, :2], np.array([at], dtype=float))
    if weights.min() < -1e-9:
        return None
    normal = weights @ body.normals[palmar[best]]
    return weights @ body.space.points[palmar[best]], -normal / np.linalg.norm(normal)


def on_neighborhood(pressure: Array, seen: Neighborhood) -> Array:
    """Extend the pressure (n_t, n) kPa of the candidates by zeros to their neighborhood."""
    return np.pad(pressure, ((0, 0), (0, len(seen.vertices) - pressure.shape[1])))


def first_moments(pad: Pad) -> Array:
    """Return the first moments (n_pad, 3) mm³ of the hat functions of the vertices."""
    corners = pad.points[pad.triangles]
    twelfths = triangle_areas(corners)[:, None, None] / 12
    moments = np.zeros_like(pad.points)
    share = twelfths * (corners + corners.sum(axis=1, keepdims=True))
    np.add.at(moments, pad.triangles, share)
    return moments


def whole_pad(body: Solid, on: Neighborhood | Patch) -> tuple[Pad, Integers]:
    """Return the pad of the whole finger, and the index in `on` of each of its points."""
    vertices, areas = on.vertices, on.areas
    points, normals = body.space.points[vertices], body.normals[vertices]
    triangles = numbering(vertices, len(body.space.points))[on.triangles]
    triangles = triangles[(triangles >= 0).all(axis=1)]
    if not body.half:
        return Pad(points, areas, normals, triangles), np.arange(len(points))
    halves = Halves.of(points)
    pad = Pad(
        points=halves.vectors(points),
        areas=halves.shares(areas),
        normals=halves.vectors(normals),
        triangles=halves.triangles(triangles),
    )
    return pad, halves.origin
