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
from fefinger.support.outputs import unreadable
from fefinger.support.text import plain


UNITS = {
    **{"time": "s", "depth": "mm", "force": "N", "x": "mm", "y": "mm", "height": "mm"},
    **{"angle": "degrees", "tilt": "degrees"},
}

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


def read_table(source: str, file: str | PathLike[str]) -> CsvTable:
    """Read a CSV file with a header; messages name it `source`.

    Raises
    ------
    InputError
        A file that cannot be read, has nothing below its header, or other separators than commas.
    """
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
    header = rows[0][1] if rows else []
    for mark, name in SEPARATORS.items():
        if len(header) == 1 and mark in header[0]:
            raise InputError(
                f"{source}: expected commas between the columns and points in the numbers, "
                f"received {name} in the first line, {header[0]!r}; separate them by commas, and "
                f"{DECIMAL}"
            )
    if len(rows) < 2:
        received = f"the header {','.join(header)!r} alone" if rows else "an empty file"
        msg = f"{source}: expected a header and rows of numbers below it, received {received}"
        raise InputError(msg)
    return CsvTable(source, header, rows[1:])


def read_columns(field: str, file: Path, names: tuple[str, ...]) -> tuple[tuple[float, ...], ...]:
    """Read columns of a CSV file whose header has `names`, alone or followed by their UNITS.

    Raises
    ------
    InputError
        A file that cannot be read or used; the message names it `field`.
    """
    table = read_table(f"{field}: {str(file)!r}", file)
    named = [
        re.fullmatch(rf"{name}([^a-z0-9]+{UNITS[name].lower()})?[^a-z0-9]*", cell.lower())
        for name, cell in zip(names, table.header, strict=False)
    ]
    if len(table.header) != len(names) or not all(named):
        units = ", ".join(f"{name} in {UNITS[name]}" for name in names)
        raise InputError(
            f"{table.source}: expected the first line to be '{','.join(names)}', and no other "
            f"column, {units}, received {','.join(table.header)!r}"
        )
    values = table.numbers(range(len(names)))
    return tuple(map(tuple, values.T.tolist()))
