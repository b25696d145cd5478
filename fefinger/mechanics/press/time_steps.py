"""Time steps that follow the motion: fine while it moves, growing while it rests."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fefinger.scene.motion import Motion
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.units import SLOW


MOVING_STEP = 1e-3  # s: filters up to FAI (10 Hz) and the 4 ms relaxation are resolved
FAST_STEP = 2e-4  # s: FAII takes a second derivative of up to 1 kHz
LONG = 5.0  # s: ramps and cycles that are longer take steps longer by as much, after their start
GROWTH = 1.25  # of successive steps while at rest, and at the start of a long ramp
RESTING_STEP = 0.05  # s, the longest, up to a rest of RESTING_STEPS of them
RESTING_STEPS = 200  # longer rests take longer steps

MODAL_STEP = 1e-4
"""Longest step in s with inertia while the indenter moves: RESOLVED over it, or 3 kHz, bounds the
modes that swing."""

RESOLVED = 0.3
"""Cycles per step of the fastest mode that has inertia: of an oscillation with twice its frequency
no step would see the direction. Modes beyond deform as in statics."""

MOST = 250_000
"""Steps of which the history of a contact still fits into memory."""

MOST_OF_FORCE = 5_000_000
"""Steps of which the force alone still fits into memory."""


@dataclass(frozen=True)
class _Piece:
    """A part of the motion without corners, from `start` to `stop` s.

    Its steps grow from `first` s, however long it is: tissue relaxes fastest at its start. In a
    rest they grow on, else to `step` s.
    """

    start: float
    stop: float
    first: float
    step: float
    moves: bool

    @property
    def count(self) -> int:
        """Steps of it, if even."""
        return max(1, int(np.ceil((self.stop - self.start) / self.step - 1e-9)))

    def times(self) -> Array:
        """Return its times in s but the first."""
        if not self.moves:
            return _growing(self.start, self.stop, self.first)
        if self.count == 1:  # as most of a sampled motion, which has thousands
            return np.array([self.stop])
        lengths, length = [], self.first
        while length < self.step * (1 - 1e-9):
            lengths.append(length)
            length *= GROWTH
        lead = self.start + np.cumsum(lengths)
        lead = lead[lead < self.stop - self.step]
        even = replace(self, start=float(lead[-1])) if len(lead) else self
        return np.append(lead, np.linspace(even.start, even.stop, even.count + 1)[1:])


def time_grid(
    motion: Motion, *, fast: bool, refine: int = 1, most: int = MOST, feature: float = np.inf
) -> Array:
    """Return times (n_t,) in s from 0 to the end of the motion, with all of its corners.

    `fast` limits the step in motion to 0.2 ms (a 25000th of ramps and cycles longer than 5 s, after
    their start); `refine` divides every step. `feature` in mm is the smallest part of a texture
    that may slide, which takes shorter steps, but none below the `fast` ones. InputError for a
    motion that takes more than `most` steps.
    """
    pieces = list(_pieces(motion, fast=fast, feature=feature))
    reason = _too_long(motion, pieces, most)
    if reason:
        raise InputError(reason)
    grid = np.concatenate([np.zeros(1), *(piece.times() for piece in pieces)])
    if refine == 1:
        return grid
    fractions = np.arange(1, refine + 1) / refine
    return np.append(0.0, (grid[:-1, None] + np.diff(grid)[:, None] * fractions).ravel())


def moving(motion: Motion, time: Array) -> int:
    """Count the times (n_t,) s at which the contact differs from that at the time before.

    Under a constant force tissue creeps, and contact grows; at a constant depth and place it stays.
    """
    if motion.by_force or motion.turns_plate:
        return len(time)
    course = np.column_stack([motion.value(time), motion.shift(time)])
    return int(np.count_nonzero(np.diff(course, axis=0).any(axis=1)))


def too_long(
    motion: Motion, *, fast: bool, most: int = MOST, feature: float = np.inf
) -> tuple[str, ...]:
    """Error messages for a motion of more than `most` time steps: one or none."""
    reason = _too_long(motion, _pieces(motion, fast=fast, feature=feature), most)
    return (reason,) if reason else ()


def _too_long(motion: Motion, pieces: "Iterator[_Piece] | list[_Piece]", most: int) -> str:
    steps = sum(piece.count for piece in pieces if piece.moves)
    if steps <= most:
        return ""
    todo = "take fewer cycles or a shorter motion"
    if motion.sample_rate is not None and motion.sample_rate * SLOW <= 1:
        todo = "its samples are so far apart as if their times were in ms; give them in s"
    return (
        f"motion: expected one of at most {most} time steps, which fit into memory, received one "
        f"of {steps}; {todo}"
    )


def _pieces(motion: Motion, *, fast: bool, feature: float) -> Iterator[_Piece]:
    corners = np.unique(np.clip([0.0, *motion.breakpoints, motion.duration], 0.0, motion.duration))
    finest = FAST_STEP if fast else MOVING_STEP
    cycle = 1.0 / motion.wave_frequency if motion.wave_frequency else np.inf
    moving = motion.moving
    inside = [corners[:-1], (corners[:-1] + corners[1:]) / 2, np.nextafter(corners[1:], -np.inf)]
    speeds = np.linalg.norm(motion.velocity(np.array(inside)), axis=-1).max(axis=0)
    steps_per_part = 10  # in which a part of a texture passes, as a dot or a groove
    with np.errstate(divide="ignore", over="ignore"):  # at rest: infinite
        passing = (feature / steps_per_part / speeds).tolist()
    # The error of these steps is measured: reports/time-steps.json.
    steps_per_cycle, steps_per_move = 40, 60
    for (start, stop), part in zip(pairwise(corners.tolist()), passing, strict=True):
        middle = (start + stop) / 2
        move = [end - begin for begin, end in moving if begin <= middle <= end]
        longer = max(1.0, min(stop - start, cycle) / LONG)
        shares = [cycle / steps_per_cycle, *(length / steps_per_move for length in move)]
        first, step = (
            min([finest * long, max(FAST_STEP * long, part), *shares]) for long in (1.0, longer)
        )
        yield _Piece(start, stop, first, step, bool(move))


def _growing(start: float, stop: float, step: float) -> Array:
    longest = max(RESTING_STEP, (stop - start) / RESTING_STEPS)
    lengths = [step]
    while sum(lengths) < stop - start:
        lengths.append(min(lengths[-1] * GROWTH, longest))
    edges = np.cumsum(lengths)
    return start + (stop - start) * edges / edges[-1]
