"""Numbers of MATLAB `.mat` and HDF5 files, by name, also of damaged ones: values or a sentence."""

import warnings
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fefinger.support import processes
from fefinger.support.checks import InputError
from fefinger.support.inputs import check_heaps


def matlab(field: str, path: Path) -> Mapping[str, Any]:
    """Return the numbers of a MATLAB file by name; fields of a struct are "name.field"."""
    if path.read_bytes()[:128].startswith(b"MATLAB 7.3") or _is_hdf5(path):
        return hdf5(field, path)
    most = 2.5e8  # bytes: four million rows of seven numbers
    if _unpacked(path.read_bytes(), most) > most:
        raise InputError(
            f"{field}: expected a MATLAB file with at most {most / 1e6:g} MB of values, received "
            "more, packed; cut out the part that matters"
        )
    try:
        with processes.in_background(_loaded, str(path)) as wait:
            return wait()
    except processes.WorkerExit:
        why = "a damaged one"
    except Exception as error:  # of any class, by what the bytes are
        why = f"another: {error}"
    raise InputError(f"{field}: expected a MATLAB file, received {why}")


def _loaded(path: str) -> dict[str, Any]:
    """Load a MATLAB file, in a process of its own: damaged ones end the library, or it never ends.

    A number of elements that the file states without having them is allocated.
    """
    with suppress(ImportError, ValueError, OSError):  # Windows; a lower limit of the user's
        import resource

        for limit, most in ((resource.RLIMIT_CPU, 60), (resource.RLIMIT_AS, 4_000_000_000)):
            resource.setrlimit(limit, (most, resource.getrlimit(limit)[1]))
    from scipy.io import loadmat

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of objects that are no numbers
        stored = loadmat(path, simplify_cells=True)
    simple = {
        name: np.asarray(value)
        for name, value in _flat(stored)
        if isinstance(value, np.ndarray | np.generic | int | float)  # ragged lists are none
    }
    return {name: array for name, array in simple.items() if array.dtype.kind in "iuf"}


def _unpacked(content: bytes, most: float) -> int:
    """Count the bytes of the packed variables of a MATLAB file when they are unpacked, up to most.

    The library would unpack whatever the file says, a thousand times its size.
    """
    order: Literal["little", "big"] = "little" if content[126:128] == b"IM" else "big"
    at, size = 128, 0
    while at + 8 <= len(content):
        kind, length = (int.from_bytes(content[at + i : at + i + 4], order) for i in (0, 4))
        left = content[at + 8 : at + 8 + length] if kind == 15 else b""  # 15: packed
        unpacker = zlib.decompressobj()
        with suppress(zlib.error):  # which the library reports
            while left and size <= most:
                size += len(unpacker.decompress(left, 1 << 20))
                left = unpacker.unconsumed_tail
        at += 8 + length
    return size


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _is_hdf5(path: Path) -> bool:
    import h5py

    return bool(h5py.is_hdf5(path))


def hdf5(field: str, path: Path) -> Mapping[str, Any]:
    """Return the data sets of an HDF5 file by name; units are (unit, values)."""
    import h5py

    found: dict[str, Any] = {}

    most = 1.25e8  # numbers: a gigabyte of them

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "iuf" and item.size is not None:
            if sum(values.size for _, values in found.values()) + item.size > most:
                raise InputError(
                    f"{field}: expected at most {most:g} numbers, received more in "
                    f"{name!r}; cut out the part that matters"
                )
            unit = next((item.attrs[key] for key in ("units", "unit") if key in item.attrs), "")
            found[name.replace("/", ".")] = (_unit(unit), np.asarray(item[()]))

    try:
        check_heaps(path)
        with h5py.File(path) as file:
            file.visititems(visit)
    except (InputError, MemoryError):
        raise
    except Exception as error:  # of any class, by what the bytes are
        raise InputError(
            f"{field}: expected an HDF5 file, received a damaged or another one: {error}"
        ) from None
    return found


def _unit(stated: object) -> str:
    """Return a unit as an attribute states it; "" for what is no text."""
    value = stated.item() if isinstance(stated, np.ndarray) and stated.size == 1 else stated
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    return value if isinstance(value, str) else ""
