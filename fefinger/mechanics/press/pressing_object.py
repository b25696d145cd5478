"""The object of a press with the flexibility of its surface, on the candidates of a body."""

import numpy as np

from fefinger.contact.elastic_kernel import Facets, Kernel, flexibility, moved_points
from fefinger.contact.soft import RIGID, ElasticObject, PressingObject
from fefinger.fem.body import Solid
from fefinger.fem.contact.obstacle import OwnObstacle
from fefinger.fem.contact.patch import Patch, trace_of
from fefinger.fem.elements.spaces import Space
from fefinger.geometry import mirror
from fefinger.scene.indenter import Indenter
from fefinger.support.threads import one_thread
from fefinger.theory.contact.point_load import moment
from fefinger.theory.contact.stack import Stack


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
    images = np.array([np.ones(3), mirror.SIGNS][: solid.sides])
    around = np.ascontiguousarray(solid.space.points[on.neighborhood.vertices])
    return ElasticObject(
        flexibility(made, skin, count, images),
        moved_points(made, skin, around, count, images),
    )
