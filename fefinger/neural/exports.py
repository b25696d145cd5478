"""Export of spike trains to CSV, NPZ, pandas, xarray and, with extras, Neo and NWB."""

import csv
import hashlib
import math
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from importlib import import_module
from importlib.metadata import version
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from fefinger.neural.train_record import TrainRecord
from fefinger.support.arrays import Array
from fefinger.support.atomic_write import moved
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


NPZ_FORMAT = "fefinger spike trains 1"

CSV_COLUMNS = ("unit", "type", "x_mm", "y_mm", "z_mm", "time_s")

UNIT_COLUMNS = (
    *("unit", "type", "x_mm", "y_mm", "z_mm", "depth_mm", "delay_s"),
    *("count", "t_start_s", "t_stop_s"),
)
"""Columns of the table of units, with their number of spikes from t_start_s to t_stop_s."""

SIGNALS = ("x_in", "current")
PER_UNIT = ("peak_mV", "block_seconds", "stimulus_driven")
LISTS = ("types", "names", "notes")
OPTIONAL = ("delays", "positions", "depths", "seed", "trial")

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
}
"""Units of the arrays of SpikeTrains, as stored with them."""

MEANINGS = {
    "x_in": "input of the end organs, compression positive, linear between its times",
    "current": "generator current at these times, not linear between them: the membranes were "
    "given it at more times",
}
"""Descriptions of SIGNALS, for file formats that hold descriptions."""


def to_csv(trains: TrainRecord, path: str | PathLike[str]) -> None:
    """Write one row per spike in CSV_COLUMNS, by unit and then time; unknown places are empty.

    Silent units have no row: `units_to_csv` writes all.
    """
    places: list[tuple[str, ...]] = [("", "", "")] * len(trains)
    if trains.positions is not None:
        places = [tuple(repr(float(x)) for x in row) for row in trains.positions]
    with _in_place(path) as new, open(new, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(CSV_COLUMNS)
        for i, times in enumerate(trains.times):
            unit = (trains.names[i], trains.types[i], *places[i])
            writer.writerows((*unit, repr(float(time))) for time in times)


def units_to_csv(trains: TrainRecord, path: str | PathLike[str]) -> None:
    """Write one row per unit in UNIT_COLUMNS, silent ones too; unknown places are empty."""
    table = {name: column.tolist() for name, column in _units(trains).items()}
    with _in_place(path) as new, open(new, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(UNIT_COLUMNS)
        for row in zip(*(table[name] for name in UNIT_COLUMNS), strict=True):
            missing = (isinstance(value, float) and math.isnan(value) for value in row)
            writer.writerow("" if m else value for value, m in zip(row, missing, strict=True))


def to_npz(trains: TrainRecord, path: str | PathLike[str]) -> None:
    """Write all fields to a compressed NPZ file, which `read_npz` reads back bit by bit.

    `spikes` holds the times of all units, those of unit i from offsets[i] to offsets[i + 1];
    `units_of_arrays` the unit of each array as "name unit", `meanings` the descriptions of SIGNALS
    as "name: meaning".
    """
    names = ("time", *SIGNALS, *PER_UNIT, *LISTS, *OPTIONAL)
    arrays = {name: getattr(trains, name) for name in names if getattr(trains, name) is not None}
    arrays |= {name: _whole(arrays[name]) for name in ("seed", "trial") if name in arrays}
    arrays |= {
        "spikes": np.concatenate(trains.times),
        "offsets": np.cumsum([0, *trains.count()]),
        "span": [trains.t_start, trains.t_stop],
        "format": NPZ_FORMAT,
        "family": trains.family,
        "units_of_arrays": [f"{name} {unit}" for name, unit in UNITS.items()],
        "meanings": [f"{name}: {meaning}" for name, meaning in MEANINGS.items()],
    }
    with _in_place(path) as new, open(new, "wb") as file:
        np.savez_compressed(file, **arrays)


def read_npz(path: str | PathLike[str]) -> dict[str, Any]:
    """Read the fields of SpikeTrains that `to_npz` wrote; InputError for another file."""
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
    try:
        return _fields(data)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        msg = f"{path}: expected every array of spike trains, cannot use them: {error}; save again"
        raise InputError(msg) from error


def _fields(data: dict[str, NDArray[Any]]) -> dict[str, Any]:
    """Convert stored arrays to the fields of SpikeTrains; KeyError where one is missing."""
    fields: dict[str, Any] = {name: data[name] for name in ("time", *SIGNALS, *PER_UNIT)}
    fields |= {name: tuple(data[name].tolist()) for name in LISTS}
    fields |= {name: data[name] for name in ("delays", "positions", "depths") if name in data}
    fields |= {name: int(data[name].item()) for name in ("seed", "trial") if name in data}
    fields |= {name: data[name].item() for name in ("family",) if name in data}
    fields["times"] = tuple(np.split(data["spikes"], data["offsets"][1:-1]))
    fields["t_start"], fields["t_stop"] = data["span"].tolist()
    return fields


def to_pandas(trains: TrainRecord) -> "pd.DataFrame":
    """Convert to a table with one row per spike.

    Columns unit, type, x_mm, y_mm, z_mm, depth_mm, time_s and delay_s, the conduction delay that
    time_s includes. Silent units have no row: means over units need `units_to_pandas`.
    """
    import pandas as pd

    owner = np.repeat(np.arange(len(trains)), trains.count())
    places, depths = _places(trains)
    table = {"unit": np.array(trains.names)[owner], "type": np.array(trains.types)[owner]}
    table |= {f"{axis}_mm": places[owner, i] for i, axis in enumerate("xyz")}
    table |= {"depth_mm": depths[owner], "time_s": np.concatenate(trains.times)}
    table["delay_s"] = trains.delays[owner]
    return pd.DataFrame(table)


def units_to_pandas(trains: TrainRecord) -> "pd.DataFrame":
    """Convert to a table with one row per unit, silent ones too, in UNIT_COLUMNS.

    `count` are its spikes from t_start_s to t_stop_s, so that count / (t_stop_s - t_start_s) is its
    mean rate.
    """
    import pandas as pd

    return pd.DataFrame(_units(trains), columns=list(UNIT_COLUMNS))


def _units(trains: TrainRecord) -> dict[str, NDArray[Any]]:
    """Columns (n_units,) of the table of units."""
    places, depths = _places(trains)
    table: dict[str, NDArray[Any]] = {
        "unit": np.array(trains.names, object),
        "type": np.array(trains.types, object),
        "depth_mm": depths,
        "delay_s": trains.delays,
        "count": trains.count(),
        "t_start_s": np.full(len(trains), trains.t_start),
        "t_stop_s": np.full(len(trains), trains.t_stop),
    }
    return table | {f"{axis}_mm": places[:, i] for i, axis in enumerate("xyz")}


def to_xarray(trains: TrainRecord) -> "xr.Dataset":
    """Convert to a Dataset: signals over `time` and `unit`, spikes over `spike`.

    `spike_unit` is the index of the unit of each spike. Every variable has its units, and the
    signals have a description in `long_name`.
    """
    import xarray as xr

    def variable(name: str, dims: tuple[str, ...], values: Any) -> Any:
        return xr.Variable(dims, values, {"units": UNITS[name]})

    data = {name: variable(name, ("time", "unit"), getattr(trains, name)) for name in SIGNALS}
    for name, meaning in MEANINGS.items():
        data[name].attrs["long_name"] = meaning
    data |= {name: variable(name, ("unit",), getattr(trains, name)) for name in PER_UNIT}
    data["delays"] = variable("delays", ("unit",), trains.delays)
    data["delays"].attrs["long_name"] = "conduction delay, part of the times of the spikes"
    data["spike_time"] = variable("times", ("spike",), np.concatenate(trains.times))
    data["spike_unit"] = xr.Variable(("spike",), np.repeat(range(len(trains)), trains.count()))
    if trains.positions is not None:
        data["positions"] = variable("positions", ("unit", "axis"), trains.positions)
    if trains.depths is not None:
        data["depths"] = variable("depths", ("unit",), trains.depths)
    coordinates = {
        "unit": list(trains.names),
        "type": ("unit", list(trains.types)),
        "time": variable("time", ("time",), trains.time),
    }
    if trains.positions is not None:
        coordinates["axis"] = ["x", "y", "z"]
    return xr.Dataset(data, coordinates, _provenance(trains))


def to_neo(trains: TrainRecord) -> Any:
    """Convert to a neo.Block with one Segment: a SpikeTrain per unit, and the signals.

    Each SpikeTrain is named after its unit and annotated with afferent_class, delay_s, position_mm
    and depth_mm; displacement and current are IrregularlySampledSignals. Needs the extra `neo`.
    """
    neo, pq = _extra("neo", "neo"), _extra("quantities", "neo")
    segment = neo.Segment(name="trial")
    places, depths = _places(trains)
    for i, times in enumerate(trains.times):
        annotations: dict[str, Any] = {"afferent_class": trains.types[i]}
        annotations["delay_s"] = float(trains.delays[i])
        if trains.positions is not None:
            annotations["position_mm"] = places[i].tolist()
        if trains.depths is not None:
            annotations["depth_mm"] = float(depths[i])
        span = {"t_start": trains.t_start * pq.s, "t_stop": trains.t_stop * pq.s}
        segment.spiketrains.append(
            neo.SpikeTrain(times * pq.s, name=trains.names[i], **span, **annotations)
        )
    density = pq.CompoundUnit("uA/cm**2")
    for name, unit in (("x_in", pq.mm), ("current", density)):
        labels = {"name": name, "description": MEANINGS[name]}
        segment.irregularlysampledsignals.append(
            neo.IrregularlySampledSignal(trains.time * pq.s, getattr(trains, name), unit, **labels)
        )
    block = neo.Block(name="fefinger", **_provenance(trains))
    block.segments.append(segment)
    return block


def to_nwb(
    trains: TrainRecord,
    path: str | PathLike[str],
    *,
    description: str = "simulated spike trains of tactile afferents",
    started: datetime | None = None,
) -> None:
    """Write an NWB file: units, their class and place, and the displacement that drove them.

    Lengths are in mm in the table and in m in the series, as the format requires. `started` is the
    time of the session with its zone, by default now. Needs the extra `nwb`.
    """
    pynwb = _extra("pynwb", "nwb")
    digest = hashlib.sha256(b"".join(times.tobytes() for times in (*trains.times, trains.x_in)))
    provenance = _provenance(trains)
    file = pynwb.NWBFile(
        session_description=description,
        identifier=digest.hexdigest(),
        session_start_time=started or datetime.now(UTC),
        source_script=provenance["source"],
        source_script_file_name="fefinger",
        notes="\n".join([*trains.notes, f"seed: {trains.seed}", f"trial: {trains.trial}"]),
    )
    columns = {
        "unit_name": "name of the unit",
        "afferent_class": "SAI, SAII, FAI or FAII",
        "x_mm": "distal place of the end organ, nan if unknown",
        "y_mm": "radial place of the end organ, nan if unknown",
        "z_mm": "dorsal place of the end organ, nan if unknown",
        "depth_mm": "depth of the end organ under the skin, nan if unknown",
        "delay_s": "conduction delay from the end organ to the recording, part of the spike times",
    }
    for name, meaning in columns.items():
        file.add_unit_column(name, meaning)
    places, depths = _places(trains)
    for i, times in enumerate(trains.times):
        values = (trains.names[i], trains.types[i], *places[i].tolist(), float(depths[i]))
        values = (*values, float(trains.delays[i]))
        file.add_unit(
            spike_times=times,
            obs_intervals=[[trains.t_start, trains.t_stop]],
            **dict(zip(columns, values, strict=True)),
        )
    series = pynwb.TimeSeries(
        name="skin_displacement",
        data=trains.x_in,
        unit="m",
        conversion=1e-3,
        timestamps=trains.time,
        description=f"one column per unit: {MEANINGS['x_in']}",
    )
    file.add_stimulus(series)
    with _in_place(path) as new, pynwb.NWBHDF5IO(str(new), "w") as io:
        io.write(file)


def _places(trains: TrainRecord) -> tuple[Array, Array]:
    """Positions (n_units, 3) and depths (n_units,) in mm, nan where unknown."""
    n = len(trains)
    places = np.full((n, 3), np.nan) if trains.positions is None else trains.positions
    return places, np.full(n, np.nan) if trains.depths is None else trains.depths


def _provenance(trains: TrainRecord) -> dict[str, Any]:
    """Version of the program, seed, trial and notes."""
    source: dict[str, Any] = {"source": f"fefinger {version('fefinger')}"}
    source["trial"] = _whole(trains.trial)
    if trains.seed is not None:
        source["seed"] = _whole(trains.seed)
    return source | {"notes": "\n".join(trains.notes)}


def _whole(value: int) -> int | str:
    """Return a whole number of 0 or more, as text where it has more bits than files hold."""
    return value if value <= np.iinfo(np.int64).max else str(value)


def _extra(module: str, extra: str) -> Any:
    """Import a module of an extra; InputError explains how to install it."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        msg = f"{module} is not installed; install it with: pip install 'fefinger[{extra}]'"
        raise InputError(msg) from error


@contextmanager
def _in_place(path: str | PathLike[str]) -> Iterator[Path]:
    """Yield a temporary name next to `path`; move the file to `path` after the enclosed block."""
    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(f"{path}: expected a folder that exists, received {str(path.parent)!r}")
    try:
        with moved(path) as new:
            yield new
    except OSError as error:
        msg = f"{path}: cannot be written: {error.strerror or error}; choose another file"
        raise InputError(msg) from None
