"""The user's cache of meshes, operators, patches and presses, which any process may share.

An entry appears complete or not at all and is removed at once: a process that reads it meanwhile
keeps its open files, and a later one builds the entry again.
"""

import json
import os
import shutil
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from tokenize import TokenError
from zipfile import BadZipFile

from fefinger.support.atomic_write import lock, temporary_folder
from fefinger.support.interrupt import on_end, shielded


KINDS = ("meshes", "operators", "modes", "patches", "presses", "elastic")
LIMITS_MB = {"operators": 10_000, "modes": 2000, "patches": 2000, "elastic": 2000}
"""Limits in MB by kind; beyond them the least recently used entries are removed. There is an
operator per finger, and a patch per indenter and set of end organs."""

DAY = 24 * 3600.0

ABANDONED = DAY
"""Age in s from which an unfinished entry counts as abandoned by its process."""

DAMAGED = (
    *(OSError, ValueError, KeyError, EOFError, BadZipFile, zlib.error),
    *(NotImplementedError, RuntimeError, SyntaxError, TokenError),  # of damaged headers
)
"""Errors of reading missing or damaged arrays, which are then made again."""

BUILDING, LEAVING = ".building-", ".leaving-"
UNFINISHED = "unfinished"


@dataclass(frozen=True)
class Entry:
    """One cached item: kind, description, files or folder, size in bytes, time of last use."""

    kind: str
    what: str
    paths: tuple[Path, ...]
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
    return tuple(entry for entry in chosen if all([_removed(path) for path in entry.paths]))


def unused(days: float) -> tuple[Entry, ...]:
    """Entries that were not used for `days` days, and abandoned ones."""
    now = time.time()
    least = {UNFINISHED: ABANDONED}
    return tuple(e for e in entries() if now - e.used >= least.get(e.what, days * DAY))


def touch(place: Path) -> None:
    """Set the time of last use of an entry to now."""
    with suppress(OSError):
        os.utime(place)


@contextmanager
def appearing(place: Path) -> Iterator[Path]:
    """Yield a folder to fill and rename it to `place` afterwards, unless `place` exists by then."""
    place.parent.mkdir(parents=True, exist_ok=True)
    with temporary_folder(place.parent, BUILDING) as path:
        yield path
        with suppress(OSError), shielded():  # another process was faster
            os.rename(path, place)


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
    finished = [entry for entry in _entries(kind, described=False) if entry.what != UNFINISHED]
    total = 0
    for number, entry in enumerate(sorted(finished, key=lambda entry: -entry.used)):
        total += entry.size
        if number and total > 1e6 * LIMITS_MB[kind]:
            remove([entry])


def _entries(kind: str, *, described: bool = True) -> Iterator[Entry]:
    """Yield the entries of one kind, whole or damaged; descriptions read files of each."""
    for paths in _together(root() / kind):
        with suppress(OSError):  # removed by another process in the meantime
            first, size = paths[0], sum(_size(path) for path in paths)
            used = max(path.stat().st_mtime for path in paths)
            what = UNFINISHED if first.name.startswith(".") else ""
            if described and not what:
                what = _description(first)
            yield Entry(kind, what, paths, size, used)


def _together(folder: Path) -> Iterator[tuple[Path, ...]]:
    """Yield the paths of each entry in a folder: one, or a mesh and its sidecar (first)."""
    groups: dict[str, list[Path]] = {}
    with suppress(OSError):
        for path in sorted(folder.iterdir()):
            alone = path.name.startswith(".") or path.suffix not in (".json", ".vtu")
            groups.setdefault(path.name if alone else f"{path.stem}.vtu", []).append(path)
    yield from map(tuple, groups.values())


def _size(path: Path) -> int:
    if not path.is_dir():
        return path.stat().st_size
    return sum(file.stat().st_size for file in path.rglob("*") if file.is_file())


def _description(path: Path) -> str:
    """Describe a mesh (from its sidecar) or what was computed on it; "" for damaged entries."""
    try:
        return _DESCRIPTIONS[path.parent.name](path)
    except (*DAMAGED, TypeError, IndexError):
        return ""


def _body(path: Path) -> str:
    """Describe the finger of an operator or of modes from its identity."""
    identity = json.loads((path / "identity.json").read_text(encoding="utf-8"))
    ratios = " and ".join(f"{value:g}" for value in identity["poisson"])
    sha256 = identity["mesh_file_sha256"]
    mesh = _mesh_names().get(sha256, f"{sha256[:8]}, which is no longer here")
    loads = {"even": "equal", "odd": "opposite"}[identity["parity"]]
    stiff = f"pulp {identity['modulus_ratio']:.3g} times as stiff as skin"
    return f"mesh {mesh}, {loads} loads on both sides, {stiff}, Poisson's ratios {ratios}"


def _mesh_names() -> dict[str, str]:
    """Return the names of the shipped and cached meshes by the hash of their files."""
    names = {}
    with suppress(ModuleNotFoundError):
        for folder in (files("fefinger.meshes"), root() / "meshes"):
            for file in folder.iterdir() if folder.is_dir() else ():
                if file.name.endswith(".json"):
                    with suppress(OSError, ValueError, KeyError, TypeError):
                        about = json.loads(file.read_text(encoding="utf-8"))
                        names[about["sha256"]] = about["name"]
    return names


def _patch(path: Path) -> str:
    import numpy as np

    points = len(np.load(path / "flexibility.npy", mmap_mode="r", allow_pickle=False))
    return f"object on a finger, for `condensed`: {points} points of the pad"


def _reach(path: Path) -> str:
    """Say how far a press with a depth in mm and a force in N goes."""
    import numpy as np

    with path.open("rb") as opened, np.load(opened, allow_pickle=False) as stored:
        depth, force = stored["depth"], stored["force"]
    return f"of {len(depth)} depths to {depth[-1]:.3g} mm and {force[-1]:.3g} N"


_DESCRIPTIONS: dict[str, Callable[[Path], str]] = {
    "meshes": lambda path: str(json.loads(path.read_text(encoding="utf-8"))["name"]),
    "operators": lambda path: f"finger for `condensed`: {_body(path)}",
    "modes": lambda path: f"finger for `modal`: {_body(path)}",
    "patches": _patch,
    "presses": lambda path: f"press of a calibration: {_reach(path)}",
    "elastic": lambda path: f"object on a finger, for `pressed`: table {_reach(path)}",
}


def _removed(path: Path) -> bool:
    """Move a file or folder out of the cache, then delete it; True if it is no longer there."""
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
