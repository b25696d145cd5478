"""Output files: checks before a computation starts, atomic writing, and messages where it fails."""

import errno
import os
import secrets
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from fefinger.support.checks import InputError
from fefinger.support.interrupt import on_end, shielded


if TYPE_CHECKING:
    import xarray as xr


SAVING = ".saving-"
"""Prefix of the hidden folders in which files are completed, on the file system of their place."""

RANDOM = 6
"""Random bytes in the name of a temporary folder."""

FULL = errno.ENOSPC, errno.EDQUOT, errno.EFBIG
"""Error numbers of a full disk, a used-up quota and a file that is too long."""


def write_error(error: OSError, place: str | PathLike[str] | None = None) -> str:
    """Error message for files that could not be written to `place`, a file or a folder."""
    where = f" {str(place)!r}" if place is not None else ""
    space = "free some space or " if error.errno in FULL else ""
    return f"cannot write{where}: {error.strerror or error}; {space}choose another folder"


@contextmanager
def as_input_error(place: str | PathLike[str]) -> Iterator[None]:
    """Turn an OSError of the enclosed block, which writes to `place`, into an InputError."""
    try:
        yield
    except OSError as error:
        raise InputError(write_error(error, place)) from None


@contextmanager
def in_place(path: str | PathLike[str]) -> Iterator[Path]:
    """Yield a temporary name beside `path`; move the file to `path` after the enclosed block.

    Raises InputError for a file that cannot be written; nothing is left of it.
    """
    with as_input_error(path), moved(Path(path)) as new:
        yield new


@contextmanager
def together(folder: str | PathLike[str], texts: Mapping[str, str]) -> Iterator[None]:
    """Write text files, by name, into an existing folder around an enclosed block.

    All files appear after the block has finished; none appears if it fails.

    Raises InputError for a folder that cannot be written to.
    """
    with as_input_error(folder), ExitStack() as opened:
        for name, text in texts.items():
            new = opened.enter_context(moved(Path(folder, name)))
            new.write_text(text, encoding="utf-8")
        yield


def write(folder: str | PathLike[str], texts: Mapping[str, str]) -> None:
    """Write text files, by name, into an existing folder: all of them or none."""
    with together(folder, texts):
        pass


@contextmanager
def moved(path: Path) -> Iterator[Path]:
    """Yield a temporary path of the same name, as `in_place`, but raise OSError on failure."""
    with temporary_folder(path.parent, SAVING) as folder:
        yield folder / path.name
        with shielded():
            (folder / path.name).replace(path)


@contextmanager
def temporary_folder(
    inside: str | PathLike[str] | None = None, prefix: str = "fefinger-"
) -> Iterator[Path]:
    """Yield a new folder and remove it after the enclosed block.

    It lies in `inside`, by default in the temporary folder of the system. It is also removed when a
    signal ends the process (`interrupt`); and those that killed processes left there are removed
    first, since a folder is locked as long as the process that made it lives. (On Windows, which
    has no such locks, they stay.)
    """
    parent = Path(inside or tempfile.gettempdir())
    for left in parent.glob(f"{prefix}{'[0-9a-f]' * 2 * RANDOM}"):
        with suppress(OSError, ImportError), ExitStack() as held:
            held.callback(os.close, lock(left))
            remove_folder(left)
    with ExitStack() as opened:
        with shielded():  # no folder without an action that removes it
            path = _locked_folder(parent, prefix, opened)
            opened.enter_context(on_end(lambda: remove_folder(path)))
            opened.callback(remove_folder, path)
        yield path


def _locked_folder(parent: Path, prefix: str, opened: ExitStack) -> Path:
    """Make a folder that is locked until `opened` closes, where the system has locks."""
    while True:
        path = parent / f"{prefix}{secrets.token_hex(RANDOM)}"
        path.mkdir(mode=0o700)
        try:
            opened.callback(os.close, lock(path))
        except (BlockingIOError, FileNotFoundError):
            continue  # another process took it for one that was left, and removes it
        except (OSError, ImportError):
            return path
        if path.exists():
            return path


def lock(path: Path, flags: int = os.O_RDONLY, waiting: Callable[[], object] | None = None) -> int:
    """Lock a file or folder and return the open handle that holds the lock.

    While another process holds it, call `waiting` and wait. Raises OSError where the system gives
    no lock or, without `waiting`, another process holds it, and ImportError on Windows.
    """
    import fcntl

    handle = os.open(path, flags, 0o644)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if waiting is None:
                raise
            waiting()
            fcntl.flock(handle, fcntl.LOCK_EX)
    except BaseException:  # as KeyboardInterrupt while it waits
        os.close(handle)
        raise
    return handle


def remove_folder(path: Path) -> None:
    """Remove a folder with its contents, also while another thread still writes there."""
    for _ in range(10):  # a file written during the removal makes rmtree leave the folder
        shutil.rmtree(path, ignore_errors=True)
        if not path.exists():
            return


PACKED = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
"""How. Higher levels take three times as long for a tenth less."""


def netcdf(labeled: "xr.Dataset") -> bytes:
    """Return a Dataset as the bytes of a netCDF file.

    HDF5 writes to memory, because on a disk that is full it cannot close its file, and then ends
    the whole process.
    """
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    encoding: dict[object, dict[str, object]] = {}
    many = 1000  # values from which on an array is compressed
    for name, variable in labeled.variables.items():
        packed = PACKED if variable.size >= many and variable.dtype.kind in "iuf" else {}
        encoding[name] = {"_FillValue": None, **packed}
    buffer = BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        labeled.dump_to_store(H5NetCDFStore(file), encoding=encoding)
    return buffer.getvalue()


def check_ending(path: str | PathLike[str], option: str, ending: str) -> None:
    """Raise InputError unless the file given as `option` has the suffix `ending`."""
    if Path(path).suffix.lower() != ending:
        message = f"{option}: expected a file that ends in {ending}, received {os.fspath(path)!r}"
        raise InputError(message)


def output_file(path: str | PathLike[str], option: str, ending: str = "") -> Path:
    """Check the file given as `option` and create its folder; InputError where it is unusable."""
    if ending:
        check_ending(path, option, ending)
    if os.path.isdir(path):
        message = f"{option}: expected a file, received the folder {str(path)!r}; choose another"
        raise InputError(message)
    output_folder(Path(path).parent)
    check_name(path, option)
    return Path(path)


def check_name(path: str | PathLike[str], option: str) -> None:
    """Raise InputError where no file can have the name given as `option`, as it is too long."""
    try:
        os.lstat(path)
    except FileNotFoundError:
        return
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"{option}: expected a file that can be written, received {os.fspath(path)!r} "
            f"({reason}); choose another"
        ) from None


def output_folder(folder: str | PathLike[str]) -> Path:
    """Create `folder` if needed and return it; InputError where files cannot be written to it."""
    if not os.fspath(folder).strip():
        raise InputError(
            "output folder: expected a name, received an empty one; write . for the current one"
        )
    path = Path(folder)
    advice = "choose another"
    if os.path.exists(path) and not os.path.isdir(path):
        message = f"output folder: expected a folder, received the file {str(path)!r}; {advice}"
        raise InputError(message)
    try:
        for each in reversed(_missing(path)):  # mkdir(parents=True) recurses
            each.mkdir(exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"output folder: expected a folder that can be written, received {str(path)!r} "
            f"({reason}); {advice}"
        ) from None
    return path


def _missing(path: Path) -> list[Path]:
    """List a folder and those around it that do not exist, the innermost first."""
    return [each for each in (path, *path.parents) if not os.path.lexists(each)]


def keep(foreign: Sequence[str], folder: str | PathLike[str], ours: str) -> None:
    """Raise InputError where writing `ours` would replace files of another origin.

    foreign: names of these files in `folder`: the user or another command wrote them.
    """
    if foreign:
        raise InputError(
            f"output folder: {', '.join(map(repr, foreign))} in {os.fspath(folder)!r} would be "
            f"overwritten, and no {ours} of fefinger there holds it; move it away or choose "
            "another folder"
        )


@contextmanager
def output(folder: str | PathLike[str] | None) -> Iterator[Path | None]:
    """Create an output folder for the enclosed block; after an error remove it if it is empty."""
    if folder is None:
        yield None
        return
    made = _missing(Path(folder))

    def remove_empty() -> None:
        for path in made:
            with suppress(OSError, ValueError):  # something is in it, or it has no name
                path.rmdir()

    try:
        with on_end(remove_empty):
            yield output_folder(folder)
    except BaseException:  # as KeyboardInterrupt
        remove_empty()
        raise
