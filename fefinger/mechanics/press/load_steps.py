"""Few steps along a motion, and the way back from them to every time of the answer."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fefinger.scene.finger import Finger
from fefinger.scene.motion import Motion
from fefinger.theory.relaxation import Prony, creep_integral, hereditary_integral


Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]
Curve = Callable[[Array], Array]

STRIDES = 8  # steps to the peak of the motion, of equal ways
PACES = 16  # more of them, of equal times: tissue relaxes in slow corners and at turns
REST = 0.5  # a step of a rest, against the time that it has lasted
LEAST = 5  # in every piece; 3 miss 4 % of a vibration at 200 Hz
WRONG = 5e-3  # of the peak that a spring may be wrong by
ROOT = 1 / 3  # of the force that depth and area begin as: a spring linear in it sees neither
STILL = 1e-9  # path against the peak that counts as none


@dataclass(frozen=True)
class Stride:
    """The chosen steps among the times of the answer.

    time (n_t,) s and path (n_t,) the motion's value at all times; chosen (n,) the numbers of the
    steps; clock (n_t,) what the answer is smooth in between them: the steps that are due while the
    indenter moves, the logarithm of the time while it rests; seams: the numbers among the chosen
    where one piece ends.
    """

    time: Array
    path: Array
    chosen: Integers
    clock: Array
    seams: Integers

    @property
    def times(self) -> Array:
        """Times (n,) of the steps in s."""
        return self.time[self.chosen]

    @property
    def value(self) -> Array:
        """The motion's value (n,) at the steps."""
        return self.path[self.chosen]

    def until(self, count: int) -> "Stride":
        """Return the first `count` steps alone, and the times up to them."""
        last = int(self.chosen[count - 1]) + 1
        seams = np.append(self.seams[self.seams < count - 1], count - 1)
        chosen = self.chosen[:count]
        return Stride(self.time[:last], self.path[:last], chosen, self.clock[:last], seams)

    def smooth(self, values: Array) -> Array:
        """Interpolate (n, ...) to all times by splines with continuous second derivatives."""
        from scipy.interpolate import CubicSpline

        return self._pieces(values, lambda x, y: CubicSpline(x, y, axis=0))

    def bounded(self, values: Array) -> Array:
        """Interpolate (n, ...) to all times without overshoot, so that no force pulls."""
        from scipy.interpolate import PchipInterpolator

        return self._pieces(values, lambda x, y: PchipInterpolator(x, y, axis=0))

    def _pieces(self, values: Array, fit: Callable[[Array, Array], Curve]) -> Array:
        out = np.empty((len(self.time), *values.shape[1:]))
        for first, last in pairwise(self.seams):
            known = self.chosen[first : last + 1]
            piece = slice(known[0], known[-1] + 1)
            out[piece] = fit(self.clock[known], values[first : last + 1])(self.clock[piece])
        out[self.chosen] = values  # to the last bit: what is out of contact has no pressure at all
        return out


def stride(motion: Motion, time: Array, memories: Collection[Prony], refine: int = 1) -> Stride:
    """Choose steps of nearly equal ways, some * `refine` to the peak, and growing ones at rest.

    More of them where a spring that stiffens, and relaxes by any of the `memories` of the tissues,
    would be wrong by more than WRONG of its peak: where a motion changes its speed, above all.
    """
    steps = _even(motion, time, refine)
    for memory in memories:
        exact = _spring(memory, motion, time, steps.path)
        limit = WRONG / refine**2 * np.abs(exact).max(axis=0)
        while True:
            few = _spring(memory, motion, steps.times, steps.value)
            found = np.column_stack([steps.bounded(few[:, 0]), steps.smooth(few[:, 1])])
            more = _halves(steps, (np.abs(found - exact) > limit).any(axis=1))
            if not len(more):
                break
            steps = _with(steps, more, motion.breaks)
    return steps


def heaviest(motion: Motion, steps: Stride, memories: Collection[Prony]) -> set[int]:
    """Return the steps, by number, at which such a spring pushes most, or by force is deepest."""
    return {
        int(_spring(memory, motion, steps.times, steps.value)[:, 0].argmax()) for memory in memories
    }


def memories(finger: Finger) -> frozenset[Prony]:
    """Return how the tissues of a finger relax."""
    layers = (finger.skin, finger.subcutaneous)
    return frozenset(layer.prony or finger.prony for layer in layers)


def _even(motion: Motion, time: Array, refine: int) -> Stride:
    """Choose steps by the way and the time of every piece that rises, falls or rests.

    Even ways alone make the last step of a rounded ramp so long that its relaxation is 2 % of the
    peak force; two thirds of the steps are therefore even in time. The clock counts both alike: in
    the way alone, relaxation in a slow corner is a root, and splines miss it by 1 % of the peak.
    """
    path = np.asarray(motion.value(time), dtype=np.float64)
    rises = np.diff(path)
    still = np.abs(rises) <= STILL * motion.peak
    kind = np.where(still, 0, np.sign(rises)).astype(int)
    seams = np.concatenate([[0], np.flatnonzero(np.diff(kind)) + 1, [len(time) - 1]])
    way = np.concatenate([[0.0], np.cumsum(np.abs(rises))])
    clock = np.zeros_like(time)
    chosen = [np.zeros(1, dtype=np.int64)]
    for first, last in pairwise(seams):
        inside = np.arange(first, last + 1)
        if still[first]:
            passed = time[inside] - time[first]
            clock[inside] = clock[first] + np.log1p(passed / passed[1])
            marks = _growing(passed, REST / refine)
        else:
            gone = way[inside] - way[first]
            passed = time[inside] - time[first]
            due = STRIDES * gone + PACES * gone[-1] * passed / passed[-1]
            clock[inside] = clock[first] + due
            count = max(int(np.ceil(refine * due[-1] / motion.peak)), LEAST)
            even = np.linspace(0, due[-1], count + 1)[1:]
            marks = np.searchsorted(due, even * (1 - STILL))  # rounding makes no step late
        chosen.append(np.append(inside[np.minimum(marks, len(inside) - 1)], last))
    picked = np.unique(np.concatenate(chosen))
    return Stride(time, path, picked, clock, np.searchsorted(picked, seams))


def _spring(memory: Prony, motion: Motion, time: Array, path: Array) -> Array:
    """Return force and displacement (n_t, 2) of a spring that stiffens and relaxes, at times.

    Under force control: as the displacement of a soft spring, and of one as stiff as a contact.
    """
    x = np.maximum(path, 0.0) / motion.peak
    if motion.control == "force":
        crept = creep_integral(memory, time, x)
        return np.column_stack([crept, np.maximum(crept, 0.0) ** ROOT])
    return np.column_stack([hereditary_integral(memory, time, x**1.5 + x**3), x])


def _halves(steps: Stride, wrong: Flags) -> Integers:
    """Return times (numbers) that divide the strides in which something is `wrong` (n_t,).

    One is divided where the path bends most, or else in the middle of its clock; in place of one
    that has no time inside, the last before it that has.
    """
    chosen, found = steps.chosen, []
    strides = np.searchsorted(chosen, np.flatnonzero(wrong))
    divisible = np.flatnonzero(np.diff(chosen) > 1) + 1
    last = np.searchsorted(divisible, strides[strides > 0], side="right") - 1
    for stride in divisible[np.unique(last[last >= 0])]:
        inside = np.arange(chosen[stride - 1], chosen[stride] + 1)
        time, path, clock = steps.time[inside], steps.path[inside], steps.clock[inside]
        bend = np.abs(np.interp(time, time[[0, -1]], path[[0, -1]]) - path)
        middle = np.searchsorted(clock, (clock[0] + clock[-1]) / 2)
        at = bend.argmax() if bend.max() > STILL * np.abs(steps.path).max() else middle
        found.append(inside[np.clip(at, 1, len(inside) - 2)])
    return np.array(found, dtype=np.int64)


def _with(steps: Stride, more: Integers, breaks: Collection[float]) -> Stride:
    """Return the steps and `more` of them, with seams at those where the motion has a break."""
    chosen = np.union1d(steps.chosen, more)
    broken = more[np.isin(steps.time[more], np.array(breaks))]
    seams = np.union1d(steps.chosen[steps.seams], broken)
    return replace(steps, chosen=chosen, seams=np.searchsorted(chosen, seams))


def _growing(passed: Array, growth: float) -> Integers:
    """Return the numbers of times that each come `growth` times later than the one before."""
    marks, last = [], 0
    for number in range(1, len(passed)):
        if passed[number] - passed[last] >= growth * passed[last]:
            marks.append(number)
            last = number
    return np.array(marks, dtype=np.int64)
