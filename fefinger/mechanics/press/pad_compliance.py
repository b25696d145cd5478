"""Compliance of the palmar pad for tractions in any direction: what objects at any pose press."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy import sparse

from fefinger.contact.elastic_kernel import Facets
from fefinger.contact.pad_worlds import Pad
from fefinger.fem.condensation import Operator
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import candidates, directed, patch
from fefinger.fem.elements.recovery import recovered_strain_at
from fefinger.mechanics.press import operator, placement
from fefinger.results.records import Sites
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array, Floats, Integers


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
