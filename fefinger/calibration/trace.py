"""A record reduced to averages: force, path of the indenter, and the covariance of both."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from fefinger.support.arrays import Array, Integers
from fefinger.theory.lumped.ramp_hold import RampHold, group_starts


REST, APPROACH, NEAR, RAMP = 20, 20, 80, 200
"""Largest numbers of averages: in the rest, in the approach, before touch, and on the ramp."""

WINDOWS = (1, 2, 4, 8, 16)
"""Parts of a stretch over which its path may be a line or a cubic, the longest first."""

FEWEST = 5
"""Fewest averages that a line or a cubic goes through."""

AT = 1e-6
"""Time in s from the corner to the nodes before and after it."""

FADING, FINEST = 0.07, 2e-5
"""Largest step between nodes after the corner, over the time since it, and one in s that is short
enough: the fast relaxation of a force is then met within 3e-4 of it."""

WHOLE = 32
"""Samples of a group up to which its average is that of the model at all of them: a corner of the
force, which a delay puts into a group, bends it there."""

NEIGHBORS = (1, 3, 9, 27)  # distances that are summed: a path that is off may be so for long


SURE = 4.0
"""Standard deviations of the position from the level of a hold that are certainly off it."""


@dataclass(frozen=True)
class Trace:
    """Averages (n,) over groups of samples, and the path of the indenter through nodes (m,).

    time s, force N, size: samples of a group; path (k,) mm: smoothed positions away from the
    corner, and spread (k, k) mm²: their covariance; node_time s; to_nodes (m, k): the path at the
    nodes; sampled s: times at which a force is taken for an average, from `begin` (n,) on.
    """

    time: Array
    force: Array
    size: Array
    path: Array
    spread: Array
    node_time: Array
    to_nodes: Array
    sampled: Array
    begin: Integers

    @cached_property
    def node_position(self) -> Array:
        """The path (m,) mm at the nodes."""
        return np.asarray(self.to_nodes @ self.path)

    def averaged(self, sampled: Array) -> Array:
        """Return the averages (n,) or (n, l) of values (k,) or (k, l) at the sampled times."""
        size = np.diff(np.append(self.begin, len(sampled))).astype(float)
        sums = np.add.reduceat(sampled, self.begin)
        return np.asarray(sums / size.reshape(-1, *[1] * (sampled.ndim - 1)))

    @cached_property
    def position(self) -> Array:
        """The path (n,) mm at the times of the averages."""
        return np.interp(self.time, self.node_time, self.node_position)


def trace(record: RampHold, force: Array, position_noise: float) -> Trace:
    """Reduce a record with forces (n_t,) N; position_noise mm of one sample.

    The path is smoothed as much as its noise hides, apart in the rest before, the ramp and the
    hold: noise of the position would otherwise act on the model's force as if the finger had felt
    it. It meets the corner where what is before it and what is after it, continued, meet.
    """
    begun = _begun(record.position[: record.hold], position_noise)
    # Travel in mm before certain contact that counts as near: the first contact bends the force,
    # whose average is then not the one at the average depth.
    about = 1.0
    near = np.flatnonzero(record.position[: record.touch] < record.position[record.touch] - about)
    close = max(int(near[-1]) + 1 if near.size else 0, begun)
    parts = ((0, REST), (begun, APPROACH), (close, NEAR), (max(record.touch, close), RAMP))
    starts = np.array(group_starts(record, parts))
    size = np.diff([*starts, len(record.time)]).astype(float)
    time, position, force = (
        np.add.reduceat(values, starts) / size for values in (record.time, record.position, force)
    )
    sd = max(position_noise, 1e-9) / np.sqrt(size)
    away = _unsure(record, position_noise)
    stretches = (
        starts + size <= begun,
        (starts >= begun) & (starts + size <= record.hold - away),
        starts >= record.hold + away,
    )
    used = np.concatenate([np.flatnonzero(part) for part in stretches])
    ends = np.cumsum([0, *(int(part.sum()) for part in stretches)]).tolist()
    smoother = np.zeros((len(used), len(used)))
    # Averages of the hold get longer with the time since its start, so their number is even in it.
    at = np.where(starts >= record.hold, np.arange(len(starts)), time)[used]
    for part in (slice(*each) for each in pairwise(ends)):
        smoother[part, part] = smoothing(at[part], position[used][part], sd[used][part])
    path = smoother @ position[used]
    spread = (smoother * sd[used] ** 2) @ smoother.T
    node_time, to_nodes = _nodes(time[used], path, ends[2])
    sampled, begin = _sampled(record.time, starts, time)
    return Trace(time, force, size, path, spread, node_time, to_nodes, sampled, begin)


def _sampled(time: Array, starts: Integers, middle: Array) -> tuple[Array, Integers]:
    """Return times of all samples of small groups and the middle of others, and where groups begin.

    time (n_t,) s of samples; starts, middle (n,): first samples and mean times of groups.
    """
    groups = np.split(time, starts[1:])
    kept = [each if len(each) <= WHOLE else middle[i : i + 1] for i, each in enumerate(groups)]
    begin = np.cumsum([0, *map(len, kept[:-1])])
    return np.concatenate(kept), begin


def _begun(position: Array, noise: float) -> int:
    """Return the first sample of a motion that is certainly not at the rest before it, or 0."""
    tolerance = max(SURE * noise, 1e-3 * float(np.ptp(position)))
    level = float(np.median(position[: max(FEWEST, len(position) // WINDOWS[-1])]))
    still = np.flatnonzero(np.abs(position - level) <= tolerance)
    begun = int(still[-1]) + 1 if still.size else 0
    return begun if begun >= FEWEST else 0


def _unsure(record: RampHold, noise: float) -> int:
    """Return the number of samples about the corner that noise may put on the wrong side of it."""
    most = 10  # most samples before and after the corner that are left out of the path there
    ramp = slice(max(record.touch, record.hold - 4 * most), record.hold)
    step = float(np.median(np.abs(np.diff(record.position[ramp])))) if record.hold > 2 else 0.0
    return min(1 + math.ceil(SURE * noise / max(step, 1e-9)), most)


def smoothing(at: Array, values: Array, sd: Array) -> Array:
    """Return the strongest smoother (n, n) of values (n,) that leaves them within noise sd (n,).

    at (n,): abscissas, in which the values are a level, or nearly lines or cubics for a while.
    """
    count = len(values)
    tried = [(count, 0), *((count // part, degree) for part in WINDOWS for degree in (1, 3))]
    for points, degree in [*tried, (9, 1), (9, 3), (FEWEST, 3)]:
        if max(FEWEST, degree + 2) <= points <= count:
            smoother = _local(at, 1 / sd**2, points, degree)
            if _is_noise((smoother @ values - values) / sd):
                return smoother
    return np.eye(count)


def _local(at: Array, weights: Array, points: int, degree: int) -> Array:
    """Return the smoother (n, n) by polynomials through the nearest points of each."""
    count = len(at)
    smoother = np.zeros((count, count))
    powers = np.arange(degree + 1)
    whole = None
    for i in range(count):
        first = min(max(i - points // 2, 0), count - points)
        near = slice(first, first + points)
        if whole is None or points < count:
            middle, scale = at[near].mean(), max(float(np.ptp(at[near])), 1e-30)
            design = ((at[near] - middle)[:, None] / scale) ** powers
            root = np.sqrt(weights[near])
            whole = np.linalg.pinv(root[:, None] * design) * root
        smoother[i, near] = ((at[i] - middle) / scale) ** powers @ whole
    return smoother


def _is_noise(off: Array) -> bool:
    """Whether distances (n,) from a path, over their noise, are noise alone."""
    # Standard deviations that no average, nor a sum of neighbors, is off a path by noise alone.
    stray = 4.5
    for width in NEIGHBORS:
        if width <= len(off):
            sums = np.convolve(off, np.ones(width), "valid") / np.sqrt(width)
            if np.abs(sums).max() > stray:
                return False
    return True


def _nodes(time: Array, path: Array, corner: int) -> tuple[Array, Array]:
    """Return times (m,) of the nodes, and the path there by that at `time`: (m, k).

    corner: the first of `time` (k,) that is in the hold.
    """
    knots, rows = time, np.eye(len(time))
    met = _corner(time, path, corner)
    if met is not None:
        at, ends = met
        held = np.arange(len(time)) >= corner
        before, after = ~held & (time < at - AT), held & (time > at + AT)
        knots = np.concatenate([time[before], [at - AT, at + AT], time[after]])
        rows = np.concatenate([rows[before], ends, rows[after]])
    # Largest step in mm of depth between nodes of the model: its force then bends by 1e-4.
    steps = np.abs(np.diff(rows @ path)) / 0.02
    if met is not None:
        since = np.maximum(knots[:-1] - met[0], 0)
        fades = np.diff(knots) / np.maximum(FADING * since, FINEST)
        steps = np.where(knots[:-1] > met[0], np.maximum(steps, fades), steps)
    counts = np.maximum(np.ceil(steps), 1).astype(int)
    left = np.repeat(np.arange(len(counts)), counts)
    ahead = np.concatenate([np.arange(count) / count for count in counts.tolist()])
    left, ahead = np.append(left, len(counts) - 1), np.append(ahead, 1.0)
    ahead_of = ahead[:, None]
    to_nodes = (1 - ahead_of) * rows[left] + ahead_of * rows[left + 1]
    return (1 - ahead) * knots[left] + ahead * knots[left + 1], to_nodes


def _corner(time: Array, path: Array, corner: int) -> tuple[float, Array] | None:
    """Return the time of the corner, and the path (2, k) before and after it by that at `time`.

    None where the path does not lead there. What the path errs by differs on its sides.
    """
    last = corner - 1
    first = max(last - max(2, last // WINDOWS[-1]), 0)
    if first == last:
        return None
    speed = (path[last] - path[first]) / (time[last] - time[first])
    ahead = (path[corner] - path[last]) / speed if speed else 0.0
    # Noise may have put the first of the hold before the corner.
    if not AT < ahead < 2 * (time[corner] - time[last]):
        return None
    further = ahead / (time[last] - time[first])
    rows = np.zeros((2, len(time)))
    rows[0, [first, last]] = -further, 1 + further
    rows[1, corner] = 1.0
    return float(time[last] + ahead), rows
