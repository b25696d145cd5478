"""Coulomb friction through the load steps of a press: coefficients, slip so far, lost work.

As `contact.frictional` at small strain: where the kinetic coefficient is less than the static one,
a vertex has the kinetic one from the step after its first slip to the step in which it sticks
again, or leaves contact.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from fefinger.contact.frictional import STUCK
from fefinger.fem.contact.deformed_gap import ContactSurface
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.state import Friction, State
from fefinger.geometry.profiles import frame
from fefinger.support.arrays import Array, Flags


class FrictionHistory:
    """Friction of a contact through time, with the static and the kinetic coefficient `mu`.

    Attributes
    ----------
    coefficient
        (n,): of each candidate in the next step.
    slip
        (2, n) mm of the skin over the obstacle since first contact.
    sticking
        (n,): which candidates under pressure did not slip in the last step.
    lost
        µJ: the work of friction so far.
    """

    def __init__(self, contact: ContactSurface, mu: tuple[float, float]) -> None:
        self.contact, self.mu = contact, mu
        count = len(contact)
        self.coefficient: Array = np.full(count, mu[0])
        self.slip: Array = np.zeros((2, count))
        self.sticking: Flags = np.zeros(count, dtype=np.bool_)
        self.lost = 0.0

    def after(self, before: State) -> Friction:
        """Return the friction of a step that starts from an equilibrium."""
        return Friction(self.coefficient, before)

    def advance(self, before: State, state: State) -> None:
        """Update slip, work and coefficients with the equilibrium at the end of a step."""
        slid = self.contact.slip(self.contact.at(state), state, before)
        pressed = state.pressure > 0
        full = self.coefficient * state.pressure * (1 - STUCK)
        self.sticking = pressed & (np.hypot(*state.traction) < full)
        self.coefficient = np.where(pressed & ~self.sticking, self.mu[1], self.mu[0])
        self.slip = np.where(pressed, self.slip + slid / self.contact.projected, 0.0)
        self.lost -= float((state.traction * slid)[:, pressed].sum())


@dataclass(frozen=True)
class SideLoad:
    """What an object pulls along the plane across its axis, at n_t equilibria.

    force (n_t, 2) mN of pressure and friction on the meshed part; axial (n_t,) mN of friction along
    the axis; torque (n_t,) mN mm of friction about the axis through the center of pressure; with
    friction traction (n_t, 2, n) kPa, slip (n_t, 2, n) mm since first contact, sticking (n_t, n)
    and the work (n_t,) in µJ so far. The first axis is left out of a single one.
    """

    force: Array
    axial: Array
    torque: Array
    traction: Array
    slip: Array
    sticking: Flags
    work: Array

    @classmethod
    def of(
        cls, contact: ContactSurface, space: Space, state: State, friction: FrictionHistory | None
    ) -> Self:
        """Collect the loads of an equilibrium."""
        across, count, none = frame(contact.obstacle.axis)[:2], space.n_displacements, np.zeros(())
        gap = contact.at(state)
        pressed = (gap.loads @ state.pressure)[:count].reshape(-1, 3)
        if friction is None:
            empty = np.empty((2, 0))
            return cls(pressed.sum(axis=0) @ across.T, none, none, empty, empty, empty > 0, none)
        pulled = (gap.tangential @ state.traction.ravel())[:count].reshape(-1, 3)
        places = (space.node_points + state.values[:count].reshape(-1, 3)) @ across.T
        along = pressed @ contact.obstacle.axis
        center = along @ places / along.sum() if along.any() else np.zeros(2)
        x, y = (places - center).T
        sideways = pulled @ across.T
        return cls(
            force=(pressed + pulled).sum(axis=0) @ across.T,
            axial=pulled.sum(axis=0) @ contact.obstacle.axis,
            torque=x @ sideways[:, 1] - y @ sideways[:, 0],
            traction=state.traction,
            slip=friction.slip,
            sticking=friction.sticking,
            work=np.array(friction.lost),
        )

    @classmethod
    def stacked(cls, every: Sequence[Self]) -> Self:
        """Join the loads of single equilibria."""
        names = [each.name for each in fields(cls)]
        return cls(*(np.array([getattr(each, name) for each in every]) for name in names))
