"""Contact of a linearized body: the pressures, tractions and depth of one Newton iteration."""

from dataclasses import dataclass

import numpy as np

from fefinger.contact.active_set import DONE
from fefinger.contact.complementarity import pressure_at_force
from fefinger.contact.coulomb import CoulombSolver
from fefinger.contact.force_control import CORRECTIONS, depth_of_force
from fefinger.contact.soft import ObjectSurface
from fefinger.fem.hyperelastic.state import State, Target
from fefinger.fem.hyperelastic.tangent import FactoredTangent
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import PRESS_LESS, ConvergenceError
from fefinger.support.tolerances import COMPLEMENTARITY, FORCE_MATCH


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
