"""Files of rigs to a `Recording`: text in any locale, LabVIEW `.lvm`, MATLAB `.mat`, HDF5.

Of a text the rows of numbers decide which separator and which decimal sign it has; lines above
them are a header. Of MATLAB and HDF5 files the columns are the series of the most common length.
"""

import io
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fefinger.support import array_files
from fefinger.support.arrays import Array
from fefinger.support.checks import HUGE, InputError
from fefinger.support.csv_columns import shortened
from fefinger.support.inputs import MOST, check_input
from fefinger.support.recordings import Recording, is_unit


STYLES = (
    *(("\t", "."), (";", "."), (",", "."), ("|", "."), (None, ".")),
    *(("\t", ","), (";", ","), ("|", ","), (None, ",")),
)
"""Separators, None for spaces, and decimal signs of a text."""

PEEKED = 1 << 18
"""Bytes at the beginning and at the end of a long text by which it is told."""

RATES = ("fs", "rate", "sampling_rate", "sample_rate", "sampling_frequency", "samplerate")
STEPS = ("dt", "delta_t", "sampling_interval", "sample_time")
"""Names of numbers that stand for times that a file does not have."""

END = "***End_of_Header***"
COMMENT = re.compile(r"^\s*(#|%|//)\s*")
Text = list[tuple[int, str]]


class Series(NamedTuple):
    """A series of a file: its name, its unit or "", and its values (n,)."""

    name: str
    unit: str
    values: Array


def read(field: str, file: str | Path) -> Recording:
    """Read the columns of a file; messages begin with `field`, such as its name.

    Raises
    ------
    InputError
        For a file that cannot be read, without rows of numbers, or with a row that is none.
    """
    path = Path(file)
    check_input(field, path, "a file of a record, such as CSV")
    largest = 1e9  # bytes of a file that is read
    if path.stat().st_size > largest:
        size = path.stat().st_size / 1e6
        msg = f"{field}: expected a file of at most {largest / 1e6:g} MB, received {size:.4g} MB"
        raise InputError(f"{msg}; cut out the part that matters")
    kind = path.suffix.lower()
    if kind == ".mat":
        found = _columns(field, array_files.matlab(field, path))
    elif kind in (".h5", ".hdf5", ".hdf", ".nc"):
        found = _columns(field, array_files.hdf5(field, path))
    else:
        found = _long(field, path) or _text(field, _decoded(field, path.read_bytes()))
    wrong = np.argwhere(~(np.abs(found.values) <= HUGE))
    if wrong.size:
        row, column = wrong[0].tolist()
        finite = np.isfinite(found.values[row, column])
        expected = f"a size of at most {HUGE:g}" if finite else "a finite number"
        raise InputError(
            f"{field}: line {found.line(row)}, column {found.headers[column]}: expected "
            f"{expected}, received {found.values[row, column]:g}; remove rows without a value"
        )
    return found


def _text(field: str, text: str) -> Recording:
    return _labview(field, text) if text.startswith("LabVIEW Meas") else _table(field, text)


def _long(field: str, path: Path) -> Recording | None:
    """Read a long text in a tenth of the time and memory; None if it is not plain numbers.

    Its beginning and its end tell what it is.
    """
    size = path.stat().st_size
    if size < 4 * PEEKED:
        return None
    with open(path, "rb") as opened:
        first, end = opened.read(PEEKED), opened.seek(size - PEEKED)
        last = opened.read(size - end)
    if first.startswith((b"\xff\xfe", b"\xfe\xff", b"LabVIEW Meas")):
        return None
    whole = first[: first.rfind(b"\n") + 1] + last[last.find(b"\n") + 1 :]
    try:
        peeked = _table(field, _decoded(field, whole))
        style = _style([(0, line) for line in _decoded(field, last).splitlines()[1:]])
        if style is None or style[1] == ",":
            return None
        values = np.loadtxt(
            path,
            delimiter=style[0],
            comments=None,
            skiprows=peeked.line(0) - 1,
            max_rows=MOST + 1,
            ndmin=2,
            encoding="latin-1",  # of the header; numbers are ASCII
        )
    except ValueError:
        return None
    if values.shape[1] != len(peeked.headers) or len(values) > MOST:
        return None
    begins = peeked.line(0)
    return Recording(field, peeked.headers, peeked.units, values, lambda row: row + begins)


def _decoded(field: str, content: bytes) -> str:
    """Return the text of a file in UTF-8, UTF-16 with its mark, or Windows' encoding."""
    marked = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    for encoding in ("utf-16",) if marked else ("utf-8-sig", "cp1252"):
        try:
            text = content.decode(encoding)
        except UnicodeError:
            continue
        if "\0" not in text:
            return text
    raise InputError(f"{field}: expected a CSV file of text, received other bytes")


def _cells(line: str, separator: str | None) -> list[str]:
    cells = [cell.strip().strip('"').strip() for cell in line.split(separator)]
    return cells[:-1] if len(cells) > 2 and not cells[-1] else cells  # a separator ends the line


def _number(cell: str, decimal: str) -> float | None:
    if decimal == ",":
        if "." in cell:
            return None
        cell = cell.replace(",", ".")
    try:
        return float(cell)
    except ValueError:
        return None


def _is_row(cells: Sequence[str], decimal: str) -> bool:
    return len(cells) > 1 and all(_number(cell, decimal) is not None for cell in cells)


def _style(lines: Text) -> tuple[str | None, str] | None:
    """Return the separator and the decimal sign in which most of the last lines are numbers."""
    looked = 200  # lines at the end of a text by which its style is told
    counts = [
        sum(_is_row(_cells(line, separator), decimal) for _, line in lines[-looked:])
        for separator, decimal in STYLES
    ]
    return STYLES[int(np.argmax(counts))] if max(counts) else None


def _table(field: str, text: str, named: Sequence[Sequence[str]] = ()) -> Recording:
    """Read a text: a header of some lines or none, then rows of numbers.

    named: names and units of the columns where another header gave them.
    """
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1) if line.strip(" \t,;\0")]
    style = _style(lines)
    if style is None:
        received = f"the lines {shortened([lines[0][1]])} ..." if lines else "an empty file"
        raise InputError(
            f"{field}: expected a header and rows of numbers below it, received {received}"
        )
    separator, decimal = style
    first = next(
        i for i, (_, line) in enumerate(lines) if _is_row(_cells(line, separator), decimal)
    )
    rows = lines[first:]
    count = Counter(len(_cells(line, separator)) for _, line in rows).most_common(1)[0][0]
    headers, units = named or _header(lines[:first], separator, count)
    values = _numbers(field, rows, style, headers, count)
    return Recording(field, tuple(headers), tuple(units), values, lambda row: rows[row][0])


def _header(above: Text, separator: str | None, count: int) -> tuple[list[str], list[str]]:
    """Return names and units of columns from the lines above the numbers, by default numbered."""
    found = [_cells(COMMENT.sub("", line), separator) for _, line in above]
    fits = [cells for cells in found if len(cells) == count]
    if not fits and found:  # a header with commas above rows with tabs, or the like
        last = COMMENT.sub("", above[-1][1])
        splits = (_cells(last, other) for other in (",", ";", "\t", "|", None))
        fits = [cells for cells in splits if len(cells) == count][:1]
    if not fits:
        if found and len(found[-1]) > 1:  # a header of another length is told by a row
            return found[-1], [""] * len(found[-1])
        return [f"column {i}" for i in range(1, count + 1)], [""] * count
    if len(fits) > 1 and all(map(is_unit, fits[-1])) and any(fits[-1]):
        return fits[-2], fits[-1]
    return fits[-1], [""] * count


def _numbers(
    field: str, rows: Text, style: tuple[str | None, str], headers: Sequence[str], count: int
) -> Array:
    """Return the numbers (n, count) of rows; InputError for a line that is none."""
    separator, decimal = style
    _check_rows(field, len(rows), count)
    body = "\n".join(line for _, line in rows)
    body = body.replace(",", ".") if decimal == "," else body
    try:
        if len(headers) == count:
            return np.loadtxt(io.StringIO(body), delimiter=separator, comments=None, ndmin=2)
    except ValueError:
        pass  # cell by cell finds what is wrong, and where
    table = [_row(field, *row, style, headers) for row in rows]
    return np.array(table, dtype=float)


def _row(
    field: str, at: int, line: str, style: tuple[str | None, str], headers: Sequence[str]
) -> list[float]:
    cells, where = _cells(line, style[0]), f"{field}: line {at}"
    if len(cells) != len(headers):
        todo = "; write 0.5 for 0,5 if its commas are decimal" if style == (",", ".") else ""
        msg = f"{where}: expected {len(headers)} values, received {len(cells)}{todo}"
        raise InputError(msg)
    numbers = [_number(cell, style[1]) for cell in cells]
    for cell, number, name in zip(cells, numbers, headers, strict=True):
        if number is None:
            msg = f"{where}, column {name}: expected a finite number, received {cell!r}"
            raise InputError(f"{msg}; remove rows without a value")
    return [number for number in numbers if number is not None]


def _labview(field: str, text: str) -> Recording:
    """Read a LabVIEW measurement file; segments with a header each (Multi_Headings) are joined."""
    lines = [(at, line) for at, line in enumerate(text.splitlines(), 1) if line.strip()]
    ends = [k for k, (_, line) in enumerate(lines) if line.startswith(END)]
    channels = [k for k, (_, line) in enumerate(lines) if line.startswith("Channels")]
    begins = [k for k in channels if k > min(ends, default=k)]
    if not begins or len(begins) != len(ends) - 1:
        raise InputError(
            f"{field}: expected a LabVIEW file with a header from Channels to {END} above the rows "
            f"of each segment, received {len(begins)} and {max(len(ends) - 1, 0)} of these lines"
        )
    parts = [
        _segment(field, lines[: ends[0]] + lines[begin:end], lines[end + 1 : until])
        for begin, end, until in zip(begins, ends[1:], [*begins[1:], len(lines)], strict=True)
    ]
    first = parts[0]
    for before, part in pairwise(parts):
        last, start = before.values[-1, 0], part.values[0, 0]
        if part.headers != first.headers or part.units != first.units:
            problem = f"columns as in the first one, received {shortened(part.headers)}"
        elif "X_Value" in first.headers and start <= last:
            problem = f"times that go on, received {start:g} s after {last:g} s"
        else:
            continue
        raise InputError(
            f"{field}: line {part.line(0)}: expected a segment with {problem}; save each press in "
            "a file of its own"
        )
    at = [part.line(row) for part in parts for row in range(len(part.values))]
    values = np.concatenate([part.values for part in parts])
    return Recording(field, first.headers, first.units, values, at.__getitem__)


def _segment(field: str, heads: Text, body: Text) -> Recording:
    """Read a segment, with times from X0 and Delta_X where it has none, as the first column."""
    pairs = [re.split(r"\t" if "\t" in line else ",", line) for _, line in heads]
    head = {cells[0]: [cell.strip() for cell in cells[1:] if cell.strip()] for cells in pairs}
    mark = {"Comma": ",", "Tab": "\t"}.get(next(iter(head.get("Separator", [])), "Tab"), "\t")
    decimal = next(iter(head.get("Decimal_Separator", [])), ".")
    if len(body) < 2:
        raise InputError(f"{field}: expected names and rows of numbers below {END}, received none")
    names = [cell.strip() for cell in body[0][1].split(mark)]
    names = names[:-1] if names[-1] == "Comment" else names
    has_time = next(iter(head.get("X_Columns", [])), "One") != "No"
    rows = [[cell.strip() for cell in line.split(mark)][: len(names)] for _, line in body[1:]]
    keep = [i for i, name in enumerate(names) if name and (has_time or name != "X_Value")]
    numbers = [[_number(row[i], decimal) for i in keep if i < len(row)] for row in rows]
    bad = next((k for k, row in enumerate(numbers) if None in row or len(row) < len(keep)), None)
    if bad is not None:
        msg = f"{len(keep)} numbers in every row, received {body[1 + bad][1]!r:.60}"
        raise InputError(f"{field}: line {body[1 + bad][0]}: expected {msg}")
    values, labels = np.array(numbers, dtype=float), [names[i] for i in keep]
    times = [k for k, name in enumerate(labels) if name == "X_Value"]
    if (values[:, times[1:]] != values[:, times[:1]]).any():
        msg = "the same times X_Value of all channels, received others"
        raise InputError(f"{field}: expected {msg}; save with one column of them (X_Columns One)")
    values = np.delete(values, times[1:], axis=1)
    labels = [name for k, name in enumerate(labels) if k not in times[1:]]
    stated = iter(head.get("Y_Unit_Label", []))
    units = ["s" if name == "X_Value" else next(stated, "") for name in labels]
    if not has_time:
        start, step = (
            _number(next(iter(head.get(key, [])), ""), decimal) for key in ("X0", "Delta_X")
        )
        if step is None:
            raise InputError(f"{field}: expected Delta_X, the time between rows, received none")
        values = np.column_stack([_times(step, len(values)) + (start or 0.0), values])
        labels, units = ["X_Value", *labels], ["s", *units]
    return Recording(field, tuple(labels), tuple(units), values, lambda row: body[1 + row][0])


def _check_rows(field: str, length: int, count: int) -> None:
    """Raise InputError for more rows than MOST."""
    if length > MOST:
        raise InputError(
            f"{field}: expected at most {MOST} rows of {count} numbers, received {length}; take "
            "fewer, or the part that matters"
        )


def _columns(field: str, stored: Mapping[str, Any]) -> Recording:
    """Make a record of the series of the most common length among stored values."""
    series: list[Series] = []
    scalars: dict[str, float] = {}
    for name, value in stored.items():
        unit, value = value if isinstance(value, tuple) else ("", value)
        array = np.asarray(value)
        if array.dtype.kind not in "iuf" or array.size == 0:
            continue
        with np.errstate(over="ignore"):  # of long doubles, refused with other sizes
            array = np.squeeze(array.astype(float))
        if array.ndim == 0:
            scalars[name.rpartition(".")[2].lower()] = float(array)
        elif array.ndim == 1:
            series.append(Series(name, unit, array))
        elif array.ndim == 2:
            tall = array if array.shape[0] >= array.shape[1] else array.T
            series += [Series(f"{name} {i}", unit, row) for i, row in enumerate(tall.T, start=1)]
    if not series:
        raise InputError(f"{field}: expected series of numbers, received none in the file")
    lengths = Counter(len(each.values) for each in series)
    length = max(lengths, key=lambda size: (lengths[size], size))
    series = [each for each in series if len(each.values) == length]
    _check_rows(field, length, len(series))
    step = next((scalars[name] for name in STEPS if scalars.get(name, 0.0) > 0), None)
    rate = next((scalars[name] for name in RATES if scalars.get(name, 0.0) > 0), None)
    if step is None and rate is not None:
        step = 1 / rate
    names = [each.name.rpartition(".")[2] for each in series]
    if len(set(names)) < len(names):
        names = [each.name for each in series]
    if step is not None and not any(name.lower() in ("time", "t") for name in names):
        series.insert(0, Series("time", "s", _times(step, length)))
        names.insert(0, "time")
    values = np.column_stack([each.values for each in series])
    return Recording(field, tuple(names), tuple(each.unit for each in series), values, _row_number)


def _times(step: float, count: int) -> Array:
    """Return times (count,) from 0 on; ones beyond all bounds are refused with what a file has."""
    with np.errstate(all="ignore"):
        times: Array = np.arange(count) * np.float64(step)
    return times


def _row_number(row: int) -> int:
    return row + 1
