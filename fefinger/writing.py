"""Files that appear complete or not at all, and a sentence where they cannot be written."""

import errno
import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from fefinger.checks import InputError


if TYPE_CHECKING:
    import xarray as xr

FULL = errno.ENOSPC, errno.EDQUOT, errno.EFBIG
"""What the system calls a full disk, a quota that is used up and a file that is too long."""


def said(error: OSError, place: str | PathLike[str] | None = None) -> str:
    """Return the sentence on files that could not be written to `place`, a file or a folder."""
    where = f" {str(place)!r}" if place is not None else ""
    advice = "free some space or choose another folder"
    advice = advice if error.errno in FULL else "choose another folder"
    return f"cannot write{where}: {error.strerror or error}; {advice}"


@contextmanager
def spoken(place: str | PathLike[str]) -> Iterator[None]:
    """Turn an OSError of the work inside, which writes to `place`, into an InputError."""
    try:
        yield
    except OSError as error:
        raise InputError(said(error, place)) from None


@contextmanager
def in_place(path: str | PathLike[str]) -> Iterator[Path]:
    """Give a temporary name beside `path`, and move the file there once it is written.

    Raises
    ------
    InputError
        A file that cannot be written; nothing is left of it.
    """
    with spoken(path), _moved(Path(path)) as new:
        yield new


@contextmanager
def together(folder: str | PathLike[str], texts: Mapping[str, str]) -> Iterator[None]:
    """Write texts to files by their names in an existing folder, around the work inside.

    All of them appear once that is done, or none.

    Raises
    ------
    InputError
        A folder that they cannot be written to.
    """
    with spoken(folder), ExitStack() as opened:
        for name, text in texts.items():
            new = opened.enter_context(_moved(Path(folder, name)))
            new.write_text(text, encoding="utf-8")
        yield


def write(folder: str | PathLike[str], texts: Mapping[str, str]) -> None:
    """Write texts as `together`, and nothing else."""
    with together(folder, texts):
        pass


@contextmanager
def _moved(path: Path) -> Iterator[Path]:
    new = path.with_name(f".{path.name}.{os.getpid()}.new")
    try:
        yield new
        new.replace(path)
    finally:
        new.unlink(missing_ok=True)


def netcdf(labeled: "xr.Dataset") -> bytes:
    """Return a Dataset as the bytes of a netCDF file.

    HDF5 writes to memory, because on a disk that is full it cannot close its file, and then ends
    the whole process.
    """
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    plain = {name: {"_FillValue": None} for name in labeled.variables}
    buffer = BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        labeled.dump_to_store(H5NetCDFStore(file), encoding=plain)
    return buffer.getvalue()
