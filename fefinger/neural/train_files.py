"""Files of spike trains: arrays in NPZ, extras for other formats, and files that appear whole.

Among the other formats: Neurodata Without Borders (NWB), in a file that its inspector accepts.
"""

import hashlib
import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from importlib import import_module
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from fefinger.support.arrays import Array
from fefinger.support.atomic_write import moved
from fefinger.support.checks import InputError, number
from fefinger.support.inputs import check_input


if TYPE_CHECKING:
    import pandas as pd


NPZ_FORMAT = "fefinger spike trains 1"

SIGNALS = ("x_in", "current")
PER_UNIT = ("peak_mV", "block_seconds", "stimulus_driven")
LISTS = ("types", "names", "notes")
LATER = ("reruns",)
"""Lists that files of earlier versions lack."""

CSV_COLUMNS = ("unit", "type", "x_mm", "y_mm", "z_mm", "time_s")

UNIT_COLUMNS = (
    *("unit", "type", "x_mm", "y_mm", "z_mm", "depth_mm", "delay_s"),
    *("count", "count_least", "count_most", "t_start_s", "t_stop_s"),
)
"""Columns of the table of units, with their number of spikes from t_start_s to t_stop_s, and the
least and largest one in other runs."""

OPTIONAL = ("delays", "positions", "depths", "seed", "trial", "rerun_counts")

STORED = ("time", *SIGNALS, *PER_UNIT, *LISTS, *LATER, *OPTIONAL)
"""Fields of SpikeTrains that files hold as they are."""

UNITS = {
    "times": "s",
    "time": "s",
    "x_in": "mm",
    "current": "uA/cm2",
    "peak_mV": "mV",
    "block_seconds": "s",
    "stimulus_driven": "1",
    "delays": "s",
    "positions": "mm",
    "depths": "mm",
    "rerun_counts": "1",
}
"""Units of the arrays of SpikeTrains, as stored with them."""

MEANINGS = {
    "x_in": "input of the end organs, compression positive, linear between its times",
    "current": "generator current at these times, not linear between them: the membranes were "
    "given it at more times",
}
"""Descriptions of SIGNALS, for file formats that hold descriptions."""


def write_npz(path: str | PathLike[str], times: Sequence[Array], given: Mapping[str, Any]) -> None:
    """Write the spike times (n_spikes,) of units and the other fields of spike trains."""
    arrays = {name: given[name] for name in STORED if given[name] is not None}
    arrays |= {name: whole(arrays[name]) for name in ("seed", "trial") if name in arrays}
    arrays |= {
        "spikes": np.concatenate(times),
        "offsets": np.cumsum([0, *map(len, times)]),
        "span": [given["t_start"], given["t_stop"]],
        "format": NPZ_FORMAT,
        "family": given["family"],
        "units_of_arrays": [f"{name} {unit}" for name, unit in UNITS.items()],
        "meanings": [f"{name}: {meaning}" for name, meaning in MEANINGS.items()],
    }
    with in_place(path) as new, open(new, "wb") as file:
        np.savez_compressed(file, **arrays)


def whole(value: int) -> int | str:
    """Return a whole number of 0 or more, as text where it has more bits than files hold."""
    return value if value <= np.iinfo(np.int64).max else str(value)


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


SIMULATED = {
    "subject_id": "simulated",
    "description": "a computed fingertip with model afferents; no person was recorded",
    "species": "Homo sapiens",
    "sex": "U",
    "age": "P18Y/",
}
"""Subject of computed spikes: an adult's finger."""

COLUMNS = {
    "unit_name": "name of the unit",
    "afferent_class": "SAI, SAII, FAI or FAII",
    "x_mm": "distal place of the end organ, nan if unknown",
    "y_mm": "radial place of the end organ, nan if unknown",
    "z_mm": "dorsal place of the end organ, nan if unknown",
    "depth_mm": "depth of the end organ under the skin, nan if unknown",
    "delay_s": "conduction delay from the end organ to the recording, part of the spike times",
}
"""Columns of the table of units, and their meaning."""


class Recorded(NamedTuple):
    """What is written: spike times in s by unit, units, span in s, and what drove them.

    table: one row per unit with COLUMNS first; time (n_t,) s; displacement (n_t, n_units) mm, and
    its meaning; source: version of the program.
    """

    times: Sequence[Array]
    table: "pd.DataFrame"
    span: tuple[float, float]
    time: Array
    displacement: Array
    meaning: str
    notes: Sequence[str]
    source: str


def write_nwb(
    path: str | PathLike[str],
    recorded: Recorded,
    *,
    description: str,
    started: datetime | None,
    subject: Mapping[str, object] | None,
    resolution: float | None,
    about: Mapping[str, object] | None,
) -> None:
    """Write what was recorded as `SpikeTrains.to_nwb` says."""
    pynwb = of_extra("pynwb", "nwb")
    if resolution is None:
        resolution = float(np.diff(recorded.time).min())
    resolution = number("resolution", resolution, above=0, unit="s")
    digest = hashlib.sha256(
        b"".join(times.tobytes() for times in (*recorded.times, recorded.displacement))
    )
    who = _made("subject", pynwb.file.Subject, dict(SIMULATED if subject is None else subject))
    file = _made(
        "about",
        pynwb.NWBFile,
        {
            "session_description": description,
            "experiment_description": description,
            "identifier": digest.hexdigest(),
            "session_start_time": started or datetime.now(UTC),
            "source_script": recorded.source,
            "source_script_file_name": "fefinger",
            "notes": "\n".join(recorded.notes),
            "subject": who,
            **(about or {}),
        },
    )
    file.units = pynwb.misc.Units(
        name="units", description="model afferents", resolution=resolution
    )
    for name, meaning in COLUMNS.items():
        file.add_unit_column(name, meaning)
    table = recorded.table.iloc[:, : len(COLUMNS)]
    for times, values in zip(recorded.times, table.itertuples(index=False), strict=True):
        file.add_unit(
            spike_times=times,
            obs_intervals=[list(recorded.span)],
            **dict(zip(COLUMNS, values, strict=True)),
        )
    series = pynwb.TimeSeries(
        name="skin_displacement",
        data=recorded.displacement,
        unit="meters",  # the name of NWB; readers find it beside a prefix, not "m"
        conversion=1e-3,
        **_clock(recorded.time),
        description=f"one column per unit: {recorded.meaning}",
    )
    file.add_stimulus(series)
    with in_place(path) as new, pynwb.NWBHDF5IO(str(new), "w") as io:
        io.write(file)


def _made(name: str, cls: Any, fields: Mapping[str, object]) -> Any:
    """Return an object of pynwb, or raise InputError for fields that it does not take."""
    try:
        return cls(**fields)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected fields of NWB's {cls.__name__}: {error}") from None


def _clock(time: Array) -> dict[str, object]:
    """Return the times (n,) of a series as start and rate, if they are even."""
    steps = np.diff(time)
    even = 1e-9  # relative difference of steps of time that are one step
    if np.ptp(steps) > even * steps.mean():
        return {"timestamps": time}
    return {"starting_time": float(time[0]), "rate": float((len(time) - 1) / (time[-1] - time[0]))}
