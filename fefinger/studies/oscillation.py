"""Dynamic stiffness of a vibration: force over depth, in its last cycles."""

from typing import TYPE_CHECKING

import numpy as np

from fefinger.support.arrays import Array


if TYPE_CHECKING:
    from fefinger.scene.motion import Motion

CYCLES = 4
"""Cycles that are fitted, or as many as there are."""


def dynamic_stiffness(motion: "Motion", time: Array, depth: Array, force: Array) -> complex | None:
    """Fit force over depth in N/mm along the phase of a wave, force leading by its phase.

    time (n_t,) s, depth (n_t,) mm, force (n_t,) N. Means and slow drifts do not count. None without
    a whole cycle, or where contact is lost in a cycle. Of a sweep it is that at its end.
    """
    wave = motion.trajectory.wave
    if wave is None:
        return None
    frequency = wave.last_frequency
    cycles = min(CYCLES, int((motion.duration - wave.start) * frequency * (1 + 1e-9)))
    last = time >= time[-1] - cycles / frequency * (1 + 1e-9)
    if not cycles or not (force[last] > 0).all():
        return None
    angle, drift = wave.angle(time[last] - wave.start), (time[last] - time[-1]) * frequency / cycles
    terms = np.column_stack([np.cos(angle), np.sin(angle), drift**0, drift, drift**2])
    fitted = np.linalg.lstsq(terms, np.column_stack([depth[last], force[last]]), rcond=None)[0]
    moved, pushed = fitted[0] - 1j * fitted[1]
    return complex(pushed / moved)
