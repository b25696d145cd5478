"""Iterates of Newton's method for a body in contact: error, end, and Anderson acceleration."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fefinger.contact.frictional import STUCK
from fefinger.fem.contact.deformed_gap import ContactSurface, DeformedGap
from fefinger.fem.hyperelastic.continuum import Continuum
from fefinger.fem.hyperelastic.state import Friction, State, Target
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import PRESS_LESS, ConvergenceError


ASTRAY = 16  # iterations after which an error above 1 is accepted only while it falls


@dataclass(frozen=True)
class Iterate:
    """An iterate with its internal force `inner` (n_unknowns,) mN, gaps and relative error.

    loads: of unit pressures and, with friction, of unit tractions; slip (2, n) mm³: since the start
    of the load step, (2, 0) without friction; bearing (n,) or (3n,) mm²: their forces along the
    axis.
    """

    state: State
    inner: Array
    gap: DeformedGap
    loads: sparse.csc_matrix
    slip: Array
    bearing: Array
    error: float = np.inf


def relative_error(
    body: Continuum,
    contact: ContactSurface,
    free: Integers,
    iterate: Iterate,
    target: Target,
    load: float,
) -> float:
    """Return the largest of the relative errors of force, volume, gap, slip and prescribed force.

    free: unknowns that are not held; load mN: the largest one so far.
    """
    state, gaps = iterate.state, iterate.gap.gaps
    residual = iterate.inner - iterate.loads @ state.contact
    projected, n = contact.projected, body.space.n_displacements
    load = max(load, target.force_floor)
    size = max(abs(state.depth), float(np.abs(state.values[:n]).max(initial=0.0)))
    shallow = target.force_floor / body.scale / float(np.sqrt(projected.sum()))
    size = max(size, target.depth_floor, shallow)
    forces = float(np.linalg.norm(residual[free[free < n]]))
    volumes = float(np.abs(residual[n:]).sum()) / body.scale
    apart = np.where(state.pressure > 0, np.abs(gaps), np.maximum(-gaps, 0.0)) / projected
    errors = [
        forces / load if load > 0 else forces,
        volumes / (size * projected.sum()) if size > 0 else volumes,
        float(apart.max()) / size if size > 0 else 0.0,
    ]
    if target.friction is not None and size > 0:
        errors.append(
            float(_unlawful(state, target.friction, iterate.slip / projected).max()) / size
        )
    if target.by_force:
        reached = float(iterate.bearing @ state.contact)
        most = max(target.value, reached, target.force_floor, 1e-300)
        errors.append(abs(reached - target.value) / most)
    worst = max(errors)
    return worst if np.isfinite(worst) else np.inf


def _unlawful(state: State, friction: Friction, slip: Array) -> Array:
    """Return the part (n,) mm of the slip (2, n) mm that Coulomb's law does not allow.

    Under pressure: all of it where the skin sticks; where it slips, what is not against the
    traction.
    """
    size, bound = np.hypot(*state.traction), friction.coefficient * state.pressure
    slips = (size >= bound * (1 - STUCK)) & (size > 0)
    against = -np.divide(state.traction, size, where=slips, out=np.zeros_like(slip))
    allowed = against * np.maximum((against * slip).sum(axis=0), 0.0)
    return np.where(bound > 0, np.hypot(*(slip - allowed)), 0.0)


def stagnant(errors: list[float], stuck: int) -> bool:
    """Whether the errors of an iteration, oldest first, no longer improve.

    stuck: iterations without a smaller error before that is so, whatever the error.
    """
    last = len(errors) - 1
    if last - int(np.argmin(errors)) > stuck:
        return True
    falls = 4.0  # factor by which the error must fall in ASTRAY / 2 iterations
    return last > ASTRAY and errors[-1] > max(1.0, errors[last - ASTRAY // 2] / falls)


def not_converged(tolerance: float, error: float, count: int) -> ConvergenceError:
    """Return the error of an iteration that has not reached its tolerance."""
    message = (
        f"equilibrium: expected a relative residual of at most {tolerance:g}, reached "
        f"{error:.1e} after {count} iterations; {PRESS_LESS}"
    )
    return ConvergenceError(message)


class Anderson:
    """Anderson acceleration with the last `depth` iterates; a depth of 1 is the plain iteration.

    Anderson, J. ACM 12:547, 1965.
    """

    def __init__(self, depth: int) -> None:
        self.depth = depth
        self.points: list[Array] = []
        self.changes: list[Array] = []

    def next(self, point: Array, change: Array) -> Array:
        """Return the next point (n,) after `point`, which the iteration would move by `change`.

        Raises ConvergenceError if changes have grown beyond numbers.
        """
        self.points = [*self.points, point][-self.depth :]
        self.changes = [*self.changes, change][-self.depth :]
        if len(self.points) == 1:
            return point + change
        differences = np.diff(self.changes, axis=0)
        square = differences @ differences.T
        if not np.isfinite(square).all():
            message = f"equilibrium: the iteration diverged; {PRESS_LESS}"
            raise ConvergenceError(message)
        weights = np.linalg.lstsq(square, differences @ change, rcond=1e-12)[0]
        moved = np.diff(self.points, axis=0) + differences
        return np.asarray(point + change - weights @ moved)
