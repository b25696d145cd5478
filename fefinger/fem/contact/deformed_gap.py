"""Weighted gaps between a deformed pad and a rigid obstacle, with their derivatives.

With g(x) the distance of a point behind the obstacle's surface along its travel, the weighted gap
of a hat psi_i is w_i = integral of psi_i phi(g(x)) da over the deformed pad, da = J dA: finite
sliding, because g is evaluated at the deformed point. lambda_i >= 0 times its derivative B_i is the
load, so that phi'(g) times the sum of psi_i lambda_i is the pressure. g grows by 1 per mm along the
axis, and the force along the axis is the sum of t_i lambda_i, t_i being the integral of
psi_i phi'(g) da, or of m_i p_i, m_i that of psi_i dA and p_i = lambda_i t_i / m_i, the pressure on
undeformed area. Gaps w_i m_i / t_i with the loads B_i m_i / t_i of these p_i replace w_i and
lambda_i in the solver.

Integrals over the undeformed pad instead make incompressible tissue unstable where the pressure is
some times its modulus: a facet behind the obstacle may spread and its neighbor before it shrink,
which displaces a volume and so takes work from the pressure, but closes no gap that is weighted so.
Over the deformed pad, a uniform pressure does the work of the volume between pad and obstacle.
Compressible tissue does not answer that work by its mean stress, and is the more stable with
J = 1 (`ContactSurface.spreads`). Both converge to the same contact.

    phi(g) = g - c² h / b ln cosh(b g / (c h)),    phi'(g) = 1 - c tanh(b g / (c h)),

on a facet of size h, equals g where the facet lies flat on the obstacle. Weighted means of g itself
do not detect a facet that folds, with half of its six nodes behind the obstacle and half before
it, as happens under 40 % of compression along the skin. phi is concave: a fold closes its weighted
gaps, and pressure resists it in proportion. The error of phi is of second order in g / h.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from fefinger.contact.soft import RIGID_SURFACE, ObjectSurface
from fefinger.fem.contact.deformed_kernels import Indices, add_loads, fill_spread
from fefinger.fem.contact.obstacle import FAR, Obstacle, Rigid
from fefinger.fem.contact.patch import RINGS, Candidates, Neighborhood, candidates, neighborhood
from fefinger.fem.elements.assembly import scattered
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.state import State
from fefinger.geometry.profiles import frame
from fefinger.support.arrays import Array, Flags, Integers


# Tuned: with b = 2 or c = 0.5 pads of stiffening tissue still fold; larger values need more
# iterations.
BEND = 4.0  # b: change of the pressure with g, per size of a facet
MOST = 0.9  # c: largest relative change of the pressure, behind and before the obstacle


@dataclass(frozen=True)
class DeformedGap:
    """Weighted gaps, contact loads and their derivatives of a deformed pad under a pressure.

    pressure p (n,) kPa; at the integration points: distance g (n_tri, n_q) mm and its gradient
    (n_tri, n_q, 3), the ratio J (n_tri, n_q) of deformed to undeformed area and its derivative
    (n_tri, 6, n_q, 3) 1/mm with respect to the displacements of the nodes.
    """

    contact: "ContactSurface"
    pressure: Array
    distance: Array
    gradient: Array
    spread: Array
    spreading: Array

    @cached_property
    def weighted(self) -> Array:
        """The weighted gaps w (n,) mm³."""
        return self.contact.on.integrated(self._hats * self._bent[:, None])

    @property
    def gaps(self) -> Array:
        """The gaps w m / t (n,) mm³, which decrease by m per mm of travel, as on the flat pad."""
        return self.weighted / self.steepness

    @cached_property
    def steepness(self) -> Array:
        """The mean t / m (n,) of phi'."""
        slopes = self.contact.on.integrated(self._hats * self._slope[:, None])
        return np.asarray(slopes / self.contact.projected)

    @cached_property
    def loads(self) -> sparse.csc_matrix:
        """The loads B m / t (n_unknowns, n) mm² of unit pressures.

        They are the derivatives of the gaps per deformed area, w / t, times m: a uniform gap does
        not change where the pad spreads.
        """
        _, rows, slots = self.contact.columns
        data = np.zeros(len(rows))
        add_loads(
            self.contact.on.part.hats,
            self.contact.on.part.quadratic,
            self.gradient,
            self._slope,
            self._bent,
            self.spread,
            self.spreading,
            self.weighted / (self.steepness * self.contact.projected),
            self.steepness,
            self.contact.on.owner,
            slots,
            data,
        )
        return self._columns(data)

    @cached_property
    def tangential(self) -> sparse.csc_matrix:
        """The loads (n_unknowns, 2n) mm² of unit tractions in both directions along the obstacle.

        The traction is spread as the pressure, phi' sum psi lambda |grad g|, and acts along the
        obstacle's tangents over the two directions across its axis: first those of all candidates
        over the first direction, then over the second. On a plate the sum over the nodes is m q
        along each, to rounding. The same integral of a displacement is the weighted slip.
        """
        on, part = self.contact.on, self.contact.on.part
        sums = np.einsum(
            "tjq,tq,kq,tqac->tajkc",
            self._hats,
            self._slope,
            part.quadratic,
            tangents(self.contact.obstacle.axis, self.gradient),
            optimize=True,
        )
        sums /= self.steepness[on.owner][:, None, :, None, None]
        slots, size = self.contact.columns[2], len(self.loads.data)
        owned = slots >= 0
        along, across = (
            self._columns(np.bincount(slots[owned], sums[:, a][owned], size).astype(np.float64))
            for a in range(2)
        )
        if self.contact.medial.any():
            across = across @ sparse.diags_array(1.0 - self.contact.medial)
        return sparse.hstack([along, across], format="csc")

    @cached_property
    def fold_stiffness(self) -> Array:
        """Derivative (n,) kPa/mm of the pressure with respect to g: the resistance to folds."""
        mean = self.contact.on.integrated(self._hats * self._fall[:, None])
        return np.asarray(self._multipliers * mean / self.contact.projected)

    def stiffness(self) -> sparse.csr_matrix:
        """Contribution of phi'' to the tangent: integral of -phi'' psi lambda (grad g . v)² da.

        (n_unknowns, n_unknowns) mN/mm; it is positive semidefinite.
        """
        return self._normal(self._multipliers, self._fall)

    def spreading_stiffness(self) -> sparse.csr_matrix:
        """Contribution to the tangent of facets that spread while their gap changes.

        (n_unknowns, n_unknowns) mN/mm: minus the integral of psi lambda phi' (grad g . v dJ(v') +
        grad g . v' dJ(v)) dA. With `stiffness` it is the derivative of the loads of a flat contact
        in all directions that close no weighted gap; in the others the complementarity problem
        fixes the displacement. Second derivatives of g and, of the order of the gap, of J are left
        out.
        """
        weights = -self._slope * self._spread_over(self._multipliers, self.contact.on.part.hats)
        spreading = self.spreading.swapaxes(1, 2).reshape(self._along.shape)
        block = np.einsum("tq,tqi,tqj->tij", weights, self._along, spreading)
        return self._assembled(block + block.swapaxes(1, 2))

    def support(self, chosen: Flags) -> sparse.csr_matrix:
        """Return the integral of psi (grad g . v)² da over `chosen` candidates.

        (n_unknowns, n_unknowns) mm².
        """
        return self._normal(chosen.astype(np.float64), np.ones_like(self.distance))

    @cached_property
    def _hats(self) -> Array:
        """Weights times hats (n_tri, 3, n_q) mm² on the deformed pad."""
        return np.asarray(self.contact.on.part.hats * self.spread[:, None])

    @cached_property
    def _along(self) -> Array:
        """Derivative (n_tri, n_q, 18) of g with respect to the displacements of a facet's nodes."""
        along = np.einsum("kq,tqc->tqkc", self.contact.on.part.quadratic, self.gradient)
        return np.asarray(along.reshape(*along.shape[:2], -1))

    @cached_property
    def _bent(self) -> Array:
        """The values phi(g) (n_tri, n_q) mm."""
        t = self.distance / self._scale
        bent = self.distance - MOST * self._scale * (np.logaddexp(t, -t) - np.log(2.0))
        return np.asarray(bent)

    @cached_property
    def _multipliers(self) -> Array:
        """Lambda (n,) kPa, with the tension that an iterate may have set to zero."""
        return np.asarray(np.maximum(self.pressure, 0.0) / self.steepness)

    @cached_property
    def _scale(self) -> Array:
        return np.asarray(MOST * self.contact.sizes / BEND)

    @cached_property
    def _turn(self) -> Array:
        return np.asarray(np.tanh(self.distance / self._scale))

    @cached_property
    def _slope(self) -> Array:
        return np.asarray(1.0 - MOST * self._turn)

    @cached_property
    def _fall(self) -> Array:
        return np.asarray(MOST / self._scale * (1.0 - self._turn**2))

    def _normal(self, factor: Array, density: Array) -> sparse.csr_matrix:
        """Return the integral of psi `factor` (n,) `density` (n_tri, n_q) (grad g . v)² da."""
        weights = self._spread_over(factor, self._hats) * density
        return self._assembled(np.einsum("tq,tqi,tqj->tij", weights, self._along, self._along))

    def _spread_over(self, factor: Array, hats: Array) -> Array:
        """Sum (n_tri, n_q) of the `hats` (n_tri, 3, n_q), times the `factor` (n,) of each."""
        owner = self.contact.on.owner
        return np.einsum("tjq,tj->tq", hats, np.where(owner >= 0, factor[owner], 0.0))

    def _columns(self, data: Array) -> sparse.csc_matrix:
        """Matrix (n_unknowns, n) of entries at the places of `ContactSurface.columns`."""
        starts, rows, _ = self.contact.columns
        shape = (self.contact.n_unknowns, len(self.contact))
        return sparse.csc_matrix((data, rows, starts), shape=shape)

    def _assembled(self, block: Array) -> sparse.csr_matrix:
        """Matrix (n_unknowns, n_unknowns) of the blocks (n_tri, 18, 18) of the facets."""
        rows, count = self.contact.rows.reshape(len(block), -1), self.contact.n_unknowns
        return scattered(block, rows[:, :, None], rows[:, None, :], (count, count)).tocsr()


@dataclass(frozen=True)
class ContactSurface:
    """Contact candidates of a pad at finite deformation, and the obstacle.

    on: the candidates; neighborhood: they and the vertices around them, where gaps are read;
    at_rest (n_near, 3) mm: the undeformed positions of the neighborhood; reach mm: the largest gap
    of the candidates; medial (n,): those in the plane of symmetry of half a finger, which no
    friction pulls across it; spreads: whether gaps are weighted over the deformed pad; surface: how
    far the obstacle gives way under the pressure.
    """

    obstacle: Obstacle
    on: Candidates
    neighborhood: Neighborhood
    at_rest: Array
    n_unknowns: int
    reach: float
    medial: Flags
    spreads: bool = True
    surface: ObjectSurface = RIGID_SURFACE

    def __len__(self) -> int:
        """Return the number of candidates."""
        return len(self.on.vertices)

    @cached_property
    def projected(self) -> Array:
        """The integrals m (n,) mm² of the hats: closure of the gaps per mm of travel."""
        return self.on.integrated(self.on.part.hats)

    @cached_property
    def sizes(self) -> Array:
        """Sizes h (n_tri, 1) mm of the facets: legs of a right isosceles triangle of that area."""
        return np.asarray(np.sqrt(2 * self.on.part.weights.sum(axis=1, keepdims=True)))

    @cached_property
    def rows(self) -> Integers:
        """Unknowns (n_tri, 6, 3) of the facets."""
        return np.asarray(3 * self.on.part.nodes[:, :, None] + np.arange(3))

    @cached_property
    def columns(self) -> tuple[Indices, Indices, Indices]:
        """Places of loads: starts and rows of a CSC matrix (n_unknowns, n), and slots in its data.

        slots (n_tri, 3, 6, 3): of a facet's hats, nodes and directions, -1 without a candidate.
        """
        owner = self.on.owner[:, :, None, None]
        keys = owner * self.n_unknowns + self.rows[:, None]
        owned = np.broadcast_to(owner >= 0, keys.shape)
        places, inverse = np.unique(keys[owned], return_inverse=True)
        slots = np.full(keys.shape, -1, dtype=np.int32)
        slots[owned] = inverse
        starts = np.searchsorted(places, self.n_unknowns * np.arange(len(self) + 1))
        return starts.astype(np.int32), (places % self.n_unknowns).astype(np.int32), slots

    def at(self, state: State) -> DeformedGap:
        """Evaluate the gaps and loads of the pad in a state."""
        places = self.deformed(state.values) - state.shift
        distance, gradient = self.obstacle.implicit(places, state.depth)
        distance = np.where(np.isfinite(distance), distance, FAR)
        distance = distance + self.surface.at_places(state.pressure)
        part = self.on.part
        count, points = part.weights.shape
        spread, spreading = np.ones((count, points)), np.zeros((count, 6, points, 3))
        if self.spreads:
            fill_spread(state.values, self.rows, part.sides, part.slopes, spread, spreading)
        return DeformedGap(self, state.pressure, distance, gradient, spread, spreading)

    def bearing(self, loads: sparse.csc_matrix) -> Array:
        """Compute the force along the axis (k,) mm² of unit loads (n_unknowns, k).

        That of pressures is `projected`, to rounding; tractions over slopes have one too.
        """
        return np.asarray(loads.T @ self.translation(self.obstacle.axis))

    def slip(self, gap: DeformedGap, state: State, before: State) -> Array:
        """Compute the slip (2, n) mm³ of the skin over the obstacle between two states.

        It is weighted as the tractions of `gap`, those of `state`, and grows by m per mm on a
        plate.
        """
        moved = (state.depth - before.depth) * self.obstacle.axis + state.shift - before.shift
        change = state.values - before.values - self.translation(moved)
        return np.asarray(gap.tangential.T @ change).reshape(2, -1)

    def translation(self, moved: Array) -> Array:
        """Return the displacements (n_unknowns,) of skin that moves by (3,) mm."""
        values = np.zeros(self.n_unknowns)
        values[self.rows] = moved
        return values

    def deformed(self, values: Array) -> Array:
        """Deformed positions (n_tri, n_q, 3) mm of the quadrature points."""
        nodal = values[self.rows]
        return np.asarray(self.on.places + np.einsum("kq,tkc->tqc", self.on.part.quadratic, nodal))

    def clearance(self, state: State) -> tuple[Array, Array]:
        """Compute normal gaps (n_near,) mm and displacements (n_near, 3) mm of the neighborhood.

        The gap is FAR where the obstacle is not ahead.
        """
        moved = state.values[3 * self.neighborhood.vertices[:, None] + np.arange(3)]
        places = self.at_rest + moved - state.shift
        distance, gradient = self.obstacle.implicit(places, state.depth)
        distance = distance + self.surface.around(state.pressure)
        gap = distance / np.linalg.norm(gradient, axis=1)
        return np.where(np.isfinite(gap), gap, FAR), moved


def contact_surface(
    space: Space,
    triangles: Integers,
    normals: Array,
    obstacle: Obstacle,
    reach: float,
    *,
    spreads: bool = True,
    half: bool = False,
    under: Rigid | None = None,
) -> ContactSurface:
    """Build the contact surface: the candidates within `reach` mm, and one ring around them.

    The ring is for sharp edges: the gap beside one grows beyond any reach within a facet, while
    the skin folds around it. half: of a finger, at a plane of symmetry y = 0; under: all that an
    obstacle passes over on its path, by default the obstacle.
    """
    under = obstacle if under is None else under
    on = candidates(space, triangles, normals, under, reach, rings=1)
    around = neighborhood(space, triangles, normals, under, reach, on.vertices, 1 + RINGS)
    at_rest = space.points[around.vertices]
    medial = half & (space.points[on.vertices, 1] == 0)
    return ContactSurface(obstacle, on, around, at_rest, space.n_unknowns, reach, medial, spreads)


def tangents(axis: Array, gradient: Array) -> Array:
    """Return orthogonal tangents (..., 2, 3) of an obstacle, of the length of its gradient.

    gradient (..., 3): of its distance, 1 along the axis (3,). Over a plate the tangents are the two
    directions across the axis; over a slope the first stays above the first of these.
    """
    across = frame(axis)[:2]
    slopes = gradient @ across.T
    first, second = (across[a] - slopes[..., a, None] * axis for a in range(2))
    first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    second = second - (second * first).sum(axis=-1, keepdims=True) * first
    second = second / np.linalg.norm(second, axis=-1, keepdims=True)
    length = np.linalg.norm(gradient, axis=-1)[..., None, None]
    return np.asarray(length * np.stack([first, second], axis=-2))
