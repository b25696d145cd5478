"""Compiled parts of the units of `recorded`: state, noise, generator and jitter."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fefinger.support.arrays import Array


class Units(NamedTuple):
    """Parameters of units, one row each; times in s, currents over the threshold current.

    gain per mm, at_rest and share (n, 2) of the filter, pole (n, 2) in rad/s; negative: weight of a
    negative output of the filter; largest: current of the saturated generator; adapting: part of
    the current that adaptation takes away, within adaptation s; recovery: current after a spike,
    which fades within recovering s; membrane, refractory; noise: standard deviation at its knots;
    latency: mean time from threshold to impulse, jitter: its standard deviation; stream: of the
    random numbers.
    """

    gain: Array
    at_rest: Array
    share: Array
    pole: Array
    negative: Array
    largest: Array
    adapting: Array
    adaptation: Array
    recovery: Array
    recovering: Array
    membrane: Array
    refractory: Array
    noise: Array
    latency: Array
    jitter: Array
    stream: NDArray[np.uint64]


X, MODE, SLOW, CURRENT, ADAPTED, AFTER, POTENTIAL, FREE, PEAK, FIRED, LAST, SIZE = range(12)
"""Places in the state of a unit: last input in mm, two modes of the filter, current, adaptation,
current after spikes, potential, time in s from which it is free to fire, highest potential, number
of impulses, and time in s of the last."""

KNOTS = 1e-3
"""Time in s between independent values of the noise, which is linear in between."""


@njit(cache=True)
def mixed(z: np.uint64) -> np.uint64:
    """Mix the bits of a counter (splitmix64)."""
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit(cache=True)
def normal(stream: np.uint64, knot: int) -> float:
    """Return a nearly normal number at a knot of a stream, in whatever order they are drawn.

    The sum of four uniform numbers of 16 bits, of mean 0 and variance 1: none is beyond 3.5.
    """
    bits = mixed(stream + np.uint64(knot) * np.uint64(0x9E3779B97F4A7C15))
    mask = np.uint64(0xFFFF)
    low = float(bits & mask) + float((bits >> np.uint64(16)) & mask)
    high = float((bits >> np.uint64(32)) & mask) + float(bits >> np.uint64(48))
    return (low + high - 131070.0) * (math.sqrt(3.0) / 65536.0)


@njit(cache=True, error_model="numpy")
def generator(y: float, gain: float, negative: float, saturation: float) -> float:
    """Return the generator current over threshold at an output y mm of the filter.

    saturation: one over the current of the saturated generator.
    """
    u = gain * abs(y)
    return (1.0 if y > 0.0 else negative) * u / (1.0 + u * saturation)


@njit(cache=True)
def generate(units: Units, i: int, state: Array) -> None:
    """Set the current of unit i to that of its input and filter modes."""
    y = units.at_rest[i] * state[X]
    y += units.share[i, 0] * state[MODE] + units.share[i, 1] * state[SLOW]
    state[CURRENT] = generator(y, units.gain[i], units.negative[i], 1.0 / units.largest[i])


BEFORE = -(2**40)
"""Index of the random number that the first impulse of a unit is displaced by: no knot has it."""


@njit(cache=True)
def displaced(units: Units, i: int, state: Array, fired: float) -> float:
    """Return the time in s at which unit i that reached threshold at `fired` is recorded to fire.

    Never before `fired`, nor within the refractory time of its last impulse.
    """
    time = fired + units.latency[i]
    if units.jitter[i] > 0.0:
        time += units.jitter[i] * normal(units.stream[i], BEFORE + int(state[FIRED]))
        time = max(time, state[LAST] + units.refractory[i])
    state[FIRED] += 1.0
    state[LAST] = time
    return time


def rested(units: Units, x: Array, start: float = 0.0) -> Array:
    """States (n, SIZE) of units at rest, free to fire, that jump to inputs x (n,) mm at `start`."""
    states = np.zeros((len(x), SIZE))
    states[:, FREE], states[:, LAST] = start, start - units.refractory
    states[:, X] = states[:, MODE] = states[:, SLOW] = x
    for i, state in enumerate(states):
        generate(units, i, state)
    return states
