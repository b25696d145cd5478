"""Times of the rows of a study: peak, end, and the first crossing of forces and depths."""

from typing import NamedTuple

import numpy as np

from fefinger.studies.columns import MISSED
from fefinger.support.arrays import Array


SAME = 1e-9
"""Relative difference up to which two forces or depths are the same level."""


class NamedTime(NamedTuple):
    """A named time as a fractional index; nan, with the reason in `missed`, if never reached.

    given: "force" or "depth" for a time at a given level, "" for peak and end.
    """

    name: str
    where: float
    missed: str
    given: str = ""


def named_times(
    force: Array, depth: Array, forces: tuple[float, ...], depths: tuple[float, ...]
) -> list[NamedTime]:
    """Find peak and end of a force (n_t,) in N and depth (n_t,) in mm, and crossings of levels.

    A crossing is the first on the loading, by linear interpolation between two steps.
    """
    top, deepest = first(force, force.max()), first(depth, depth.max())
    times = [NamedTime("peak", float(top), ""), NamedTime("end", float(len(force) - 1), "")]
    for name, unit, signal, levels in (
        ("force", "N", force[: top + 1], forces),
        ("depth", "mm", depth[: deepest + 1], depths),
    ):
        for level in levels:
            where = _reached(signal, level)
            reason = f"{MISSED}: {name} = {signal[-1]:.4g} {unit} at most"
            missed = reason if np.isnan(where) else ""
            times.append(NamedTime(f"{level:g} {unit}", where, missed, given=name))
    return times


def first(signal: Array, level: float) -> int:
    """Index at which a signal first reaches a level, within rounding."""
    return int(np.argmax(signal >= level - SAME * abs(level)))


def _reached(signal: Array, level: float) -> float:
    """Fractional index at which a signal first reaches a level; nan if it does not."""
    if signal.max() < level * (1 - SAME):
        return float("nan")
    after = first(signal, level)
    if after == 0:
        return 0.0
    low, high = signal[after - 1], signal[after]
    return after - 1 + min(float((level - low) / (high - low)), 1.0)


def at(signal: Array, where: float) -> Array:
    """Interpolate a signal (n_t, ...) at a fractional index."""
    low, part = int(where), where - int(where)
    return signal[low] if part == 0 else (1 - part) * signal[low] + part * signal[low + 1]


def until(signal: Array, where: float) -> Array:
    """Cut a signal (n_t,) off at a fractional index, with the interpolated value as its last."""
    return np.append(signal[: int(where) + 1], at(signal, where))
