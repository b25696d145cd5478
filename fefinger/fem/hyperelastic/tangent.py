"""Factored tangent of a body, and the flexibility of its contact candidates."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fefinger.contact.complementarity import Complementarity
from fefinger.contact.coulomb import CoulombSolver
from fefinger.fem.linalg.multifrontal_indefinite import ApproximateFactor
from fefinger.support.arrays import Array, Flags, Integers


class FactoredTangent:
    """Factored tangent K0, the contact loads L, and the computed columns of Z = K0^-1 L.

    loads: of unit pressures on the n candidates, and with friction of unit tractions in both
    directions, n or 3n columns. L' Z is the flexibility.

    gain: the relaxation factor at which the tangent was made; support (n_candidates,) kPa/mm: the
    stiffness added under the candidates; fold_stiffness (n_candidates,) kPa/mm: of the
    contact law against folds (see `deformed_gap`). column_of (n_loads,): the number of a load's
    column of Z, -1 until it is needed.

    following (n_unknowns,): displacement per mm of travel that the contact stiffness in K0 causes.
    """

    def __init__(
        self,
        approximate_factor: ApproximateFactor,
        free: Integers,
        loads: sparse.csc_matrix,
        gain: float,
        support: Array,
        fold_stiffness: Array,
    ) -> None:
        self.approximate_factor, self.free, self.gain = approximate_factor, free, gain
        self.support, self.fold_stiffness = support, fold_stiffness
        self.following = np.zeros(loads.shape[0])
        self.loads = loads
        self._surface = np.unique(loads.indices)  # all else is not loaded
        self._surface_loads = loads[self._surface]
        self.column_of = np.full(loads.shape[1], -1, dtype=np.int64)
        self.columns = np.empty((0, loads.shape[0]), dtype=np.float32)
        self.flexibility = np.empty((0, 0))
        self._near = np.zeros(len(support), dtype=np.bool_)
        self._solver: Complementarity | CoulombSolver | None = None
        self._woodbury: tuple[sparse.csc_matrix, Array, Array] | None = None

    def set_travel_load(self, load: Array) -> None:
        """Set `following` from the load C e (n_unknowns,) mN/mm of a travel: see `newton`."""
        self.following = self.solve(load)

    def travel(self, loads: sparse.csc_matrix, projected: Array) -> tuple[Array, Array]:
        """Return displacement (n,) and closing of the gaps (n_candidates,) mm² per mm of travel.

        Facets that spread on the way are left out: 5 to 24 % of the depth of an incompressible cube
        squeezed by 5 to 20 %, 1 % of a finger's. Where the body would be unstable without the
        obstacle, and gaps open by it, nothing follows.
        """
        closing = projected - loads.T @ self.following
        if (closing > 0).all():
            return self.following, closing
        return np.zeros_like(self.following), projected

    def add_support(self, support: Array, projected: Array) -> int:
        """Add an elastic `support` (n_candidates,) to the gaps, weighted by the areas `projected`.

        K0 becomes K0 + B A B', A = support / projected, by Woodbury's formula on the flexibility F:
        exact, and without another factor. Return the number of negative eigenvalues that this
        removes from K0: as many as A^-1 + F has (Haynsworth, Linear Algebra Appl. 1:73, 1968).
        """
        chosen = np.flatnonzero(support > 0)
        if not len(chosen):
            return 0
        loads = self.loads[:, chosen]
        columns = self.solve(loads.toarray())
        flexibility = loads.T @ columns
        values, vectors = np.linalg.eigh(
            np.diag(projected[chosen] / support[chosen]) + (flexibility + flexibility.T) / 2
        )
        inverse = (vectors / values) @ vectors.T
        self.support, self._woodbury = support, (loads, columns, inverse)
        self.column_of[chosen] = np.arange(len(chosen))
        self.columns = (columns - columns @ (inverse @ flexibility)).T.astype(np.float32)
        self.flexibility = loads.T @ self.columns.T
        return int((values < 0).sum())

    def solve(self, right: Array) -> Array:
        """Return K0^-1 `right` (n,) or (n, k) to the factor's precision, zero where prescribed."""
        # The factor may be in single precision: scaled, its numbers neither over- nor underflow.
        scale = float(np.abs(right).max(initial=0.0)) or 1.0
        answer = np.zeros_like(right)
        answer[self.free] = scale * self.approximate_factor.solve(right[self.free] / scale)
        if self._woodbury is not None:
            loads, columns, inverse = self._woodbury
            answer -= columns @ (inverse @ (loads.T @ answer))
        return answer

    def contact(self, near: Flags) -> Complementarity:
        """Return the complementarity solver of the candidates `near` (n_candidates,)."""
        if not (isinstance(self._solver, Complementarity) and np.array_equal(near, self._near)):
            self._near = near
            self._solver = Complementarity(self._flexibility_of(near), any_sign=True)
        return self._solver

    def coulomb(self, near: Flags) -> CoulombSolver:
        """Return the solver of contact with friction of the candidates `near` (n_candidates,)."""
        if not (isinstance(self._solver, CoulombSolver) and np.array_equal(near, self._near)):
            self._near = near
            self._solver = CoulombSolver(self._flexibility_of(np.tile(near, 3)), 0.0)
        return self._solver

    def _flexibility_of(self, chosen: Flags) -> Array:
        """Return the flexibility of `chosen` loads (n_loads,)."""
        new = np.flatnonzero(chosen & (self.column_of < 0))
        if len(new):
            self.column_of[new] = len(self.columns) + np.arange(len(new))
            added = self.solve(self.loads[:, new].toarray()).T.astype(np.float32)
            self.columns = np.concatenate([self.columns, added])
            self.flexibility = self._bordered(added, new)
        where = self.column_of[chosen]
        flexibility = self.flexibility[np.ix_(where, where)].astype(np.float64)
        return np.asarray((flexibility + flexibility.T) / 2)

    def _bordered(self, added: NDArray[np.float32], new: Integers) -> Array:
        """Return the flexibility with `added` columns (n, n_unknowns) of the loads `new`.

        Only rows and columns of the new loads are computed.
        """
        surface, loads = self._surface, self._surface_loads
        order = np.argsort(self.column_of)[-len(self.columns) :]
        known = len(order) - len(new)
        whole = np.empty((len(order), len(order)))
        whole[:known, :known] = self.flexibility
        whole[:, known:] = loads[:, order].T @ added[:, surface].T
        whole[known:, :known] = loads[:, new].T @ self.columns[:known, surface].T
        return whole

    def moved(self, contact: Array) -> Array:
        """Displacement Z dx (n_unknowns,) under a change of the contact (n_loads,) kPa."""
        weights = np.zeros(len(self.columns), dtype=np.float32)
        computed = self.column_of >= 0
        weights[self.column_of[computed]] = contact[computed]
        return np.asarray(weights @ self.columns, dtype=np.float64)
