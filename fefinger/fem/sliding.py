"""Weighted gaps between a deformed pad and a rigid obstacle, with their derivatives.

With g(x) the distance of a point behind the obstacle's surface along its travel, the weighted gap
of a hat psi_i on the undeformed pad is w_i = integral of psi_i g(x(X)) dA: finite sliding, because
g is taken where the point is now. lambda_i >= 0 times the derivative of w_i is the load; g grows by
1 per mm along the axis, so that the force along the axis is the sum of m_i lambda_i, m_i being the
integral of psi_i.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fefinger.fem.contact import RINGS, Candidates, Seen, candidates, seen
from fefinger.fem.obstacle import FAR, Obstacle
from fefinger.fem.spaces import Array, Integers, Space


Flags = NDArray[np.bool_]

SLACK = 0.05  # of the size of a facet: how far a point of it may pass through the obstacle
HOLD = 1500.0  # pressure that keeps it from going farther, in shear moduli, at a whole size more


@dataclass(frozen=True)
class Hold:
    """What keeps the facets before the obstacle.

    force (n_unknowns,) mN on the skin; pressure (n,) kPa of the candidates with the same force
    along the axis; rise (n,) kPa/mm how fast it grows with the depth; stiffness: the derivative of
    minus the force.
    """

    force: Array
    pressure: Array
    rise: Array
    stiffness: sparse.csr_matrix


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
        """The weights m (n,) mm²: how fast the weighted gaps close as the obstacle travels."""
        return self._gathered(self.hats.sum(axis=2))

    @cached_property
    def hats(self) -> Array:
        """Weights times hats (n_tri, 3, n_q) mm²."""
        return np.asarray(self.on.part.linear[None] * self.on.part.weights[:, None, :])

    def gaps(self, values: Array, depth: float) -> tuple[Array, sparse.csc_matrix]:
        """Return the weighted gaps (n,) mm³ and their derivatives (n_unknowns, n) mm²."""
        distance, gradient, _ = self.obstacle.implicit(self.now(values), depth)
        distance = np.where(np.isfinite(distance), distance, FAR)
        weighted = np.einsum("tjq,tq->tj", self.hats, distance)
        block = np.einsum("tjq,kq,tqc->tkcj", self.hats, self.on.part.quadratic, gradient)
        rows = np.broadcast_to(self._rows()[:, :, :, None], block.shape).ravel()
        columns = np.broadcast_to(self.on.owner[:, None, None, :], block.shape).ravel()
        kept = columns >= 0
        entries = (block.ravel()[kept], (rows[kept], columns[kept]))
        shape = (self.n_unknowns, len(self))
        return self._gathered(weighted), sparse.coo_matrix(entries, shape=shape).tocsc()

    @cached_property
    def sizes(self) -> Array:
        """Sizes (n_tri, 1) mm of the facets: the short sides of right ones as large."""
        return np.asarray(np.sqrt(2 * self.on.part.weights.sum(axis=1, keepdims=True)))

    def hold(self, values: Array, depth: float, gaps: Array, shear: float) -> Hold:
        """Return what keeps facets from folding through the obstacle.

        Three weighted gaps do not see a facet fold, half of its six nodes behind the obstacle and
        half before it, as it would under 40 % of compression along the skin. Points deeper in the
        obstacle than SLACK facets are therefore pushed back, by the square of what they are deeper,
        so that the force has a derivative; a fine mesh has none.
        The weighted `gaps` (n,) mm³ that an iterate has not closed yet do not count. `shear` is the
        shear modulus of the skin in kPa.
        """
        distance, gradient, _ = self.obstacle.implicit(self.now(values), depth)
        owned = self.on.owner >= 0
        ahead = np.where(owned, np.minimum(gaps / self.travel, 0.0)[self.on.owner], 0.0)
        distance = distance - np.einsum("tj,jq->tq", ahead, self.on.part.linear)
        beyond = np.maximum(-distance / self.sizes - SLACK, 0.0)
        if not beyond.any():
            empty = sparse.csr_matrix((self.n_unknowns, self.n_unknowns))
            none = np.zeros(len(self))
            return Hold(np.zeros(self.n_unknowns), none, none, empty)
        pressure = HOLD * shear * beyond**2
        hats = self.hats * owned[:, :, None]
        density = hats.sum(axis=1)
        block = np.einsum("tq,kq,tqc->tkc", density * pressure, self.on.part.quadratic, gradient)
        force = np.zeros(self.n_unknowns)
        np.add.at(force, self._rows(), block)
        total = self._gathered(np.einsum("tjq,tq->tj", hats, pressure))
        rise = 2 * HOLD * shear * beyond / self.sizes
        stiffness = self._normal(density * rise, gradient)
        risen = self._gathered(np.einsum("tjq,tq->tj", hats, rise))
        return Hold(force, total / self.travel, risen / self.travel, stiffness)

    def bed(self, values: Array, depth: float, chosen: Flags) -> sparse.csr_matrix:
        """Return the matrix of the integral of psi (grad g . v)² over the `chosen` candidates."""
        _, gradient, _ = self.obstacle.implicit(self.now(values), depth)
        owner = self.on.owner
        weights = np.einsum("tjq,tj->tq", self.hats, (owner >= 0) & chosen[owner])
        return self._normal(weights, gradient)

    def _normal(self, weights: Array, gradient: Array) -> sparse.csr_matrix:
        """Return the matrix of the sum of `weights` (n_tri, n_q) times (grad g . v)²."""
        along = np.einsum("kq,tqc->tqkc", self.on.part.quadratic, gradient)
        along = along.reshape(*along.shape[:2], -1)
        block = np.einsum("tq,tqi,tqj->tij", weights, along, along)
        rows = self._rows().reshape(len(block), -1)
        where = (
            np.broadcast_to(rows[:, :, None], block.shape).ravel(),
            np.broadcast_to(rows[:, None, :], block.shape).ravel(),
        )
        shape = (self.n_unknowns, self.n_unknowns)
        return sparse.coo_matrix((block.ravel(), where), shape=shape).tocsr()

    def now(self, values: Array) -> Array:
        """Return where the quadrature points (n_tri, n_q, 3) mm are."""
        nodal = values[self._rows()]
        return np.asarray(self.on.places + np.einsum("kq,tkc->tqc", self.on.part.quadratic, nodal))

    def clearance(self, values: Array, depth: float) -> tuple[Array, Array]:
        """Return gaps (n_seen,) mm along the normal, displacements (n_seen, 3) mm, where seen.

        The gap is FAR where the obstacle is not ahead.
        """
        moved = values[3 * self.seen.vertices[:, None] + np.arange(3)]
        distance, gradient, _ = self.obstacle.implicit(self.at_rest + moved, depth)
        gap = distance / np.linalg.norm(gradient, axis=1)
        return np.where(np.isfinite(gap), gap, FAR), moved

    def _rows(self) -> Integers:
        return np.asarray(3 * self.on.part.nodes[:, :, None] + np.arange(3))

    def _gathered(self, values: Array) -> Array:
        kept = self.on.owner >= 0
        sums = np.bincount(self.on.owner[kept], values[kept], minlength=len(self))
        return np.asarray(sums, dtype=np.float64)


def sliding(
    space: Space, triangles: Integers, normals: Array, obstacle: Obstacle, reach: float
) -> Sliding:
    """Return the patch of the pad `contact.candidates` within `reach` mm, and a ring around it.

    Beside an edge the gap grows within a facet to any reach, and skin folds around it.
    """
    on = candidates(space, triangles, normals, obstacle, reach, rings=1)
    around = seen(space, triangles, normals, obstacle, reach, on.vertices, 1 + RINGS)
    return Sliding(obstacle, on, around, space.points[around.vertices], space.n_unknowns)
