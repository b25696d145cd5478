"""A whole motion of any kind of contact, step by step."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fefinger.contact.active_set import DONE, TURNED
from fefinger.contact.stepper import Record, Stepper, Target
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import PRESS_LESS, ConvergenceError, InputError


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
