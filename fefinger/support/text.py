"""Text for a reader of the console or of a message: tables, and the ladder of a plan."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    pass


def table(rows: Sequence[Sequence[str]], heading: Sequence[str] = ()) -> str:
    """Return rows of text in columns that are as wide as their widest entry."""
    every = [list(heading), *rows] if heading else list(rows)
    widths = [max(len(row[i]) for row in every) for i in range(len(every[0]))]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in every
    ]
    return "\n".join(lines)


def strict_json(record: Any) -> str:
    """Return a record as JSON, which has no numbers that are not finite: null stands for them."""
    return json.dumps(finite(record), indent=2, allow_nan=False)


def finite(value: Any) -> Any:
    """Return values as JSON has them, with None for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def plain(text: str) -> float | str:
    """Return the number that a text is, also one that is none in TOML (".3"), or else the text."""
    try:
        return float(text)
    except ValueError:
        return text


def shown(unit: str) -> str:
    """Return a unit as it stands beside a number: nothing where it is 1."""
    return "" if unit == "1" else unit


def percent(error: float) -> str:
    """Return an error in percent, a dash where it is not known."""
    if math.isnan(error):
        return "-"
    return f"{float(f'{100 * error:.2g}'):g} %" if error < 10 else "no limit"


def beyond(value: float, limit: float, unit: str = "") -> str:
    """Return two values, the first above the second, with as many digits as show that it is."""
    shown = (float(f"{value:.{digits}g}") for digits in range(2, 18))
    return f"{next((x for x in shown if x > limit), value):.6g}{unit} > {limit:g}{unit}"


def brief(message: str) -> str:
    """Return the first and the last line of a message that may have a table between them."""
    lines = message.splitlines()
    return message if len(lines) < 2 else f"{lines[0]} [...] {lines[-1]}"


def duration(seconds: float) -> str:
    """Return a time in the unit that reads best, a dash where it is not known."""
    if math.isnan(seconds):
        return "-"
    for limit, scale, unit in ((0.95, 1e3, "ms"), (95, 1, "s"), (5700, 1 / 60, "min")):
        if seconds < limit:
            return f"{float(f'{scale * seconds:.2g}'):g} {unit}"
    return f"{float(f'{seconds / 3600:.2g}'):g} h"
