"""Equilibrium of a hyperelastic body in contact: modified Newton's method.

One iteration linearizes the body with a factored tangent K0, which is reused from earlier
iterations, and treats the contact exactly: with r the residual force, the displacements change by
K0^-1 r + Z dlambda, Z = K0^-1 B, and lambda >= 0 solves the complementarity problem of the weighted
gaps after this change. Residual and gaps always belong to the nonlinear body, so an old factor
costs iterations but no accuracy; it is replaced when the residual falls too slowly. Where that
fails, as when a facet snaps through and the tangent is indefinite on the way, a blend of the
consistent and a positive definite tangent is used (`_globalized`), without acceleration until the
residual falls again.

Under force control the obstacle travels by dd in an iteration. The contact stiffness C in K0, of
facets that fold and spread, resists motion against the obstacle: its force is C (v - dd e), e being
the motion of the obstacle, so that K0^-1 C e dd is added to the displacements. Without it the slope
of the force was twice the true one, and each iteration halved the error.

With friction, the loads are those of pressures and of tractions in both directions along the
obstacle, and the contact obeys Coulomb's law for the slip since the last equilibrium (backward
Euler). That the tractions of a facet change with its shape is left out of the tangent, not of the
residual.

The flow of one load step:

    find                      starts from the guess of the load path, with the last factor
      _search                 up to ITERATIONS times:
        _evaluate             residual force and weighted gaps of the iterate, and its error; done?
        _renew                a new factor, where the error falls too slowly or facets have folded
        _step                 the next iterate: linearized body, exact contact, acceleration
      _globalized             only where that fails, up to DESCENT times:
        _evaluate, _step      the same, without acceleration and with the step cut to TRUST
        _blend                a factor in each iteration, of a blend of the two tangents
        _search               the end, from an iterate that is near, with definite tangents
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np
from scipy import sparse

from fefinger.fem.contact.deformed_gap import ContactSurface, DeformedGap
from fefinger.fem.hyperelastic.continuum import Continuum
from fefinger.fem.hyperelastic.iterate import (
    Anderson,
    Iterate,
    not_converged,
    relative_error,
    stagnant,
)
from fefinger.fem.hyperelastic.linearized import FactoredTangent, LinearizedContact
from fefinger.fem.hyperelastic.state import State, Target
from fefinger.fem.linalg.multifrontal_indefinite import ApproximateFactor
from fefinger.fem.linalg.system import System, approximate_factor
from fefinger.support.arrays import Array
from fefinger.support.checks import PRESS_LESS, ConvergenceError, InputError
from fefinger.support.tolerances import EQUILIBRIUM


# The iteration with a reused factor (`_search`): when it renews, and when it gives up. Tuned on
# presses of the finger; they change the number of iterations and factors, not the equilibrium.
ITERATIONS = 120
PATIENCE = 25  # iterations of one step before its factor is renewed
STALLED = 5  # iterations without a smaller error before it is renewed sooner
STUCK = 2 * PATIENCE  # iterations without a smaller error before the step is given up
FEW = 3  # iterations of a step with a good factor
SEARCH = 8  # factors of one step under depth control; beyond, blended tangents cost less
SOON = 3  # iterations with a factor before the fold stiffness may renew it
RETREATS = 8  # halvings of an iteration that inverted a cell

# The contact in a factor. STIFF is the change of the fold stiffness that a factor tolerates, in
# shear modulus / facet size: a larger one saves factors (flat-press, standard: 9 with 2, 6 with 5),
# but with 5 an incompressible cube that is squeezed to half converged beside its closed form.
STIFF = 3.0
NEAR = 0.1  # gap over depth below which a vertex takes part in the complementarity problem
SUPPORTS = 4.0, 32.0, 256.0  # stiffness under the contact, in shear modulus / size of the patch

# The iteration with blended tangents (`_globalized`): the shares of the blend, its steps, and when
# it ends. Tuned on bodies that buckle; only steps on which `_search` fails need it.
DESCENT = 100  # iterations
STRIDE = 4.0  # factor between successive shares
LEAST = 1 / 256  # smallest share
TRUST = 0.1  # largest nodal displacement in an iteration, over the size of a facet
CALM = 4  # successive decreases of the error before acceleration is tried
SURE = 1e-3  # error below which acceleration is tried


class Exhausted(ConvergenceError):
    """Limit of factorizations reached; subdividing the step would need even more of them."""


class Equilibrium:
    """Equilibrium solver of one body and one contact for many load steps.

    The last factor of the tangent is reused from step to step. `system` is the body at rest with
    its held facets. `iterations`, `factors` and `descents` (steps that needed blended tangents)
    count the work; `allowed` bounds `factors`. `tolerance` is the relative residual to reach;
    `frictional` says whether the targets have friction.
    """

    def __init__(
        self,
        body: Continuum,
        contact: ContactSurface,
        system: System,
        tolerance: float = EQUILIBRIUM,
        *,
        frictional: bool = False,
    ) -> None:
        self.body, self.contact, self.system = body, contact, system
        self.tolerance, self.frictional = tolerance, frictional
        self.load = 0.0  # of the equilibria so far the largest, which scales the residual
        self.iterations, self.factors, self.descents = 0, 0, 0
        self.allowed = np.inf
        self._excess, self._support = 0, 0
        # A tangent has as many negative eigenvalues as pressures where the body is stable.
        self._pressures = int((system.free >= body.space.n_displacements).sum())
        at_rest, none = np.zeros(body.space.n_unknowns), np.zeros(len(contact))
        loads = self._loads(contact.at(State(at_rest, none, 0.0)))
        self._factored = FactoredTangent(
            system.approximate_factor, system.free, loads, 1.0, none, none
        )

    def find(self, start: State, target: Target) -> State:
        """Solve for the equilibrium of one load step, starting from the state `start`.

        Raises ConvergenceError if it is not reached; the step was too large for the body or the
        contact; Exhausted if it takes more factors than are allowed.
        """
        start = replace(start, shift=target.shift)
        if not target.by_force:
            start = replace(start, depth=target.value)
        try:
            return self._search(start, target)
        except ConvergenceError:
            state = self._globalized(start, target)
        self.descents += 1
        return state

    def _search(self, start: State, target: Target, *, consistent: bool = True) -> State:
        """Iterate with Anderson acceleration; with consistent or positive definite tangents."""
        state, sound = start, start
        memory = 12  # iterates of the Anderson acceleration
        mixing, retreats, error, renewed = Anderson(memory), 0, np.inf, -SOON
        best, best_at, stuck = np.inf, 0, STUCK if consistent else PATIENCE
        most = self.factors + (ITERATIONS if target.by_force else SEARCH)
        renewal = 30  # sum over steps of (iterations beyond FEW)² that justifies a new factor
        for count in range(ITERATIONS):
            iterate = self._evaluate(state, target)
            if iterate is None:
                retreats += 1
                if retreats > RETREATS or sound is start:
                    break
                state = replace(state, values=(state.values + sound.values) / 2)
                mixing = Anderson(memory)
                continue
            sound, error = state, iterate.error
            if error <= self.tolerance:
                self._excess += max(0, count - max(renewed, 0) - FEW) ** 2
                return state
            if error < best:
                best, best_at = error, count
            elif count - best_at > stuck or self.factors > most:
                break
            # One iteration brings the contact of the new step; a tangent before it ages sooner.
            worn = (count == 1 and self._excess > renewal) or count % PATIENCE == PATIENCE - 1
            stalled = count - max(best_at, renewed) >= STALLED
            fold = iterate.gap.fold_stiffness
            folds = count - renewed >= SOON and self._folds_too_stiff(fold, target)
            if worn or stalled or folds:
                self._renew(iterate, target, consistent=consistent)
                mixing, renewed = Anderson(memory), count
            state = self._step(iterate, target, mixing)
        raise not_converged(self.tolerance, error, count + 1)

    def _globalized(self, start: State, target: Target) -> State:
        """Iterate with blends of the consistent and a positive definite tangent.

        The positive definite tangent reduces the potential from any start, but slowly where the
        body buckles; the consistent one converges fast near the solution and diverges far from
        it. The share of the first shrinks as far as the contact support keeps the blend stable.
        The end is accelerated.
        """
        state, sound, plain, share = start, start, Anderson(1), 1.0
        errors, calm, sure = [np.inf], 0, SURE
        hold = 2  # iterations with one share of the definite tangent
        surer = 0.1  # factor by which the error must fall before acceleration is tried again
        for _ in range(DESCENT):
            iterate = self._evaluate(state, target)
            if iterate is None:
                if state is sound:
                    break
                state, calm, share = sound.toward(state, 0.5), 0, 1.0
                continue
            calm = calm + 1 if iterate.error < errors[-1] else 0
            sound = state
            errors.append(iterate.error)
            if iterate.error <= self.tolerance:
                return state
            if stagnant(errors, STUCK):
                break
            if calm >= CALM and iterate.error < sure:
                with suppress(ConvergenceError):
                    return self._search(state, target, consistent=False)
                sure = surer * iterate.error
            share = self._blend(iterate, target, share)
            state = self._trusted(state, self._step(iterate, target, plain))
            if not target.by_force and (len(errors) - 1) % hold == 0:
                share = max(share / STRIDE, LEAST)
        raise not_converged(self.tolerance, errors[-1], len(errors) - 1)

    def _trusted(self, state: State, far: State) -> State:
        """Shorten an iteration from `state` to `far` to the largest trusted displacement."""
        n = self.body.space.n_displacements
        moved = (far.values - state.values)[:n].reshape(-1, 3)
        most = float(np.linalg.norm(moved, axis=1).max(initial=0.0))
        trusted = TRUST * float(self.contact.sizes.mean())
        return far if most <= trusted else state.toward(far, trusted / most)

    def _evaluate(self, state: State, target: Target) -> Iterate | None:
        """Evaluate residual and gaps; None if a cell is inverted or the forces diverge."""
        self.iterations += 1
        inner, least = self.body.residual(state.values, target.history)
        most = 1e30  # nodal force in mN of a diverged iteration, whatever the tissue
        if least <= 0 or not np.abs(inner).max() < most:  # "not <" also catches nan
            return None
        gap, slip = self.contact.at(state), state.traction
        loads = self._loads(gap)
        if target.friction is not None:
            slip = self.contact.slip(gap, state, target.friction.before)
        bearing = self.contact.projected
        if self.frictional:
            bearing = np.append(bearing, self.contact.bearing(gap.tangential))
        iterate = Iterate(state, inner, gap, loads, slip, bearing)
        load = max(self.load, float(np.linalg.norm(gap.loads @ state.pressure)))
        error = relative_error(self.body, self.contact, self.system.free, iterate, target, load)
        if error <= self.tolerance:
            self.load = load
        return replace(iterate, error=error)

    def _loads(self, gap: DeformedGap) -> sparse.csc_matrix:
        """Return the loads of unit pressures and, with friction, of unit tractions."""
        if not self.frictional:
            return gap.loads
        return sparse.hstack([gap.loads, gap.tangential], format="csc")

    def _folds_too_stiff(self, fold_stiffness: Array, target: Target) -> bool:
        """Whether the fold stiffness has changed too much for the present factor.

        The iteration would oscillate: it converges for changes that are small beside K0.
        """
        gain = target.history.gain
        skin = gain * self.body.scale / np.sqrt(self.contact.projected)
        factored = self._factored.fold_stiffness * gain / self._factored.gain
        change = np.abs(fold_stiffness - factored)
        return bool((change > np.maximum(STIFF * skin, factored / 2)).any())

    def _renew(self, iterate: Iterate, target: Target, *, consistent: bool = True) -> None:
        """Factor the tangent of the iterate, with an elastic support where it is in contact.

        Without the obstacle, a body under pressure may be close to buckling. Under depth control
        the consistent tangent is therefore factored with an added stiffness against the motion
        that the contact prevents anyway: the least of SUPPORTS with which it is stable. `_step`
        subtracts the force of this support again. Unless `consistent`, the positive definite
        tangent is factored instead, which needs no support.

        Raises ConvergenceError if it is singular.
        """
        body, gain = self.body, target.history.gain
        pressed = iterate.state.pressure > 0
        contact, support = iterate.gap.stiffness(), 0.0
        if consistent:
            contact += iterate.gap.spreading_stiffness()
        matrix = body.tangent(iterate.state.values, target.history, consistent=consistent) + contact
        if not consistent or target.by_force:
            renewed = self._factor_approximately(matrix)
        else:
            under = iterate.gap.support(pressed)
            unit = gain * body.scale / float(np.sqrt(self.contact.projected.sum()))
            while True:
                support = SUPPORTS[self._support] * unit
                renewed = self._factor_approximately(matrix + support * under)
                if renewed.negative <= self._pressures or self._support == len(SUPPORTS) - 1:
                    break
                self._support += 1
        supports = np.where(pressed, support, 0.0)
        self._factored = self._contacting(renewed, iterate.gap, target, supports, contact)
        self._excess = 0

    def _contacting(
        self,
        renewed: ApproximateFactor,
        gap: DeformedGap,
        target: Target,
        support: Array,
        stiffness: sparse.csr_matrix,
    ) -> FactoredTangent:
        """Return the factor of a tangent with the contact of the gaps.

        support (n,) kPa/mm: what was added to the tangent under the candidates; stiffness
        (n_unknowns, n_unknowns): the part of the tangent that the contact has.
        """
        gain, free = target.history.gain, self.system.free
        loads = self._loads(gap)
        factored = FactoredTangent(renewed, free, loads, gain, support, gap.fold_stiffness)
        if target.by_force:  # else the obstacle stays where it is
            rigid = self.contact.translation(self.contact.obstacle.axis)
            factored.set_travel_load(stiffness @ rigid)
        return factored

    def _blend(self, iterate: Iterate, target: Target, share: float) -> float:
        """Factor a blend of the tangents; return the share of the positive definite one.

        That is `share` or, where the blend is unstable with a support under the closed gaps, the
        least of its multiples by powers of STRIDE with which it is stable. Under force control
        there is no support, and the share is 1.

        Raises ConvergenceError if it is singular.
        """
        body, projected = self.body, self.contact.projected
        values = iterate.state.values
        definite = body.tangent(values, target.history, consistent=False)
        difference = body.tangent(values, target.history) - definite
        bends, spreads = iterate.gap.stiffness(), iterate.gap.spreading_stiffness()
        difference += spreads
        fixed = definite + bends
        unit = target.history.gain * body.scale / float(np.sqrt(projected.sum()))
        leans = (iterate.state.pressure > 0) & (not target.by_force)
        support = np.where(leans, SUPPORTS[-1] * unit, 0.0)
        while True:
            renewed = self._factor_approximately(fixed + (1 - share) * difference)
            contact = bends + (1 - share) * spreads
            factored = self._contacting(
                renewed, iterate.gap, target, np.zeros(len(projected)), contact
            )
            negative = renewed.negative - factored.add_support(support, projected)
            self._factored = factored
            if share >= 1 or negative <= self._pressures:
                return share
            share = min(STRIDE * share, 1.0)

    def _factor_approximately(self, matrix: sparse.csr_matrix) -> ApproximateFactor:
        if self.factors >= self.allowed:
            message = (
                f"equilibrium: not reached within the limit of {self.factors} factorizations; "
                f"{PRESS_LESS}"
            )
            raise Exhausted(message)
        self.factors += 1
        try:
            return approximate_factor(matrix, self.system)
        except InputError as error:
            # The tangent at rest was factored, so the cause is this iterate, not the model.
            message = f"equilibrium: the tangent of an iterate is singular; {PRESS_LESS}"
            raise ConvergenceError(message) from error

    def _step(self, iterate: Iterate, target: Target, mixing: "Anderson") -> State:
        """Make one iteration: linearized body, exact law of the contact."""
        state, factored, surface = iterate.state, self._factored, self.contact.surface
        gaps, loads, projected = iterate.gap.gaps, iterate.gap.loads, self.contact.projected
        mean_gap = gaps / projected  # mm; `gaps` are mm³
        near = (state.pressure > 0) | (mean_gap <= mean_gap.min() + NEAR * abs(state.depth))
        # K0 was made with another relaxation factor: K = K0 / gain_ratio.
        gain_ratio = factored.gain / target.history.gain
        support = factored.support * (state.pressure > 0) / gain_ratio  # kPa/mm
        force = iterate.loads @ state.contact - loads @ (support * mean_gap) - iterate.inner  # mN
        at_same_contact = gain_ratio * factored.solve(force)  # mm, with contact and depth kept
        following, closing = factored.travel(loads, projected)  # mm and mm² per mm of travel
        if self.frictional:
            slipping = iterate.bearing[len(projected) :] - iterate.gap.tangential.T @ following
            closing = np.concatenate([closing, slipping])
        apart = np.concatenate([gaps, iterate.slip.ravel()])
        free = apart + state.depth * closing + iterate.loads.T @ at_same_contact  # mm³
        linearized = LinearizedContact(
            factored, surface, gain_ratio, state, free, closing, iterate.bearing
        )
        while True:
            depth, contact = linearized.solve(near, target)
            change = at_same_contact + factored.moved(gain_ratio * (contact - state.contact))
            change += (depth - state.depth) * following
            predicted_gaps = gaps + (state.depth - depth) * projected + loads.T @ change
            pressure, traction = np.split(contact, [len(projected)])
            predicted_gaps += surface.opened(pressure - state.pressure)
            penetrating = ~near & (predicted_gaps < 0)
            if not penetrating.any():
                break
            near = near | penetrating
        # With the depth, of which `change` is a function under force control.
        point, moved = np.append(state.values, state.depth), np.append(change, depth - state.depth)
        mixed = mixing.next(point, moved)
        return State(mixed[:-1], pressure, float(mixed[-1]), target.shift, traction.reshape(2, -1))
