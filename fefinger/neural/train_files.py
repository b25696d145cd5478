"""Files of spike trains: arrays in NPZ, extras for other formats, and files that appear whole."""

import os
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from fefinger.support.atomic_write import moved
from fefinger.support.checks import InputError
from fefinger.support.inputs import check_input


NPZ_FORMAT = "fefinger spike trains 1"

SIGNALS = ("x_in", "current")
PER_UNIT = ("peak_mV", "block_seconds", "stimulus_driven")
LISTS = ("types", "names", "notes")
LATER = ("reruns",)
"""Lists that files of earlier versions lack."""


def read_npz(path: str | PathLike[str]) -> dict[str, NDArray[np.generic]]:
    """Read the arrays of a file that `to_npz` wrote."""
    check_input(str(path), path, "an NPZ file of spike trains")
    try:
        # Opened here: numpy leaves a damaged file open.
        with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
            data = {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError, TypeError, BadZipFile, zlib.error) as error:
        # Not what numpy says of another file: it advises to run the code in it.
        why = f": {error}" if isinstance(error, OSError) else ": it is none, or damaged"
        msg = f"{path}: expected an NPZ file of spike trains, which cannot be read{why}"
        raise InputError(msg) from error
    if str(data.get("format")) != NPZ_FORMAT:
        msg = f"{path}: expected the format {NPZ_FORMAT!r}, received {data.get('format')}"
        raise InputError(msg)
    return data


def fields_of(data: dict[str, NDArray[np.generic]]) -> dict[str, Any]:
    """Convert stored arrays to the fields of SpikeTrains; KeyError where one is missing."""
    fields: dict[str, Any] = {name: data[name] for name in ("time", *SIGNALS, *PER_UNIT)}
    fields |= {name: tuple(data[name].tolist()) for name in LISTS}
    fields |= {name: tuple(data[name].tolist()) for name in LATER if name in data}
    arrays = ("delays", "positions", "depths", "rerun_counts")
    fields |= {name: data[name] for name in arrays if name in data}
    fields |= {name: int(data[name].item()) for name in ("seed", "trial") if name in data}
    fields |= {name: data[name].item() for name in ("family",) if name in data}
    fields["times"] = tuple(np.split(data["spikes"], data["offsets"][1:-1]))
    fields["t_start"], fields["t_stop"] = data["span"].tolist()
    return fields


def of_extra(module: str, extra: str) -> ModuleType:
    """Import a module of an extra; InputError explains how to install it."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        msg = f"{module} is not installed; install it with: pip install 'fefinger[{extra}]'"
        raise InputError(msg) from error


@contextmanager
def in_place(path: str | PathLike[str]) -> Iterator[Path]:
    """Yield a temporary name next to `path`; move the file to `path` after the enclosed block."""
    path = Path(path)
    if not os.path.isdir(path.parent):
        raise InputError(f"{path}: expected a folder that exists, received {str(path.parent)!r}")
    try:
        with moved(path) as new:
            yield new
    except OSError as error:
        msg = f"{path}: cannot be written: {error.strerror or error}; choose another file"
        raise InputError(msg) from None


def equal(one: object, other: object) -> bool:
    """Whether two values of a field are equal; tuples and arrays element by element."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(equal, one, other))
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return np.array_equal(one, other, equal_nan=True)
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return False
    return bool(one == other)
