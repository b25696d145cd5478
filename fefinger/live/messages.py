"""What the page may send: JSON objects with a `kind`, checked as any other input."""

import json
from dataclasses import dataclass

from fefinger.live.player import ABOVE, PRESETS
from fefinger.live.setup import Setup
from fefinger.support.checks import InputError, boolean, choice, number, reject_unknown
from fefinger.support.vocabulary import Control


LONGEST = 2000
"""Largest number of letters of a message."""


@dataclass(frozen=True)
class Choose:
    """Prepare the finger and the object of a choice."""

    setup: Setup


@dataclass(frozen=True)
class Move:
    """Move the object to a depth in mm or a force in N."""

    control: Control
    value: float


@dataclass(frozen=True)
class Play:
    """Play a preset."""

    name: str


@dataclass(frozen=True)
class Pause:
    """Stop the clock, or let it go on."""

    on: bool


@dataclass(frozen=True)
class Record:
    """Begin a record, or end it."""

    on: bool


@dataclass(frozen=True)
class Save:
    """Save the record."""


@dataclass(frozen=True)
class Drawn:
    """A frame was drawn; the next may follow."""


Message = Choose | Move | Play | Pause | Record | Save | Drawn

KEYS = {
    "choose": ("setup",),
    "move": ("control", "value"),
    "play": ("name",),
    "pause": ("on",),
    "record": ("on",),
    "save": (),
    "drawn": (),
}
"""Keys of the messages by their kind, all of them needed."""


def parse(text: str) -> Message:
    """Return a message of the page; InputError for anything else."""
    if len(text) > LONGEST:
        size = f"{len(text)} letters"
        raise InputError(f"message: expected at most {LONGEST} letters, received {size}")
    try:
        table = json.loads(text)
    except (ValueError, RecursionError):
        table = None
    if not isinstance(table, dict):
        raise InputError(f"message: expected a JSON object, received {text[:40]!r}")
    kind = choice("message.kind", table.pop("kind", None), KEYS)
    reject_unknown("message", table, KEYS[kind])
    for key in KEYS[kind]:
        if key not in table:
            raise InputError(f"message.{key}: missing; a message {kind!r} needs it")
    return _read(kind, table)


def _read(kind: str, table: dict[str, object]) -> Message:
    """Return a message from a table with the keys of its kind."""
    if kind == "choose":
        given = table["setup"]
        if not isinstance(given, dict):
            raise InputError(f"message.setup: expected a table, received {given!r}")
        return Choose(Setup.of(given))
    if kind == "move":
        control = Control(choice("message.control", table["control"], tuple(Control)))
        least, unit = control.of(ABOVE, 0.0), control.unit
        return Move(control, number("message.value", table["value"], at_least=least, unit=unit))
    if kind == "play":
        return Play(choice("message.name", table["name"], PRESETS))
    if kind in ("pause", "record"):
        on = boolean("message.on", table["on"])
        return Pause(on) if kind == "pause" else Record(on)
    return Save() if kind == "save" else Drawn()
