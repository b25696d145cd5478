"""Stiffness of a press: slope of force over depth, from a fit to the loading near a time.

The logarithm of the force is fitted by a parabola in that of the depth. The fit is exact for a
power law, and within 1 % inside and 3 % at the end for an exponential one, for any spacing of the
steps. Under plates at 0 to 60 degrees to 1 N, `linear` on the coarse mesh differs from the standard
one by 1 % at 0.5 N and 2 % at the end (RMS), the slope of a single step by 4 and 5 %.
"""

from typing import NamedTuple

import numpy as np

from fefinger.studies.times import at
from fefinger.support.arrays import Array, Flags


WINDOW = 1.3
"""The fit covers depths from 1 / WINDOW to WINDOW times the depth; where the loading ends before,
the window is extended below by as much."""

POINTS = 5
"""Fewest time steps of a fit."""

MOVING = 0.5
"""Share of the top rate below which the motion counts as a hold: there the slope of force over
depth would be that of relaxation."""

RESTING = "none: not on the loading, or slower than half the top rate of the motion"


class Slope(NamedTuple):
    """A slope in N/mm, the number of fitted time steps, and the reason where it is nan."""

    value: float
    points: int
    note: str


def stiffness(time: Array, depth: Array, force: Array, where: float, *, control: str) -> Slope:
    """Fit the slope of force over depth at a fractional index.

    time (n_t,) s, depth (n_t,) mm, force (n_t,) N; control: "depth" or "force", whichever the
    motion prescribes. Only steps that follow each other on the loading are fitted, on which both
    rise and the motion is no slower than MOVING of its top rate.
    """
    driven = force if control == "force" else depth
    rate = np.diff(driven) / np.diff(time)
    loading = (np.diff(depth) > 0) & (np.diff(force) > 0) & (rate >= MOVING * np.abs(rate).max())
    step, here = max(int(np.ceil(where)) - 1, 0), float(at(depth, where))
    if not loading[step] or here <= 0:
        return Slope(float("nan"), 0, RESTING)
    low, high = _stretch(loading, step)
    depth, force = depth[low:high], force[low:high]
    away = np.log(np.maximum(depth / here, 1e-300))
    above = min(np.log(WINDOW), away[-1])
    # The margin of 1e-9 includes steps at the ends of the window despite rounding.
    near = (away >= above - 2 * np.log(WINDOW) - 1e-9) & (away <= above + 1e-9) & (force > 0)
    points = int(near.sum())
    if points < POINTS:
        note = f"none: {points} steps of the loading within a factor of {WINDOW:g} of the depth"
        return Slope(float("nan"), points, f"{note}, expected {POINTS}")
    size, power, _ = np.polynomial.polynomial.polyfit(away[near], np.log(force[near]), 2)
    return Slope(float(power * np.exp(size) / here), points, "")


def _stretch(good: Flags, step: int) -> tuple[int, int]:
    """Range of times around a step between which every step is good: first, and last + 1."""
    bad = np.flatnonzero(~good)
    before, after = bad[bad < step], bad[bad > step]
    low = int(before[-1]) + 1 if before.size else 0
    return low, (int(after[0]) if after.size else len(good)) + 1
