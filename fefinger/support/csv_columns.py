"""Columns of numbers from a CSV file; messages name the line."""

import csv
import math
import re
import warnings
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from os import PathLike
from pathlib import Path

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.inputs import MOST, unreadable
from fefinger.support.text import plain
from fefinger.support.units import in_milliseconds, seconds_or_milliseconds


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
"""By unit, the sizes in it of the units that a header may state, in small letters."""

SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars", " ": "spaces"}
"""Names of wrong separators in messages."""

DECIMAL = "write 0.5 for 0,5 if its commas are decimal"


@dataclass(frozen=True)
class CsvTable:
    """A CSV file whose rows are read on demand, without blank ones.

    source: name of the file in messages; first: number of the first line below the header.
    """

    source: str
    file: str | PathLike[str]
    header: list[str]
    first: int

    def numbers(self, columns: Sequence[int], most: int = MOST) -> Array:
        """Read some columns as numbers (n_rows, n_columns).

        Raises InputError for more than `most` rows, a row with more or fewer values than the
        header, or a value that is not a finite number.
        """
        columns = list(columns)
        values = self._quickly(most)
        if values is None:  # reading line by line finds what is wrong, and where
            wanted = array("d")
            for line, cells in islice(self._rows(), most + 1):
                wanted.extend(self._row(line, cells, columns))
            values = np.array(wanted).reshape(-1, len(columns))
        else:
            values = values[:, columns]
        if len(values) > most:
            raise InputError(
                f"{self.source}: expected at most {most} rows of {len(self.header)} numbers, "
                "received more; take fewer, or the part that matters"
            )
        return values

    def line(self, row: int) -> int:
        """Return the number of the line of a row."""
        return next(islice(self._rows(), row, None))[0]

    def _quickly(self, most: int) -> Array | None:
        """Read all columns in a tenth of the time; None if they are not plain finite numbers."""
        with open(self.file, encoding="utf-8-sig") as stream, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a file without rows
            try:
                values = np.loadtxt(
                    islice(stream, self.first - 1, None),
                    delimiter=",",
                    comments=None,
                    ndmin=2,
                    max_rows=most + 1,
                )
            except ValueError:
                return None
        plain = values.shape[1] == len(self.header) and len(values) and np.isfinite(values).all()
        return values if plain else None

    def _rows(self) -> Iterator[tuple[int, list[str]]]:
        return islice(_lines(self.source, self.file), self.first > 1, None)

    def _row(self, line: int, cells: list[str], columns: Sequence[int]) -> list[float]:
        """Return some cells of a line as numbers, or raise InputError."""
        where = f"{self.source}: line {line}"
        if len(cells) != len(self.header):
            todo = f"; {DECIMAL}" if len(cells) > len(self.header) else ""
            msg = f"{where}: expected {len(self.header)} values, received {len(cells)}{todo}"
            raise InputError(msg)
        numbers = []
        for column in columns:
            number = plain(cells[column])
            if isinstance(number, str) or not math.isfinite(number):
                todo = DECIMAL if "," in cells[column] else "remove rows without a value"
                raise InputError(
                    f"{where}, column {self.header[column]}: expected a finite number, "
                    f"received {cells[column]!r}; {todo}"
                )
            numbers.append(number)
        return numbers


def _lines(source: str, file: str | PathLike[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield the lines that are not blank as (number, cells)."""
    if reason := unreadable(file):
        msg = f"{source}: expected a CSV file, received a path that {reason}; check its name"
        raise InputError(msg)
    try:
        with open(file, newline="", encoding="utf-8-sig") as stream:
            for number, line in enumerate(csv.reader(stream), start=1):
                cells = [cell.strip() for cell in line]
                if any(cells):
                    yield number, cells
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        received = f"another: {error}"
        if isinstance(error, UnicodeDecodeError):
            received = "bytes that are no UTF-8 text; save it as UTF-8"
        raise InputError(f"{source}: expected a CSV file of text, received {received}") from error


def _first(source: str, file: str | PathLike[str]) -> tuple[int, list[str]]:
    """Return the first line as `_lines`; (0, []) of an empty file."""
    line, first = next(_lines(source, file), (0, []))
    for mark, name in SEPARATORS.items():
        if len(first) == 1 and mark in first[0]:
            raise InputError(
                f"{source}: expected commas between the columns and points in the numbers, "
                f"received {name} in the first line, {shortened(first)}; separate them by commas, "
                f"and {DECIMAL}"
            )
    return line, first


def read_table(source: str, file: str | PathLike[str]) -> CsvTable:
    """Read the header of a CSV file; messages name the file `source`.

    Raises InputError for a file that cannot be read, has nothing below its header, or other
    separators than commas.
    """
    line, header = _first(source, file)
    table = CsvTable(source, file, header, line + 1)
    if next(table._rows(), None) is None:
        received = f"the header {shortened(header)} alone" if header else "an empty file"
        msg = f"{source}: expected a header and rows of numbers below it, received {received}"
        raise InputError(msg)
    return table


def read_matrix(source: str, file: str | PathLike[str], most: int) -> Array:
    """Read a CSV file of at most `most` numbers without a header: (n_rows, n_columns).

    Raises InputError for a file that cannot be read, is empty or too long, has a header, or rows of
    different lengths.
    """
    _, first = _first(source, file)
    if not first:
        raise InputError(f"{source}: expected rows of numbers, received an empty file")
    if not is_numeric(first):
        raise InputError(
            f"{source}: expected numbers alone, without a header, received the first line "
            f"{shortened(first)}"
        )
    places = range(len(first))
    table = CsvTable(source, file, [str(place + 1) for place in places], first=1)
    return table.numbers(places, most=most // len(first))


def is_numeric(cells: Sequence[str]) -> bool:
    """Return whether all cells of a line are numbers."""
    return not any(isinstance(plain(cell), str) for cell in cells)


def stated_unit(cell: str, name: str) -> str | None:
    """Return the unit that a header states after `name`, in small letters; "" without a unit.

    "Time (s)", "time [s]" and "time_s" state s. None for the header of something else.
    """
    text = cell.lower().replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")
    found = re.fullmatch(rf"{name}(?:[^a-z0-9]+([a-z%][a-z0-9/%]*))?[^a-z0-9]*", text)
    return found and (found[1] or "")


def factor(cell: str, name: str, unit: str) -> float | None:
    """Return the size in `unit` of the unit that a header states; None for another quantity."""
    stated = stated_unit(cell, name)
    return 1.0 if stated == "" else FACTORS[unit].get(stated or "")


def check_times(where: str, cell: str, time: Array) -> None:
    """Raise InputError for times (n,) that are likely in ms, under a header without a unit."""
    if stated_unit(cell, "time") == "" and in_milliseconds(time):
        raise InputError(f"{where}: {cell}: {seconds_or_milliseconds(time)}")


def read_columns(
    field: str, file: Path, names: tuple[str, ...], most: int = MOST
) -> tuple[tuple[float, ...], ...]:
    """Read a CSV file with columns of these names, converted from the units they state to UNITS.

    Raises InputError of `field` for a file that cannot be read or used, or of more than `most`
    rows.
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
    values = table.numbers(range(len(names)), most) * np.array(factors, dtype=float)
    if "time" in names:
        at = names.index("time")
        check_times(table.source, table.header[at], values[:, at])
    return tuple(map(tuple, values.T.tolist()))


def shortened(header: Sequence[str]) -> str:
    """Quote a header, or the beginning of a long one."""
    line = ",".join(header)
    shown = 60  # characters of the first line of a file that a message quotes
    return repr(line) if len(line) <= shown else f"{line[:shown]!r} ..."
