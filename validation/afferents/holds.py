"""Slow presses of the probe, and the fall of the rate of SAI in the first 12 s of a hold.

The plateau was steady, or its depth changed by 15 % within the 12 s (J Neurosci 3:2652, abstract).
"""

from functools import cache

import numpy as np
from fefinger.validation.afferents import experiments
from fefinger.validation.afferents.vibration import Probed

from fefinger.neural.recorded import Recorded
from fefinger.support.arrays import Array


FALLS: dict[float, tuple[float, float]] = {
    0.0: (0.38, 0.36),
    -0.15: (0.47, 0.46),
    0.15: (0.26, 0.22),
}
"""Recorded falls at DEPTHS, by the part by which the depth changes in 12 s; the steady ones are
fitted, the others predicted."""

DEPTHS = (0.65, 1.3)
"""Depths in mm of the holds."""

LASTING = 12.0
"""Length in s of the hold that is looked at."""

SPEED = 0.4
"""Speed in mm/s of the presses before."""

TRIALS = 6
"""Repetitions of a hold, each with noise of its own."""


@cache
def driven(drift: float) -> tuple[Array, Array]:
    """Time (n_t,) s and drives (n_t, n) of SAI in holds at DEPTHS that drift by a part of them."""
    depths = np.linspace(0.0, 1.5, 31)
    below = experiments.pressed(
        experiments.PROBE,
        depths[1:],
        np.zeros(1),
        drive="compressive",
        organ=experiments.DEPTHS["SAI"],
    )[:, 0]
    deep = np.array(DEPTHS)
    time = np.linspace(0.0, deep.max() / SPEED + LASTING + 1.0, 1601)
    since = time[:, None] - deep / SPEED
    moved = np.minimum(SPEED * time[:, None], deep)
    moved = moved * (1.0 + drift * np.clip(since / LASTING, 0.0, 1.0))
    return time, np.interp(moved, depths, np.concatenate([[0.0], below]))


def falls(unit: Recorded, drift: float = 0.0) -> Array:
    """Falls (n,) of the rate of the unit in the first 12 s of the holds at DEPTHS."""
    time, drives = driven(drift)
    x = unit.length * np.repeat(drives, TRIALS, axis=1)
    times = Probed("SAI", unit, 0.0).fire(time, x, np.ones(x.shape[1]))
    out = []
    for i, depth in enumerate(DEPTHS):
        since = np.concatenate(times[i * TRIALS : (i + 1) * TRIALS]) - depth / SPEED
        first, late = (
            int(np.count_nonzero((since >= t) & (since < t + 1.0))) for t in (0.0, LASTING - 0.5)
        )
        out.append(1.0 - late / max(first, 1))
    return np.array(out)
