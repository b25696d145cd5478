"""Weighted gaps between a deformed pad and a rigid obstacle, with their derivatives.

With g(x) the distance of a point behind the obstacle's surface along its travel, the weighted gap
of a hat psi_i on the undeformed pad is w_i = integral of psi_i phi(g(x(X))) dA: finite sliding,
because g is taken where the point is now. lambda_i >= 0 times its derivative B_i is the load, so
that phi'(g) times the sum of psi_i lambda_i is the pressure. g grows by 1 per mm along the axis,
and the force along the axis is the sum of t_i lambda_i, t_i being the integral of psi_i phi'(g), or
of m_i p_i, m_i that of psi_i and p_i = lambda_i t_i / m_i. Gaps w_i m_i / t_i with the loads
B_i m_i / t_i of these p_i stand for w_i and lambda_i.

    phi(g) = g - c² h / b ln cosh(b g / (c h)),    phi'(g) = 1 - c tanh(b g / (c h)),

on a facet of size h, is g where the facet lies flat on the obstacle. Weighted means of g itself do
not see a facet fold, half of its six nodes behind the obstacle and half before it, as it would
under 40 % of compression along the skin. phi is concave: a fold closes its weighted gaps, and
pressure resists it in proportion. What that changes is of second order in g / h.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fefinger.fem.contact.obstacle import FAR, Obstacle
from fefinger.fem.contact.patch import RINGS, Candidates, Seen, candidates, seen
from fefinger.fem.elements.spaces import Array, Integers, Space
from fefinger.fem.hyperelastic.state import State


Flags = NDArray[np.bool_]

# With a b of 2, or a c of 0.5, pads of stiffening tissue still fold; with more, steps take longer.
BEND = 4.0  # b: how fast the pressure changes with g, per size of a facet
MOST = 0.9  # c: how much it rises at most behind the obstacle, and falls before it


@dataclass(frozen=True)
class Facing:
    """A pad as it stands before an obstacle, under a pressure p (n,) kPa.

    distance g (n_tri, n_q) mm, gradient (n_tri, n_q, 3): of the points of integration.
    """

    contact: "Sliding"
    pressure: Array
    distance: Array
    gradient: Array

    @cached_property
    def weighted(self) -> Array:
        """The weighted gaps w (n,) mm³."""
        t = self.distance / self._scale
        bent = self.distance - MOST * self._scale * (np.logaddexp(t, -t) - np.log(2.0))
        return self.contact.gathered(self.contact.hats * bent[:, None])

    @property
    def gaps(self) -> Array:
        """The gaps w m / t (n,) mm³, which close as the undeformed pad's."""
        return self.weighted / self.steepness

    @cached_property
    def steepness(self) -> Array:
        """The mean t / m (n,) of phi'."""
        slopes = self.contact.gathered(self.contact.hats * self._slope[:, None])
        return np.asarray(slopes / self.contact.travel)

    @cached_property
    def loads(self) -> sparse.csc_matrix:
        """The loads B m / t (n_unknowns, n) mm² of unit pressures, the derivatives of gaps of 0."""
        on, rows = self.contact.on, self.contact.rows
        hats = self.contact.hats * self._slope[:, None]
        block = np.einsum("tjq,kq,tqc->tkcj", hats, on.part.quadratic, self.gradient)
        block /= self.steepness[on.owner][:, None, None, :]
        rows = np.broadcast_to(rows[:, :, :, None], block.shape).ravel()
        columns = np.broadcast_to(on.owner[:, None, None, :], block.shape).ravel()
        kept = columns >= 0
        entries = (block.ravel()[kept], (rows[kept], columns[kept]))
        shape = (self.contact.n_unknowns, len(self.contact))
        return sparse.coo_matrix(entries, shape=shape).tocsc()

    @cached_property
    def rise(self) -> Array:
        """How fast the pressure (n,) kPa/mm changes with g, which is what resists folds."""
        mean = self.contact.gathered(self.contact.hats * self._fall[:, None])
        return np.asarray(self._multipliers * mean / self.contact.travel)

    def stiffness(self) -> sparse.csr_matrix:
        """Return what phi'' adds to the tangent: the integral of -phi'' psi lambda (grad g . v)².

        It is positive semidefinite.
        """
        return self._normal(self._multipliers, self._fall)

    def bed(self, chosen: Flags) -> sparse.csr_matrix:
        """Return the matrix of the integral of psi (grad g . v)² over the `chosen` candidates."""
        return self._normal(chosen.astype(np.float64), np.ones_like(self.distance))

    @cached_property
    def _multipliers(self) -> Array:
        """Lambda (n,) kPa without pulls, which an iterate may have."""
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
        """Return the integral of psi `factor` (n,) `density` (n_tri, n_q) (grad g . v)²."""
        on, rows = self.contact.on, self.contact.rows
        owned = np.where(on.owner >= 0, factor[on.owner], 0.0)
        weights = np.einsum("tjq,tj->tq", self.contact.hats, owned) * density
        along = np.einsum("kq,tqc->tqkc", on.part.quadratic, self.gradient)
        along = along.reshape(*along.shape[:2], -1)
        block = np.einsum("tq,tqi,tqj->tij", weights, along, along)
        rows = rows.reshape(len(block), -1)
        where = (
            np.broadcast_to(rows[:, :, None], block.shape).ravel(),
            np.broadcast_to(rows[:, None, :], block.shape).ravel(),
        )
        shape = (self.contact.n_unknowns, self.contact.n_unknowns)
        return sparse.coo_matrix((block.ravel(), where), shape=shape).tocsr()


@dataclass(frozen=True)
class Sliding:
    """The candidates on the pad and what is seen around them, and an obstacle.

    at_rest (n_seen, 3) mm: where the vertices seen are undeformed.
    """

    obstacle: Obstacle
    on: Candidates
    seen: Seen
    at_rest: Array
    n_unknowns: int

    def __len__(self) -> int:
        """Return the number of candidates."""
        return len(self.on.vertices)

    @cached_property
    def travel(self) -> Array:
        """The integrals m (n,) mm² of the hats: how fast the gaps close as the obstacle travels."""
        return self.gathered(self.hats)

    @cached_property
    def hats(self) -> Array:
        """Weights times hats (n_tri, 3, n_q) mm²."""
        return np.asarray(self.on.part.linear[None] * self.on.part.weights[:, None, :])

    @cached_property
    def sizes(self) -> Array:
        """Sizes h (n_tri, 1) mm of the facets: the short sides of right ones as large."""
        return np.asarray(np.sqrt(2 * self.on.part.weights.sum(axis=1, keepdims=True)))

    @cached_property
    def rows(self) -> Integers:
        """The unknowns (n_tri, 6, 3) of the facets."""
        return np.asarray(3 * self.on.part.nodes[:, :, None] + np.arange(3))

    def at(self, state: State) -> Facing:
        """Return the pad in a state before the obstacle."""
        distance, gradient, _ = self.obstacle.implicit(self.now(state.values), state.depth)
        distance = np.where(np.isfinite(distance), distance, FAR)
        return Facing(self, state.pressure, distance, gradient)

    def now(self, values: Array) -> Array:
        """Return where the quadrature points (n_tri, n_q, 3) mm are."""
        nodal = values[self.rows]
        return np.asarray(self.on.places + np.einsum("kq,tkc->tqc", self.on.part.quadratic, nodal))

    def clearance(self, values: Array, depth: float) -> tuple[Array, Array]:
        """Return gaps (n_seen,) mm along the normal, displacements (n_seen, 3) mm, where seen.

        The gap is FAR where the obstacle is not ahead.
        """
        moved = values[3 * self.seen.vertices[:, None] + np.arange(3)]
        distance, gradient, _ = self.obstacle.implicit(self.at_rest + moved, depth)
        gap = distance / np.linalg.norm(gradient, axis=1)
        return np.where(np.isfinite(gap), gap, FAR), moved

    def gathered(self, density: Array) -> Array:
        """Return sums (n,) over the facets of the candidates of densities (n_tri, 3, n_q)."""
        sums, kept = density.sum(axis=2), self.on.owner >= 0
        found = np.bincount(self.on.owner[kept], sums[kept], minlength=len(self))
        return np.asarray(found, dtype=np.float64)


def sliding(
    space: Space, triangles: Integers, normals: Array, obstacle: Obstacle, reach: float
) -> Sliding:
    """Return the patch of the pad `contact.candidates` within `reach` mm, and a ring around it.

    Beside an edge the gap grows within a facet to any reach, and skin folds around it.
    """
    on = candidates(space, triangles, normals, obstacle, reach, rings=1)
    around = seen(space, triangles, normals, obstacle, reach, on.vertices, 1 + RINGS)
    return Sliding(obstacle, on, around, space.points[around.vertices], space.n_unknowns)
