"""The object of a press with the flexibility of its surface, on the candidates of a body."""

import numpy as np

from fefinger.contact.elastic_kernel import (
    Facets,
    Kernel,
    flexibility,
    moved_points,
    symmetric,
    weighted,
)
from fefinger.contact.soft import (
    RIGID,
    RIGID_SURFACE,
    ElasticObject,
    ElasticSurface,
    ObjectSurface,
    PressingObject,
)
from fefinger.fem.body import Solid
from fefinger.fem.contact.deformed_gap import ContactSurface
from fefinger.fem.contact.obstacle import OwnObstacle
from fefinger.fem.contact.patch import Patch, trace_of
from fefinger.fem.elements.spaces import Space
from fefinger.geometry import mirror
from fefinger.scene.indenter import Indenter
from fefinger.support.arrays import Array
from fefinger.support.threads import one_thread
from fefinger.theory.contact.stack import Stack, moment


def kernel(body: Stack) -> Kernel:
    """Return the displacement around a point load on an elastic body."""
    return Kernel(*moment(body))


def facets(space: Space, on: Patch) -> Facets:
    """Return the facets that carry the hats of a patch."""
    part, owner = trace_of(space, on)
    return Facets(space.points[part.triangles], owner, part.places, part.hats)


@one_thread
def pressing_object(indenter: Indenter | OwnObstacle, solid: Solid, on: Patch) -> PressingObject:
    """Return the object that presses the candidates of a solid."""
    body = None if isinstance(indenter, OwnObstacle) else indenter.soft_body
    if body is None:
        return RIGID
    count, skin, made = len(on.vertices), facets(solid.space, on), kernel(body)
    images = images_of(solid)
    around = np.ascontiguousarray(solid.space.points[on.neighborhood.vertices])
    return ElasticObject(
        flexibility(made, skin, count, images),
        moved_points(made, skin, around, count, images),
    )


@one_thread
def object_surface(indenter: Indenter, solid: Solid, contact: ContactSurface) -> ObjectSurface:
    """Return the surface of the object that presses the candidates of a solid at finite strain."""
    body, on = indenter.soft_body, contact.on
    if body is None:
        return RIGID_SURFACE
    corners = np.ascontiguousarray(solid.space.points[on.part.triangles])
    skin = Facets(corners, on.owner, np.ascontiguousarray(on.part.places), on.part.hats)
    count, made, images = len(contact), kernel(body), images_of(solid)
    flat = skin.places.reshape(-1, 3)
    places = moved_points(made, skin, flat, count, images).reshape(*skin.places.shape[:2], count)
    around = np.ascontiguousarray(contact.at_rest)
    return ElasticSurface(
        symmetric(weighted(skin, places)),
        places,
        moved_points(made, skin, around, count, images),
    )


def images_of(solid: Solid) -> Array:
    """Return the signs (1 or 2, 3) by which the meshed part gives the whole finger."""
    return np.array([np.ones(3), mirror.SIGNS][: solid.sides])
