"""What the skin is pressed by: a rigid object, or a soft one with a flexibility C of its own.

A soft object gives way by C q, q its elastic pressure: gap - depth m + F y + C q >= 0. With p =
g y + h as in `frictionless` and p = k q + l alike, by the relaxation of the object (k = 1 and l = 0
of an elastic one), the matrix of a step is F + g C / k and its offset g (gap - depth m) - F h -
g C l / k. Each body has a history of its own, which needs F p and C p.

`ElasticSurface` is that of skin at finite strain: small strain of its own, under pressures on
undeformed areas of the skin.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol, Unpack

import numpy as np

from fefinger.contact import active_set
from fefinger.contact.active_set import DONE, LcpState
from fefinger.contact.complementarity import Complementarity
from fefinger.contact.frictionless import (
    FrictionlessContact,
    FrictionlessOptions,
    FrictionlessParts,
    energy,
    gaps_at,
    press,
)
from fefinger.contact.inertial import InertialContact, InertialParts, StepFactors
from fefinger.contact.prony_history import (
    PronyHistory,
    Relaxation,
    increments,
    load_history,
    prony_history,
    store_history,
)
from fefinger.contact.stepper import Target
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.compiled import njit


class PressingObject(Protocol):
    """What a contact asks of an object: its kind of contact, and how far its surface gives way."""

    def frictionless(
        self, *parts: *FrictionlessParts, **options: Unpack[FrictionlessOptions]
    ) -> FrictionlessContact:
        """Return a frictionless contact with it; arguments as of `FrictionlessContact`."""

    def inertial(self, *parts: *InertialParts) -> InertialContact:
        """Return a contact of modes with it; arguments as of `InertialContact`."""

    def recession(self, time: Array, pressure: Array) -> Array:
        """Return the displacement (n_t, n_near) mm of its surface away from the skin.

        Or what is broadcast to that. time (n_t,) s, pressure (n_t, n) kPa on the candidates;
        n_near: vertices around them.
        """


class RigidObject:
    """An object that does not give way."""

    def frictionless(
        self, *parts: *FrictionlessParts, **options: Unpack[FrictionlessOptions]
    ) -> FrictionlessContact:
        """Return a frictionless contact with it."""
        return FrictionlessContact(*parts, **options)

    def inertial(self, *parts: *InertialParts) -> InertialContact:
        """Return a contact of modes with it."""
        return InertialContact(*parts)

    def recession(self, time: Array, pressure: Array) -> Array:
        """Return 0 (1, 1)."""
        return np.zeros((1, 1))


RIGID = RigidObject()


NONE: tuple[Array, Array] = np.zeros(0), np.zeros(0)
"""Weights and rates of no Prony terms."""


@dataclass(frozen=True)
class SoftObject:
    """A soft object: C (n, n) mm³/kPa on the candidates, and (n_near, n) mm/kPa around them.

    branches: weights and rates (m,) of its own Prony terms, over its long-time modulus.
    """

    flexibility: Array
    around: Array
    branches: tuple[Array, Array] = NONE

    def frictionless(
        self, *parts: *FrictionlessParts, **options: Unpack[FrictionlessOptions]
    ) -> FrictionlessContact:
        """Return a frictionless contact with it."""
        return SoftContact((self.flexibility, self.branches), *parts, **options)

    def inertial(self, *parts: *InertialParts) -> InertialContact:
        """Return a contact of modes with it, elastic."""
        return SoftInertialContact(self.flexibility, *parts)

    def recession(self, time: Array, pressure: Array) -> Array:
        """Return the displacement (n_t, n_near) mm of its surface away from the skin."""
        return np.asarray(self._elastic(time, pressure) @ self.around.T)

    def _elastic(self, time: Array, pressure: Array) -> Array:
        """Return its elastic pressures (n_t, n) kPa, linear over the steps."""
        weights, rates = self.branches
        if not len(rates):
            return pressure
        history = Relaxation(np.array([1.0, *weights]), rates, pressure.shape[1])
        elastic = np.empty_like(pressure)
        for k, (before, now) in enumerate(pairwise([float(time[0]), *time.tolist()])):
            g, past = history.history(now - before)
            elastic[k] = (pressure[k] - past) / g
            history.advance(now - before, elastic[k])
        return elastic


@njit(cache=True)
def _step(
    s: LcpState,
    m: PronyHistory,
    body: PronyHistory,
    flexibility: Array,
    own: Array,
    work: Array,
    chosen: Integers,
    search: Array,
    gap: Array,
    projected: Array,
    limits: Integers,
    offset: Array,
    dt: float,
    value: float,
    by_force: bool,
    stiffness: float,
    tolerance: float,
) -> int:
    g, k = load_history(m, dt), load_history(body, dt)
    past, moved, factor = work[0], work[1], work[2]
    for j in range(len(past)):
        past[j] = m.moved_past[j] + stiffness / k * body.moved_past[j]
    failed = press(
        s, search, gap, past, stiffness, projected, limits, offset, value, by_force, tolerance
    )
    if failed == DONE:
        active_set.combine(moved, flexibility, s.x, chosen, factor)
        store_history(m, s.x, moved, dt, g)
        active_set.combine(moved, own, s.x, chosen, factor)
        store_history(body, s.x, moved, dt, k)
    return failed


class SoftContact(FrictionlessContact):
    """Frictionless contact with a soft object.

    soft: its C (n, n), and its Prony terms as of `SoftObject`; the rest as of
    `FrictionlessContact`.

    Attributes
    ----------
    body
        The history of the object.
    """

    def __init__(
        self,
        soft: tuple[Array, tuple[Array, Array]],
        *parts: *FrictionlessParts,
        **options: Unpack[FrictionlessOptions],
    ) -> None:
        super().__init__(*parts, **options)
        (own, branches), flexibility = soft, parts[0]
        count = len(flexibility)
        self.own, self.flexibility = np.array(own), np.array(flexibility)
        self.body = prony_history(branches, count)
        self._state += self.body.state
        self._work, self._chosen = np.zeros((3, count)), np.zeros(count, dtype=np.int64)
        self._scaled, self._part = np.empty_like(self.own), 0.0

    def _advance(self, dt: float, target: Target) -> int:
        gap, limits = gaps_at(self.gap, target, self.limits, turns=self.turns)
        gains, yields = (
            1.0 + float(increments(each.weights, each.rates, dt).sum())
            for each in (self.history, self.body)
        )
        stiffness = gains * self.stiffening
        if (part := stiffness / yields) != self._part:  # exact: steps of a length give a number
            np.multiply(self.own, part, out=self._scaled)
            np.add(self.flexibility, self._scaled, out=self.lcp.flexibility)
            self._part = part
        return int(
            _step(
                self.lcp,
                self.history,
                self.body,
                self.flexibility,
                self.own,
                self._work,
                self._chosen,
                self.search,
                gap,
                self.projected,
                limits,
                self._offset,
                dt,
                target.value,
                target.by_force,
                stiffness,
                self.tolerance,
            )
        )

    def energy(self) -> tuple[float, float]:
        """Return the stored energy of both bodies in µJ and the dissipated power in µW."""
        (stored, lost), (own, own_lost) = super().energy(), energy(self.body, self.own)
        return stored + own, lost + own_lost


class SoftInertialContact(InertialContact):
    """Contact of a body of modes with an elastic object, which has no mass of its own.

    own: C (n, n); the rest as of `InertialContact`.
    """

    def __init__(self, own: Array, *parts: *InertialParts) -> None:
        super().__init__(*parts)
        self.own = np.array(own)

    def make_factors(self, dt: float) -> StepFactors:
        """Compute the factors of a step of `dt` s."""
        made = super().make_factors(dt)
        return made._replace(flexibility=made.flexibility + self.own)


class ObjectSurface(Protocol):
    """What contact at finite strain asks of an object's surface."""

    def at_places(self, pressure: Array) -> Array:
        """Return its displacement (n_tri, n_q) mm away from the skin, at the quadrature points.

        pressure (n,) kPa on the candidates; or what is broadcast to that, as below.
        """

    def around(self, pressure: Array) -> Array:
        """Return its displacement (n_near,) mm at the candidates and around them."""

    def softened(self, solver: Complementarity, near: Flags, gain: float) -> Complementarity:
        """Return a solver with the flexibilities of object and body, at `near` candidates (n,).

        gain: factor on pressures in the solver.
        """

    def opened(self, pressure: Array) -> Array:
        """Return the weighted gaps (n,) mm³ that pressures (n,) kPa open by its flexibility."""


class RigidSurface:
    """A surface that does not give way."""

    def at_places(self, pressure: Array) -> Array:
        """Return 0 (1, 1)."""
        return np.zeros((1, 1))

    def around(self, pressure: Array) -> Array:
        """Return 0 (1,)."""
        return np.zeros(1)

    def softened(self, solver: Complementarity, near: Flags, gain: float) -> Complementarity:
        """Return the solver as it is."""
        return solver

    def opened(self, pressure: Array) -> Array:
        """Return 0 (1,)."""
        return np.zeros(1)


RIGID_SURFACE = RigidSurface()


@dataclass(frozen=True)
class ElasticSurface:
    """An elastic surface: C (n, n) mm³/kPa, and displacements per pressure in mm/kPa.

    places (n_tri, n_q, n), where the skin is integrated; vertices (n_near, n).
    """

    flexibility: Array
    places: Array
    vertices: Array

    def at_places(self, pressure: Array) -> Array:
        """Return its displacement (n_tri, n_q) mm away from the skin, at the quadrature points."""
        return np.asarray(self.places @ pressure)

    def around(self, pressure: Array) -> Array:
        """Return its displacement (n_near,) mm at the candidates and around them."""
        return np.asarray(self.vertices @ pressure)

    def softened(self, solver: Complementarity, near: Flags, gain: float) -> Complementarity:
        """Return a solver with its flexibility beside the body's."""
        own = self.flexibility[np.ix_(near, near)] / gain
        both = Complementarity(solver.flexibility + own, any_sign=solver.any_sign)
        both.active = solver.active
        return both

    def opened(self, pressure: Array) -> Array:
        """Return the weighted gaps (n,) mm³ that pressures (n,) kPa open by its flexibility."""
        return np.asarray(self.flexibility @ pressure)
