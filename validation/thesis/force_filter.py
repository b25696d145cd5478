"""Low-pass filter of the force sensor of Pawluk (1997), section 2.2."""

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support.arrays import Array
from fefinger.theory.contact import elastic


def two_pole(time: ArrayLike, signal: ArrayLike, corner: float = 1000.0) -> Array:
    """Filter a signal (n_t,) by a two-pole Butterworth low-pass of `corner` Hz.

    The filter of the force sensor (section 2.2). Exact for straight lines between the samples at
    rising times (n_t,) s; before the first one the signal rests at its first value.
    """
    elastic.require_positive("two_pole", corner=corner)
    time = elastic.numbers("two_pole", "times", time)
    signal = elastic.numbers("two_pole", "values", signal)
    if time.ndim != 1 or signal.shape != time.shape or (np.diff(time) <= 0).any():
        raise ValueError("two_pole: expected a value at each of rising times, (n_t,) both")
    # One of the conjugate pair; the real part of its state, doubled in `gain`, holds both.
    pole = 2 * np.pi * corner * np.exp(0.75j * np.pi)
    gain = 2 * (2 * np.pi * corner) ** 2 / (pole - pole.conjugate())
    state = -signal[0] / pole + 0j
    out = np.empty(len(time))
    out[0] = signal[0]
    for i, (step, change) in enumerate(zip(np.diff(time), np.diff(signal), strict=True)):
        x = pole * step
        first = np.expm1(x) / x
        state = np.exp(x) * state + step * (signal[i] * first + change * (first - 1) / x)
        out[i + 1] = (gain * state).real
    return out
