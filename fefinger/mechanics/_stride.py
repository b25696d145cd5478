"""Few steps along a motion, and the way back from them to every time of the answer."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fefinger.motion import Motion


Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Curve = Callable[[Array], Array]

STRIDES = 8  # steps to the peak of the motion, of equal ways
PACES = 16  # more of them, of equal times: tissue relaxes in slow corners and at turns
REST = 0.5  # a step of a rest, against the time that it has lasted
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


def stride(motion: Motion, time: Array, refine: int = 1) -> Stride:
    """Choose steps of nearly equal ways, some * `refine` to the peak, and growing ones at rest.

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
            count = max(int(np.ceil(refine * due[-1] / motion.peak)), 3)
            even = np.linspace(0, due[-1], count + 1)[1:]
            marks = np.searchsorted(due, even * (1 - STILL))  # rounding makes no step late
        chosen.append(np.append(inside[np.minimum(marks, len(inside) - 1)], last))
    picked = np.unique(np.concatenate(chosen))
    return Stride(time, path, picked, clock, np.searchsorted(picked, seams))


def _growing(passed: Array, growth: float) -> Integers:
    """Return the numbers of times that each come `growth` times later than the one before."""
    marks, last = [], 0
    for number in range(1, len(passed)):
        if passed[number] - passed[last] >= growth * passed[last]:
            marks.append(number)
            last = number
    return np.array(marks, dtype=np.int64)
