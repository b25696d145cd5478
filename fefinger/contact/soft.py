"""What the skin is pressed by: a rigid object, or an elastic one with a flexibility C of its own.

An elastic object gives way by C p under the contact pressure p, at once: gap - depth m + F y + C p
>= 0. With p = g y + h as in `frictionless` the matrix of a step is F + g C and its offset
g (gap - depth m) - F h; the history is of the skin alone, and needs F p.

`ElasticSurface` is that of skin at finite strain: small strain of its own, under pressures on
undeformed areas of the skin.
"""

from dataclasses import dataclass
from typing import Protocol, Unpack

import numpy as np

from fefinger.contact import active_set
from fefinger.contact.active_set import DONE, LcpState
from fefinger.contact.complementarity import Complementarity
from fefinger.contact.frictionless import (
    FrictionlessContact,
    FrictionlessOptions,
    FrictionlessParts,
    gaps_at,
    press,
)
from fefinger.contact.inertial import InertialContact, InertialParts, StepFactors
from fefinger.contact.prony_history import PronyHistory, increments, load_history, store_history
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

    def recession(self, pressure: Array) -> Array:
        """Return the displacement (n_t, n_near) mm of its surface away from the skin.

        Or what is broadcast to that. pressure (n_t, n) kPa on the candidates; n_near: vertices
        around them.
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

    def recession(self, pressure: Array) -> Array:
        """Return 0 (1, 1)."""
        return np.zeros((1, 1))


RIGID = RigidObject()


@dataclass(frozen=True)
class ElasticObject:
    """An elastic object: C (n, n) mm³/kPa on the candidates, and (n_near, n) mm/kPa around them."""

    flexibility: Array
    around: Array

    def frictionless(
        self, *parts: *FrictionlessParts, **options: Unpack[FrictionlessOptions]
    ) -> FrictionlessContact:
        """Return a frictionless contact with it."""
        return SoftContact(self.flexibility, *parts, **options)

    def inertial(self, *parts: *InertialParts) -> InertialContact:
        """Return a contact of modes with it."""
        return SoftInertialContact(self.flexibility, *parts)

    def recession(self, pressure: Array) -> Array:
        """Return the displacement (n_t, n_near) mm of its surface away from the skin."""
        return np.asarray(pressure @ self.around.T)


@njit(cache=True)
def _step(
    s: LcpState,
    m: PronyHistory,
    flexibility: Array,
    moved: Array,
    chosen: Integers,
    factor: Array,
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
    g = load_history(m, dt)
    past = m.moved_past
    failed = press(
        s, search, gap, past, stiffness, projected, limits, offset, value, by_force, tolerance
    )
    if failed == DONE:
        active_set.combine(moved, flexibility, s.x, chosen, factor)
        store_history(m, s.x, moved, dt, g)
    return failed


class SoftContact(FrictionlessContact):
    """Frictionless contact with an elastic object.

    own: C (n, n); the rest as of `FrictionlessContact`.
    """

    def __init__(
        self, own: Array, *parts: *FrictionlessParts, **options: Unpack[FrictionlessOptions]
    ) -> None:
        super().__init__(*parts, **options)
        flexibility = parts[0]
        count = len(flexibility)
        self.own, self.flexibility = np.array(own), np.array(flexibility)
        self._moved, self._chosen = np.zeros(count), np.zeros(count, dtype=np.int64)
        self._factor, self._scaled, self._stiffness = np.zeros(count), np.empty_like(self.own), 0.0

    def _advance(self, dt: float, target: Target) -> int:
        gap, limits = gaps_at(self.gap, target, self.limits, turns=self.turns)
        gains = increments(self.history.weights, self.history.rates, dt)
        stiffness = (1.0 + float(gains.sum())) * self.stiffening
        if stiffness != self._stiffness:  # exact: the same length of step gives the same number
            np.multiply(self.own, stiffness, out=self._scaled)
            np.add(self.flexibility, self._scaled, out=self.lcp.flexibility)
            self._stiffness = stiffness
        return int(
            _step(
                self.lcp,
                self.history,
                self.flexibility,
                self._moved,
                self._chosen,
                self._factor,
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
        stored, lost = super().energy()
        return stored + float(self.pressure @ self.own @ self.pressure / 2), lost


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
        """Return a solver with its flexibility besides that of the body, at `near` candidates (n,).

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
