"""Time steps of a press with inertia: even and short while it moves and rings, long in a rest."""

import numpy as np

from fefinger.fem.contact.modal_march import TimeGrid
from fefinger.mechanics.press.time_steps import FAST_STEP, MODAL_STEP, MOST, time_grid
from fefinger.scene.motion import Motion
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import InputError


STEPS_PER_CYCLE = 60
"""Steps per cycle of a vibration: its force is then 0.3 % off, by the order of the steps."""

RINGING = 0.1
"""Time in s in which tissue of a published relaxation stops ringing after a motion."""

SLOW = 25.0
"""A part of the motion whose steps would be this many times as long as the shortest is
quasi-static."""

RECORDED = 1e-3
"""Longest time in s between stored states while the finger rings; FAST_STEP for FAII."""


def modal_grid(motion: Motion, *, fast: bool) -> TimeGrid:
    """Return the steps of a motion; stored are those of statics, and more while it rings.

    InputError if the motion takes more steps than memory holds.
    """
    outer = time_grid(motion, fast=fast)
    lengths, moves = np.diff(outer), _moving(motion, outer)
    cycle = 1 / motion.highest_frequency if motion.highest_frequency else np.inf
    shortest = lengths[moves].min(initial=np.inf)
    longest = float(min(MODAL_STEP, cycle / STEPS_PER_CYCLE, shortest))
    short = moves & (lengths <= SLOW * longest)
    last = np.maximum.accumulate(np.where(short, outer[1:], -np.inf))
    rings = ~short & (outer[:-1] < last + RINGING)
    parts = np.ones(len(lengths), dtype=np.int64)
    swings = short | rings
    parts[swings] = np.ceil(lengths[swings] / longest * (1 - 1e-9)).astype(np.int64)
    total = int(parts.sum())
    if total > MOST:
        raise InputError(
            f"motion: expected one of at most {MOST} time steps with inertia, received one of "
            f"{total}; take fewer cycles or a shorter motion"
        )
    every = np.ones(len(lengths), dtype=np.int64)
    interval = FAST_STEP if fast else RECORDED
    recorded = np.ceil(lengths / interval * (1 - 1e-9)).astype(np.int64)
    every[rings] = np.maximum(1, parts[rings] // np.maximum(recorded[rings], 1))
    time, stored = [np.zeros(1)], [np.zeros(1, dtype=np.int64)]
    done = 0
    for start, length, count, stride in zip(outer[:-1], lengths, parts, every, strict=True):
        time.append(start + length * np.arange(1, count + 1) / count)
        chosen = np.arange(count, 0, -stride)[::-1]
        stored.append(done + chosen)
        done += int(count)
    times = np.concatenate(time)
    times[np.cumsum(parts)] = outer[1:]  # exactly those of statics
    return TimeGrid(times, np.concatenate(stored), longest * (1 + 1e-6))


def _moving(motion: Motion, time: Array) -> Flags:
    """Whether the motion moves in each interval (n_t - 1,) of the times."""
    middles = (time[1:] + time[:-1]) / 2
    moves = np.zeros(len(middles), dtype=np.bool_)
    for start, stop in motion.moving:
        moves |= (middles > start) & (middles < stop)
    return moves
