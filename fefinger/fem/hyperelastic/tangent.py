"""A factored tangent of a body, with what the contact needs of it."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fefinger.fem.contact.complementarity import Complementarity
from fefinger.fem.elements.spaces import Array, Integers
from fefinger.fem.linalg.multifrontal_single import Rough


class Factored:
    """A factored tangent K0 with the loads B and the gain of its time, and the rows of Z' so far.

    bed and rise (n_candidates,) kPa / mm: the stiffness that was put under the candidates, and that
    of what held their facets. Z = K0^-1 B.
    """

    def __init__(
        self,
        rough: Rough,
        free: Integers,
        loads: sparse.csc_matrix,
        gain: float,
        bed: Array,
        rise: Array,
    ) -> None:
        self.rough, self.free, self.loads, self.gain = rough, free, loads, gain
        self.bed, self.rise = bed, rise
        self.known = np.full(loads.shape[1], -1, dtype=np.int64)
        self.columns = np.empty((0, loads.shape[0]), dtype=np.float32)
        self.flexibility = np.empty((0, 0))
        self._near = np.zeros(loads.shape[1], dtype=np.bool_)
        self._solver: Complementarity | None = None
        self._leaning: tuple[sparse.csc_matrix, Array, Array] | None = None

    def lean(self, bed: Array, travel: Array) -> int:
        """Put a `bed` (n_candidates,) under the weighted gaps of weights `travel`.

        K0 becomes K0 + B A B', A = bed / travel, by Woodbury's formula on the flexibility F: exact,
        and without another factor. Return how many negative eigenvalues it takes from K0, which
        are those of A^-1 + F (Haynsworth, Linear Algebra Appl. 1:73, 1968).
        """
        chosen = np.flatnonzero(bed > 0)
        if not len(chosen):
            return 0
        loads = self.loads[:, chosen]
        columns = self.solve(loads.toarray())
        flexibility = loads.T @ columns
        values, vectors = np.linalg.eigh(
            np.diag(travel[chosen] / bed[chosen]) + (flexibility + flexibility.T) / 2
        )
        inverse = (vectors / values) @ vectors.T
        self.bed, self._leaning = bed, (loads, columns, inverse)
        self.known[chosen] = np.arange(len(chosen))
        self.columns = (columns - columns @ (inverse @ flexibility)).T.astype(np.float32)
        self.flexibility = loads.T @ self.columns.T
        return int((values < 0).sum())

    def solve(self, right: Array) -> Array:
        """Return K0^-1 `right` (n,) or (n, k) to the factor's precision, zero where prescribed."""
        scale = float(np.abs(right).max(initial=0.0)) or 1.0
        answer = np.zeros_like(right)
        answer[self.free] = scale * self.rough.solve(right[self.free] / scale)
        if self._leaning is not None:
            loads, columns, inverse = self._leaning
            answer -= columns @ (inverse @ (loads.T @ answer))
        return answer

    def contact(self, near: NDArray[np.bool_]) -> Complementarity:
        """Return the contact of the candidates `near`."""
        if self._solver is not None and np.array_equal(near, self._near):
            return self._solver
        new = np.flatnonzero(near & (self.known < 0))
        if len(new):
            self.known[new] = len(self.columns) + np.arange(len(new))
            found = self.solve(self.loads[:, new].toarray()).T.astype(np.float32)
            self.columns = np.concatenate([self.columns, found])
            order = np.argsort(self.known)[-len(self.columns) :]
            self.flexibility = self.loads[:, order].T @ self.columns.T
        where = self.known[near]
        flexibility = self.flexibility[np.ix_(where, where)].astype(np.float64)
        symmetric = (flexibility + flexibility.T) / 2
        self._near, self._solver = near, Complementarity(symmetric, any_sign=True)
        return self._solver

    def moved(self, pressure: Array) -> Array:
        """Return what a change of pressure (n_candidates,) moves, Z times it."""
        weights = np.zeros(len(self.columns), dtype=np.float32)
        seen = self.known >= 0
        weights[self.known[seen]] = pressure[seen]
        return np.asarray(weights @ self.columns, dtype=np.float64)
