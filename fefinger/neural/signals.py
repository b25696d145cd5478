"""Series of displacement or strain that drive afferent units: read from CSV or given as arrays."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, repeated, suggestion
from fefinger.support.csv_columns import FACTORS, check_times, factor, read_table, stated_unit
from fefinger.support.units import fitting


TIME = "time", "time_s", "time_ms"
"""Headers of the time column; the unit may also be written as in "Time (ms)"."""

SIGNALS = "displacement_mm", "displacement_um", "displacement_m", "strain"
"""Ends of the headers of signals; the unit may also be written as in "left displacement (mm)"."""

USUAL = "displacement_mm", "strain"
"""Those that are proposed for a header without a unit."""

LARGEST_MM, LARGEST_STRAIN = 10.0, 1.0
"""Largest displacement and strain: a fingertip is about 12 mm thick, strain stays below 1."""

SMALLEST_MM = 0.05
"""Largest displacement of a column below which another unit is suspected, if no unit fires."""


@dataclass(frozen=True)
class Signals:
    """A series: time (n_t,) s, drive (n_t, n_columns), mm per unit of drive, headers.

    The length of a strain column is None; the user has to give it.
    """

    time: Array
    drive: Array
    lengths: tuple[float | None, ...]
    headers: tuple[str, ...]


def read(path: str | PathLike[str]) -> Signals:
    """Read a series from a CSV file with a column of time and one per signal, each with a header.

    The header of time is one of TIME. That of a signal ends with one of SIGNALS, after any name, as
    in `left_displacement_mm`. Units may also stand in brackets, as in "time (s)". Displacement is
    positive into the skin, strain positive where it excites: compression for SAI and FAII, stretch
    of the skin for SAII and FAI.

    Raises InputError for a file or a header that cannot be read, two columns with one name, a value
    that is not a number, times that are not sorted, signals beyond LARGEST_MM or LARGEST_STRAIN.
    """
    table = read_table(str(path), path)
    header = table.header
    at = [i for i, name in enumerate(header) if factor(name, "time", "s") is not None]
    if len(at) != 1:
        msg = f"{path}: expected one column named {', '.join(TIME)}, received {', '.join(header)}"
        raise InputError(msg)
    if twice := repeated(header):
        names = ", ".join(map(repr, twice))
        raise InputError(
            f"{path}: expected a different name for each column, received {names} more than once; "
            "rename the columns, as in left_displacement_mm"
        )
    columns = [i for i in range(len(header)) if i != at[0]]
    if not columns:
        raise InputError(f"{path}: expected a column of a signal beside the time, received none")
    lengths = tuple(_length(path, header[i]) for i in columns)
    values = table.numbers(range(len(header)))
    if len(values) < 2:
        raise InputError(f"{path}: expected two rows of numbers or more, received one")
    check_times(table.source, header[at[0]], values[:, at[0]])
    signals = Signals(
        time=(factor(header[at[0]], "time", "s") or 1.0) * values[:, at[0]],
        drive=values[:, columns],
        lengths=lengths,
        headers=tuple(header[i] for i in columns),
    )
    _check(signals, table.source, lambda row: f"line {table.line(row)}")
    return signals


def given(time: ArrayLike, displacement: ArrayLike | Mapping[str, ArrayLike]) -> Signals:
    """Check the series of `spikes`; InputError for those that cannot be used."""
    several = isinstance(displacement, Mapping)
    named = displacement if isinstance(displacement, Mapping) else {USUAL[0]: displacement}
    if not named:
        raise InputError("displacement: expected one series or more, received none")
    at = _row("time", time)
    drive = np.empty((len(at), len(named)))
    for i, (name, values) in enumerate(named.items()):
        what = f"displacement[{name!r}]" if several else "displacement"
        row = _row(what, values)
        if len(row) != len(at):
            raise InputError(f"{what}: expected {len(at)} values as of time, received {len(row)}")
        drive[:, i] = row
    signals = Signals(
        time=at,
        drive=drive,
        lengths=tuple(_length("displacement", name) for name in named),
        headers=tuple(named),
    )
    _check(signals, "time, displacement", lambda row: f"sample {row}")
    return signals


def _row(name: str, values: ArrayLike) -> Array:
    """Return a series as an array (n_t,) of two finite numbers or more; InputError for another."""
    try:
        row = np.asarray(values, float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: expected numbers, received {values!r:.60}") from None
    if row.ndim != 1 or len(row) < 2:
        raise InputError(
            f"{name}: expected a series of two numbers or more, received the shape {row.shape}; "
            "give several series as a dictionary by name"
        )
    if not np.isfinite(row).all():
        first = int(np.flatnonzero(~np.isfinite(row))[0])
        raise InputError(f"{name}: expected finite numbers, received {row[first]} at [{first}]")
    return row


def _length(path: str | PathLike[str], header: str) -> float | None:
    """Length in mm of the unit of a signal, by its header; None for strain."""
    found = re.search(r"(?:^|.*[^a-z0-9])(displacement.*|strain[\s()\[\]_.-]*)$", header.lower())
    if found and found[1].startswith("strain"):
        return None
    if found and stated_unit(found[1], "displacement"):
        length = factor(found[1], "displacement", "mm")
        if length is not None:
            return length
    ends = ", ".join(SIGNALS)
    msg = f"{path}: column {header!r}: expected a name that ends with one of {ends}."
    raise InputError(msg + suggestion(header, USUAL))


def _check(signals: Signals, source: str, place: Callable[[int], str]) -> None:
    """Raise InputError for times that are not sorted and for signals beyond the limits.

    source, place: what to call the series and its samples.
    """
    back = np.flatnonzero(np.diff(signals.time) < 0)
    if len(back):
        i = int(back[0])
        raise InputError(
            f"{source}: {place(i + 1)}: expected times that never decrease, "
            f"received {signals.time[i + 1]:g} s after {signals.time[i]:g} s; sort the rows"
        )
    if not signals.time[-1] > signals.time[0]:
        raise InputError(
            f"{source}: expected times that span more than 0 s, all are {signals.time[0]:g} s"
        )
    for header, column, length in zip(
        signals.headers, signals.drive.T, signals.lengths, strict=True
    ):
        largest = float(np.abs(column).max()) * (length or 1.0)
        limit, unit = (LARGEST_STRAIN, "") if length is None else (LARGEST_MM, " mm")
        if largest > limit:
            raise InputError(
                f"{source}: column {header}: expected at most {limit:g}{unit}, received "
                f"{largest:g}{unit}{likely_unit(column, length)}; check the unit, and that the "
                "signal is zero before the touch"
            )


def likely_unit(column: Array, length: float | None) -> str:
    """Words on the unit that a column (n_t,) is likely in, where its header states another."""
    size = float(np.abs(column).max())
    if length is None:
        return fitting(size, {"percent": 0.01}, 0.01, LARGEST_STRAIN)
    others = {unit: each for unit, each in FACTORS["mm"].items() if each != length}
    return fitting(size, others, SMALLEST_MM, LARGEST_MM)
