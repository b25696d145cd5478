"""Stiffness of a press: the slope of its force over its depth, from a fit to the loading around.

The logarithm of the force is fitted by a parabola of that of the depth. A power law of any exponent
is met exactly, an exponential one within 1 % on the way and 3 % at its end, however the steps are
spaced. Under plates at 0 to 60 degrees to 1 N, `linear` on the coarse mesh differs from the
standard one by 1 % at 0.5 N and 2 % at the end (RMS), the slope of a single step by 4 and 5 %.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.results.records import Array
from fefinger.studies.times import at


WINDOW = 1.3
"""Factor of the depth, less and more, within which the loading is fitted; where it ends before, as
much more is taken below."""

POINTS = 5
"""Time steps within it that a fit takes at least."""

MOVING = 0.5
"""Part of its top rate below which the motion rests: the slope of the force over the depth is then
that of relaxation."""

RESTING = "not told: not on the loading, or slower than half the top rate of the motion"


class Slope(NamedTuple):
    """A slope in N/mm, how many time steps it is fitted to, and why it is nan where it is."""

    value: float
    points: int
    note: str


def stiffness(time: Array, depth: Array, force: Array, where: float, *, control: str) -> Slope:
    """Return the slope of the force over the depth at an index with a fraction.

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
    # a part in 1e9: steps at the ends of the window count, to rounding
    near = (away >= above - 2 * np.log(WINDOW) - 1e-9) & (away <= above + 1e-9) & (force > 0)
    points = int(near.sum())
    if points < POINTS:
        note = f"not told: {points} steps of the loading within a factor of {WINDOW:g} of the depth"
        return Slope(float("nan"), points, f"{note}, expected {POINTS}")
    size, power, _ = np.polynomial.polynomial.polyfit(away[near], np.log(force[near]), 2)
    return Slope(float(power * np.exp(size) / here), points, "")


def _stretch(good: NDArray[np.bool_], step: int) -> tuple[int, int]:
    """Return first and last + 1 of the times between which every step is good, around a step."""
    bad = np.flatnonzero(~good)
    before, after = bad[bad < step], bad[bad > step]
    low = int(before[-1]) + 1 if before.size else 0
    return low, (int(after[0]) if after.size else len(good)) + 1
