"""Spikes of afferent units driven by a displacement or strain series of the user."""

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.signals import SMALLEST_MM, Signals, given, likely_unit
from fefinger.support.arrays import Array
from fefinger.support.atomic_write import as_input_error, keep
from fefinger.support.checks import InputError, choice, integer, number, repeated, suggestion
from fefinger.support.registry import AFFERENTS
from fefinger.support.units import in_milliseconds, seconds_or_milliseconds
from fefinger.support.vocabulary import FAMILIES, TYPE_SYNONYMS, TYPES


if TYPE_CHECKING:
    from fefinger.neural.family import Family
    from fefinger.neural.trains import SpikeTrains


OR_CORNERS = "or say that straight lines between the samples are exact (corners, --corners)"
"""What else can be done where samples are too coarse for a type."""

MILLISECONDS = "divide them by 1000, or, if they are in s, pass corners=True"
"""What can be done with arrays whose times are likely in ms."""

FINER, FINEST = 8, 1e-4
"""Number of parts of an interval on the smooth curve, and the shortest of them in s."""

FILES = ("spikes.csv", "units.csv", "spikes.npz")


def spikes(
    time: ArrayLike,
    displacement: ArrayLike | Mapping[str, ArrayLike],
    types: Sequence[str] = (),
    *,
    length: float | None = None,
    corners: bool = False,
    tolerance: float | None = None,
    generator: str = "saturating",
    family: str = FAMILIES[0],
    trial: int = 0,
) -> "SpikeTrains":
    """Simulate the spikes of afferent units that a series of your own drives, without a finger.

    As `fefinger spikes` does for a CSV file.

    Parameters
    ----------
    time
        (n_t,) s, not decreasing; a repeated time is a jump.
    displacement
        (n_t,) mm into the skin (for the family "recorded": of a round pin 1 mm wide); drives a unit
        of each of `types`. Several series are a dictionary by name, as the columns of a CSV file:
        the end of a name says what it is (displacement_mm, displacement_um, displacement_m, or
        strain, positive where it excites); a name that begins with a type, as FAI_displacement_mm,
        drives a unit of this type alone.
    types
        Afferent types, by default all four for which the samples are not too coarse; the others are
        noted.
    length
        Skin displacement in mm per strain of 1: the depth of a small flat press over the strain at
        the end organ that it causes; "recorded" has a default, from its fit.
    corners
        Take straight lines between the samples as exact, corners included. Otherwise samples too
        coarse for a type that is named are refused, and a note lists the units whose spike count
        differs for a smooth curve through the samples, or for every second sample.
    tolerance
        Allowed error of spike times in ms, of the family "thesis", which sets integrator and step;
        by default Runge-Kutta at 50 µs.
    generator
        Law from end organ to current, of the family "thesis": "saturating" or "linear".
    family
        "recorded", "thesis", or one of your own.
    trial
        Number of the trial, 0 or more: another trial has other noise, but the same units. The
        family "thesis" has no noise here.

    Raises
    ------
    InputError
        Series that do not fit, are not finite, or are beyond 10 mm or a strain of 1; times that
        decrease, or that are likely in ms (noted instead with `corners`); an unknown type, family
        or name of a series; a type given twice; a strain without a length; samples too coarse for a
        type that is named, or for all; a choice that the family does not have.
    """
    signals = given(time, displacement)
    notes: tuple[str, ...] = ()
    if in_milliseconds(signals.time):
        sentence = f"time: {seconds_or_milliseconds(signals.time, MILLISECONDS)}"
        if not corners:
            raise InputError(sentence)
        notes = (sentence,)
    trains = fire(
        signals,
        types,
        length=length,
        corners=corners,
        tolerance=tolerance,
        generator=generator,
        family=family,
        trial=trial,
    )
    return replace(trains, notes=(*notes, *trains.notes))


def fire(
    signals: Signals,
    types: Sequence[str] = (),
    *,
    length: float | None = None,
    corners: bool = False,
    tolerance: float | None = None,
    generator: str = "saturating",
    family: str = FAMILIES[0],
    trial: int = 0,
) -> "SpikeTrains":
    """Simulate the spikes of units that these signals, of `read` or `given`, drive; as `spikes`."""
    from fefinger.neural.checked_signals import count_changes
    from fefinger.neural.variation import Variation

    named = tuple(choice("types", kind, TYPES, TYPE_SYNONYMS) for kind in types)
    types = named or TYPES
    if repeated(types):
        msg = f"types: expected every type once, received {', '.join(types)}; leave out repeats"
        raise InputError(msg)
    if length is not None:
        number("length", length, above=0.0, unit="mm")
    member = AFFERENTS.named("family", family)
    options = _options(member, tolerance, generator)
    lengths = member.lengths
    units = _units(signals, types, lengths if length is None else dict.fromkeys(TYPES, length))
    vary = None
    if member.noisy:
        vary = Variation(seed=0, noise=None, trial=trial)
    elif integer("trial", trial):
        msg = f"trial: units of {family!r} have no noise: expected trial 0, received {trial}"
        raise InputError(msg)
    left_out: list[str] = []
    if not corners:
        coarse = _coarse(signals, units, member.corners, named)
        left_out = [
            f"{why}, {OR_CORNERS}; {unit.kind} was left out" for unit, why in coarse.items()
        ]
        units = [unit for unit in units if unit not in coarse]
    columns, kinds, names, mm = (list(each) for each in zip(*units, strict=True))
    units_of = {"types": kinds, "lengths": mm, "names": names, "variation": vary, "exact": corners}
    run = partial(member.fire, **units_of, **options)
    trains = run(signals.time, signals.drive[:, columns])
    notes = (*left_out, *trains.notes, *_remarks(signals), *_silent(signals, columns, trains))
    if length is not None and None not in signals.lengths:
        notes += ("The length is not used, because no column is a strain.",)
    if not corners:
        fine, drive = _curved(signals)
        smooth = run(fine, drive[:, columns], check=False)
        change = (
            "a smooth curve joins the samples; sample more finely, or say that straight lines are "
            "exact (corners, --corners)"
        )
        notes += count_changes(names, trains.times, smooth.times, change)
    return replace(trains, notes=notes)


def _options(family: "Family", tolerance: float | None, generator: str) -> dict[str, object]:
    """Return the options of a family; InputError for those that it does not have."""
    for name in family.refused(tolerance=tolerance is not None, generator=generator):
        raise InputError(f"{name}: expected none for the afferents {family.name!r}, received one")
    options: dict[str, object] = {"generator": generator}
    if tolerance is not None:
        options["tolerance"] = 1e-3 * number("tolerance", tolerance, above=0, at_most=10, unit="ms")
    return {name: value for name, value in options.items() if name in family.choices}


class _Unit(NamedTuple):
    """A unit, the column of the signals that drives it, and the mm of one unit of that."""

    column: int
    kind: str
    name: str
    mm: float


def _units(signals: Signals, types: tuple[str, ...], lengths: Mapping[str, float]) -> list[_Unit]:
    """List all units; lengths in mm of a strain. InputError for a header that resembles a type."""
    units = []
    many = len(signals.headers) > 1
    for i, header in enumerate(signals.headers):
        prefix = _prefix(header)
        resembling = (
            prefix.lower() in TYPE_SYNONYMS
            or re.fullmatch("[sf]a[a-z0-9]{0,2}", prefix.lower()) is not None
        )
        if prefix not in TYPES and resembling:
            advice = suggestion(prefix, TYPES, TYPE_SYNONYMS)
            raise InputError(
                f"column {header!r}: its name begins like that of an afferent type, but is none of "
                f"{', '.join(TYPES)}.{advice} Rename the column"
            )
        for kind in (prefix,) if prefix in TYPES else types:
            name = header if prefix in TYPES else f"{header}:{kind}" if many else kind
            units.append(_Unit(i, kind, name, _mm(signals, i, lengths.get(kind))))
    return units


def _prefix(header: str) -> str:
    """Part of a header before its first mark or underscore."""
    return re.split(r"[\W_]", header)[0]


def keep_others(folder: Path) -> None:
    """Raise InputError where files named as FILES in a folder hold no earlier spike trains."""
    from fefinger.neural.trains import SpikeTrains

    present = [name for name in FILES if (folder / name).exists()]
    if FILES[-1] in present:
        with suppress(InputError):
            SpikeTrains.from_npz(folder / FILES[-1])
            present = []
    keep(present, folder, "spike trains")


def save(trains: "SpikeTrains", folder: Path) -> list[str]:
    """Write spike trains to FILES in a folder and return the paths.

    InputError where they cannot be written, or where files of these names are not spike trains.
    """
    keep_others(folder)
    paths = [folder / name for name in FILES]
    with as_input_error(folder):
        trains.to_csv(paths[0])
        trains.units_to_csv(paths[1])
        trains.to_npz(paths[2])
    return [str(path) for path in paths]


def _mm(signals: Signals, column: int, length: float | None) -> float:
    """Length in mm of the unit of a column; for strain the `length` that the user gave."""
    unit_length = signals.lengths[column]
    if unit_length is not None:
        return unit_length
    if length is None:
        raise InputError(
            f"length: column {signals.headers[column]!r} is a strain; expected the skin "
            "displacement in mm per strain of 1 (the depth of a small flat press over the strain "
            "that it causes at the end organ, 2 mm for 0.2 mm and 0.1), received none"
        )
    return length


def _remarks(signals: Signals) -> list[str]:
    """Describe columns that do not start at 0, or extend further below 0 than above it."""
    notes = [
        f"{header}: starts at {first:g}, which is a jump from 0 for every unit; begin the series "
        "before the touch, unless the jump is intended"
        for header, first in zip(signals.headers, signals.drive[0], strict=True)
        if first != 0.0
    ]
    # Ratio of the lowest value below 0 to the highest one from which a wrong sign is suspected: the
    # extremes of a vibration about 0 differ only by its sampling.
    outward = 1.1
    for header, column, length in zip(
        signals.headers, signals.drive.T, signals.lengths, strict=True
    ):
        low, high = float(column.min()), max(0.0, float(column.max()))
        if -low > outward * high:
            wanted = "into the skin" if length is not None else "where it excites the type"
            notes.append(
                f"{header}: goes down to {low:g}, but only up to {high:g}; expected are positive "
                f"values {wanted}; if the sign is wrong, change it"
            )
    return notes


def _silent(signals: Signals, columns: list[int], trains: "SpikeTrains") -> list[str]:
    """Describe displacements that fire no unit and are so small as if they had another unit."""
    firing = {i for i, times in zip(columns, trains.times, strict=True) if len(times)}
    notes = []
    for i in sorted({*columns} - firing):
        length, column = signals.lengths[i], signals.drive[:, i]
        hint = "" if length is None else likely_unit(column, length)
        largest = float(np.abs(column).max()) * (length or 1.0)
        if hint and largest < SMALLEST_MM:
            notes.append(
                f"{signals.headers[i]}: fires no unit; it reaches {largest:g} mm{hint}; its name "
                "has to end with the unit of its numbers"
            )
    return notes


def _curved(signals: Signals) -> tuple[Array, Array]:
    """Interpolate the drive at finer times by cubic splines from jump to jump."""
    from scipy.interpolate import CubicSpline

    from fefinger.neural.checked_signals import dense_times

    jumps = np.flatnonzero(np.diff(signals.time) == 0) + 1
    times, drives = [], []
    for time, drive in zip(
        np.split(signals.time, jumps), np.split(signals.drive, jumps), strict=True
    ):
        fine = time
        if len(time) > 1:
            fine = dense_times(time, np.maximum(np.diff(time) / FINER, FINEST))
            drive = CubicSpline(time, drive)(fine)
        times.append(fine)
        drives.append(drive)
    return np.concatenate(times), np.concatenate(drives)


def _coarse(
    signals: Signals, units: Sequence[_Unit], poles: Mapping[str, float], named: Sequence[str]
) -> dict[_Unit, str]:
    """Return why samples are too coarse, by unit.

    InputError if that is so for a type that the user has named, or for all units.
    """
    known = [unit for unit in units if unit.kind in poles]
    reasons = {unit: _too_coarse(signals, unit, poles[unit.kind]) for unit in known}
    coarse = {unit: reason for unit, reason in reasons.items() if reason}
    wanted = [u for u in coarse if u.kind in (*named, _prefix(signals.headers[u.column]))]
    if wanted or len(coarse) == len(units):
        first = wanted[0] if wanted else units[0]
        raise InputError(
            f"{coarse[first]}, leave {first.kind} out of the types (--type), {OR_CORNERS}"
        )
    return coarse


def _too_coarse(signals: Signals, unit: _Unit, pole: float) -> str:
    """Return why the samples of a column are too coarse for a type, with the rate it needs, or "".

    The velocity jumps between samples further apart than a fifth of the period of the fastest
    `pole` in Hz of the type. The limit of the jump is absolute for FA units, which respond to a
    jump by itself, and relative to the largest velocity for SA units.
    """
    from fefinger.neural.checked_signals import FAII_JUMP, coarse_jump

    x = unit.mm * signals.drive[:, unit.column]
    # Samples per period of the fastest pole of a type from which on its input is fine enough.
    rate = 5.0
    jump, limit = coarse_jump(signals.time, x, 1 / (rate * pole)), FAII_JUMP
    if unit.kind.startswith("SA"):
        apart = np.diff(signals.time)
        # Limit for SA units of the jump of velocity between coarse samples, over the largest
        # velocity: straight lines through a sinusoid with such jumps deviate from it by 1 %.
        slow_jump = 0.3
        limit = slow_jump * float(np.abs(np.diff(x)[apart > 0] / apart[apart > 0]).max())
    if jump <= limit:
        return ""
    digit = 10.0 ** (np.floor(np.log10(rate * pole)) - 1)
    enough = np.ceil(rate * pole / digit - 1e-9) * digit  # rounded up to two digits
    return (
        f"column {signals.headers[unit.column]!r}: its samples are too coarse for {unit.kind}, "
        f"which responds up to about {pole:.3g} Hz: the velocity jumps by {jump:.3g} mm/s between "
        f"samples; sample at {enough:g} Hz or more"
    )
