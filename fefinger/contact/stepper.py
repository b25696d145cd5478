"""A contact through time: what its kinds share.

    stepper.advance(dt, Target(depth))             # or Target(force, by_force=True), in mN
    stepper.depth, stepper.pressure, stepper.elastic

`march` takes one through a whole motion; a loop in real time calls `advance` itself. A step
that is refused leaves the contact as it was.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from fefinger.contact import complementarity
from fefinger.contact.active_set import DONE, ENDLESS, MISSED, SINGULAR, TURNED
from fefinger.contact.force_control import CORRECTIONS, DEPTH, PEAK, depth_search
from fefinger.contact.prony_history import PronyHistory
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import PRESS_LESS, ConvergenceError, InputError


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


@dataclass(frozen=True)
class Prescribed:
    """Prescribed depth in mm or force in mN (`control`) of the indenter at each time in s.

    shift (n_t, 2) mm of the object across its axis, and turn (n_t, 2) as of `Target`, if any.
    """

    control: str
    time: Array
    value: Array
    shift: Array | None = None
    turn: Array | None = None

    @property
    def by_force(self) -> bool:
        """Whether the force is prescribed, and not the depth."""
        return self.control == "force"

    def targets(self) -> list[Target]:
        """Return the target of every step."""
        still: list[list[float]] = [[0.0, 0.0]] * len(self.time)
        shift, turn = (still if each is None else each.tolist() for each in (self.shift, self.turn))
        return [
            Target(value, self.by_force, (at[0], at[1]), (turned[0], turned[1]))
            for value, at, turned in zip(self.value.tolist(), shift, turn, strict=True)
        ]


@dataclass(frozen=True)
class SlidingHistory:
    """Path, tangential force and slip of a contact over time.

    shift (n_t, 2) mm of the obstacle across its axis; slopes (n_t, 2) mN: the force on the meshed
    part with which pressure on inclined heights pushes along these two directions. With friction:
    traction (n_t, 2, n) kPa on the skin, slip (n_t, 2, n) mm of the skin over the obstacle, summed
    since first contact, sticking (n_t, n), lost (n_t,) µJ: the work of friction so far, and cone:
    the largest distance of a traction from Coulomb's law, over the largest pressure.
    """

    shift: Array
    slopes: Array
    traction: Array | None = None
    slip: Array | None = None
    sticking: Flags | None = None
    lost: Array | None = None
    cone: float = 0.0


@dataclass(frozen=True)
class History:
    """Contact through time.

    depth (n_t,) mm, pressure (n_t, n) kPa the contact pressure p, elastic_pressure (n_t, n) kPa the
    elastic one q, followed by both components of the elastic traction where there is friction
    (n_t, 3n), by the amplitudes of the modes where there is inertia; exchanges counts the contact
    solutions; sliding: where the obstacle moves sideways or has friction.
    """

    depth: Array
    pressure: Array
    elastic_pressure: Array
    exchanges: int
    sliding: SlidingHistory | None = None


def march(
    stepper: Stepper,
    prescribed: Prescribed,
    progress: Callable[[float], None] = lambda fraction: None,
    *,
    stored: Integers | None = None,
) -> History:
    """Take a contact at rest through a motion; the first target is reached by a jump.

    stored (n_out,): numbers of the steps that the history holds, rising; all by default.

    Raises
    ------
    InputError
        If contact reaches the end of the obstacle.
    ConvergenceError
        If the contact or the depth under force control does not converge.
    """
    numbers = np.arange(len(prescribed.time)) if stored is None else stored
    rows = collected(stepper, prescribed, stepper.record, progress, numbers)
    return _history(rows, prescribed, numbers, int(stepper.solved[0]))


def collected(
    stepper: Stepper,
    prescribed: Prescribed,
    record: Callable[[], Record],
    progress: Callable[[float], None] = lambda fraction: None,
    numbers: Integers | None = None,
) -> dict[str, Array]:
    """Take a contact through a motion, as `march`; return what `record` reads, by its names.

    numbers (n_out,): of the steps at which it does, rising; all by default.
    """
    targets = prescribed.targets()
    stepper.begin(targets[0], float(prescribed.value.max(initial=0.0)))
    numbers = np.arange(len(prescribed.time)) if numbers is None else numbers
    steps = np.diff(prescribed.time, prepend=prescribed.time[0]).tolist()
    rows: dict[str, Array] = {}
    row, count = 0, len(numbers)
    for k, (dt, target) in enumerate(zip(steps, targets, strict=True)):
        outcome = stepper.advance(dt, target)
        if outcome != DONE:
            raise failure(stepper, outcome, target, float(prescribed.time[k]))
        if row < count and k == numbers[row]:
            for name, value in record().items():
                if name not in rows:
                    rows[name] = np.empty((count, *np.shape(value)), np.asarray(value).dtype)
                rows[name][row] = value
            row += 1
            progress((k + 1) / len(steps))
    return rows


def failure(
    stepper: Stepper, outcome: int, target: Target, time: float
) -> InputError | ConvergenceError:
    """Return the error of a step that failed at a time in s, with what to do."""
    if outcome == TURNED:
        x, y = target.shift
        return InputError(
            f"motion: expected a path on which the pad stays on the object, but at {time:.4g} s, "
            f"with the object moved by ({x:.3g}, {y:.3g}) mm, contact reaches its end; take a "
            "shorter path or a larger object"
        )
    return ConvergenceError(f"{stepper.failures[outcome]}, at {time:.4g} s; {PRESS_LESS}")


def _history(
    rows: dict[str, Array], prescribed: Prescribed, numbers: Integers, solved: int
) -> History:
    """Collect the stored rows of a motion."""
    basic = rows["depth"], rows["pressure"], rows["elastic_pressure"], solved
    if "slopes" not in rows:
        return History(*basic)
    shift = np.zeros((len(prescribed.time), 2)) if prescribed.shift is None else prescribed.shift
    sliding = SlidingHistory(shift[numbers], rows["slopes"])
    if "traction" in rows:
        sliding = replace(
            sliding,
            traction=rows["traction"],
            slip=rows["slip"],
            sticking=rows["sticking"].astype(bool),
            lost=rows["lost"],
            cone=float(rows["cone"].max()),
        )
    return History(*basic, sliding)
