"""Columns of numbers from a CSV file, with messages that name its lines."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.likely_units import in_milliseconds, seconds_or_milliseconds
from fefinger.support.outputs import unreadable
from fefinger.support.text import plain


UNITS = {
    **{"time": "s", "depth": "mm", "force": "N", "x": "mm", "y": "mm", "height": "mm"},
    **{"angle": "degrees", "tilt": "degrees"},
}
"""Units of the columns that scenes read."""

FACTORS = {
    "s": {"s": 1.0, "ms": 1e-3},
    "mm": {"mm": 1.0, "um": 1e-3, "m": 1e3},
    "N": {"n": 1.0, "mn": 1e-3},
    "kPa": {"kpa": 1.0},
    "degrees": {"degrees": 1.0, "deg": 1.0},
}
"""Units, in small letters, that a header may state instead of a unit, and their size in it."""

SHOWN = 60
"""Longest first line of a file that a message quotes in full."""

SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars", " ": "spaces"}
"""Separators other than commas that a file may have by mistake, with their names."""

DECIMAL = "write 0.5 for 0,5 if its commas are decimal"


@dataclass(frozen=True)
class CsvTable:
    """The header of a CSV file, and its rows as (number of the line, cells), no blank ones.

    `source` names the file in messages.
    """

    source: str
    header: list[str]
    rows: list[tuple[int, list[str]]]

    def numbers(self, columns: Sequence[int]) -> Array:
        """Convert some columns (n_columns,) to numbers (n_rows, n_columns).

        Raises
        ------
        InputError
            A row with more or fewer values than the header, or a value that is not finite.
        """
        values = np.empty((len(self.rows), len(columns)))
        for row, (line, cells) in zip(values, self.rows, strict=True):
            where = f"{self.source}: line {line}"
            if len(cells) != len(self.header):
                todo = f"; {DECIMAL}" if len(cells) > len(self.header) else ""
                msg = f"{where}: expected {len(self.header)} values, received {len(cells)}{todo}"
                raise InputError(msg)
            for k, column in enumerate(columns):
                number = plain(cells[column])
                row[k] = np.nan if isinstance(number, str) else number
                if not np.isfinite(row[k]):
                    todo = DECIMAL if "," in cells[column] else "remove rows without a value"
                    raise InputError(
                        f"{where}, column {self.header[column]}: expected a finite number, "
                        f"received {cells[column]!r}; {todo}"
                    )
        return values


def _lines(source: str, file: str | PathLike[str]) -> list[tuple[int, list[str]]]:
    """Read the lines that are not blank, as (number, cells), separated by commas."""
    if reason := unreadable(file):
        msg = f"{source}: expected a CSV file, received a path that {reason}; check its name"
        raise InputError(msg)
    try:
        with open(file, newline="", encoding="utf-8-sig") as stream:
            lines = [[cell.strip() for cell in line] for line in csv.reader(stream)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        received = f"another: {error}"
        if isinstance(error, UnicodeDecodeError):
            received = "bytes that are no UTF-8 text; save it as UTF-8"
        raise InputError(f"{source}: expected a CSV file of text, received {received}") from error
    rows = [(number, cells) for number, cells in enumerate(lines, start=1) if any(cells)]
    first = rows[0][1] if rows else []
    for mark, name in SEPARATORS.items():
        if len(first) == 1 and mark in first[0]:
            raise InputError(
                f"{source}: expected commas between the columns and points in the numbers, "
                f"received {name} in the first line, {shortened(first)}; separate them by commas, "
                f"and {DECIMAL}"
            )
    return rows


def read_table(source: str, file: str | PathLike[str]) -> CsvTable:
    """Read a CSV file with a header; messages name it `source`.

    Raises
    ------
    InputError
        A file that cannot be read, has nothing below its header, or other separators than commas.
    """
    rows = _lines(source, file)
    header = rows[0][1] if rows else []
    if len(rows) < 2:
        received = f"the header {','.join(header)!r} alone" if rows else "an empty file"
        msg = f"{source}: expected a header and rows of numbers below it, received {received}"
        raise InputError(msg)
    return CsvTable(source, header, rows[1:])


def read_matrix(source: str, file: str | PathLike[str]) -> Array:
    """Read a CSV file of numbers alone, without a header: (n_rows, n_columns).

    Raises
    ------
    InputError
        A file that cannot be read, is empty or has a header, or rows of different lengths.
    """
    rows = _lines(source, file)
    if not rows:
        raise InputError(f"{source}: expected rows of numbers, received an empty file")
    if not is_numeric(rows[0][1]):
        raise InputError(
            f"{source}: expected numbers alone, without a header, received the first line "
            f"{shortened(rows[0][1])}"
        )
    places = range(len(rows[0][1]))
    return CsvTable(source, [str(place + 1) for place in places], rows).numbers(places)


def is_numeric(cells: Sequence[str]) -> bool:
    """Return whether all cells of a line are numbers."""
    return not any(isinstance(plain(cell), str) for cell in cells)


def stated_unit(cell: str, name: str) -> str | None:
    """Return the unit that a header states after `name`, in small letters: "" for none.

    None for a header that is another name. "Time (s)", "time [s]" and "time_s" state s.
    """
    text = cell.lower().replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")
    found = re.fullmatch(rf"{name}(?:[^a-z0-9]+([a-z%][a-z0-9/%]*))?[^a-z0-9]*", text)
    return found and (found[1] or "")


def factor(cell: str, name: str, unit: str) -> float | None:
    """Return the size in `unit` of the unit of a column; None for another name or unit."""
    stated = stated_unit(cell, name)
    return 1.0 if stated == "" else FACTORS[unit].get(stated or "")


def check_times(where: str, cell: str, time: Array) -> None:
    """Raise InputError for times (n,) that are likely in ms, under a header without a unit."""
    if stated_unit(cell, "time") == "" and in_milliseconds(time):
        raise InputError(f"{where}: {cell}: {seconds_or_milliseconds(time)}")


def read_columns(field: str, file: Path, names: tuple[str, ...]) -> tuple[tuple[float, ...], ...]:
    """Read columns of a CSV file whose header has `names`, alone or followed by their units.

    They are converted to UNITS.

    Raises
    ------
    InputError
        A file that cannot be read or used; the message names it `field`.
    """
    table = read_table(f"{field}: {str(file)!r}", file)
    factors = [
        factor(cell, name, UNITS[name]) for name, cell in zip(names, table.header, strict=False)
    ]
    if len(table.header) != len(names) or None in factors:
        units = ", ".join(f"{name} in {UNITS[name]}" for name in names)
        raise InputError(
            f"{table.source}: expected the first line to be '{','.join(names)}', and no other "
            f"column, {units}, received {shortened(table.header)}"
        )
    values = table.numbers(range(len(names))) * np.array(factors, dtype=float)
    if "time" in names:
        at = names.index("time")
        check_times(table.source, table.header[at], values[:, at])
    return tuple(map(tuple, values.T.tolist()))


def shortened(header: Sequence[str]) -> str:
    """Quote the first line of a file, its beginning where it is long."""
    line = ",".join(header)
    return repr(line) if len(line) <= SHOWN else f"{line[:SHOWN]!r} ..."
