"""Compiled filter of an end organ, at and between the samples; imported at its first use."""

import numpy as np
from numpy.typing import NDArray

from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


Modes = NDArray[np.inexact]
"""Numbers of modes: complex where poles are."""


@njit(cache=True, nogil=True)
def remember(decay: Modes, ramp: Modes, columns: Array, out: Modes) -> None:
    """Compute the modes `out` (n_t, n_poles, n) at all samples from those at the first.

    decay, ramp (n_t - 1, n_poles): factors of an interval on a mode and on the change of its input;
    columns (n_t, n): the input.
    """
    for k in range(len(decay)):
        for i in range(decay.shape[1]):
            for u in range(columns.shape[1]):
                change = columns[k + 1, u] - columns[k, u]
                out[k + 1, i, u] = decay[k, i] * out[k, i, u] + ramp[k, i] * change


@njit(cache=True, nogil=True, error_model="numpy")
def between(
    at_rest: float,
    weights: Modes,
    poles: Modes,
    columns: Array,
    slopes: Array,
    memory: Modes,
    interval: Integers,
    since: Array,
) -> Array:
    """Output (n_at, n) at `since` s after the sample `interval`, both (n_at,).

    columns, slopes (n_t, n): input and its slope after each sample; memory (n_t, n_poles, n).
    """
    out = np.empty((len(since), columns.shape[1]))
    for a in range(len(since)):
        k, s = interval[a], since[a]
        for u in range(columns.shape[1]):
            out[a, u] = at_rest * (columns[k, u] + slopes[k, u] * s)
        for i in range(len(poles)):
            fading = weights[i] * np.exp(-poles[i] * s)
            fresh = (weights[i] - fading) / poles[i]
            for u in range(columns.shape[1]):
                out[a, u] += (fading * memory[k, i, u] + fresh * slopes[k, u]).real
    return out
