"""Time steps that follow the motion: fine while it moves, growing while it rests."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fefinger.motion import Motion


MOVING_STEP = 1e-3  # s: filters up to FAI (10 Hz) and the 4 ms relaxation are resolved
FAST_STEP = 2e-4  # s: FAII takes a second derivative of up to 1 kHz
STEPS_PER_CYCLE = 40
STEPS_PER_MOVE = 60
GROWTH = 1.25  # of successive steps while at rest
RESTING_STEP = 0.05  # s, the longest, up to a rest of RESTING_STEPS of them
RESTING_STEPS = 200  # longer rests take longer steps


def time_grid(motion: Motion, *, fast: bool, refine: int = 1) -> NDArray[np.float64]:
    """Return times (n_t,) in s from 0 to the end of the motion, with all of its corners.

    `fast` limits the step in motion to 0.2 ms; `refine` divides every step.
    """
    corners = np.unique(np.clip([0.0, *motion.breaks, motion.duration], 0.0, motion.duration))
    finest = FAST_STEP if fast else MOVING_STEP
    frequency = getattr(motion, "frequency", None)
    if frequency:
        finest = min(finest, 1.0 / (STEPS_PER_CYCLE * frequency))
    pieces = [np.zeros(1)]
    for start, stop in pairwise(corners):
        middle = (start + stop) / 2
        move = [end - begin for begin, end in motion.moving if begin <= middle <= end]
        step = min([finest, *(length / STEPS_PER_MOVE for length in move)])
        pieces.append(_even(start, stop, step) if move else _growing(start, stop, step))
    grid = np.concatenate(pieces)
    if refine == 1:
        return grid
    fractions = np.arange(1, refine + 1) / refine
    return np.append(0.0, (grid[:-1, None] + np.diff(grid)[:, None] * fractions).ravel())


def _even(start: float, stop: float, step: float) -> NDArray[np.float64]:
    count = max(1, int(np.ceil((stop - start) / step - 1e-9)))
    return np.linspace(start, stop, count + 1)[1:]


def _growing(start: float, stop: float, step: float) -> NDArray[np.float64]:
    longest = max(RESTING_STEP, (stop - start) / RESTING_STEPS)
    lengths = [step]
    while sum(lengths) < stop - start:
        lengths.append(min(lengths[-1] * GROWTH, longest))
    edges = np.cumsum(lengths)
    return start + (stop - start) * edges / edges[-1]
