"""The load steps of a motion, and interpolation from them to every time of the answer.

An example: a plate goes to 1 mm in 0.1 s, rests for 1 s, and is lifted in 0.1 s. The motion has
three pieces (rise, rest, fall) and four seams: its start, the two turns, and its end. In the rise
24 steps are due, BY_DISTANCE of them by the distance gone and BY_TIME by the time passed. Their
number grows from 0 to 24, and is the coordinate: a step is taken wherever it reaches a whole
number. In the rest the coordinate goes on with the logarithm of the time since the turn, and each
step comes half again as long after the turn as the one before; in the fall 24 more are due. The
answer is interpolated in the coordinate, from seam to seam: it may have corners where the motion
has.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from itertools import count, pairwise

import numpy as np

from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.motion import Motion
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.theory.relaxation import Prony, creep_integral, hereditary_integral


Curve = Callable[[Array], Array]

BY_DISTANCE = 8  # steps to the peak of the motion, of equal distances
BY_TIME = 16  # more of them, of equal times: tissue relaxes in slow corners and at turns
SPRING_ERROR = 5e-3  # of the peak, by which a spring may be wrong between its steps
PATIENCE = 8  # times that steps are divided where a spring is wrong; motions of scenes take four
NEARLY = 0.8  # wrong by this part, they are divided too from then on: else a cycle after the other
ONSET = 1.5  # path to gross slip over friction and depth, of incompressible bodies (Mindlin)
STRIDE = 0.25  # mm between steps, where an object that is no plate slides
PER_FEATURE = 4  # steps over its narrowest part
STILL = 1e-9  # path against the peak that counts as none


@dataclass(frozen=True)
class LoadSteps:
    """The load steps among the times of the answer.

    time (n_t,) s and path (n_t,) the motion's value at all times; chosen (n,) the numbers of the
    steps; coordinate (n_t,) that the answer is interpolated in: the steps that are due while the
    indenter moves, the logarithm of the time while it rests; seams: the numbers among the chosen
    where a piece of the motion, which rises, falls or rests, ends.
    """

    time: Array
    path: Array
    chosen: Integers
    coordinate: Array
    seams: Integers

    @property
    def times(self) -> Array:
        """Times (n,) of the steps in s."""
        return self.time[self.chosen]

    @property
    def value(self) -> Array:
        """The motion's value (n,) at the steps."""
        return self.path[self.chosen]

    def until(self, count: int) -> "LoadSteps":
        """Return the first `count` steps alone, and the times up to them."""
        last = int(self.chosen[count - 1]) + 1
        seams = np.append(self.seams[self.seams < count - 1], count - 1)
        chosen = self.chosen[:count]
        coordinate = self.coordinate[:last]
        return LoadSteps(self.time[:last], self.path[:last], chosen, coordinate, seams)

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
            steps = self.chosen[first : last + 1]
            if steps[-1] - steps[0] == last - first:
                continue  # every time of the piece is a step, as of most pieces between samples
            piece = slice(steps[0], steps[-1] + 1)
            curve = fit(self.coordinate[steps], values[first : last + 1])
            out[piece] = curve(self.coordinate[piece])
        out[self.chosen] = values  # to the last bit: what is out of contact has no pressure at all
        return out


def load_steps(
    motion: Motion,
    time: Array,
    relaxations: Collection[Prony],
    refine: int = 1,
    *,
    friction: float = 0.0,
    depth: float = np.inf,
    stride: float = np.inf,
) -> LoadSteps:
    """Choose steps of nearly equal distances, divided by `refine`, and growing ones at rest.

    Along a path, a coefficient of `friction` that builds up or turns round counts as that part of a
    press to `depth` mm, and every `stride` mm takes a step.

    More of them where a spring that stiffens, and relaxes by any of the `relaxations` of the
    tissues, would be wrong by more than SPRING_ERROR of its peak: where a motion changes its speed,
    above all.
    """
    along = np.zeros(len(time) - 1)
    if motion.slides:
        path = motion.shift(time)
        along = np.linalg.norm(np.diff(path, axis=0), axis=1) / stride / (BY_DISTANCE + BY_TIME)
        if friction > 0:
            along += friction * _built_up(path / (ONSET * friction * depth))
    steps = _even(motion, time, refine, along)
    for prony in relaxations:
        exact = _spring(prony, motion, time, steps.path)
        limit = SPRING_ERROR / refine**2 * np.abs(exact).max(axis=0)
        for tried in count():
            few = _spring(prony, motion, steps.times, steps.value)
            spring = np.column_stack([steps.bounded(few[:, 0]), steps.smooth(few[:, 1])])
            off = (np.abs(spring - exact) / limit).max(axis=1)
            more = _halves(steps, off > (1.0 if tried < PATIENCE else NEARLY))
            if off.max() <= 1.0 or not len(more):
                break
            steps = _with(steps, more, motion.breakpoints)
    return steps


def peak_steps(motion: Motion, steps: LoadSteps, relaxations: Collection[Prony]) -> set[int]:
    """Return the numbers of the steps with the largest force, or under force control depth."""
    return {
        int(_spring(prony, motion, steps.times, steps.value)[:, 0].argmax())
        for prony in relaxations
    }


def tissue_relaxations(finger: Finger) -> frozenset[Prony]:
    """Return the different Prony series of the soft tissues of a finger."""
    layers = (finger.skin, finger.subcutaneous)
    return frozenset(layer.prony or finger.prony for layer in layers)


def stride_of(indenter: Indenter) -> float:
    """Return the distance in mm between steps on a path of an object, by its narrowest part."""
    if indenter.flat is not None:
        return float("inf")
    return min(STRIDE, indenter.feature / PER_FEATURE)


def _built_up(path: Array) -> Array:
    """Return by how much (n_t - 1,) friction changes along a path (n_t, 2), 1 being its largest.

    As where a spring that the path draws slips the more the nearer it is to its bound; the path is
    over the length within which it comes near.
    """
    drawn, changes = np.zeros(2), []
    for moved in np.diff(path, axis=0):
        far = float(np.hypot(*moved))
        changed = (moved / far - drawn) * -np.expm1(-far) if far > 0 else moved
        drawn = drawn + changed
        changes.append(float(np.hypot(*changed)))
    return np.array(changes)


def _even(motion: Motion, time: Array, refine: int, along: Array) -> LoadSteps:
    """Choose steps by the distance and the time of every piece that rises, falls or rests.

    Even distances alone make the last step of a rounded ramp so long that its relaxation is 2 % of
    the peak force; two thirds of the steps are therefore even in time. The coordinate counts both
    alike: in the distance alone, relaxation in a slow corner is a root, and splines miss it by 1 %
    of the peak. along (n_t - 1,): what the path counts as, beside the peak.
    """
    path = np.asarray(motion.value(time), dtype=np.float64)
    rises, along = np.diff(path), np.where(along > STILL, along, 0.0)
    still = (np.abs(rises) <= STILL * motion.peak) & (along == 0)
    kind = np.where(still, 0, np.sign(rises) + 3 * (along > 0)).astype(int)
    seams = np.concatenate([[0], np.flatnonzero(np.diff(kind)) + 1, [len(time) - 1]])
    distance = np.concatenate([[0.0], np.cumsum(np.abs(rises) + along * motion.peak)])
    coordinate = np.zeros_like(time)
    chosen = [np.zeros(1, dtype=np.int64)]
    rest = 0.5  # a step of a rest, against the time that it has lasted
    least = 5  # in every piece; 3 miss 4 % of a vibration at 200 Hz
    for first, last in pairwise(seams):
        inside = np.arange(first, last + 1)
        if still[first]:
            passed = time[inside] - time[first]
            coordinate[inside] = coordinate[first] + np.log1p(passed / passed[1])
            marks = _growing(passed, rest / refine)
        else:
            gone = distance[inside] - distance[first]
            passed = time[inside] - time[first]
            due = BY_DISTANCE * gone + BY_TIME * gone[-1] * passed / passed[-1]
            coordinate[inside] = coordinate[first] + due / motion.peak  # else a tiny one is lost
            count = max(int(np.ceil(refine * due[-1] / motion.peak)), least)
            even = np.linspace(0, due[-1], count + 1)[1:]
            marks = np.searchsorted(due, even * (1 - STILL))  # rounding makes no step late
        chosen.append(np.append(inside[np.minimum(marks, len(inside) - 1)], last))
    picked = np.unique(np.concatenate(chosen))
    return LoadSteps(time, path, picked, coordinate, np.searchsorted(picked, seams))


def _spring(prony: Prony, motion: Motion, time: Array, path: Array) -> Array:
    """Return force and displacement (n_t, 2) of a spring that stiffens and relaxes, at times.

    Under force control: as the displacement of a soft spring, and of one as stiff as a contact.
    """
    x = np.maximum(path, 0.0) / motion.peak
    if motion.by_force:
        depth = creep_integral(prony, time, x)
        # Of the force that depth and area begin as: a spring linear in it sees neither.
        root = 1 / 3
        return np.column_stack([depth, np.maximum(depth, 0.0) ** root])
    return np.column_stack([hereditary_integral(prony, time, x**1.5 + x**3), x])


def _halves(steps: LoadSteps, wrong: Flags) -> Integers:
    """Return times (numbers) that divide the steps in which something is `wrong` (n_t,).

    One is divided where the path bends most, or else in the middle of its coordinate; in place of
    one that has no time inside, the last before it that has.
    """
    chosen, halves = steps.chosen, []
    ends = np.searchsorted(chosen, np.flatnonzero(wrong))
    divisible = np.flatnonzero(np.diff(chosen) > 1) + 1
    last = np.searchsorted(divisible, ends[ends > 0], side="right") - 1
    for end in divisible[np.unique(last[last >= 0])]:
        inside = np.arange(chosen[end - 1], chosen[end] + 1)
        time, path = steps.time[inside], steps.path[inside]
        coordinate = steps.coordinate[inside]
        bend = np.abs(np.interp(time, time[[0, -1]], path[[0, -1]]) - path)
        middle = np.searchsorted(coordinate, (coordinate[0] + coordinate[-1]) / 2)
        at = bend.argmax() if bend.max() > STILL * np.abs(steps.path).max() else middle
        halves.append(inside[np.clip(at, 1, len(inside) - 2)])
    return np.array(halves, dtype=np.int64)


def _with(steps: LoadSteps, more: Integers, breaks: Collection[float]) -> LoadSteps:
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
