"""Text for a reader of the console or of a message: tables, and the ladder of a plan."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from fefinger.results.records import Rung
    from fefinger.scene.ask import Ask


SAID = {
    "force": "force",
    "pressure": "highest pressure over 1 mm²",
    "area": "contact area",
    "strain": "strain at the end organs",
}
"""What errors are stated of, in words."""


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


def ladder(rungs: Sequence["Rung"], chosen: "Rung | None" = None) -> str:
    """Return the ladder as a table, one line per refusal, and below it where the errors are from.

    The chosen rung is marked by a star.
    """
    rows = []
    for rung in rungs:
        said = [f"{refusal.about}: {refusal.reason}" for refusal in rung.refusals]
        star = "*" if rung is chosen else ""
        mesh, error, seconds = rung.resolution or "-", percent(rung.error), duration(rung.seconds)
        first = said[0] if said else "chosen" if star else "good enough"
        rows.append((star, rung.mechanics, mesh, error, seconds, first))
        rows += [("", "", "", "", "", more) for more in said[1:]]
    heading = ("", "mechanics", "mesh", "error", "time", "refused because")
    return f"{table(rows, heading)}\n\n{_sources(rungs)}"


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


def trust(rung: "Rung", ask: "Ask") -> str:
    """Return how far from the truth each thing that is asked may be, in a sentence or two.

    Where the force is prescribed, its error is that at the depth that is found, all others are at
    that force.
    """
    errors = {"force": rung.error, **rung.errors}
    asked = ask.force, ask.pressure, ask.pressure, ask.strain or ask.spikes
    wanted = [name for name, wish in zip(SAID, asked, strict=True) if wish]
    known = [name for name in wanted if math.isfinite(errors.get(name, math.nan))]
    unknown = [SAID[name] for name in wanted if name not in known]
    words = SAID
    if "depth" in errors:
        known, words = ["depth", *known], SAID | {"force": "force at the depth", "depth": "depth"}
    told = ", ".join(f"{words[name]} {percent(errors[name])}" for name in known)
    sentences = [f"Expected within: {told}."] if known else []
    if ask.spikes and "spike count" in errors:
        count, first = percent(errors["spike count"]), duration(errors["first spike"])
        sentences.append(f"In scenes like it spike counts were within {count}, first ones {first}.")
    elif ask.spikes:
        unknown.append("spikes")
    sentences += [f"No error is known of: {', '.join(unknown)}."] if unknown else []
    return " ".join(sentences)


def duration(seconds: float) -> str:
    """Return a time in the unit that reads best, a dash where it is not known."""
    if math.isnan(seconds):
        return "-"
    for limit, scale, unit in ((0.95, 1e3, "ms"), (95, 1, "s"), (5700, 1 / 60, "min")):
        if seconds < limit:
            return f"{float(f'{scale * seconds:.2g}'):g} {unit}"
    return f"{float(f'{seconds / 3600:.2g}'):g} h"


def _sources(rungs: Sequence["Rung"]) -> str:
    """Return one line per source of an error, with the mechanics that it is of."""
    by_source: dict[str, list[str]] = {}
    for rung in rungs:
        if not math.isnan(rung.error):
            name = f"{rung.mechanics} {rung.resolution or ''}".strip()
            by_source.setdefault(rung.evidence, []).append(name)
    rows = [(", ".join(names), source) for source, names in by_source.items()]
    return table(rows, ("error of", "evidence")) if rows else "No error is known."
