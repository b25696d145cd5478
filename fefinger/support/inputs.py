"""What is read from outside: regular files alone, and TOML and JSON within bounds.

Every reader asks here, because a pipe without a writer waits for ever, a device has no end, and the
parsers of Python, with all that goes through their values later, recurse.
"""

import json
import os
import stat
import tomllib
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from fefinger.support.checks import InputError, shown


DEEPEST = 32
"""Largest number of tables and lists around a value; scenes and records have six."""

WIDEST = 64
"""Largest number of bits of a whole number, that of TOML."""

LINE = 10_000
"""Characters of a first line that are read."""

BOUNDS = (
    f"expected values inside at most {DEEPEST} tables or lists, and whole numbers of at most "
    f"{WIDEST} bits, received deeper or longer ones"
)

KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}
"""What is no file."""


def unreadable(path: str | PathLike[str]) -> str:
    """Why no file can be read at `path`, as "does not exist"; empty where one can."""
    try:
        kind = stat.S_IFMT(os.stat(path).st_mode)
    except (OSError, ValueError):  # ValueError: a null character in the name
        return "does not exist"
    if kind != stat.S_IFREG:
        return f"is {KINDS.get(kind, 'no file')}"
    return "" if os.access(path, os.R_OK) else "may not be read"


def check_input(field: str, path: str | PathLike[str], expected: str) -> None:
    """Raise InputError of `field`, which expects `expected`, unless `path` is a file to be read."""
    if not isinstance(path, str | PathLike):
        raise InputError(f"{field}: expected the path of {expected}, received {shown(path)}")
    if reason := unreadable(path):
        message = f"{field}: expected {expected}, received {os.fspath(path)!r}, which {reason}"
        raise InputError(message)


def read_text(field: str, path: str | PathLike[str], expected: str) -> str:
    """Read a file of UTF-8 text; InputError of `field`, which expects `expected`, for another."""
    check_input(field, path, expected)
    try:
        return Path(path).read_text(encoding="utf-8-sig")  # editors on Windows put a mark first
    except UnicodeDecodeError as error:
        received = f"no text (UTF-8): other bytes at {error.start}"
    except OSError as error:
        received = f"which cannot be read: {error.strerror}"
    raise InputError(f"{field}: expected {expected}, received {os.fspath(path)!r}, {received}")


def first_line(path: str | PathLike[str]) -> str:
    """Return the first line of a text file; "" where none can be read."""
    if unreadable(path):
        return ""
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.readline(LINE).strip()


def parse_toml(field: str, text: str) -> dict[str, Any]:
    """Parse TOML within BOUNDS; InputError of `field` beyond them, TOMLDecodeError for no TOML."""
    try:
        return bounded(field, tomllib.loads(text))
    except (tomllib.TOMLDecodeError, InputError):
        raise
    except (RecursionError, ValueError):  # ValueError: a number of thousands of digits
        raise InputError(f"{field}: {BOUNDS}") from None


def read_json(path: str | PathLike[str]) -> Any:
    """Read a JSON file within BOUNDS; InputError for another one, or none."""
    text = read_text("record", path, "a JSON file")
    try:
        return bounded("record", json.loads(text, parse_constant=_refuse))
    except (RecursionError, ValueError) as error:
        message = f"record: expected a JSON file, received {os.fspath(path)!r}: {error}"
        raise InputError(message) from None


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is no number of JSON")


def bounded(field: str, values: Any) -> Any:
    """Return nested values; InputError of `field` for such beyond BOUNDS."""
    level = [values]
    for _ in range(DEEPEST + 1):
        if any(isinstance(value, int) and value.bit_length() > WIDEST for value in level):
            break
        inner: list[Any] = []
        for value in level:
            if isinstance(value, Mapping):
                inner.extend(value.values())
            elif isinstance(value, list | tuple):
                inner.extend(value)
        if not inner:
            return values
        level = inner
    raise InputError(f"{field}: {BOUNDS}")
