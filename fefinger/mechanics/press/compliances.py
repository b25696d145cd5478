"""Compliance of the pad for tractions in any direction, and of the surface of an object."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy import sparse

from fefinger.contact.elastic_kernel import (
    Facets,
    Kernel,
    flexibility,
    moved_points,
    symmetric,
    weighted,
)
from fefinger.contact.pad_worlds import Pad
from fefinger.contact.soft import (
    RIGID,
    RIGID_SURFACE,
    ElasticSurface,
    ObjectSurface,
    PressingObject,
    SoftObject,
)
from fefinger.fem.body import Solid
from fefinger.fem.condensation import Operator
from fefinger.fem.contact.deformed_gap import ContactSurface
from fefinger.fem.contact.obstacle import Obstacle, OwnObstacle
from fefinger.fem.contact.patch import Patch, candidates, directed, patch, trace_of
from fefinger.fem.elements.probe import recovered_strain_at
from fefinger.fem.elements.spaces import Space
from fefinger.geometry import finger_mesh
from fefinger.mechanics.press import operator, placement
from fefinger.results.records import Sites
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.support.arrays import Array, Floats, Integers
from fefinger.support.processes import one_thread
from fefinger.theory.contact.stack import Stack, moment


@dataclass(frozen=True)
class PadCompliance:
    """A pad, its vertices (n,) in the mesh, and what tractions on them cause.

    compliance (3n, 3n) mm³/kPa and strain (6 n_sites, 3n) 1/kPa of the relaxed body, for the
    components x, y, z of each vertex in turn; facets that carry the hats, with their corners.
    """

    pad: Pad
    compliance: Floats
    vertices: Integers
    strain: Array
    facets: Facets


def pad_compliance(
    finger: Finger, solid: Operator, sites: Sites, kind: type[np.floating]
) -> PadCompliance:
    """Reduce a whole finger to its palmar pad and the strain at sites, from the cache if there.

    kind: precision of the compliance.
    """
    space = solid.space
    everywhere = (
        solid.pad,
        solid.normals,
        # All of the pad is a candidate of a plate 100 mm below it.
        Obstacle(np.array([0.0, 0.0, 1.0]), np.array([0, 0, -100.0])),
    )
    chosen = candidates(space, *everywhere, np.inf, 0, solid.loadable)
    part, n = chosen.part, len(chosen.vertices)
    on = patch(space, *everywhere, np.inf, 0, solid.loadable)
    loads = sparse.hstack([directed(space, on, each) for each in np.eye(3)]).tocsc()
    by_vertex = np.arange(3 * n).reshape(3, n).T.ravel()
    three = replace(
        on,
        vertices=np.repeat(chosen.vertices, 3),
        loads=loads[:, by_vertex],
        places=sparse.csc_matrix((space.n_unknowns, 0)),
    )
    probe = partial(recovered_strain_at, space, sites.points, solid.planes)
    reduced = operator.reduced(finger, solid, three, sites.points, probe)
    outward = _unit(np.einsum("kq,tkd->tqd", part.linear, solid.normals[part.triangles]))
    weights, rates = (np.array(each, dtype=np.float64) for each in finger.prony.branches)
    pad = Pad(
        points=np.array(space.points[chosen.vertices]),
        normals=_unit(solid.normals[chosen.vertices]),
        owner=np.array(chosen.owner, dtype=np.int64),
        places=np.array(chosen.places),
        skin=np.ascontiguousarray(outward),
        hats=np.array(part.hats),
        areas=np.array(chosen.integrated(part.hats)),
        border=np.array(chosen.border | np.isin(chosen.vertices, placement.border(solid))),
        weights=weights,
        rates=rates,
    )
    corners = np.array(space.points[part.triangles])
    facets = Facets(corners, pad.owner, np.array(part.places), pad.hats)
    compliance = np.array(reduced.flexibility, dtype=kind, order="C")
    strain = np.array(reduced.strain_operator)
    return PadCompliance(pad, compliance, chosen.vertices, strain, facets)


def _unit(vectors: Array) -> Array:
    return np.ascontiguousarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


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
    if isinstance(indenter, OwnObstacle) or (body := indenter.soft_body) is None:
        return RIGID
    count, skin, made = len(on.vertices), facets(solid.space, on), kernel(body)
    images = images_of(solid)
    around = np.ascontiguousarray(solid.space.points[on.neighborhood.vertices])
    return SoftObject(
        flexibility(made, skin, count, images),
        moved_points(made, skin, around, count, images),
        indenter.soft_prony.branches,
    )


@one_thread
def object_surface(indenter: Indenter, solid: Solid, contact: ContactSurface) -> ObjectSurface:
    """Return the surface of the object that presses the candidates of a solid at finite strain."""
    body = indenter.soft_body
    if body is None:
        return RIGID_SURFACE
    return elastic_surface(body, solid.space, contact, images_of(solid))


def elastic_surface(
    body: Stack, space: Space, contact: ContactSurface, images: Array
) -> ElasticSurface:
    """Return the surface of a body on candidates; images as of `images_of`."""
    on = contact.on
    corners = np.ascontiguousarray(space.points[on.part.triangles])
    skin = Facets(corners, on.owner, np.ascontiguousarray(on.part.places), on.part.hats)
    count, made = len(contact), kernel(body)
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
    return np.array([np.ones(3), finger_mesh.SIGNS][: solid.sides])
