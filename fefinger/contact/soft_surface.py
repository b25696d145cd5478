"""Surface of an object in contact at finite strain: rigid, or elastic with a flexibility C.

An elastic surface gives way by C p at once, at small strain of its own, under pressures p on
undeformed areas of the skin.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fefinger.contact.complementarity import Complementarity
from fefinger.support.arrays import Array, Flags


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
        both = Complementarity(
            solver.flexibility + own, any_sign=solver.any_sign, symmetric=solver.symmetric
        )
        both.active = solver.active
        return both

    def opened(self, pressure: Array) -> Array:
        """Return the weighted gaps (n,) mm³ that pressures (n,) kPa open by its flexibility."""
        return np.asarray(self.flexibility @ pressure)
