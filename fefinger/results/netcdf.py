"""A result as one netCDF file with labels and units, and its fields as a VTK time series.

The series is one HDF5 file of type UnstructuredGrid, format version 2.2. The mesh is stored once
and every step refers to it.
Source: VTK file formats, "VTKHDF File Format", sections Unstructured Grid and Temporal Data.
"""

import dataclasses
import hashlib
import json
import os
from collections.abc import Callable, Mapping
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fefinger.neural.drives import Reference
from fefinger.neural.trains import SpikeTrains
from fefinger.results import labels, records, result_record
from fefinger.results.labels import LAYOUT
from fefinger.results.records import Fields, Harmonic
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Integers
from fefinger.support.checks import InputError
from fefinger.support.inputs import check_heaps, unreadable


if TYPE_CHECKING:
    import xarray as xr


FORMAT = "fefinger result 1"
FAMILY = FORMAT.rstrip("0123456789")
"""Beginning of the format of every version."""

SINGLE = {"pad", "site", "unit", "point"}
"""Dimensions along which values through time are stored in single precision, of 7 digits: most of a
result, whose errors are percents."""

DIGEST = "sha256"
"""Attribute with the checksum of the values; results of earlier versions have none."""

OF_PLUGIN = ("plugins", "indenter")
"""Beginnings of the fields of errors that a plugin causes, not the saved result."""

RECORDS: Mapping[str, Callable[..., object]] = {"Result": result_record.ResultRecord} | {
    record.__name__: record
    for record in (
        *(result_record.Plan, result_record.Settings, records.Rung, records.Refusal),
        *(records.Response, records.Lateral, records.Pad, records.Sites, records.Fields),
        *(Harmonic, Reference, SpikeTrains),
    )
}


def read(path: str | PathLike[str]) -> result_record.ResultRecord:
    """Read a result from its folder or its `result.nc`.

    Raises InputError where there is no such file, or it is damaged or not of fefinger.
    """
    import h5netcdf
    import xarray as xr

    file = Path(path)
    if os.path.isdir(file):
        file = file / "result.nc"
    if reason := unreadable(file):
        raise InputError(
            f"result: expected a folder written by `fefinger run -o` or its result.nc, "
            f"received {str(path)!r}: {str(file)!r} {reason}"
        )
    if not hasattr(h5netcdf.File, "_writable"):
        h5netcdf.File._writable = False  # else one of a bad header prints an error when it closes
    try:
        check_heaps(file)
        with xr.open_dataset(
            file, engine="h5netcdf", decode_times=False, phony_dims="access"
        ) as opened:
            kind = opened.attrs.get("format")
            if kind == FORMAT:
                # Largest ratio of the bytes of all values to those of their file, which are
                # compressed: pressures and strains of a short touch in a long rest were 30 times
                # their file.
                most_unpacked = 200
                if opened.nbytes > most_unpacked * file.stat().st_size:
                    raise ValueError("more values than the file can hold")
                arrays = opened.load()
                if arrays.attrs.get(DIGEST, "") not in ("", _digest(arrays)):
                    raise ValueError("not the values that were written")
                result = _decode(json.loads(arrays["record"].item()), arrays)
                if not isinstance(result, result_record.ResultRecord):
                    raise TypeError(type(result))
                return result
    except MemoryError:
        raise
    except Exception as error:  # of any class, by what the bytes are
        if isinstance(error, InputError) and error.field.startswith(OF_PLUGIN):
            raise
        raise InputError(
            f"result: expected a result of fefinger in {str(file)!r}, received a damaged or "
            "foreign file; run the scene again"
        ) from None
    raise InputError(f"result: {str(file)!r} is {_another(kind)}; run the scene again")


def _another(kind: object) -> str:
    """Say what a file of another format is."""
    if not str(kind).startswith(FAMILY):
        return "not a result of fefinger"
    return f"written by another version of fefinger: format {kind!r}, this version reads {FORMAT!r}"


def stored(file: Path) -> frozenset[str] | None:
    """Return the names of the arrays of a saved result of any version; None for another file."""
    import h5netcdf

    if unreadable(file):
        return None
    try:
        check_heaps(file)
        with h5netcdf.File(file, "r") as opened:
            ours = str(opened.attrs.get("format")).startswith(FAMILY)
            return frozenset(opened.variables) if ours else None
    except Exception:  # of any class, by what the bytes are
        return None


def dataset(result: result_record.ResultRecord) -> "xr.Dataset":
    """Convert a result to a Dataset of arrays with names, dimensions and units."""
    import xarray as xr

    variables: dict[str, xr.Variable] = {}
    record = json.dumps(_encode(result, "", variables))
    variables["scene"] = xr.Variable((), result.scene.to_toml(), {"long_name": "scene as TOML"})
    variables["record"] = xr.Variable(
        (), record, {"long_name": "all that is no array: plan, status, notes, provenance (JSON)"}
    )
    coordinates: dict[str, object] = {**labels.coordinates(variables)}
    if result.spikes is not None:
        coordinates["unit"] = list(result.spikes.names)
        coordinates["unit_type"] = ("unit", list(result.spikes.types))
    if result.sites is not None:
        coordinates["site_type"] = ("site", list(result.sites.types))
    title = f"{result.scene.name}: {result.plan.mechanics}"
    variables = {name: _single(variable) for name, variable in variables.items()}
    labeled = xr.Dataset(variables, coordinates, {"format": FORMAT, "title": title})
    return labeled.assign_attrs({DIGEST: _digest(labeled)})


def _single(variable: "xr.Variable") -> "xr.Variable":
    """Return a variable in single precision, if it is one of many values through time."""
    through_time = variable.dims[:1] in (("time",), ("frame",))
    many = through_time and variable.dtype == np.float64 and SINGLE.intersection(variable.dims)
    return variable.astype(np.float32) if many else variable


def _digest(arrays: "xr.Dataset") -> str:
    """Return a checksum of all values, which tells whether a byte of the file has changed."""
    digest = hashlib.sha256()
    for name in sorted(map(str, arrays.variables)):
        values = arrays[name].values
        digest.update(f"{name} {values.shape}\n".encode())
        text = values.dtype.kind in "OSU"
        digest.update(json.dumps(values.tolist()).encode() if text else values.tobytes())
    return digest.hexdigest()


def _encode(value: object, place: str, variables: "dict[str, xr.Variable]") -> object:
    """Encode a value for JSON, with its arrays moved into `variables`.

    Tuples become lists, lists {"list": [...]}, arrays {"array": name}, records {"record": class,
    field: ...}; a tuple of arrays becomes one array and {"ragged": name}. Messages name `place`.
    """
    if isinstance(value, Scene):
        return {"scene": "scene"}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        kind = type(value).__name__
        fields = (field.name for field in dataclasses.fields(value))
        encoded = {f: _encode_field(getattr(value, f), (kind, f), variables) for f in fields}
        return {"record": kind} | encoded
    if isinstance(value, dict):
        return {"dict": {str(key): _encode(v, place, variables) for key, v in value.items()}}
    if isinstance(value, list):
        return {"list": [_encode(v, place, variables) for v in value]}
    if isinstance(value, tuple):
        return [_encode(v, place, variables) for v in value]
    if isinstance(value, np.generic):
        return value.item()
    if value is None or isinstance(value, str | bool | int | float):
        return value
    raise TypeError(f"{place}: expected numbers, text or records to save, received {type(value)}")


def _encode_field(
    value: object, key: tuple[str, str], variables: "dict[str, xr.Variable]"
) -> object:
    """Encode a field of a record; arrays, and tuples of arrays of several lengths, by LAYOUT."""
    import xarray as xr

    if isinstance(value, np.ndarray):
        name = LAYOUT[key].name
        variables[name] = labels.labeled(key, value)
        return {"array": name}
    if isinstance(value, tuple) and key in LAYOUT:
        label = LAYOUT[key]
        rows = np.repeat(np.arange(len(value)), [len(row) for row in value])
        flat = np.concatenate([np.empty(0), *value])
        variables[label.name] = labels.labeled(key, flat)
        index = {"units": "1", "long_name": f"unit that each {label.name} belongs to"}
        variables[f"{label.name}_unit"] = xr.Variable(label.dims, rows, index)
        return {"ragged": label.name, "rows": len(value)}
    return _encode(value, ".".join(key), variables)


def _decode(value: object, arrays: "xr.Dataset") -> object:
    """Decode what `_encode` has made."""
    if isinstance(value, list):
        return tuple(_decode(v, arrays) for v in value)
    if not isinstance(value, dict):
        return value
    if "record" in value:
        kind = RECORDS[value["record"]]
        return kind(**{key: _decode(v, arrays) for key, v in value.items() if key != "record"})
    if "scene" in value:
        return Scene.from_stored(arrays["scene"].item())
    if "array" in value:
        values = arrays[value["array"]].values
        return values.astype(np.float64) if values.dtype == np.float32 else values
    if "ragged" in value:
        flat, rows = arrays[value["ragged"]].values, arrays[value["ragged"] + "_unit"].values
        return tuple(flat[rows == row] for row in range(value["rows"]))
    if "list" in value:
        return [_decode(v, arrays) for v in value["list"]]
    return {key: _decode(v, arrays) for key, v in value["dict"].items()}


def write_vtkhdf(fields: Fields, path: str | PathLike[str]) -> None:
    """Write `fields` to `path` in single precision, one step per stored time.

    Point data: displacement (3 components, mm), strain (xx yy zz xy yz xz, the order of VTK and of
    `Fields` alike), pressure (kPa); cell data: region (1 skin, 2 subcutaneous tissue, 3 bone).
    """
    import h5py

    n_points, n_cells, steps = len(fields.points), len(fields.cells), fields.times.size
    same: Integers = np.zeros(steps, dtype=np.int64)  # every step refers to the one mesh
    stacked = {
        "displacement": fields.displacement.reshape(-1, 3),
        "strain": fields.strain.reshape(-1, 6),
        "pressure": fields.pressure.reshape(-1),
    }
    rows = np.arange(steps, dtype=np.int64) * n_points  # and to its own rows of the point data
    values = {
        "NumberOfPoints": np.array([n_points]),
        "NumberOfCells": np.array([n_cells]),
        "NumberOfConnectivityIds": np.array([4 * n_cells]),
        "Points": fields.points.astype(np.float32),
        "Connectivity": fields.cells.astype(np.int64).ravel(),
        "Offsets": np.arange(0, 4 * n_cells + 1, 4),
        "Types": np.full(n_cells, 10, dtype=np.uint8),  # VTK_TETRA
        **{f"PointData/{name}": each.astype(np.float32) for name, each in stacked.items()},
        "CellData/region": fields.region,
        "Steps/Values": fields.times.astype(np.float64),
        "Steps/NumberOfParts": same + 1,
        **{f"Steps/{name}": same for name in ("PartOffsets", "PointOffsets")},
        **{f"Steps/{name}": same[:, None] for name in ("CellOffsets", "ConnectivityIdOffsets")},
        **{f"Steps/PointDataOffsets/{name}": rows for name in stacked},
        "Steps/CellDataOffsets/region": same,
    }
    buffer = BytesIO()  # in memory: see `atomic_write.netcdf`
    with h5py.File(buffer, "w") as file:
        root = file.create_group("VTKHDF", track_order=True)
        root.attrs["Version"] = (2, 2)  # steps in time exist from 2.0 on
        root.attrs["Type"] = np.bytes_("UnstructuredGrid")
        for name, each in values.items():
            root[name] = each
        root["Steps"].attrs["NSteps"] = steps
    Path(path).write_bytes(buffer.getbuffer())
