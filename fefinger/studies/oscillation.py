"""Dynamic stiffness of a vibration: force over depth at its frequency, in its last cycles."""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.support.arrays import Array


if TYPE_CHECKING:
    from fefinger.scene.motion import Motion

CYCLES = 4
"""Cycles that are fitted, or as many as there are."""


def dynamic_stiffness(motion: "Motion", time: Array, depth: Array, force: Array) -> complex | None:
    """Fit force over depth in N/mm at the frequency of a motion, force leading by its phase.

    time (n_t,) s, depth (n_t,) mm, force (n_t,) N. Means and slow drifts do not count. None without
    a whole cycle, or where contact is lost in a cycle.
    """
    wave = motion.trajectory.wave
    frequency = motion.wave_frequency
    if wave is None or frequency is None:
        return None
    cycles = min(CYCLES, int((motion.duration - wave.start) * frequency * (1 + 1e-9)))
    last = time >= time[-1] - cycles / frequency * (1 + 1e-9)
    if not cycles or not (force[last] > 0).all():
        return None
    t = time[last] - time[-1]
    angle, drift = 2 * np.pi * frequency * t, t * frequency / cycles
    terms = np.column_stack([np.cos(angle), np.sin(angle), np.ones_like(t), drift, drift**2])
    fitted = np.linalg.lstsq(terms, np.column_stack([depth[last], force[last]]), rcond=None)[0]
    moved, pushed = fitted[0] - 1j * fitted[1]
    return complex(pushed / moved)
