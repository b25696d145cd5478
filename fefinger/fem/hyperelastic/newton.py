"""Equilibrium of a hyperelastic body in contact: Newton's method on a factor that is kept.

One iteration linearizes the body with a factored tangent K0 and leaves the complementarity of
the contact exact: with r the residual force, the displacements change by K0^-1 r + Z dlambda, Z =
K0^-1 B, and lambda >= 0 solves the complementarity problem of the weighted gaps that this change
leaves. Residual and gaps are always those of the true body, so an old factor costs iterations and
never accuracy; it is replaced when the residual shrinks too slowly. Where that fails, as when a
facet snaps through and the tangent is indefinite on the way, blends of the tangent with one made
positive definite lead downhill, without acceleration until the residual shrinks again.
"""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from fefinger.fem.contact.deformed_gap import Facing, Sliding
from fefinger.fem.contact.viscoelastic import depth_at
from fefinger.fem.elements.spaces import Array
from fefinger.fem.hyperelastic.anderson import Anderson
from fefinger.fem.hyperelastic.continuum import Continuum
from fefinger.fem.hyperelastic.state import Asked, State
from fefinger.fem.hyperelastic.tangent import Factored
from fefinger.fem.linalg.multifrontal_single import Rough
from fefinger.fem.linalg.system import System, rough
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.tolerances import EQUILIBRIUM


ITERATIONS = 120
PATIENCE = 25  # iterations of one step before its factor is renewed
STUCK = 2 * PATIENCE  # of them without a smaller error, before it is given up
FEW = 6  # iterations of a step that a good factor takes
RENEWAL = 200  # squares of the iterations beyond FEW, over steps, that a new factor is worth
SEARCH = 8  # factors of one step under depth control; more, and the way downhill is shorter
SOON = 3  # iterations that a factor is given at least
STIFF = 2.0  # what a factor need not know of what resists folds, in shear moduli over a facet
NEAR = 0.1  # gap, as part of the depth, below which a vertex is made ready for contact
BEDS = 4.0, 32.0, 256.0  # stiffness under the contact, in shear moduli over the size of the patch
MEMORY = 12  # iterates that the acceleration remembers
RETREATS = 8  # halvings of an iteration that turned a cell inside out
DESCENT = 100  # iterations downhill
ASTRAY = 16  # of them after which more than the load may be out of balance only if that falls,
FALLS = 4.0  # by so much in half of them
KEPT = 2  # of them with one share of the tangent made positive definite
STRIDE = 4.0  # by what that is divided
LEAST = 1 / 256  # of it
TRUST = 0.1  # of the size of a facet, that a node may move by in one of them
CALM = 4  # of them with ever smaller errors, before they are accelerated
SURE = 1e-3  # error below which they may be
MOST = 1e30  # mN at a node, of any tissue: more, and the iteration has run away
SURER = 0.1  # by how much smaller the error has to be before that is tried again


class Exhausted(ConvergenceError):
    """An equilibrium that takes more factors than are allowed: shorter steps take even more."""


class Equilibrium:
    """Solver of one body and one contact for many steps; it keeps the last factor.

    `system` is the body at rest, with what holds it; `iterations`, `factors` and `descents`, the
    steps that were found downhill, count the work, and `allowed` bounds `factors`.
    """

    def __init__(self, body: Continuum, contact: Sliding, system: System) -> None:
        self.body, self.contact, self.system = body, contact, system
        self.load = 0.0  # the largest load so far, which scales the residual
        self.iterations, self.factors, self.descents = 0, 0, 0
        self.allowed = np.inf
        self._excess, self._bed = 0, 0
        # A tangent has as many negative eigenvalues as pressures where the body is stable.
        self._pressures = int((system.free >= body.space.n_displacements).sum())
        at_rest, none = np.zeros(body.space.n_unknowns), np.zeros(len(contact))
        loads = contact.at(State(at_rest, none, 0.0)).loads
        self._factored = Factored(system.rough, system.free, loads, 1.0, none, none)

    def find(self, start: State, asked: Asked) -> State:
        """Return the equilibrium near `start`.

        Raises
        ------
        ConvergenceError
            If it is not reached; the step was too large for the body or the contact.
        Exhausted
            If it takes more factors than are allowed.
        """
        if asked.control == "depth":
            start = replace(start, depth=asked.target)
        try:
            return self._search(start, asked)
        except ConvergenceError:
            found = self._descend(start, asked)
        self.descents += 1
        return found

    def _search(self, start: State, asked: Asked, *, whole: bool = True) -> State:
        """Iterate from `start`, accelerated; with true tangents if `whole`."""
        state, sound = start, start
        mixing, retreats, error, renewed = Anderson(MEMORY), 0, np.inf, -SOON
        best, found, stuck = np.inf, 0, STUCK if whole else PATIENCE
        most = self.factors + (SEARCH if asked.control == "depth" else ITERATIONS)
        for count in range(ITERATIONS):
            look = self._look(state, asked)
            if look is None:
                retreats += 1
                if retreats > RETREATS or sound is start:
                    break
                state = replace(state, values=(state.values + sound.values) / 2)
                mixing = Anderson(MEMORY)
                continue
            sound, error = state, look.error
            if error <= EQUILIBRIUM:
                self._excess += max(0, count - FEW) ** 2
                return state
            if error < best:
                best, found = error, count
            elif count - found > stuck or self.factors > most:
                break
            worn = self._excess > RENEWAL or count % PATIENCE == PATIENCE - 1
            if worn or (count - renewed >= SOON and self._outgrown(look.facing.rise, asked)):
                self._renew(look, asked, whole=whole)
                mixing, renewed = Anderson(MEMORY), count
            state = self._step(look, asked, mixing)
        raise _missed(error, count + 1)

    def _descend(self, start: State, asked: Asked) -> State:
        """Go downhill from `start` on blends of tangents, accelerated at the end.

        A tangent made positive definite leads downhill from anywhere, but slowly where the body
        buckles; the true one leads there at once, but anywhere from far away. The share of the
        first shrinks, as far as what the body leans on keeps the blend stable.
        """
        state, sound, plain, share = start, start, Anderson(1), 1.0
        errors, calm, sure = [np.inf], 0, SURE
        for _ in range(DESCENT):
            look = self._look(state, asked)
            if look is None:
                if state is sound:
                    break
                state, calm, share = sound.toward(state, 0.5), 0, 1.0
                continue
            calm = calm + 1 if look.error < errors[-1] else 0
            sound = state
            errors.append(look.error)
            if look.error <= EQUILIBRIUM:
                return state
            if _in_vain(errors):
                break
            if calm >= CALM and look.error < sure:
                with suppress(ConvergenceError):
                    return self._search(state, asked, whole=False)
                sure = SURER * look.error
            share = self._blend(look, asked, share)
            state = self._trusted(state, self._step(look, asked, plain))
            if asked.control == "depth" and (len(errors) - 1) % KEPT == 0:
                share = max(share / STRIDE, LEAST)
        raise _missed(errors[-1], len(errors) - 1)

    def _trusted(self, state: State, far: State) -> State:
        """Return the state as far on the way from `state` to `far` as an iteration is trusted."""
        n = self.body.space.n_displacements
        moved = (far.values - state.values)[:n].reshape(-1, 3)
        most = float(np.linalg.norm(moved, axis=1).max(initial=0.0))
        trusted = TRUST * float(self.contact.sizes.mean())
        return far if most <= trusted else state.toward(far, trusted / most)

    def _look(self, state: State, asked: Asked) -> "_Look | None":
        """Return what an iterate is like; None if a cell is inside out, or forces have run away."""
        self.iterations += 1
        inner, least = self.body.residual(state.values, asked.memory)
        if least <= 0 or not np.abs(inner).max() < MOST:  # nor where one is not a number
            return None
        facing = self.contact.at(state)
        return _Look(state, inner, facing, self._error(state, asked, inner, facing))

    def _outgrown(self, rise: Array, asked: Asked) -> bool:
        """Return whether what resists folds is too stiff for the factor, which does not know it.

        The iteration would go back and forth: it is meant for errors that are small beside K0.
        """
        gain = float(asked.memory.gains.mean())
        skin = gain * self.body.scale / np.sqrt(self.contact.travel)
        known = self._factored.rise * gain / self._factored.gain
        return bool((np.abs(rise - known) > np.maximum(STIFF * skin, known / 2)).any())

    def _error(self, state: State, asked: Asked, inner: Array, facing: Facing) -> float:
        """Return the largest of the relative errors of force, volume, gap and target."""
        travel, n = self.contact.travel, self.body.space.n_displacements
        force, gaps = facing.loads @ state.pressure, facing.gaps
        free = self.system.free[self.system.free < n]
        load = max(self.load, float(np.linalg.norm(force)))
        self.load, residual = load, inner - force
        load = max(load, asked.small)
        size = max(abs(state.depth), float(np.abs(state.values[:n]).max(initial=0.0)))
        shallow = asked.small / self.body.scale / float(np.sqrt(travel.sum()))
        size = max(size, asked.shallow, shallow)
        forces = float(np.linalg.norm(residual[free]))
        volumes = float(np.abs(residual[n:]).sum()) / self.body.scale
        apart = np.where(state.pressure > 0, np.abs(gaps), np.maximum(-gaps, 0.0)) / travel
        errors = [
            forces / load if load > 0 else forces,
            volumes / (size * travel.sum()) if size > 0 else volumes,
            float(apart.max()) / size if size > 0 else 0.0,
        ]
        if asked.control == "force":
            reached = float(travel @ state.pressure)
            most = max(asked.target, reached, asked.small, 1e-300)
            errors.append(abs(reached - asked.target) / most)
        worst = max(errors)
        return worst if np.isfinite(worst) else np.inf

    def _renew(self, look: "_Look", asked: Asked, *, whole: bool = True) -> None:
        """Factor the tangent of the state, on a bed where it touches.

        Without what it leans on, a body under pressure may be about to buckle. Under depth control
        the true tangent is therefore factored with a stiffness of its own against what the contact
        forbids anyhow, the least of BEDS on which it is stable; `_step` takes its force off again.
        Unless `whole`, it is made positive definite instead.

        Raises
        ------
        ConvergenceError
            If it is singular.
        """
        body, gain = self.body, float(asked.memory.gains.mean())
        touched = look.state.pressure > 0
        matrix = body.tangent(look.state.values, asked.memory, whole=whole)
        matrix, bed = matrix + look.facing.stiffness(), 0.0
        if not (whole and asked.control == "depth"):
            renewed = self._rough(matrix)
        else:
            under = look.facing.bed(touched)
            unit = gain * body.scale / float(np.sqrt(self.contact.travel.sum()))
            while True:
                bed = BEDS[self._bed] * unit
                renewed = self._rough(matrix + bed * under)
                if renewed.negative <= self._pressures or self._bed == len(BEDS) - 1:
                    break
                self._bed += 1
        beds = np.where(touched, bed, 0.0)
        self._factored = Factored(
            renewed, self.system.free, look.facing.loads, gain, beds, look.facing.rise
        )
        self._excess = 0

    def _blend(self, look: "_Look", asked: Asked, share: float) -> float:
        """Factor a blend of the tangents; return the share of the one made positive definite.

        That is `share`, or more where the body would buckle on a bed under the weighted gaps that
        are closed: the least of its multiples by STRIDE with which it does not. Under force control
        there is no bed, and the share is 1.

        Raises
        ------
        ConvergenceError
            If it is singular.
        """
        body, travel, gain = self.body, self.contact.travel, float(asked.memory.gains.mean())
        values = look.state.values
        definite = body.tangent(values, asked.memory, whole=False)
        apart = body.tangent(values, asked.memory) - definite
        fixed = definite + look.facing.stiffness()
        unit = gain * body.scale / float(np.sqrt(travel.sum()))
        leans = (look.state.pressure > 0) & (asked.control == "depth")
        bed = np.where(leans, BEDS[-1] * unit, 0.0)
        while True:
            renewed = self._rough(fixed + (1 - share) * apart)
            none, loads = np.zeros(len(travel)), look.facing.loads
            held = Factored(renewed, self.system.free, loads, gain, none, look.facing.rise)
            negative = renewed.negative - held.lean(bed, travel)
            self._factored = held
            if share >= 1 or negative <= self._pressures:
                return share
            share = min(STRIDE * share, 1.0)

    def _rough(self, matrix: sparse.csr_matrix) -> Rough:
        if self.factors >= self.allowed:
            message = f"equilibrium: not reached with the {self.factors} factors that are allowed"
            raise Exhausted(message)
        self.factors += 1
        try:
            return rough(matrix, self.system)
        except InputError as error:
            # The body at rest was factored, so that it is this iterate that has gone astray.
            message = "equilibrium: the tangent of an iterate is singular; take shorter steps"
            raise ConvergenceError(message) from error

    def _step(self, look: "_Look", asked: Asked, mixing: "Anderson") -> State:
        """Return the state after one iteration."""
        state, held = look.state, self._factored
        gaps, loads, travel = look.facing.gaps, look.facing.loads, self.contact.travel
        size = abs(state.depth)
        apart = gaps / travel
        near = (state.pressure > 0) | (apart <= apart.min() + NEAR * size)
        softer = held.gain / float(asked.memory.gains.mean())
        bed = held.bed * (state.pressure > 0) / softer
        force = loads @ (state.pressure - bed * apart) - look.inner
        alone = softer * held.solve(force)
        free = gaps + state.depth * travel + loads.T @ alone
        while True:
            solver = held.contact(near)
            pressure, depth = np.zeros(len(travel)), state.depth
            clear = free[near] - softer * (solver.flexibility @ state.pressure[near])
            if asked.control == "depth":
                pressure[near] = solver.solve(clear - depth * travel[near]) / softer
            else:
                depth, pressure[near], _ = depth_at(
                    solver, 1 / softer, clear, travel[near], asked.target, depth, asked.peak
                )
            change = alone + held.moved(softer * (pressure - state.pressure))
            left = gaps + (state.depth - depth) * travel + loads.T @ change
            missed = ~near & (left < 0)
            if not missed.any():
                break
            near = near | missed
        return State(mixing.next(state.values, change), pressure, depth)


@dataclass(frozen=True)
class _Look:
    """An iterate: inner (n_unknowns,) mN the force of the body; error, the largest relative one."""

    state: State
    inner: Array
    facing: Facing
    error: float


def _in_vain(errors: list[float]) -> bool:
    """Return whether errors of iterations downhill, the last one last, lead nowhere."""
    last = len(errors) - 1
    if last - int(np.argmin(errors)) > STUCK:
        return True
    return last > ASTRAY and errors[-1] > max(1.0, errors[last - ASTRAY // 2] / FALLS)


def _missed(error: float, count: int) -> ConvergenceError:
    message = (
        f"equilibrium: asked for a relative residual of {EQUILIBRIUM:g}, reached {error:.1e} "
        f"after {count} iterations; take shorter steps"
    )
    return ConvergenceError(message)
