"""Compiled time step of the units of `recorded`; imported at the first run."""

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
    jitter: of the time from threshold to impulse in s; stream: of the random numbers.
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
    jitter: Array
    stream: NDArray[np.uint64]


X, MODE, SLOW, CURRENT, ADAPTED, AFTER, POTENTIAL, FREE = range(8)
KNOT, LEFT, RIGHT, PEAK, FIRED, LAST, SIZE = range(8, 15)
"""Places in the state of a unit: last input in mm, two modes of the filter, current, adaptation,
current after spikes, potential, time in s from which it is free to fire, index of the last knot of
the noise, noise at that knot and the next, highest potential, number of impulses, and time in s of
the last."""

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


@njit(cache=True)
def _noise(stream: np.uint64, state: Array, t: float) -> float:
    """Noise of a unit at t s, over its standard deviation; draws the knots as they come."""
    since = t * (1.0 / KNOTS)
    if not state[KNOT] <= since < state[KNOT] + 1.0:
        knot = math.floor(since)
        near = knot == state[KNOT] + 1.0
        state[LEFT] = state[RIGHT] if near else normal(stream, int(knot))
        state[RIGHT] = normal(stream, int(knot) + 1)
        state[KNOT] = knot
    return state[LEFT] + (state[RIGHT] - state[LEFT]) * (since - state[KNOT])


BEFORE = -(2**40)
"""Index of the random number that the first impulse of a unit is displaced by: no knot has it."""


@njit(cache=True)
def displaced(units: Units, i: int, state: Array, fired: float) -> float:
    """Return the time in s at which unit i is recorded to fire, after its last impulse."""
    time = fired
    if units.jitter[i] > 0.0:
        time += units.jitter[i] * normal(units.stream[i], BEFORE + int(state[FIRED]))
        time = max(time, state[LAST] + units.refractory[i])
    state[FIRED] += 1.0
    state[LAST] = time
    return time


@njit(cache=True, error_model="numpy")
def advance(
    units: Units,
    i: int,
    state: Array,
    span: tuple[float, float],
    x: float,
    longest: float,
    spikes: Array,
    count: int,
) -> int:
    """Advance unit i over a span (start, stop) in s in which its input runs straight to x mm.

    Steps of at most `longest` s: filter, adaptation and membrane are exact for the mean current of
    a step, and a spike lies on the straight line between the potentials at its ends, displaced by
    its jitter. Returns the new count of spikes, whose times in s go to `spikes` as far as it is
    long enough.
    """
    start, length = span[0], span[1] - span[0]
    change = x - state[X]
    if length <= 0.0:
        state[X] = x
        state[MODE] += change
        state[SLOW] += change
        generate(units, i, state)
        return count
    steps = max(1, math.ceil(length / longest - 1e-9))
    h = length / steps
    first, second = units.pole[i, 0], units.pole[i, 1]
    fade, wane = math.exp(-first * h), math.exp(-second * h)
    grow = change * ((1.0 - fade) / (first * length))
    rise = change * ((1.0 - wane) / (second * length))
    leak, adapt = -math.expm1(-h / units.membrane[i]), -math.expm1(-h / units.adaptation[i])
    after = math.exp(-h / units.recovering[i])
    gain, negative, saturation = units.gain[i], units.negative[i], 1.0 / units.largest[i]
    move, stream, refractory = change / steps, units.stream[i], units.refractory[i]
    at_rest, share, other = units.at_rest[i], units.share[i, 0], units.share[i, 1]
    adapting, noise, membrane = units.adapting[i], units.noise[i], units.membrane[i]
    entered, mode, slow, current = state[X], state[MODE], state[SLOW], state[CURRENT]
    adapted, taken, v, free = state[ADAPTED], state[AFTER], state[POTENTIAL], state[FREE]
    peak = state[PEAK]
    for k in range(steps):
        t = start + k * h
        entered += move
        mode = fade * mode + grow
        slow = wane * slow + rise
        y = at_rest * entered + share * mode + other * slow
        before, current = current, generator(y, gain, negative, saturation)
        mean = 0.5 * (before + current)
        drive = mean - adapting * (adapted + 0.5 * adapt * (mean - adapted))
        drive -= 0.5 * taken * (1.0 + after)
        if noise > 0.0:
            drive += noise * min(mean, 1.0) * _noise(stream, state, t + 0.5 * h)
        adapted += adapt * (mean - adapted)
        taken *= after
        if free >= t + h:
            continue
        part = leak if free <= t else -math.expm1((free - t - h) / membrane)
        now = v + part * (drive - v)
        peak = max(peak, now)
        if now < 1.0:
            v = now
            continue
        begin = max(free, t)
        fired = begin + (t + h - begin) * max(0.0, (1.0 - v) / max(now - v, 1e-300))
        recorded = displaced(units, i, state, fired)
        if count < len(spikes):
            spikes[count] = recorded
        count += 1
        v, free = 0.0, fired + refractory
        taken += units.recovery[i]
    state[X], state[MODE], state[SLOW], state[CURRENT] = x, mode, slow, current
    state[ADAPTED], state[AFTER], state[POTENTIAL], state[FREE] = adapted, taken, v, free
    state[PEAK] = min(1.0, peak)
    return count


def rested(units: Units, x: Array, start: float = 0.0) -> Array:
    """States (n, SIZE) of units at rest that jump to inputs x (n,) in mm at `start` s."""
    states = np.zeros((len(x), SIZE))
    states[:, KNOT] = np.nan
    states[:, LAST] = start - units.refractory
    states[:, X] = states[:, MODE] = states[:, SLOW] = x
    for i, state in enumerate(states):
        generate(units, i, state)
    return states
