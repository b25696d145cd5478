"""Named columns of numbers from a CSV file."""

import csv
import re
from pathlib import Path

from fefinger.support.checks import InputError


UNITS = {"time": "s", "depth": "mm", "force": "N", "x": "mm", "y": "mm"}

COUNTS = {2: "two", 4: "four"}


def read_columns(field: str, file: Path, names: tuple[str, ...]) -> tuple[tuple[float, ...], ...]:
    """Read columns of a CSV file whose header has `names`, alone or followed by their UNITS.

    Raises
    ------
    InputError
        A file that cannot be read or used; the message names it `field`.
    """
    try:
        with file.open(newline="", encoding="utf-8-sig") as stream:
            rows = [row for row in csv.reader(stream) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        msg = f"{field}: cannot read {str(file)!r}: {error}"
        raise InputError(msg) from None
    head = [cell.strip().lower() for cell in rows[0]] if rows else []
    if len(head) != len(names) or not all(map(_named, head, names)):
        units = ", ".join(f"{name} in {UNITS[name]}" for name in names)
        msg = (
            f"{field}: expected the first line of {str(file)!r} to be '{','.join(names)}', and no "
            f"other column, {units}, received {','.join(rows[0]) if rows else 'an empty file'!r}"
        )
        raise InputError(msg)
    table: list[tuple[float, ...]] = []
    for count, row in enumerate(rows[1:], start=1):
        try:
            values = tuple(map(float, row))
        except ValueError:
            values = ()
        if len(values) != len(names):
            wanted = COUNTS[len(names)]
            msg = (
                f"{field}: row {count} of {str(file)!r}: expected {wanted} numbers, received {row}"
            )
            raise InputError(msg)
        table.append(values)
    return tuple(tuple(row[k] for row in table) for k in range(len(names)))


def _named(head: str, name: str) -> bool:
    """Return whether the header of a column is `name`, alone or followed by its unit."""
    return bool(re.fullmatch(rf"{name}([^a-z0-9]+{UNITS[name].lower()})?[^a-z0-9]*", head))
