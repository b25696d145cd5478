"""Reading of files: regular ones alone, TOML and JSON within bounds, and sound.

A pipe without a writer makes a reader wait forever, and a device has no end. Parsers recurse into
nested values, as does what uses the values later.
"""

import json
import mmap
import os
import stat
import struct
import tomllib
import warnings
from collections.abc import Mapping
from importlib import resources
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from fefinger.support.checks import InputError, shown


if TYPE_CHECKING:
    from fefinger.support.arrays import Array

Value = TypeVar("Value")

DEEPEST = 32
"""Largest number of tables and lists around a value; scenes and records have up to six."""

WIDEST = 64
"""Largest number of bits of a whole number, as in TOML."""

MOST = 4_000_000
"""Largest number of samples or rows of a file: an hour at 1 kHz."""


HEAP = b"GCOL\x01\0\0\0"
"""Beginning of a heap of an HDF5 file, which holds texts of any length."""

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
"""Things other than regular files, in messages."""


def unreadable(path: str | PathLike[str]) -> str:
    """Return why no file can be read at `path`, such as "does not exist"; "" if one can."""
    try:
        kind = stat.S_IFMT(os.stat(path).st_mode)
    except (OSError, ValueError):  # ValueError: a null character in the name
        return "does not exist"
    if kind != stat.S_IFREG:
        return f"is {KINDS.get(kind, 'no file')}"
    try:
        with open(path, "rb") as file:
            file.read(1)
    except PermissionError:
        return "may not be read"
    except OSError as error:  # of a bad disk, or of a file of the kernel
        return f"cannot be read ({error.strerror})"
    return ""


def check_input(field: str, path: str | PathLike[str], expected: str) -> None:
    """Raise InputError of `field` unless `path` is a file that can be read.

    `expected` describes the file in messages.
    """
    if not isinstance(path, str | PathLike):
        raise InputError(f"{field}: expected the path of {expected}, received {shown(path)}")
    if reason := unreadable(path):
        message = f"{field}: expected {expected}, received {os.fspath(path)!r}, which {reason}"
        raise InputError(message)


def read_text(field: str, path: str | PathLike[str], expected: str) -> str:
    """Read a file of UTF-8 text, or raise InputError as `check_input`."""
    check_input(field, path, expected)
    try:
        return Path(path).read_text(encoding="utf-8-sig")  # without the mark of Windows
    except UnicodeDecodeError as error:
        received = f"no text (UTF-8): other bytes at {error.start}"
    except OSError as error:
        received = f"which cannot be read: {error.strerror}"
    raise InputError(f"{field}: expected {expected}, received {os.fspath(path)!r}, {received}")


def first_line(path: str | PathLike[str]) -> str:
    """Return the first line of a text file; "" if it cannot be read."""
    if unreadable(path):
        return ""
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.readline(10_000).strip()


def parse_toml(field: str, text: str) -> dict[str, Any]:
    """Parse TOML; InputError of `field` beyond BOUNDS, TOMLDecodeError for other text."""
    try:
        return bounded(field, tomllib.loads(text))
    except (tomllib.TOMLDecodeError, InputError):
        raise
    except (RecursionError, ValueError):  # ValueError: a number of thousands of digits
        raise InputError(f"{field}: {BOUNDS}") from None


class NoSingleValueError(ValueError):
    """Text that is not one value of TOML."""


def parse_value(field: str, text: str) -> Any:
    """Parse one value of TOML.

    Raises NoSingleValueError for other text, also with keys on lines after the value, and
    InputError of `field` beyond BOUNDS.
    """
    try:
        table = parse_toml(field, f"value = {text}")
    except tomllib.TOMLDecodeError as error:
        raise NoSingleValueError(str(error)) from None
    value, *others = table
    if others:
        message = f"expected one value, received the key {others[0]!r} after it"
        raise NoSingleValueError(message)
    return table[value]


def read_json(path: str | PathLike[str]) -> Any:
    """Read a JSON file, or raise InputError; also for values beyond BOUNDS."""
    text = read_text("record", path, "a JSON file")
    try:
        return bounded("record", json.loads(text, parse_constant=_refuse))
    except (RecursionError, ValueError) as error:
        message = f"record: expected a JSON file, received {os.fspath(path)!r}: {error}"
        raise InputError(message) from None


def check_heaps(path: str | PathLike[str]) -> None:
    """Raise ValueError where a heap of texts of an HDF5 file is damaged: HDF5 may read on forever.

    The library goes from entry to entry by their lengths, also where a length is 0.
    """
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        start = content.find(HEAP)
        while start >= 0:
            end = start + int.from_bytes(content[start + 8 : start + 16], "little")
            at = start + 16
            while at + 16 <= min(end, len(content)):
                used, size = struct.unpack("<H6xQ", content[at : at + 16])
                at += 16 + (size + 7) // 8 * 8 if used else size
                if at > end or not (used or size):
                    raise ValueError("a heap of texts is damaged")
            start = content.find(HEAP, start + 1)


def read_report(name: str) -> str:
    """Return the text of a report that is installed with the package."""
    return resources.files("fefinger.reports").joinpath(name).read_text(encoding="utf-8")


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is no number of JSON")


def bounded(field: str, values: Value) -> Value:
    """Return nested values, or raise InputError of `field` where they are beyond BOUNDS."""
    level: list[object] = [values]
    for _ in range(DEEPEST + 1):
        if any(isinstance(value, int) and value.bit_length() > WIDEST for value in level):
            break
        inner: list[object] = []
        for value in level:
            if isinstance(value, Mapping):
                inner.extend(value.values())
            elif isinstance(value, list | tuple):
                inner.extend(value)
        if not inner:
            return values
        level = inner
    raise InputError(f"{field}: {BOUNDS}")


def read_wave(name: str, file: Path) -> "tuple[int, Array]":
    """Read a WAV file: samples per s, and the samples (n,) of its first channel, from -1 to 1.

    Raises InputError of `name` for another file, a silent one, or one of more than MOST samples.
    """
    import numpy as np
    from scipy.io import wavfile

    check_input(name, file, "a WAV file")
    # A sample has at most 16 bytes, of two channels of 8.
    size, largest = file.stat().st_size, MOST * 16
    if size > largest:
        raise InputError(
            f"{name}: expected a WAV file of at most {largest / 1e6:g} MB, received {str(file)!r} "
            f"of {size / 1e6:.4g} MB; cut out the part that matters"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)  # chunks without sound
            rate, samples = wavfile.read(file)
    except Exception as error:  # of any class
        # SciPy raises UnboundLocalError where a chunk before the samples is broken.
        broken = isinstance(error, UnboundLocalError)
        why = "a chunk of it is broken, so that its samples are not found" if broken else error
        raise InputError(f"{name}: expected a WAV file, received {str(file)!r}: {why}") from None
    first = samples if samples.ndim == 1 else samples[:, 0]
    if not 2 <= len(first) <= MOST:
        raise InputError(
            f"{name}: expected 2 to {MOST} samples, received {len(first)} in {str(file)!r}; cut "
            "out the part that matters"
        )
    wave = first.astype(np.float64)
    if first.dtype == np.uint8:
        wave = (wave - 128.0) / 128.0
    elif np.issubdtype(first.dtype, np.integer):
        wave = wave / -float(np.iinfo(first.dtype).min)
    if not (np.isfinite(wave).all() and np.abs(wave).max() <= 1.0):
        raise InputError(f"{name}: expected samples from -1 to 1, received others in {str(file)!r}")
    if not wave.any():
        message = f"{name}: expected a WAV file with sound, received {str(file)!r}, which is silent"
        raise InputError(message)
    return int(rate), wave
