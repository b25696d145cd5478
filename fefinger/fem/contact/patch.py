"""Frictionless unilateral contact as a linear complementarity problem on the pad.

The pressure is a combination of linear hat functions psi_j on the pad with coefficients
lambda_j >= 0; it acts along the indenter's normal n. With U_j the displacement under psi_j n, the
weighted gaps are w = s - d m + F lambda, where F_ij is the integral of psi_i n . U_j, s_i that of
psi_i n . axis times the gap at first touch, m_i that of psi_i n . axis and d the depth:
w >= 0, lambda >= 0, lambda . w = 0, with no penalty. The force along the axis is m . lambda.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fefinger.fem.contact.obstacle import Rigid
from fefinger.fem.elements.assembly import numbering, scattered
from fefinger.fem.elements.spaces import Space, Trace, trace
from fefinger.support.arrays import Array, Flags, Integers


RINGS = 2  # rings of vertices around the candidates: the reach of a fit of the contact area
EDGES = (0, 1), (1, 2), (0, 2)  # of a facet, in the order of the midside nodes of `Trace`
SIDES = 24  # subdivisions of a facet in the search for the first touch of a plate
NEAR = 0.25  # edge lengths behind the foremost vertex within which facets are searched


@dataclass(frozen=True)
class Neighborhood:
    """The candidates and rings of vertices around them, for gaps outside the contact.

    vertices (n_near,) of the mesh, the candidates first; triangles (n_tri, 3) around them; areas
    (n_near,) mm² of their hats.
    """

    vertices: Integers
    triangles: Integers
    areas: Array


@dataclass(frozen=True)
class Patch:
    """Discrete contact of a pad: candidate vertices, unit loads and initial weighted gaps.

    vertices (n,) of the mesh, triangles (n_tri, 3) that carry their hats, loads (n_unknowns, n) the
    unit loads psi_j n, gap (n,) mm³ the weighted gaps s, projected (n,) mm² the areas m of the
    hats across the axis, moment (n, 3) mm³ the weights of the moment about the origin, areas (n,)
    mm² of the hats, border and obstacle_border (n,) as those of the `candidates`.
    At the vertices of `neighborhood`: distance (n_near,) mm along the axis, cosine (n_near,) of n
    and axis, and places (n_unknowns, n_near), whose transpose maps the unknowns to n . u.
    """

    vertices: Integers
    triangles: Integers
    loads: sparse.csc_matrix
    gap: Array
    projected: Array
    moment: Array
    areas: Array
    border: Flags
    obstacle_border: Flags
    neighborhood: Neighborhood
    distance: Array
    cosine: Array
    places: sparse.csc_matrix

    def clearance(self, depth: Array, normal_displacement: Array) -> Array:
        """Gap (n_t, n_near) mm at the vertices of the neighborhood, along the obstacle's normal.

        depth (n_t,) mm; normal_displacement (n_t, n_near) mm: that along that normal.
        """
        return self.cosine * (self.distance - depth[:, None]) + normal_displacement


def smooth_places(points: Array, normals: Array, surface: Trace) -> Array:
    """Return the quadrature points (n_tri, n_q, 3) lifted from the facets to the smooth surface.

    Each edge bulges at its middle by (n1 - n0) . (x1 - x0) / 8 along the mean normal, which is
    exact for a sphere to third order in the edge; the facet in between is quadratic.
    """
    lifts = _lifts(points, normals, surface.triangles)
    return np.asarray(surface.places + np.einsum("kq,tkd->tqd", surface.quadratic[3:], lifts))


def foremost(points: Array, normals: Array, triangles: Integers, axis: Array) -> Array:
    """First point of contact (3,) mm of the smooth surface with a plate moving along `axis`.

    The resolution is 1 / SIDES of a facet; facets within NEAR edge lengths of the foremost vertex
    are searched.
    """
    ahead = points[triangles] @ axis
    edge = np.linalg.norm(np.diff(points[triangles], axis=1), axis=2).mean()
    near = triangles[ahead.min(axis=1) <= ahead.min() + NEAR * edge]
    i, j = (each.ravel() / SIDES for each in np.indices((SIDES + 1, SIDES + 1)))
    inside = i + j < 1 + 0.5 / SIDES
    weights = np.stack([1 - i - j, i, j])[:, inside]
    bulges = 4 * np.stack([weights[a] * weights[b] for a, b in EDGES])
    places = np.einsum("kq,tkd->tqd", weights, points[near])
    places += np.einsum("kq,tkd->tqd", bulges, _lifts(points, normals, near))
    flat = places.reshape(-1, 3)
    return np.asarray(flat[int(np.argmin(flat @ axis))])


def _lifts(points: Array, normals: Array, triangles: Integers) -> Array:
    """Offsets (n_tri, 3, 3) mm of the midpoints of the edges from the flat facets."""
    corners, directions = points[triangles], normals[triangles]
    lifts = np.zeros((len(corners), 3, 3))
    for place, (a, b) in enumerate(EDGES):
        edge = corners[:, b] - corners[:, a]
        height = np.sum((directions[:, b] - directions[:, a]) * edge, axis=1) / 8
        mean = directions[:, a] + directions[:, b]
        length = np.linalg.norm(mean, axis=1, keepdims=True)
        lifts[:, place] = height[:, None] * mean / np.where(length > 0, length, 1.0)
    return lifts


@dataclass(frozen=True)
class Candidates:
    """Vertices and facets of the pad that may come into contact.

    vertices (n,) of the mesh; part: the trace of the triangles that carry their hats; places
    (n_tri, n_q, 3) mm of its smooth surface; owner (n_tri, 3) the candidate at each corner, -1 for
    none; border (n,) the candidates beyond which contact could spread out of the patch;
    obstacle_border (n,) those of them beyond which the obstacle is not ahead, however large the
    patch; beyond (n,) those at which its shape has ended.
    """

    vertices: Integers
    part: Trace
    places: Array
    owner: Integers
    border: Flags
    obstacle_border: Flags
    beyond: Flags

    def integrated(self, density: Array) -> Array:
        """Assemble integrals (n,) of the candidates from densities (n_tri, 3, n_q)."""
        owned = self.owner >= 0
        sums = density.sum(axis=2)[owned]
        sums = np.bincount(self.owner[owned], sums, minlength=len(self.vertices))
        return np.asarray(sums, dtype=np.float64)


def candidates(
    space: Space,
    triangles: Integers,
    normals: Array,
    obstacle: Rigid,
    reach: float,
    rings: int = 0,
    within: Flags | None = None,
) -> Candidates:
    """Select the pad vertices whose initial gap is at most `reach` mm, and rings around them.

    `triangles` (n, 3) are all of the pad; `normals` (n_points, 3) its smooth outward normals, zero
    for flat facets. A vertex takes part if the obstacle is ahead of all of its triangles, and if it
    is `within` (n_points,), where that is given.
    """
    surface = trace(space, triangles)
    distance, _ = obstacle.gap(smooth_places(space.points, normals, surface))
    behind = ~np.isfinite(distance).all(axis=1)
    used = np.zeros(len(space.points), dtype=bool)
    pad = np.unique(triangles)
    used[pad[obstacle.gap(space.points[pad])[0] <= reach]] = True
    for _ in range(rings):
        used[triangles[used[triangles].any(axis=1)]] = True
    if within is not None:
        used &= within
    used[triangles[behind]] = False
    carrying = used[triangles].any(axis=1)
    border, beyond, rim = (np.zeros_like(used) for _ in range(3))
    border[triangles[carrying & ~used[triangles].all(axis=1)]] = True
    beyond[triangles[behind]] = True
    rim[triangles[carrying & beyond[triangles].any(axis=1)]] = True
    vertices = np.flatnonzero(used)
    part = trace(space, triangles[carrying])
    places = smooth_places(space.points, normals, part)
    owner = numbering(vertices, len(used))[part.triangles]
    ended = obstacle.beyond(space.points[vertices])
    return Candidates(vertices, part, places, owner, border[vertices], rim[vertices], ended)


def patch(
    space: Space,
    triangles: Integers,
    normals: Array,
    obstacle: Rigid,
    reach: float,
    rings: int = 0,
    within: Flags | None = None,
) -> Patch:
    """Build the patch: the `candidates`, their unit loads and gaps, and their neighborhood."""
    chosen = candidates(space, triangles, normals, obstacle, reach, rings, within)
    part, owner, vertices = chosen.part, chosen.owner, chosen.vertices
    distance, direction = obstacle.gap(chosen.places)
    cosine = direction @ obstacle.axis

    def integrated(density: Array) -> Array:
        return chosen.integrated(part.hats * density[:, None])

    arm = np.cross(part.places, direction)
    around = neighborhood(space, triangles, normals, obstacle, reach, vertices, rings + RINGS)
    apart, normal = obstacle.gap(space.points[around.vertices])
    rows, columns = 3 * around.vertices[:, None] + np.arange(3), np.arange(len(apart))[:, None]
    return Patch(
        vertices=vertices,
        triangles=part.triangles,
        loads=_loads(space, part, direction, owner, len(vertices)),
        gap=integrated(cosine * distance),
        projected=integrated(cosine),
        moment=np.stack([integrated(arm[..., k]) for k in range(3)], axis=1),
        areas=integrated(np.ones_like(cosine)),
        border=chosen.border,
        obstacle_border=chosen.obstacle_border | chosen.beyond,
        neighborhood=around,
        distance=apart,
        cosine=normal @ obstacle.axis,
        places=scattered(normal, rows, columns, (space.n_unknowns, len(apart))).tocsc(),
    )


def trace_of(space: Space, on: Patch) -> tuple[Trace, Integers]:
    """Return the trace of a patch and the candidates at its corners (n_tri, 3), -1 for none."""
    part = trace(space, on.triangles)
    return part, numbering(on.vertices, len(space.points))[part.triangles]


def directed(space: Space, on: Patch, direction: Array) -> sparse.csc_matrix:
    """Return unit loads (n_unknowns, n) of the hats of a patch along one direction (3,)."""
    part, owner = trace_of(space, on)
    along = np.broadcast_to(direction, part.places.shape)
    return _loads(space, part, along, owner, len(on.vertices))


def neighborhood(
    space: Space,
    triangles: Integers,
    normals: Array,
    obstacle: Rigid,
    reach: float,
    vertices: Integers,
    rings: int,
) -> Neighborhood:
    """Return the candidates `vertices` and the vertices of the `rings` around them."""
    around = candidates(space, triangles, normals, obstacle, reach, rings)
    every = np.concatenate([vertices, np.setdiff1d(around.vertices, vertices)])
    area = np.repeat(around.part.weights.sum(axis=1) / 3, 3)
    areas = np.bincount(around.part.triangles.ravel(), area, minlength=len(space.points))
    return Neighborhood(every, around.part.triangles, areas[every])


def _loads(
    space: Space, part: Trace, direction: Array, owner: Integers, count: int
) -> sparse.csc_matrix:
    """Return unit loads (n_unknowns, count): integrals of psi_j n . v for all displacements v."""
    block = np.einsum("tjq,kq,tqc->tkcj", part.hats, part.quadratic, direction)
    rows = 3 * part.nodes[:, :, None, None] + np.arange(3)[:, None]
    return scattered(block, rows, owner[:, None, None, :], (space.n_unknowns, count)).tocsc()
