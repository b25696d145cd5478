"""The user's cache of meshes, operators, patches and presses, which any process may share.

An entry is a folder. It appears complete or not at all and is removed at once: a process that reads
it meanwhile keeps its open files, and a later one builds the entry again. So it does where a file
is not as it was written, by its checksum.
"""

import os
import shutil
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TypeVar
from zipfile import BadZipFile

from fefinger.support.atomic_write import lock, temporary_folder
from fefinger.support.interrupt import on_end, shielded


Value = TypeVar("Value")

KINDS = ("meshes", "operators", "modes", "patches", "presses", "elastic", "machine")
LIMITS_MB = {"operators": 10_000, "modes": 2000, "patches": 2000, "elastic": 2000}
"""Limits in MB by kind; beyond them the least recently used entries are removed. There is an
operator per finger, and a patch per indenter and set of end organs."""

WHAT, CHECKSUMS = "what.txt", "checksums.txt"
"""Files of every entry: its description, and the checksums of its other files."""


DAY = 24 * 3600.0  # s

ABANDONED = DAY
"""Age in s from which an unfinished entry counts as abandoned by its process."""

DAMAGED = (OSError, ValueError, LookupError, TypeError, EOFError, BadZipFile, zlib.error)
"""Errors of reading an entry of another version, or shipped arrays that are damaged."""

BUILDING, LEAVING = ".building-", ".leaving-"
UNFINISHED = "unfinished"


@dataclass(frozen=True)
class Entry:
    """One cached item: kind, description, folder, size in bytes, time of last use."""

    kind: str
    what: str
    path: Path
    size: int
    used: float


def root() -> Path:
    """Folder of the cache."""
    from platformdirs import user_cache_path

    return user_cache_path("fefinger")


def entries() -> tuple[Entry, ...]:
    """All entries, finished or not, by kind and the last used first."""
    unsorted = [entry for kind in KINDS for entry in _entries(kind)]
    return tuple(sorted(unsorted, key=lambda entry: (entry.kind, -entry.used)))


def remove(chosen: Sequence[Entry]) -> tuple[Entry, ...]:
    """Remove entries and return those whose removal succeeded."""
    return tuple(entry for entry in chosen if _removed(entry.path))


def unused(days: float) -> tuple[Entry, ...]:
    """Entries that were not used for `days` days, and abandoned ones."""
    now = time.time()
    least = {UNFINISHED: ABANDONED}
    return tuple(e for e in entries() if now - e.used >= least.get(e.what, days * DAY))


def load(place: Path, read: Callable[[Path], Value]) -> Value | None:
    """Read the folder of an entry with `read`, as its last use; None without an entry.

    An entry that is damaged is removed.
    """
    if not os.path.lexists(place):
        return None
    with suppress(OSError):  # a cache that may be read alone
        os.utime(place)
    with suppress(*DAMAGED):
        known = place / CHECKSUMS
        if known.is_file() and known.read_text(encoding="utf-8") == _checksums(place):
            return read(place)
    _removed(place)
    return None


@contextmanager
def appearing(place: Path, what: str, *, replacing: bool = False) -> Iterator[Path]:
    """Yield a folder to fill; rename it to `place` afterwards, with its description and checksums.

    An entry that exists by then stays, since other processes may have used it already, unless it is
    to be replaced. Raises OSError where the cache cannot be written.
    """
    place.parent.mkdir(parents=True, exist_ok=True)
    with temporary_folder(place.parent, BUILDING) as path:
        yield path
        (path / WHAT).write_text(what, encoding="utf-8")
        (path / CHECKSUMS).write_text(_checksums(path, place.name), encoding="utf-8")
        with suppress(OSError), shielded():
            if replacing:
                _removed(place)
            os.rename(path, place)


def _checksums(folder: Path, name: str = "") -> str:
    """Lines with the name of an entry (by default its folder's), and the checksums of its files."""
    lines = [name or folder.name]
    for file in sorted(folder.iterdir()):
        if file.name != CHECKSUMS and file.is_file():
            status = file.stat()
            lines.append(f"{_crc32(file, status.st_size, status.st_mtime_ns):08x} {file.name}")
    return "\n".join(lines)


@lru_cache
def _crc32(file: Path, size: int, modified: int) -> int:
    """CRC-32 of a file, computed once in a process: 3 to 4 GB/s."""
    total = 0
    with file.open("rb") as opened:
        while chunk := opened.read(2**20):
            total = zlib.crc32(chunk, total)
    return total


@contextmanager
def alone(place: Path, waiting: Callable[[], object] = lambda: None) -> Iterator[None]:
    """Hold a lock so that one thread of one process at a time builds the entry at `place`.

    Others call `waiting`, wait, and should then look whether the entry exists. The system releases
    the lock of a process that ends in any way. Without locks, or in a cache that cannot be written,
    nobody waits.
    """
    path = place.with_name(f"{BUILDING}{place.stem}.lock")
    handle = None
    with suppress(OSError, ImportError):
        path.parent.mkdir(parents=True, exist_ok=True)
        while handle is None:
            handle = _locked(path, waiting)
    if handle is None:
        yield
        return
    with on_end(lambda: path.unlink(missing_ok=True)):
        try:
            yield
        finally:
            with suppress(OSError):
                path.unlink()
            os.close(handle)


def _locked(path: Path, waiting: Callable[[], object]) -> int | None:
    """Lock a file and return its handle; None if the holder before deleted the file meanwhile.

    Raises OSError or ImportError where the system gives no lock.
    """
    handle = lock(path, os.O_RDWR | os.O_CREAT, waiting)
    with ExitStack() as opened, suppress(FileNotFoundError):
        opened.callback(os.close, handle)
        if os.path.samestat(os.fstat(handle), os.stat(path)):
            opened.pop_all()
            return handle
    return None


def limit(kind: str) -> None:
    """Remove the least recently used entries of a kind until the rest is within LIMITS_MB.

    The last used entry and unfinished ones stay in any case.
    """
    finished = [entry for entry in _entries(kind) if entry.what != UNFINISHED]
    total = 0
    for number, entry in enumerate(sorted(finished, key=lambda entry: -entry.used)):
        total += entry.size
        if number and total > 1e6 * LIMITS_MB[kind]:
            remove([entry])


def _entries(kind: str) -> Iterator[Entry]:
    """Yield the entries of one kind, whole or damaged."""
    with suppress(OSError):  # there are none
        for path in sorted((root() / kind).iterdir()):
            with suppress(OSError):  # removed by another process in the meantime
                what = UNFINISHED if path.name.startswith(".") else _description(path)
                yield Entry(kind, what, path, _size(path), path.lstat().st_mtime)


def _size(path: Path) -> int:
    return sum(file.lstat().st_size for file in (path, *path.rglob("*")) if not file.is_dir())


def _description(path: Path) -> str:
    """Read the description of an entry; "" for damaged ones."""
    with suppress(OSError, ValueError):
        return (path / WHAT).read_text(encoding="utf-8")
    return ""


def _removed(path: Path) -> bool:
    """Move a file or folder out of the cache, then delete it; True if it is no longer there."""
    if path.is_symlink() or not path.is_dir():
        with suppress(OSError):
            path.unlink()
        return not os.path.lexists(path)
    aside = path.with_name(f"{LEAVING}{os.getpid()}-{path.name.lstrip('.')}")
    try:
        os.rename(path, aside)
    except OSError:  # gone already, or held by another process where that keeps a folder
        return not path.exists()
    shutil.rmtree(aside, ignore_errors=True)
    return True
