"""Afferent units: skin displacement or strain at end organs in, spike trains out."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.checks import InputError, choice, number
from fefinger.neural.drives import DEFAULT_DRIVE, DRIVES
from fefinger.neural.endorgans import TYPES
from fefinger.neural.gains import GAINS
from fefinger.neural.generators import GENERATORS, transduce
from fefinger.neural.membranes import LARGEST_STEP, Firing, HodgkinHuxley
from fefinger.neural.trains import SpikeTrains


Array = NDArray[np.float64]

FAII_STEP, FAII_JUMP = 2e-4, 2.0
"""s and mm/s: a jump of velocity between samples further apart than the step is noted for FAII,
whose filter differentiates twice up to 100 Hz; 3.2 mm/s is the smallest jump that fires it."""

SMALLEST_REFERENCE = 0.02
"""Reference drive over the norm of the reference strain: below it the length L is noise."""


def simulate(
    time: ArrayLike,
    drive: ArrayLike,
    *,
    types: Sequence[str],
    lengths: ArrayLike = 1.0,
    generator: str = "saturating",
    membrane: HodgkinHuxley | None = None,
    names: Sequence[str] | None = None,
    positions: ArrayLike | None = None,
    dt: float = LARGEST_STEP,
    check: bool = True,
) -> SpikeTrains:
    """Return the spikes of afferent units from the drives of their end organs.

    x_in = length * drive, end-organ filter, half-wave rectification, generator, membrane. The
    drive is linear between its samples; everything behind it is evaluated every `dt` or less, so
    the sampling may be as uneven as the signal allows.

    Parameters
    ----------
    time
        (n_t,) s, not decreasing; a repeated time is a jump. The drive is zero before `time[0]`.
    drive
        (n_t, n_units), dimensionless; or mm of skin displacement with the default length 1.
    types
        Afferent type of each unit.
    lengths
        (n_units,) or one number: mm of skin displacement that a unit of drive stands for.
    generator
        "saturating" or "linear".
    membrane
        Default HodgkinHuxley() with rates / 6.
    names, positions
        Names of the units (default: types, numbered where they repeat) and (n_units, 3) mm.
    dt
        Longest integration step in s.
    check
        Count again with half the step and with half of the samples; differences become notes.

    Raises
    ------
    InputError
        Arrays that do not fit, unknown names, values that are not finite, times that decrease.
    """
    types = tuple(choice("types", kind, TYPES) for kind in types)
    choice("generator", generator, GENERATORS)
    time, x_in = checked_signals(time, drive, lengths, len(types))
    membrane = membrane or HodgkinHuxley()
    names = unit_names(types) if names is None else tuple(names)
    if len(names) != len(types):
        msg = f"names: expected {len(types)} for {len(types)} units, received {len(names)}"
        raise InputError(msg)
    firing = _fire(time, x_in, types, generator, membrane, dt, driven=True)
    notes = remarks(time, x_in, types, names, firing)
    if check:
        thin = np.unique(np.append(np.arange(0, len(time), 2), len(time) - 1))
        half = _fire(time, x_in, types, generator, membrane, dt / 2, driven=False)
        coarse = _fire(time[thin], x_in[thin], types, generator, membrane, dt, driven=False)
        notes += count_changes(names, firing, half, "the step of the membrane is halved")
        notes += count_changes(names, firing, coarse, "only every second sample is used")
    return SpikeTrains(
        types=types,
        names=names,
        times=firing.times,
        t_start=float(time[0]),
        t_stop=float(time[-1]),
        time=time,
        x_in=x_in,
        current=_currents(time, x_in, types, generator),
        peak_mV=firing.peak_mV,
        block_seconds=firing.block_seconds,
        stimulus_driven=firing.stimulus_driven,
        positions=None if positions is None else np.asarray(positions, float),
        notes=notes,
    )


def from_strain(
    time: ArrayLike,
    strain: ArrayLike,
    normals: ArrayLike,
    types: Sequence[str],
    *,
    reference_depth: float,
    reference_types: Sequence[str],
    reference_strain: ArrayLike,
    reference_normals: ArrayLike,
    drives: Mapping[str, str] | None = None,
    generator: str = "saturating",
    names: Sequence[str] | None = None,
    positions: ArrayLike | None = None,
    dt: float = LARGEST_STEP,
    check: bool = True,
) -> SpikeTrains:
    """Return the spikes of afferent units from the strain at their end organs.

    Parameters
    ----------
    time, strain, normals, types
        (n_t,) s; (n_t, n_units, 3, 3); unit normals (n_units, 3); afferent type of each unit.
    reference_depth, reference_types, reference_strain, reference_normals
        A small flat press of the same finger: depth in mm and, for each of the n types, strain
        (n, 3, 3) and normal (n, 3) at the central site. The length of a type is the depth over its
        drive there, so that a flat probe gives the one-dimensional case of the thesis.
    drives
        Drive per type, where it is not DEFAULT_DRIVE.
    generator, names, positions, dt, check
        As in `simulate`.

    Raises
    ------
    InputError
        As `simulate`; also a type without a reference, or one whose reference drive is not clearly
        above zero.
    """
    x_in = displacements(
        strain,
        normals,
        types,
        reference_depth=reference_depth,
        reference_types=reference_types,
        reference_strain=reference_strain,
        reference_normals=reference_normals,
        drives=drives,
    )
    return simulate(
        time,
        x_in,
        types=types,
        generator=generator,
        names=names,
        positions=positions,
        dt=dt,
        check=check,
    )


def displacements(
    strain: ArrayLike,
    normals: ArrayLike,
    types: Sequence[str],
    *,
    reference_depth: float,
    reference_types: Sequence[str],
    reference_strain: ArrayLike,
    reference_normals: ArrayLike,
    drives: Mapping[str, str] | None = None,
) -> Array:
    """Return the skin displacement x_in (n_t, n_sites) in mm that strain at end organs stands for.

    The drive of each site's type times its length; parameters and errors as in `from_strain`, with
    sites, one per end organ, for units.
    """
    types = tuple(choice("types", kind, TYPES) for kind in types)
    chosen = {**DEFAULT_DRIVE, **(drives or {})}
    for kind, name in chosen.items():
        choice("drives", kind, TYPES)
        choice(f"drives.{kind}", name, DRIVES)
    strain, normals = np.asarray(strain, float), np.asarray(normals, float)
    n = len(types)
    if strain.ndim != 4 or strain.shape[1:] != (n, 3, 3) or normals.shape != (n, 3):
        msg = (
            f"strain, normals: expected (n_t, {n}, 3, 3) and ({n}, 3) for {n} sites, received "
            f"{strain.shape} and {normals.shape}"
        )
        raise InputError(msg)
    if not np.isfinite(strain).all():
        msg = "strain: expected finite values"
        raise InputError(msg)
    lengths = _lengths(
        {kind: chosen[kind] for kind in types},
        reference_depth,
        tuple(reference_types),
        np.asarray(reference_strain, float),
        np.asarray(reference_normals, float),
    )
    x_in = np.empty(strain.shape[:2])
    for kind, length in lengths.items():
        of_kind = np.array([other == kind for other in types])
        x_in[:, of_kind] = length * DRIVES[chosen[kind]](strain[:, of_kind], normals[of_kind])
    return x_in


def count_changes(
    names: Sequence[str], firing: Firing | SpikeTrains, other: Firing | SpikeTrains, change: str
) -> tuple[str, ...]:
    """Return a sentence per unit whose spike count is another when `change`; empty: all survive."""
    return tuple(
        f"{name}: the spike count goes from {len(a)} to {len(b)} when {change}"
        for name, a, b in zip(names, firing.times, other.times, strict=True)
        if len(a) != len(b)
    )


def _lengths(
    drives: Mapping[str, str], depth: float, types: tuple[str, ...], strain: Array, normals: Array
) -> dict[str, float]:
    """Return the length L in mm per type: reference depth over reference drive."""
    depth, n = number("reference_depth", depth, above=0.0, unit="mm"), len(types)
    if strain.shape != (n, 3, 3) or normals.shape != (n, 3):
        msg = (
            f"reference_strain, reference_normals: expected ({n}, 3, 3) and ({n}, 3) for {n} "
            f"types, received {strain.shape} and {normals.shape}"
        )
        raise InputError(msg)
    lengths = {}
    for kind, name in drives.items():
        if kind not in types:
            msg = f"reference_types: expected every type that is asked, {kind} is missing"
            raise InputError(msg)
        i = types.index(kind)
        value = float(DRIVES[name](strain[i : i + 1], normals[i : i + 1])[0])
        norm = float(np.linalg.norm(strain[i]))
        if not value > SMALLEST_REFERENCE * norm:
            msg = (
                f"drives.{kind}: the drive {name!r} is {value:.3g} at the site of {kind} in the "
                f"reference press of {depth:g} mm, against a strain of {norm:.3g}; expected it "
                "clearly above zero; choose another drive or another depth of the site"
            )
            raise InputError(msg)
        lengths[kind] = depth / value
    return lengths


def checked_signals(
    time: ArrayLike, drive: ArrayLike, lengths: ArrayLike, n_units: int
) -> tuple[Array, Array]:
    """Return the checked time (n_t,) and x_in (n_t, n_units)."""
    time, drive = np.asarray(time, float), np.asarray(drive, float)
    if not n_units:
        msg = "types: expected one afferent unit or more, received none"
        raise InputError(msg)
    if time.ndim != 1 or len(time) < 2 or drive.shape != (len(time), n_units):
        msg = (
            f"time, drive: expected (n_t,) and (n_t, {n_units}) for {n_units} units with two "
            f"samples or more, received {time.shape} and {drive.shape}"
        )
        raise InputError(msg)
    x_in = drive * np.broadcast_to(np.asarray(lengths, float), (n_units,))
    if not (np.isfinite(time).all() and np.isfinite(x_in).all()) or np.any(np.diff(time) < 0):
        msg = "time, drive: expected finite values and times in s that never decrease"
        raise InputError(msg)
    return time, x_in


def unit_names(types: tuple[str, ...]) -> tuple[str, ...]:
    """Return types as names, numbered where a type repeats."""
    seen = [types[: i + 1].count(kind) for i, kind in enumerate(types)]
    return tuple(
        kind if types.count(kind) == 1 else f"{kind}-{n}"
        for kind, n in zip(types, seen, strict=True)
    )


def dense_times(time: Array, dt: float) -> Array:
    """Return times that contain `time` and divide each interval evenly into steps of at most dt."""
    steps = np.ceil(np.diff(time) / dt - 1e-9).astype(int)
    k = np.repeat(np.arange(len(steps)), steps)
    j = np.arange(len(k)) - np.repeat(np.cumsum(steps) - steps, steps)
    inside = time[k] + j * (np.diff(time) / np.maximum(steps, 1))[k]
    return np.append(inside, time[-1])


def _currents(time: Array, x_in: Array, types: tuple[str, ...], generator: str) -> Array:
    """Return generator currents (n_t, n_units) in uA/cm²."""
    columns = [
        transduce(kind, time, x_in[:, i], gain=GAINS[kind], generator=generator)
        for i, kind in enumerate(types)
    ]
    return np.column_stack(columns)


def _fire(
    time: Array,
    x_in: Array,
    types: tuple[str, ...],
    generator: str,
    membrane: HodgkinHuxley,
    dt: float,
    *,
    driven: bool,
) -> Firing:
    """Run every unit by itself, so that the dense signals of one are all that is in memory."""
    at = dense_times(time, dt)
    runs = []
    for i, kind in enumerate(types):
        current = transduce(kind, time, x_in[:, i], gain=GAINS[kind], generator=generator, at=at)
        runs.append(membrane.fire(at, current, dt=dt, stimulus_driven=driven))
    return Firing(
        times=tuple(run.times[0] for run in runs),
        peak_mV=np.concatenate([run.peak_mV for run in runs]),
        block_seconds=np.concatenate([run.block_seconds for run in runs]),
        stimulus_driven=np.concatenate([run.stimulus_driven for run in runs]),
        final=np.concatenate([run.final for run in runs]),
    )


def remarks(
    time: Array, x_in: Array, types: tuple[str, ...], names: tuple[str, ...], firing: Firing
) -> tuple[str, ...]:
    """Return sentences on block, on crossings that the current drives, and on coarse samples."""
    notes = [
        f"{name}: in depolarization block for {blocked:.3g} s"
        for name, blocked in zip(names, firing.block_seconds, strict=True)
        if blocked > 0
    ]
    notes += [
        f"{name}: crossings of 40 mV that also occur with sodium activation frozen: {driven} "
        f"(spikes: {len(times)}); the current drives them, not the membrane"
        for name, driven, times in zip(names, firing.stimulus_driven, firing.times, strict=True)
        if driven > 0
    ]
    for i, kind in enumerate(types):
        jump = coarse_jump(time, x_in[:, i], FAII_STEP) if kind == "FAII" else 0.0
        if jump > FAII_JUMP:
            notes.append(
                f"{names[i]}: the velocity of its input jumps by {jump:.3g} mm/s at samples more "
                f"than {1e3 * FAII_STEP:g} ms apart, which a second derivative takes for sharp "
                "corners; sample the motion more finely unless they are meant"
            )
    return tuple(notes)


def coarse_jump(time: Array, x: Array, longest: float) -> float:
    """Return the largest jump of velocity, in mm/s, next to an interval longer than `longest` s."""
    moving = np.diff(time) > 0
    step, change = np.diff(time)[moving], np.diff(x)[moving]
    coarse = np.maximum(step[1:], step[:-1]) > longest * (1 + 1e-6)
    return float(np.abs(np.diff(change / step))[coarse].max(initial=0.0))
