"""The user's cache: meshes, operators, patches, presses that were made once and are used again.

What is in it appears complete or not at all, and leaves at once: whoever reads it while it is
removed keeps what is open, and whoever comes later makes it anew.
"""

import json
import os
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from fefinger.support.atomic_write import temporary_folder
from fefinger.support.interrupt import on_end, shielded


KINDS = ("meshes", "operators", "patches", "presses")
LIMITS_MB = {"operators": 10_000, "patches": 2000}
"""What a kind may take, beyond which the least recently used of it goes: an operator is kept for
every finger, a patch for every indenter and set of end organs."""

ABANDONED = 24 * 3600.0
"""Age in s of a part that was never finished, after which nobody is writing it any more."""

DAY = 24 * 3600.0

BUILDING, LEAVING = ".building-", ".leaving-"


@dataclass(frozen=True)
class Entry:
    """Something kept: its kind, what it is, its files or folder, bytes, and when it was used."""

    kind: str
    what: str
    paths: tuple[Path, ...]
    size: int
    used: float


def root() -> Path:
    """Return the folder of the cache."""
    from platformdirs import user_cache_path

    return user_cache_path("fefinger")


def entries() -> tuple[Entry, ...]:
    """Return all that is kept, by kind and the last used first; and what was never finished."""
    found = [entry for kind in KINDS for entry in _kept(kind)]
    return tuple(sorted(found, key=lambda entry: (entry.kind, -entry.used)))


def remove(chosen: Sequence[Entry]) -> tuple[Entry, ...]:
    """Remove entries, and return those that could be."""
    return tuple(entry for entry in chosen if all([_gone(path) for path in entry.paths]))


def unused(days: float) -> tuple[Entry, ...]:
    """Return what has not been used for so many days, and what was abandoned."""
    now = time.time()
    least = {True: ABANDONED, False: days * DAY}
    return tuple(e for e in entries() if now - e.used >= least[e.what == UNFINISHED])


def touch(place: Path) -> None:
    """Note that an entry is used."""
    with suppress(OSError):
        os.utime(place)


@contextmanager
def appearing(place: Path) -> Iterator[Path]:
    """Yield a folder to fill, which then appears in its place, unless another did before."""
    place.parent.mkdir(parents=True, exist_ok=True)
    with temporary_folder(place.parent, BUILDING) as path:
        yield path
        with suppress(OSError), shielded():  # another process was faster
            os.rename(path, place)


@contextmanager
def alone(place: Path, waiting: Callable[[], object] = lambda: None) -> Iterator[None]:
    """Let only one process at a time, and one thread of it, make what is to be at a place.

    Others wait, and then should look whether it is there; `waiting` is called before. The system
    gives up the lock of a process that ends in any way. Where there are no locks, or the cache
    cannot be written, nobody waits.
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
    """Return the handle of a file that is locked; None if who held it took it away meanwhile.

    Raises OSError or ImportError where there is no lock to be had.
    """
    import fcntl  # not on Windows

    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            waiting()
            fcntl.flock(handle, fcntl.LOCK_EX)
        with suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(handle), os.stat(path)):
                return handle
    except BaseException:  # as KeyboardInterrupt while it waits
        os.close(handle)
        raise
    os.close(handle)
    return None


def limit(kind: str) -> None:
    """Remove what was used least recently of a kind, until the rest takes no more than it may.

    The last used stays in any case, and what is being made.
    """
    finished = [entry for entry in _kept(kind) if entry.what != UNFINISHED]
    total = 0
    for number, entry in enumerate(sorted(finished, key=lambda entry: -entry.used)):
        total += entry.size
        if number and total > 1e6 * LIMITS_MB[kind]:
            remove([entry])


UNFINISHED = "unfinished"


def _kept(kind: str) -> Iterator[Entry]:
    """Yield what is kept of a kind: folders, and files that go together, whole or damaged."""
    for paths in _together(root() / kind):
        with suppress(OSError):  # removed by another process in the meantime
            first, size = paths[0], sum(_size(path) for path in paths)
            used = max(path.stat().st_mtime for path in paths)
            what = UNFINISHED if first.name.startswith(".") else _told(first)
            yield Entry(kind, what, paths, size, used)


def _together(folder: Path) -> Iterator[tuple[Path, ...]]:
    """Yield each folder and file in a folder, a mesh with its sidecar first; none if unreadable."""
    found: dict[str, list[Path]] = {}
    with suppress(OSError):
        for path in sorted(folder.iterdir()):
            alone = path.name.startswith(".") or path.suffix not in (".json", ".vtu")
            found.setdefault(path.name if alone else f"{path.stem}.vtu", []).append(path)
    yield from map(tuple, found.values())


def _size(path: Path) -> int:
    if not path.is_dir():
        return path.stat().st_size
    return sum(file.stat().st_size for file in path.rglob("*") if file.is_file())


def _told(path: Path) -> str:
    """Return what a mesh (by its sidecar) or an operator (by its folder) is of.

    Patches and presses have nothing to say, nor has what is damaged.
    """
    try:
        if path.suffix == ".json":
            return str(json.loads(path.read_text(encoding="utf-8"))["name"])
        identity = json.loads((path / "identity.json").read_text(encoding="utf-8"))
        ratios = " and ".join(f"{value:g}" for value in identity["poisson"])
        return (
            f"{identity['parity']} half of mesh {identity['mesh_file_sha256'][:8]}, modulus ratio "
            f"{identity['modulus_ratio']:.4g}, Poisson's ratios {ratios}"
        )
    except (OSError, ValueError, KeyError, TypeError):
        return ""


def _gone(path: Path) -> bool:
    """Take a file or folder out of the cache at once, then delete it; return whether it went."""
    if not path.is_dir():
        with suppress(OSError):
            path.unlink()
        return not path.exists()
    aside = path.with_name(f"{LEAVING}{os.getpid()}-{path.name.lstrip('.')}")
    try:
        os.rename(path, aside)
    except OSError:  # gone already, or held by another process where that keeps a folder
        return not path.exists()
    shutil.rmtree(aside, ignore_errors=True)
    return True
