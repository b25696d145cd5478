"""Factored tangent of a body, and its contact in one Newton iteration: pressures and depth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fefinger.contact.active_set import DONE
from fefinger.contact.complementarity import Complementarity, pressure_at_force
from fefinger.contact.coulomb import CoulombSolver
from fefinger.contact.force_control import CORRECTIONS, depth_of_force
from fefinger.contact.soft import ObjectSurface
from fefinger.fem.hyperelastic.state import State, Target
from fefinger.fem.linalg.multifrontal_indefinite import ApproximateFactor
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import PRESS_LESS, ConvergenceError
from fefinger.support.tolerances import COMPLEMENTARITY, FORCE_MATCH


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


@dataclass(frozen=True)
class LinearizedContact:
    """Gaps and slips that change linearly with depth, pressures and tractions.

    factored: the tangent, with the flexibility of the candidates, that of `gain_ratio` times the
    present tangent; free (n,) or (3n,) mm³: gaps, and with friction slips in both directions, at a
    depth of 0 under the contact of `state`; closing (n,) or (3n,) mm²: by how much they fall per mm
    of depth; bearing (n,) or (3n,) mm²: force along the axis per pressure and traction.
    """

    factored: FactoredTangent
    surface: ObjectSurface
    gain_ratio: float
    state: State
    free: Array
    closing: Array
    bearing: Array

    def solve(self, near: Flags, target: Target) -> tuple[float, Array]:
        """Return the depth mm, and the contact (n,) or (3n,) kPa of the candidates `near` (n,).

        Raises ConvergenceError if no contact obeys its law, or none bears the force.
        """
        if target.friction is None:
            return self._frictionless(near, target)
        return self._with_friction(near, target, target.friction.coefficient[near])

    def _frictionless(self, near: Flags, target: Target) -> tuple[float, Array]:
        state, ratio, closing = self.state, self.gain_ratio, self.closing[near]
        pressure, depth = np.zeros(len(near)), state.depth
        solver = self.surface.softened(self.factored.contact(near), near, ratio)
        bare_gaps = self.free[near] - ratio * (solver.flexibility @ state.pressure[near])
        if target.by_force:
            depth, pressure[near], _ = pressure_at_force(
                solver,
                1 / ratio,
                bare_gaps,
                self.bearing[near],
                target.value,
                depth,
                target.peak,
                closing,
            )
        else:
            pressure[near] = solver.solve(bare_gaps - depth * closing) / ratio
        return depth, pressure

    def _with_friction(
        self, near: Flags, target: Target, coefficient: Array
    ) -> tuple[float, Array]:
        chosen, contact, depth = np.tile(near, 3), np.zeros(3 * len(near)), self.state.depth
        solver = self.factored.coulomb(near)
        solver.mu[:] = coefficient
        closing = self.closing[chosen]
        bare = self.free[chosen]
        bare = bare - self.gain_ratio * (solver.flexibility @ self.state.contact[chosen])
        count, bearing = len(coefficient), self.bearing[chosen]

        def borne(tried: float) -> tuple[float, float]:
            _solve(solver, bare - tried * closing)
            return float(bearing @ solver.x) / self.gain_ratio, 0.0

        touch = float(np.min(bare[:count] / closing[:count]))
        if not target.by_force:
            _solve(solver, bare - depth * closing)
        elif target.value <= 0:
            return touch, contact
        else:
            search = {"guess": depth, "peak": target.peak, "match": FORCE_MATCH}
            depth, tried = depth_of_force(borne, touch, target.value, **search)
            if tried > CORRECTIONS:
                raise ConvergenceError(
                    f"force control: expected {target.value:.6g} mN, reached "
                    f"{borne(depth)[0]:.6g} mN after {CORRECTIONS} corrections; {PRESS_LESS}"
                )
        contact[chosen] = solver.x / self.gain_ratio
        return depth, contact


def _solve(solver: CoulombSolver, offset: Array) -> None:
    """Solve for the contact of an offset (3n,) mm³."""
    if solver.solve(offset, COMPLEMENTARITY) != DONE:
        raise ConvergenceError(
            "contact: expected pressures and tractions that obey Coulomb's law with a coefficient "
            f"of {float(solver.mu.max()):g}, found none; {PRESS_LESS}, or take a smaller "
            "indenter.friction"
        )
