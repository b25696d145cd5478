"""Compiled units of the family `recorded`: state, noise and time steps; imported at the first run.

Units advance 16 at a time. The loop over LANES has no branch and no exponential, so that the
compiler turns it into vector instructions. What few lanes do in a step, to fire or to end a
refractory time, follows one by one.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit
from fefinger.support.processes import together


class Units(NamedTuple):
    """Parameters of units, one row each; times in s, currents over the threshold current.

    gain per mm, at_rest and share (n, 3) of the filter, pole (n, 3) in rad/s; negative: weight of a
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


X, MODE, SLOW, THIRD, CURRENT, ADAPTED, AFTER, POTENTIAL, FREE, PEAK, FIRED, LAST, SIZE = range(13)
"""Places in the state of a unit: last input in mm, three modes of the filter, current, adaptation,
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
    """Set the generator current of unit i from its input and filter modes."""
    y = units.at_rest[i] * state[X]
    y += units.share[i, 0] * state[MODE] + units.share[i, 1] * state[SLOW]
    y += units.share[i, 2] * state[THIRD]
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
    states[:, X : THIRD + 1] = x[:, None]
    for i, state in enumerate(states):
        generate(units, i, state)
    return states


LANES = 16  # as in `membranes.vectorized`

NEVER = -(10**15)
"""Knot of the noise before the first."""

# Offsets of the rows in the array of a block. One array, because the compiler then needs no checks
# at run time that rows do not overlap. Parameters:
_GAIN, _AT_REST, _SHARE, _OTHER, _LESS, _NEGATIVE, _INVERSE, _ADAPTING, _NOISE = range(
    0, 9 * LANES, LANES
)
# Factors of a step: what is left of each mode, and its part of a change of the input; the others:
_FADE, _WANE, _DIM, _GROW, _RISE, _CLIMB, _ADAPT, _FORGET, _LEAK = range(
    9 * LANES, 18 * LANES, LANES
)
# Change of the input and of the filter modes in a step:
_MOVE, _PUSH, _LIFT, _HOIST = range(18 * LANES, 22 * LANES, LANES)
# State, in the order of its places up to PEAK, and the noise at the knots before and after:
_X, _MODE, _SLOW, _THIRD, _CURRENT, _ADAPTED, _TAKEN, _V, _FREE, _PEAK, _LEFT, _RIGHT = range(
    22 * LANES, 34 * LANES, LANES
)
# What the step leaves, the mean drive and 1 for a lane to finish, and the end:
_DRIVE, _RARE, _END = range(34 * LANES, 37 * LANES, LANES)


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _steps(s: Array, t: float, h: float, since: float) -> int:
    """Advance all lanes by a step of h s from t s; return how many have to be finished.

    since: of the middle of the step, from the left knot of the noise over the distance of knots.
    """
    rare = 0
    for i in range(LANES):
        x = s[_X + i] + s[_MOVE + i]
        mode = s[_FADE + i] * s[_MODE + i] + s[_PUSH + i]
        slow = s[_WANE + i] * s[_SLOW + i] + s[_LIFT + i]
        third = s[_DIM + i] * s[_THIRD + i] + s[_HOIST + i]
        y = s[_AT_REST + i] * x + s[_SHARE + i] * mode
        y += s[_OTHER + i] * slow + s[_LESS + i] * third
        current = generator(y, s[_GAIN + i], s[_NEGATIVE + i], s[_INVERSE + i])
        mean = 0.5 * (s[_CURRENT + i] + current)
        adapted, taken, forget = s[_ADAPTED + i], s[_TAKEN + i], s[_FORGET + i]
        nearer = s[_ADAPT + i] * (mean - adapted)
        drive = mean - s[_ADAPTING + i] * (adapted + 0.5 * nearer)
        drive -= 0.5 * taken * (1.0 + forget)
        left = s[_LEFT + i]
        drive += s[_NOISE + i] * min(mean, 1.0) * (left + (s[_RIGHT + i] - left) * since)
        v, free = s[_V + i], s[_FREE + i]
        now = v + s[_LEAK + i] * (drive - v)
        now = now if free <= t else v
        finish = (now >= 1.0) | ((free > t) & (free < t + h))
        s[_X + i], s[_MODE + i], s[_SLOW + i], s[_THIRD + i] = x, mode, slow, third
        s[_CURRENT + i], s[_ADAPTED + i], s[_TAKEN + i] = current, adapted + nearer, taken * forget
        s[_PEAK + i] = max(s[_PEAK + i], now)
        s[_V + i] = v if finish else now
        s[_DRIVE + i] = drive
        s[_RARE + i] = 1.0 if finish else 0.0
        rare += 1 if finish else 0
    return rare


@njit(cache=True)
def _finish(
    units: Units, block: Integers, s: Array, t: float, h: float, spikes: Array, counts: Integers
) -> None:
    """End the step of lanes that fire or whose refractory time ends in it."""
    for i in range(len(block)):
        if s[_RARE + i] == 0.0:
            continue
        u, v, begin = block[i], s[_V + i], max(s[_FREE + i], t)
        part = s[_LEAK + i]
        if begin > t:
            part = -math.expm1((begin - t - h) / units.membrane[u])
        now = v + part * (s[_DRIVE + i] - v)
        s[_PEAK + i] = max(s[_PEAK + i], now)
        s[_V + i] = now
        if now < 1.0:
            continue
        fired = begin + (t + h - begin) * max(0.0, (1.0 - v) / max(now - v, 1e-300))
        if counts[i] < spikes.shape[1]:
            spikes[i, counts[i]] = fired
        counts[i] += 1
        s[_V + i], s[_FREE + i] = 0.0, fired + units.refractory[u]
        s[_TAKEN + i] += units.recovery[u]


@njit(cache=True)
def _refresh(units: Units, block: Integers, s: Array, h: float) -> None:
    """Compute the factors of steps of h s."""
    for i in range(len(block)):
        u = block[i]
        for mode in range(3):
            size, at = units.pole[u, mode] * h, mode * LANES + i
            s[_FADE + at] = math.exp(-size)
            s[_GROW + at] = (1.0 - s[_FADE + at]) / size
        s[_ADAPT + i] = -math.expm1(-h / units.adaptation[u])
        s[_FORGET + i] = math.exp(-h / units.recovering[u])
        s[_LEAK + i] = -math.expm1(-h / units.membrane[u])


@njit(cache=True)
def _draw(units: Units, block: Integers, s: Array, knot: int, last: int) -> None:
    """Draw the noise at a knot and the one after, of which a knot drawn last time is kept."""
    for i in range(len(block)):
        stream = units.stream[block[i]]
        s[_LEFT + i] = s[_RIGHT + i] if knot == last + 1 else normal(stream, knot)
        s[_RIGHT + i] = normal(stream, knot + 1)


@njit(cache=True)
def _load(units: Units, block: Integers, states: Array, s: Array) -> None:
    """Put parameters and states of the units of a block into its rows."""
    for i in range(len(block)):
        u = block[i]
        s[_GAIN + i], s[_NEGATIVE + i] = units.gain[u], units.negative[u]
        s[_AT_REST + i], s[_INVERSE + i] = units.at_rest[u], 1.0 / units.largest[u]
        s[_ADAPTING + i], s[_NOISE + i] = units.adapting[u], units.noise[u]
        for mode in range(3):
            s[_SHARE + mode * LANES + i] = units.share[u, mode]
        for k in range(PEAK + 1):
            s[_X + k * LANES + i] = states[u, k]


@njit(cache=True, nogil=True)
def run(
    units: Units,
    block: Integers,
    states: Array,
    time: Array,
    x: Array,
    longest: float,
    spikes: Array,
    counts: Integers,
    current: NDArray[np.floating],
) -> None:
    """Advance the units of a block, at most LANES, through a whole series by steps of one length.

    states (n_units, SIZE) at the start become those at the end; x (n_t, n_units) mm, the first row
    as in the states; longest: bound of the steps in s; spikes (n_block, room) s and counts
    (n_block,), larger than the room where it did not suffice; current (n_t, n_units): generator
    currents over threshold.
    """
    s = np.zeros(_END)
    # Lanes without a unit are never free to fire.
    s[_FREE : _FREE + LANES] = np.inf
    _load(units, block, states, s)
    size, knot = 0.0, int(NEVER)  # a constant itself would compile `_draw` once more
    for i in range(len(block)):
        current[0, block[i]] = s[_CURRENT + i]
    for k in range(1, len(time)):
        start, length = time[k - 1], time[k] - time[k - 1]
        steps = max(1, math.ceil(length / longest - 1e-9))
        h = length / steps
        if h > 0.0 and abs(size - h) > 1e-9 * h:
            _refresh(units, block, s, h)
            size = h
        for i in range(len(block)):
            change = x[k, block[i]] - s[_X + i]
            part = change / steps
            s[_MOVE + i] = part
            for at in range(i, 3 * LANES, LANES):
                s[_PUSH + at] = part * s[_GROW + at]
            if h == 0.0:
                _jump(s, i, change)
        if h > 0.0:
            for j in range(steps):
                t = start + j * h
                since = (t + 0.5 * h) * (1.0 / KNOTS)
                at = math.floor(since)
                if at != knot:
                    _draw(units, block, s, at, knot)
                    knot = at
                if _steps(s, t, h, since - knot):
                    _finish(units, block, s, t, h, spikes, counts)
        for i in range(len(block)):
            s[_X + i] = x[k, block[i]]
            current[k, block[i]] = s[_CURRENT + i]
    for i in range(len(block)):
        u = block[i]
        for k in range(PEAK + 1):
            states[u, k] = s[_X + k * LANES + i]
        states[u, PEAK] = min(1.0, states[u, PEAK])
        for k in range(min(counts[i], spikes.shape[1])):
            spikes[i, k] = displaced(units, u, states[u], spikes[i, k])


@njit(cache=True)
def _jump(s: Array, i: int, change: float) -> None:
    """Change the input of lane i by some mm at once."""
    for row in (_X, _MODE, _SLOW, _THIRD):
        s[row + i] += change
    y = s[_AT_REST + i] * s[_X + i] + s[_SHARE + i] * s[_MODE + i]
    y += s[_OTHER + i] * s[_SLOW + i] + s[_LESS + i] * s[_THIRD + i]
    s[_CURRENT + i] = generator(y, s[_GAIN + i], s[_NEGATIVE + i], s[_INVERSE + i])


def blocks_of(steps: Array) -> list[Integers]:
    """Units of each block: at most LANES, with one bound of the steps (n_units,)."""
    return [
        alike[first : first + LANES]
        for alike in (np.flatnonzero(steps == step) for step in np.unique(steps))
        for first in range(0, len(alike), LANES)
    ]


def fire(
    units: Units, states: Array, time: Array, x: Array, steps: Array
) -> tuple[list[Array], Array]:
    """Spike times of every unit in s, and generator currents (n_t, n_units) over threshold.

    An impulse whose delay from threshold leads beyond the end of the series is not in it.

    states (n_units, SIZE) at the start become those at the end; x (n_t, n_units) mm; steps
    (n_units,): bounds of the steps in s.
    """
    x = np.ascontiguousarray(x)
    current = np.empty(x.shape)
    room = int((time[-1] - time[0]) / float(units.refractory.min())) + 2

    def part(block: Integers) -> list[Array]:
        spikes, counts = np.empty((len(block), room)), np.zeros(len(block), np.int64)
        run(units, block, states, time, x, float(steps[block[0]]), spikes, counts, current)
        trains = [row[:count] for row, count in zip(spikes, counts, strict=True)]
        return [row[: np.searchsorted(row, time[-1], side="right")].copy() for row in trains]

    blocks = blocks_of(steps)
    times: list[Array] = [np.empty(0)] * len(steps)
    for block, trains in zip(blocks, together(part, blocks), strict=True):
        for i, each in zip(block, trains, strict=True):
            times[i] = each
    return times, current
