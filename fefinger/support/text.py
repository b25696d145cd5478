"""Formatting of tables, numbers, times and JSON."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any


def table(rows: Sequence[Sequence[str]], heading: Sequence[str] = ()) -> str:
    """Format rows as aligned columns."""
    every = [heading, *rows] if heading else rows
    widths = [max(map(len, column)) for column in zip(*every, strict=True)]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in every)


def strict_json(record: object) -> str:
    """Format a record as strict JSON: numbers that are not finite become null."""
    return json.dumps(finite(record), indent=2, allow_nan=False)


def finite(value: object) -> Any:
    """Return nested values for JSON, with None for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def flat(table: Mapping[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yield the entries of nested tables as (dotted name, value)."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def entries(table: Mapping[str, object]) -> Iterator[tuple[str, str]]:
    """Yield the entries of nested tables as (dotted name, text), without empty ones."""
    return ((name, str(value)) for name, value in flat(table) if value != "")


def counted(names: Sequence[str]) -> str:
    """List each name once, with its number if it occurs more often, as in "4 SAI, FAI"."""
    numbers = {name: names.count(name) for name in names}
    return ", ".join(name if n == 1 else f"{n} {name}" for name, n in numbers.items())


def outline(record: object) -> str:
    """Return the text of a record: shapes of arrays, types of long values, nothing for None."""
    parts = []
    for name, value in vars(record).items():
        if hasattr(value, "shape"):
            parts.append(f"{name} {value.shape}")
        elif value is not None:
            text = f"{value:.6g}" if isinstance(value, float) else repr(value)
            short = len(text) <= 60 and "\n" not in text
            parts.append(f"{name}={text}" if short else f"{name}: {type(value).__name__}")
    return f"{type(record).__name__}({', '.join(parts)})"


def plain(text: str) -> float | str:
    """Convert a text to a number if it is one, also as TOML does not write it (".3")."""
    try:
        return float(text)
    except ValueError:
        return text


def unit_suffix(unit: str) -> str:
    """Return the unit as it stands behind a number: "" for "1"."""
    return "" if unit == "1" else unit


def percent(error: float) -> str:
    """Format an error in percent; a dash where it is unknown (nan)."""
    if math.isnan(error):
        return "-"
    return f"{float(f'{100 * error:.2g}'):g} %" if error < 10 else "no limit"


def format_excess(value: float, limit: float, unit: str = "") -> str:
    """Format "value > limit" with as many digits as show the difference."""
    shown = (float(f"{value:.{digits}g}") for digits in range(2, 18))
    return f"{next((x for x in shown if x > limit), value):.6g}{unit} > {limit:g}{unit}"


def brief(message: str) -> str:
    """Shorten a message of several lines to its first and last lines."""
    lines = message.splitlines()
    return message if len(lines) < 2 else f"{lines[0]} [...] {lines[-1]}"


def duration(seconds: float) -> str:
    """Format a time in ms, s, min or h; a dash where it is unknown (nan)."""
    if math.isnan(seconds):
        return "-"
    for limit, scale, unit in ((0.95, 1e3, "ms"), (95, 1, "s"), (5700, 1 / 60, "min")):
        if seconds < limit:
            return f"{float(f'{scale * seconds:.2g}'):g} {unit}"
    return f"{float(f'{seconds / 3600:.2g}'):g} h"
