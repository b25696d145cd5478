"""Times of a result that a study tells of: its peak and end, and forces and depths on the way."""

from typing import NamedTuple

import numpy as np

from fefinger.results.records import Array


SAME = 1e-9
"""Relative difference up to which two forces or depths are the same level."""


class Moment(NamedTuple):
    """A time by its name, as an index with a fraction; nan where `missed` says why.

    given: "force" or "depth" for the level it is told at, or "" for what the motion prescribes.
    """

    name: str
    where: float
    missed: str
    given: str = ""


def moments(
    force: Array, depth: Array, forces: tuple[float, ...], depths: tuple[float, ...]
) -> list[Moment]:
    """Return peak and end of a force (n_t,) in N and depth (n_t,) in mm, and where levels are met.

    A level is met where the loading reaches it first, between two steps along a straight line.
    """
    top, deepest = first(force, force.max()), first(depth, depth.max())
    found = [Moment("peak", float(top), ""), Moment("end", float(len(force) - 1), "")]
    for name, unit, signal, levels in (
        ("force", "N", force[: top + 1], forces),
        ("depth", "mm", depth[: deepest + 1], depths),
    ):
        for level in levels:
            where = _reached(signal, level)
            reason = f"not reached: {name} = {signal[-1]:.4g} {unit} at most"
            missed = reason if np.isnan(where) else ""
            found.append(Moment(f"{level:g} {unit}", where, missed, given=name))
    return found


def first(signal: Array, level: float) -> int:
    """Return the index at which a signal first reaches a level, to rounding."""
    return int(np.argmax(signal >= level - SAME * abs(level)))


def _reached(signal: Array, level: float) -> float:
    """Return where a signal first reaches a level, as an index with a fraction, or nan."""
    if signal.max() < level * (1 - SAME):
        return float("nan")
    after = first(signal, level)
    if after == 0:
        return 0.0
    low, high = signal[after - 1], signal[after]
    return after - 1 + min(float((level - low) / (high - low)), 1.0)


def at(signal: Array, where: float) -> Array:
    """Return a signal (n_t, ...) at an index with a fraction."""
    low, part = int(where), where - int(where)
    return signal[low] if part == 0 else (1 - part) * signal[low] + part * signal[low + 1]


def until(signal: Array, where: float) -> Array:
    """Return a signal (n_t,) up to an index with a fraction, and there."""
    return np.append(signal[: int(where) + 1], at(signal, where))
