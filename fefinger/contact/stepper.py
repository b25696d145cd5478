"""A contact through time: what its kinds share.

    stepper.advance(dt, Target(depth))             # or Target(force, by_force=True), in mN
    stepper.depth, stepper.pressure, stepper.elastic

`march.march` takes one through a whole motion; a loop in real time calls `advance` itself. A step
that is refused leaves the contact as it was.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from fefinger.contact import complementarity
from fefinger.contact.active_set import DONE, ENDLESS, MISSED, SINGULAR
from fefinger.contact.force_control import CORRECTIONS, DEPTH, PEAK, depth_search
from fefinger.contact.prony_history import PronyHistory
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError


class Target(NamedTuple):
    """Where a step ends.

    value: depth in mm or, `by_force`, force in mN; shift mm: place of the object across its axis;
    turn: how the object is turned, as the kind of contact reads it (slopes of a plate that rocks,
    normal of a plate that rolls).
    """

    value: float
    by_force: bool = False
    shift: tuple[float, float] = (0.0, 0.0)
    turn: tuple[float, float] = (0.0, 0.0)


class Gaps(Protocol):
    """Gaps between a body and an object that moves across its axis."""

    def gap(self, shift: Array, incline: Array | None) -> tuple[Array, Flags]:
        """Return the weighted gaps (n,) mm³ at a place (2,) mm, and the rim (n,) of the object."""

    def push(self, shift: Array, pressure: Array, incline: Array | None) -> Array:
        """Return the force (2,) mN of pressures (n,) kPa on inclined heights, across the axis."""


OTHER_STATE = (
    "state: expected one of the same finger, object and candidates, received arrays of other "
    "shapes; restore it where it was made"
)

State = tuple[NDArray[Any], ...]
"""Copies of all arrays that a later step depends on."""


Record = dict[str, float | NDArray[np.generic]]
"""Present values of a contact by their names, as a history holds them."""


class StepSolver(Protocol):
    """Solver of a step: its solution, and the arrays that a failure leaves changed.

    x (k,): begins with the pressures; place: which are in contact, else -1; counts: the second one
    is the number of solutions.
    """

    @property
    def x(self) -> Array:
        """The solution."""

    @property
    def place(self) -> Integers:
        """Which vertices are in contact."""

    @property
    def counts(self) -> Integers:
        """Counts of work."""

    @property
    def volatile(self) -> State:
        """The arrays that a failure leaves changed."""


class Stepper(ABC):
    """A contact through time, at rest at first.

    solver: state of the contact solver, whose `x` begins with the pressures; history: of its
    stresses; limits (n,): outcome of contact at a vertex, DONE where there may be contact. `kept`:
    further arrays that belong to the state; moves: whether the object is moved or turned.
    """

    failures: Mapping[int, str] = {
        ENDLESS: complementarity.ENDLESS,
        SINGULAR: complementarity.INDEFINITE,
        MISSED: f"force control: expected to reach the force within {CORRECTIONS} corrections, "
        "did not",
    }
    """Sentences on failed steps."""

    def __init__(
        self,
        solver: StepSolver,
        history: PronyHistory,
        limits: Integers,
        kept: State = (),
        *,
        moves: bool = False,
    ) -> None:
        self.history, self.limits, self.moves = history, limits, moves
        self.search, self.pose = depth_search(), np.zeros(4)
        self.pressure: Array = solver.x[: len(limits)]
        self.solved: Integers = solver.counts[1:2]
        self._place = solver.place
        volatile: State = (self.search, *solver.volatile)
        self._state: State = (*volatile, self.pose, *history.state, *kept)
        self._volatile = [(each, np.empty_like(each)) for each in volatile]

    @property
    def depth(self) -> float:
        """Present depth in mm."""
        return float(self.search[DEPTH])

    @property
    def elastic(self) -> Array:
        """Elastic stress (k,) kPa, by which displacements and strains follow."""
        return self.history.elastic

    def begin(self, target: Target, largest: float) -> None:
        """Put the object of a contact at rest where a motion begins, without friction on the way.

        largest: force in mN of the motion, which scales the tolerance of small ones.
        """
        self.pose[:2], self.search[PEAK] = target.shift, largest

    def advance(self, dt: float, target: Target) -> int:
        """Advance by `dt` s to a target; return DONE or a failure, which changes nothing."""
        for now, before in self._volatile:
            before[:] = now
        outcome = self._advance(dt, target)
        if outcome != DONE:
            for now, before in self._volatile:
                now[:] = before
            self._rebuild()
        elif self.moves:
            self.pose[:2], self.pose[2:] = target.shift, target.turn
        return outcome

    def reset(self) -> None:
        """Return to rest: no contact and no history."""
        for each in self._state:
            each[:] = 0
        self._place[:] = -1
        self._rebuild()

    def state(self) -> State:
        """Return a copy of the state, some kilobytes."""
        return tuple(each.copy() for each in self._state)

    def restore(self, state: State) -> None:
        """Return to a state of this contact, or of one that was made in the same way.

        Raises
        ------
        InputError
            For the state of another contact.
        """
        if [each.shape for each in state] != [each.shape for each in self._state]:
            raise InputError(OTHER_STATE)
        for now, then in zip(self._state, state, strict=True):
            now[:] = then
        self._rebuild()

    def record(self) -> Record:
        """Return the present values that a history holds, by their names."""
        return {"depth": self.depth, "pressure": self.pressure, "elastic_pressure": self.elastic}

    @abstractmethod
    def _advance(self, dt: float, target: Target) -> int:
        """Make a step; a failure may leave the volatile arrays changed."""

    @abstractmethod
    def _rebuild(self) -> None:
        """Make anew what follows from the arrays of the state."""
