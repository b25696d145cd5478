"""The pad of the whole finger, on which a press reports pressure, and moments over it."""

import numpy as np

from fefinger.fem.body import Solid
from fefinger.fem.contact.patch import Neighborhood, Patch
from fefinger.fem.elements.assembly import numbering
from fefinger.geometry.finger_mesh import triangle_areas
from fefinger.geometry.mirror import Halves
from fefinger.results.records import Pad
from fefinger.support.arrays import Array, Integers


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
