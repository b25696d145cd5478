"""Record of spikes, input checks and threads that all membranes share."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError, number
from fefinger.support.processes import together


LARGEST_STEP = 5e-5
"""Longest integration step in s; spike counts in steps and ramps are converged there."""


@dataclass(frozen=True, kw_only=True)
class Firing:
    """Spikes and state of membranes, one entry per unit.

    times: ascending spike times in s. peak_mV: highest potential above rest. block_seconds: time
    in depolarization block. stimulus_driven: crossings of 40 mV with sodium activation frozen at
    rest (zeros where that was not computed). final: (n_units, n) potential in mV above rest and the
    gates of the membrane.
    """

    times: tuple[Array, ...]
    peak_mV: Array
    block_seconds: Array
    stimulus_driven: Integers
    final: Array


class Membrane(Protocol):
    """Model from generator current to spikes."""

    def fire(
        self, time: ArrayLike, current: ArrayLike, *, dt: float | None, stimulus_driven: bool
    ) -> Firing:
        """Integrate from rest with a current in µA/cm² at times in s, as `HodgkinHuxley.fire`."""


def largest_step(dt: float | None) -> float:
    """Check the longest step in s; by default LARGEST_STEP."""
    dt = LARGEST_STEP if dt is None else dt
    return number("dt", dt, above=0.0, at_most=LARGEST_STEP, unit="s")


def signals(time: ArrayLike, current: ArrayLike) -> tuple[Array, Array]:
    """Check the signals; return time (n_t,) in ms and current (n_t, n_units) in µA/cm²."""
    time, current = np.asarray(time, float), np.asarray(current, float)
    shaped = current.ndim in (1, 2) and current.shape[:1] == time.shape
    if not shaped or len(time) < 2 or current.size == 0:
        raise InputError(
            "time, current: expected (n_t,) and (n_t,) or (n_t, n_units) with two samples or more "
            f"and one unit or more, received {time.shape} and {current.shape}"
        )
    if not np.isfinite(time).all() or np.any(np.diff(time) < 0):
        raise InputError("time: expected finite times in s that never decrease")
    largest = float(max(current.max(initial=0.0), -current.min(initial=0.0)))
    largest_input = 1e4  # largest current in µA/cm² for which the fixed step is stable
    if not math.isfinite(largest) or largest > largest_input:
        raise InputError(
            f"current: expected at most {largest_input:g} µA/cm², received {largest:g}; "
            "lower the gain or use the saturating generator"
        )
    return 1e3 * time, current.reshape(len(time), -1)


Run = tuple[list[Array], Array]
"""Result of a run: spike times per unit in ms, and a row of numbers per unit."""


def in_blocks(
    run: Callable[[Array], Run],
    current: Array,
    width: int,
    *,
    by_onset: bool = False,
) -> Run:
    """Run blocks of `width` units on all cores and concatenate the results.

    Each thread holds the current of one block, so that memory does not grow with the units.
    `by_onset` groups units by the time at which their current begins, for a `run` that skips silent
    blocks.
    """
    units = current.shape[1]
    order = np.arange(units)
    if by_onset and units > width:
        onset = np.argmax(current != 0.0, axis=0)
        order = np.argsort(
            np.where(current[onset, order] == 0.0, len(current), onset), kind="stable"
        )

    def block(first: int) -> Run:
        return run(np.ascontiguousarray(current[:, order[first : first + width]]))

    runs = together(block, range(0, units, width))
    back = np.argsort(order)
    times = [each for part in runs for each in part[0]]
    return [times[i] for i in back], np.concatenate([rows for _, rows in runs])[back]


def fired(run: Callable[[bool], Run], *, stimulus_driven: bool) -> Firing:
    """Run membranes, and again with frozen sodium if `stimulus_driven`; collect the Firing.

    `run(frozen)` returns rows with the final state, the highest potential in mV and the ms in
    block. InputError for a current, far below zero or with huge jumps, whose state is not finite.
    """
    times, rows = run(False)
    lost = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if len(lost):
        raise InputError(
            f"current: expected one that the membrane can follow, received one that drives unit "
            f"{lost[0]} of {len(rows)} out of the range of its rates; use smaller currents, "
            "especially below zero, or smaller jumps"
        )
    driven = [len(each) for each in run(True)[0]] if stimulus_driven else [0] * len(times)
    return Firing(
        times=tuple(1e-3 * each for each in times),
        peak_mV=rows[:, -2],
        block_seconds=1e-3 * rows[:, -1],
        stimulus_driven=np.array(driven, np.int64),
        final=rows[:, :-2],
    )


def trimmed(spikes: Array, counts: Integers) -> list[Array]:
    """Cut rows of spike times to their counts; InputError where a row was too short."""
    if counts.max(initial=0) > spikes.shape[1]:
        raise InputError(
            f"current: drives the membrane {counts.max()} times through 40 mV, faster than any "
            "membrane can follow; lower the gain"
        )
    return [row[:count].copy() for row, count in zip(spikes, counts, strict=True)]
