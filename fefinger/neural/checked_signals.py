"""Checked units and input of a simulation of afferents, its sampling times and its notes."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.neural.membranes import Firing
from fefinger.neural.trains import Rerun, SpikeTrains
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice
from fefinger.support.checks import names as different
from fefinger.support.vocabulary import LONGEST_RUN, TYPE_SYNONYMS, TYPES


FAII_STEP, FAII_JUMP = 2e-4, 2.0
"""Step in s and jump in mm/s: a larger jump of velocity between samples further apart than the step
is noted for FAII, whose filter differentiates twice up to 100 Hz; 3.2 mm/s is the smallest jump
that fires it."""

MANY = 8
"""Number of units from which notes of one kind are merged into one sentence."""


@dataclass(frozen=True, kw_only=True)
class UnitInput:
    """Afferent units with the input of their end organs, checked.

    types, names (n_units,); columns: end organs of each unit; time (n_t,) s; organs (n_t, n_organs)
    mm, compression positive; delays (n_units,) s from a spike to its recording; positions
    (n_units, 3) and depths (n_units,) mm, or None; since: time in s from which spikes count.
    """

    types: tuple[str, ...]
    names: tuple[str, ...]
    columns: tuple[NDArray[np.intp], ...]
    time: Array
    organs: Array
    delays: Array
    positions: Array | None
    depths: Array | None
    since: float

    @classmethod
    def of(
        cls,
        time: ArrayLike,
        drive: ArrayLike,
        lengths: ArrayLike,
        types: Sequence[str],
        *,
        unit: ArrayLike | None = None,
        names: Sequence[str] | None = None,
        delays: ArrayLike = 0.0,
        positions: ArrayLike | None = None,
        depths: ArrayLike | None = None,
        since: float = -np.inf,
    ) -> Self:
        """Check the arguments of `simulate_units`; InputError for those that do not fit."""
        types = checked_types(types)
        n = len(types)
        columns = organ_columns(np.arange(n) if unit is None else unit, n)
        time, organs = checked_signals(time, drive, lengths, sum(map(len, columns)))
        return cls(
            types=types,
            names=unit_names(types, names),
            columns=columns,
            time=time,
            organs=organs,
            delays=unit_delays(delays, n),
            positions=unit_array("positions", positions, (n, 3)),
            depths=unit_array("depths", depths, (n,)),
            since=since,
        )

    def thinned(self, values: Array) -> tuple[Array, Array]:
        """Every second sample, and the last, of the time and of values (n_t, ...)."""
        some = np.unique(np.append(np.arange(0, len(self.time), 2), len(self.time) - 1))
        return self.time[some], values[some]

    def changes(
        self, times: Sequence[Array], other: Callable[[], Sequence[Array]], change: str
    ) -> tuple[tuple[str, ...], Rerun]:
        """Describe units whose spike count differs in another run, after a `change`; and count."""
        found = other()
        notes = count_changes(self.names, times, found, change, self.since - self.delays)
        return notes, self.rerun(found, change)

    def rerun(self, times: Sequence[Array], change: str) -> Rerun:
        """Count the spikes of another run, which left the end organs at `times`."""
        starts = np.broadcast_to(self.since - self.delays, (len(times),))
        counts = [np.count_nonzero(each >= t) for each, t in zip(times, starts, strict=True)]
        return Rerun(change, np.array(counts, np.int64))

    def trains(
        self,
        times: Sequence[Array],
        *,
        x_in: Array,
        notes: tuple[str, ...],
        reruns: Sequence[Rerun] = (),
        **fields: Any,
    ) -> SpikeTrains:
        """Spike trains of the units, recorded from `since` on, that left the end organs at `times`.

        reruns: other runs of them, whose counts bound theirs; fields: others of SpikeTrains;
        potentials and counts are 0 where they are not given.
        """
        recorded = (each + late for each, late in zip(times, self.delays, strict=True))
        zeros = np.zeros(len(self.types))
        absent = {"peak_mV": zeros, "block_seconds": zeros, "stimulus_driven": zeros.astype(int)}
        return SpikeTrains(
            types=self.types,
            names=self.names,
            times=tuple(each[each >= self.since] for each in recorded),
            t_start=max(float(self.time[0]), self.since),
            t_stop=float(self.time[-1] + self.delays.max()),
            time=self.time,
            x_in=x_in,
            delays=self.delays.copy(),
            positions=self.positions,
            depths=self.depths,
            notes=notes,
            **(absent | fields),
        ).beside(*reruns)


def checked_signals(
    time: ArrayLike, drive: ArrayLike, lengths: ArrayLike, n_units: int
) -> tuple[Array, Array]:
    """Check the signals; return time (n_t,) in s and x_in = drive * length (n_t, n_units) in mm."""
    time, drive = np.asarray(time, float), np.asarray(drive, float)
    if time.ndim != 1 or len(time) < 2 or drive.shape != (len(time), n_units):
        raise InputError(
            f"time, drive: expected (n_t,) and (n_t, {n_units}) for {n_units} units with two "
            f"samples or more, received {time.shape} and {drive.shape}"
        )
    mm = np.asarray(lengths, float)
    if mm.shape not in ((), (n_units,)):
        raise InputError(f"lengths: expected one number or {n_units} in mm, received {mm.shape}")
    x_in = drive * mm
    if not (np.isfinite(time).all() and np.isfinite(x_in).all()) or np.any(np.diff(time) < 0):
        raise InputError("time, drive: expected finite values and times in s that never decrease")
    if time[-1] - time[0] > LONGEST_RUN:
        raise InputError(
            f"time: expected at most {LONGEST_RUN:g} s in one run, received "
            f"{time[-1] - time[0]:g} s; are the times in another unit?"
        )
    return time, x_in


def checked_types(types: Sequence[str]) -> tuple[str, ...]:
    """Check that there are afferent types and that all are in TYPES."""
    if not len(types):
        raise InputError("types: expected one afferent unit or more, received none")
    return tuple(choice("types", kind, TYPES, TYPE_SYNONYMS) for kind in types)


def organ_columns(unit: ArrayLike, n_units: int) -> tuple[NDArray[np.intp], ...]:
    """Find the columns of each unit's end organs in the drive."""
    unit = np.asarray(unit)
    whole = unit.ndim == 1 and (np.issubdtype(unit.dtype, np.integer) or not unit.size)
    if not n_units or not whole or not np.array_equal(np.unique(unit), np.arange(n_units)):
        raise InputError(
            f"unit: expected the index of the unit for each end organ, with one or more for "
            f"each of {n_units} units; received {np.unique(unit).tolist()}"
        )
    order = np.argsort(unit, kind="stable")
    return tuple(np.split(order, np.searchsorted(unit[order], np.arange(1, n_units))))


def unit_delays(delays: ArrayLike, n_units: int) -> Array:
    """Check delays in s, one or (n_units,); return one for each unit."""
    later = np.asarray(delays, float)
    if later.shape not in ((), (n_units,)) or not np.all((later >= 0) & np.isfinite(later)):
        msg = f"delays: expected one or {n_units} times in s of 0 or more, received {later}"
        raise InputError(msg)
    return np.broadcast_to(later, (n_units,))


def unit_array(name: str, values: ArrayLike | None, shape: tuple[int, ...]) -> Array | None:
    """Check an optional array in mm with one row per unit; None stays None."""
    array = None if values is None else np.asarray(values, float)
    if array is not None and array.shape != shape:
        msg = f"{name}: expected {shape} mm for {shape[0]} units, received {array.shape}"
        raise InputError(msg)
    return array


def unit_names(types: tuple[str, ...], names: Sequence[str] | None = None) -> tuple[str, ...]:
    """Name the units: with the names given, or their types, numbered where they repeat.

    InputError for names that are not one per unit or not different.
    """
    if names is not None:
        names = different("names", names)
        if len(names) != len(types):
            msg = f"names: expected {len(types)} for {len(types)} units, received {len(names)}"
            raise InputError(msg)
        return names
    numbers = {kind: count(1) for kind in types}
    single = {kind for kind, number in Counter(types).items() if number == 1}
    return tuple(kind if kind in single else f"{kind}-{next(numbers[kind])}" for kind in types)


def dense_times(time: Array, steps: float | Array) -> Array:
    """Refine times: `time` and equal steps within each interval.

    steps: longest step in s, one or (n_t - 1,). A repeated time (a jump) becomes two times: the
    largest number below it and itself.
    """
    # 1e-9: rounding must not add a step to an interval that is a multiple of the step.
    count = np.ceil(np.diff(time) / steps - 1e-9).astype(int)
    k = np.repeat(np.arange(len(count)), count)
    j = np.arange(len(k)) - np.repeat(np.cumsum(count) - count, count)
    inside = time[k] + j * (np.diff(time) / np.maximum(count, 1))[k]
    jumps = time[:-1][np.diff(time) == 0]
    before = np.nextafter(jumps[jumps > time[0]], -np.inf)
    return np.unique(np.concatenate([inside, before, time[-1:]]))


def count_changes(
    names: Sequence[str],
    times: Sequence[Array],
    other: Sequence[Array],
    change: str,
    since: ArrayLike = -np.inf,
) -> tuple[str, ...]:
    """Describe units whose spike count differs between two runs; `change`: what the second changes.

    times, other: spike times of the units in s; since: time in s from which they count, one or
    (n_units,). More than MANY units share one note.
    """
    starts = np.broadcast_to(since, (len(names),))
    counts = [
        (int(np.sum(a >= start)), int(np.sum(b >= start)))
        for a, b, start in zip(times, other, starts, strict=True)
    ]
    off = [abs(b - a) for a, b in counts if a != b]
    if len(off) > MANY:
        return (
            f"{len(off)} of {len(names)} units change their spike count, by {max(off)} at most, "
            f"when {change}",
        )
    return tuple(
        f"{name}: the spike count changes from {a} to {b} when {change}"
        for name, (a, b) in zip(names, counts, strict=True)
        if a != b
    )


def remarks(names: tuple[str, ...], firing: Firing) -> tuple[str, ...]:
    """Describe depolarization block and stimulus-driven crossings."""
    blocked = [
        f"{name}: in depolarization block for {seconds:.3g} s"
        for name, seconds in zip(names, firing.block_seconds, strict=True)
        if seconds > 0
    ]
    driven = [
        f"{name}: crossings of 40 mV that also occur with sodium activation frozen: {crossings} "
        f"(spikes: {len(times)}); these are driven by the current, not by the membrane"
        for name, crossings, times in zip(names, firing.stimulus_driven, firing.times, strict=True)
        if crossings > 0
    ]
    return (*_few(blocked), *_few(driven))


def coarse_remarks(units: UnitInput, x_in: Array) -> list[str]:
    """Describe units of FAII whose input (n_t, n_units) in mm is sampled too coarsely."""
    jumps = [
        coarse_jump(units.time, x_in[:, i], FAII_STEP) if kind == "FAII" else 0.0
        for i, kind in enumerate(units.types)
    ]
    coarse = [
        f"{name}: the velocity of its input jumps by {jump:.3g} mm/s at samples more "
        f"than {1e3 * FAII_STEP:g} ms apart; a second derivative treats them as sharp "
        "corners; sample the motion more finely, unless it has these corners"
        for name, jump in zip(units.names, jumps, strict=True)
        if jump > FAII_JUMP
    ]
    return _few(coarse)


def _few(sentences: list[str]) -> list[str]:
    """Shorten more than MANY sentences to the first one and the number of units."""
    if len(sentences) <= MANY:
        return sentences
    return [f"{sentences[0]} (this or similar for {len(sentences)} units)"]


def coarse_jump(time: Array, x: Array, longest: float) -> float:
    """Largest jump of velocity in mm/s next to an interval longer than `longest` s."""
    moving = np.diff(time) > 0
    step, change = np.diff(time)[moving], np.diff(x)[moving]
    coarse = np.maximum(step[1:], step[:-1]) > longest * (1 + 1e-6)
    return float(np.abs(np.diff(change / step))[coarse].max(initial=0.0))
