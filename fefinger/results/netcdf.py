"""A result as one netCDF file: labeled arrays with units, the scene as TOML, the plan as JSON."""

import dataclasses
import json
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fefinger.neural.reference import Reference
from fefinger.neural.trains import SpikeTrains
from fefinger.results import records
from fefinger.results.harmonic import Harmonic
from fefinger.scene.scene import Scene
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    import xarray as xr


FORMAT = "fefinger result 1"


class Variable(NamedTuple):
    """Label of an array of a record in `result.nc`: name, dimensions, units and long name."""

    name: str
    dims: tuple[str, ...]
    units: str
    long_name: str


LAYOUT: dict[tuple[str, str], Variable] = {
    ("Response", "time"): Variable("time", ("time",), "s", "time"),
    ("Response", "depth"): Variable("depth", ("time",), "mm", "indenter travel after first touch"),
    ("Response", "force"): Variable("force", ("time",), "N", "force along the indenter's normal"),
    ("Response", "contact_area"): Variable("contact_area", ("time",), "mm2", "contact area"),
    ("Response", "centroid"): Variable(
        "centroid", ("time", "plane_axis"), "mm", "centroid of the contact pressure"
    ),
    ("Response", "pressure"): Variable(
        "pressure", ("time", "pad"), "kPa", "contact pressure, positive in compression"
    ),
    ("Response", "gap"): Variable(
        "gap", ("time", "pad"), "mm", "distance of the pad from the indenter along its normal"
    ),
    ("Response", "moment"): Variable(
        "moment", ("time", "axis"), "N mm", "moment of the contact pressure about the origin"
    ),
    ("Response", "strain"): Variable(
        "strain", ("time", "site", "axis", "axis_2"), "1", "strain tensor, positive in tension"
    ),
    ("Harmonic", "frequency"): Variable("frequency", ("frequency",), "Hz", "frequency"),
    ("Harmonic", "stiffness_parts"): Variable(
        "dynamic_stiffness", ("frequency", "part"), "N/mm", "force per oscillation of the indenter"
    ),
    ("Harmonic", "strain_parts"): Variable(
        "strain_transfer",
        ("frequency", "site", "axis", "axis_2", "part"),
        "1/mm",
        "strain at the sites per oscillation of the indenter",
    ),
    ("Harmonic", "skin_points"): Variable(
        "skin_points", ("skin_point", "axis"), "mm", "points of the skin in the medial plane"
    ),
    ("Harmonic", "skin_parts"): Variable(
        "skin_transfer",
        ("frequency", "skin_point", "axis", "part"),
        "1",
        "displacement of the skin per oscillation of the indenter",
    ),
    ("Harmonic", "error"): Variable(
        "truncation_error", ("frequency",), "1", "relative change of the stiffness by other modes"
    ),
    ("Harmonic", "modes"): Variable(
        "mode_frequency", ("mode",), "Hz", "modes of the finger held by the indenter, relaxed"
    ),
    ("Lateral", "shift"): Variable(
        "shift", ("time", "lateral_axis"), "mm", "place of the indenter across its normal"
    ),
    ("Lateral", "force"): Variable(
        "lateral_force", ("time", "lateral_axis"), "N", "force on the finger across the normal"
    ),
    ("Lateral", "torque"): Variable(
        "torque", ("time",), "N mm", "torque on the finger about the normal, of friction"
    ),
    ("Lateral", "stick_area"): Variable(
        "stick_area", ("time",), "mm2", "area of the contact that does not slip"
    ),
    ("Lateral", "traction"): Variable(
        "traction", ("time", "pad", "lateral_axis"), "kPa", "friction on the skin"
    ),
    ("Lateral", "slip"): Variable(
        "slip", ("time", "pad", "lateral_axis"), "mm", "slip of the skin over the indenter"
    ),
    ("Lateral", "work"): Variable("friction_work", ("time",), "mJ", "work lost in friction"),
    ("Pad", "points"): Variable("pad_points", ("pad", "axis"), "mm", "points on the pad"),
    ("Pad", "areas"): Variable(
        "pad_areas", ("pad",), "mm2", "area of the skin around each pad point"
    ),
    ("Pad", "normals"): Variable("pad_normals", ("pad", "axis"), "1", "outward normals of the pad"),
    ("Pad", "triangles"): Variable(
        "pad_triangles", ("pad_triangle", "pad_corner"), "1", "triangles between pad points"
    ),
    ("Sites", "points"): Variable("site_points", ("site", "axis"), "mm", "end-organ sites"),
    ("Sites", "normals"): Variable(
        "site_normals", ("site", "axis"), "1", "outward normals of the skin above the sites"
    ),
    ("Sites", "depths"): Variable("site_depths", ("site",), "mm", "depth of the sites under skin"),
    ("Sites", "unit"): Variable("site_unit", ("site",), "1", "unit that each end organ belongs to"),
    ("Sites", "number"): Variable(
        "site_number", ("site",), "1", "number of that unit among all requested ones"
    ),
    ("Reference", "normals"): Variable(
        "reference_normals", ("reference", "axis"), "1", "normals at the reference sites"
    ),
    ("Reference", "strain"): Variable(
        "reference_strain", ("reference", "axis", "axis_2"), "1", "strain in the reference press"
    ),
    ("Fields", "points"): Variable("mesh_points", ("point", "axis"), "mm", "mesh points"),
    ("Fields", "cells"): Variable("mesh_cells", ("cell", "corner"), "1", "tetrahedra of the mesh"),
    ("Fields", "region"): Variable(
        "mesh_region", ("cell",), "1", "region: 1 skin, 2 subcutaneous tissue, 3 bone"
    ),
    ("Fields", "times"): Variable("frame_time", ("frame",), "s", "times of the stored fields"),
    ("Fields", "displacement"): Variable(
        "mesh_displacement", ("frame", "point", "axis"), "mm", "displacement of the mesh points"
    ),
    ("Fields", "strain"): Variable(
        "mesh_strain", ("frame", "point", "component"), "1", "strain tensor at the mesh points"
    ),
    ("Fields", "pressure"): Variable(
        "mesh_pressure", ("frame", "point"), "kPa", "contact pressure at the mesh points"
    ),
    ("SpikeTrains", "times"): Variable("spike_time", ("spike",), "s", "times of the spikes"),
    ("SpikeTrains", "time"): Variable("unit_time", ("unit_time",), "s", "time of the unit signals"),
    ("SpikeTrains", "x_in"): Variable(
        "unit_x_in", ("unit_time", "unit"), "mm", "input of the end organs, compression positive"
    ),
    ("SpikeTrains", "current"): Variable(
        "unit_current",
        ("unit_time", "unit"),
        "uA/cm2",
        "generator current at these times, not linear between",
    ),
    ("SpikeTrains", "peak_mV"): Variable(
        "unit_peak", ("unit",), "mV", "highest membrane potential above rest"
    ),
    ("SpikeTrains", "block_seconds"): Variable(
        "unit_block", ("unit",), "s", "time in depolarization block"
    ),
    ("SpikeTrains", "stimulus_driven"): Variable(
        "unit_stimulus_driven", ("unit",), "1", "spikes that the current alone also produces"
    ),
    ("SpikeTrains", "positions"): Variable(
        "unit_positions", ("unit", "axis"), "mm", "places of the end organs"
    ),
    ("SpikeTrains", "depths"): Variable(
        "unit_depths", ("unit",), "mm", "depth of the end organs under skin"
    ),
}
COORDINATES = {
    "axis": ("x", "y", "z"),
    "axis_2": ("x", "y", "z"),
    "plane_axis": ("x", "y"),
    "lateral_axis": ("distal", "radial"),
    "component": ("xx", "yy", "zz", "xy", "yz", "xz"),
    "part": ("real", "imaginary"),
}
RECORDS = {"Result": records.ResultRecord} | {
    record.__name__: record
    for record in (
        records.Plan,
        records.Rung,
        records.Settings,
        records.Refusal,
        records.Response,
        Harmonic,
        records.Lateral,
        records.Pad,
        records.Sites,
        Reference,
        records.Fields,
        SpikeTrains,
    )
}


def read(path: str | PathLike[str]) -> records.ResultRecord:
    """Read the record of a result: `path` is its folder or its `result.nc`.

    Raises InputError when there is no such file, or when it is foreign or damaged.
    """
    import xarray as xr

    file = Path(path)
    if file.is_dir():
        file = file / "result.nc"
    if not file.is_file():
        message = (
            f"result: expected a folder written by `fefinger run -o` or its result.nc, "
            f"received {str(path)!r}, where there is no file {str(file)!r}"
        )
        raise InputError(message)
    try:
        with xr.open_dataset(file, engine="h5netcdf", decode_times=False) as opened:
            kind = opened.attrs.get("format")
            if kind == FORMAT:
                return _result(opened)
    except (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError) as error:
        message = (
            f"result: expected a result of fefinger in {str(file)!r}, received a damaged or "
            f"foreign file ({error}); run the scene again"
        )
        raise InputError(message) from None
    message = f"result: expected the format {FORMAT!r} in {str(file)!r}, received {kind!r}"
    raise InputError(message)


def _result(opened: "xr.Dataset") -> records.ResultRecord:
    result = _decode(json.loads(opened["record"].item()), opened.load())
    if not isinstance(result, records.ResultRecord):
        message = f"expected the record of a Result, received a {type(result).__name__}"
        raise TypeError(message)
    return result


def dataset(result: records.ResultRecord) -> "xr.Dataset":
    """Convert a result to a Dataset: arrays with names, dimensions and units."""
    import xarray as xr

    variables: dict[str, Any] = {}
    record = json.dumps(_encode(result, "", variables))
    variables["scene"] = xr.Variable((), result.scene.to_toml(), {"long_name": "scene as TOML"})
    variables["record"] = xr.Variable(
        (), record, {"long_name": "all that is no array: plan, status, notes, provenance (JSON)"}
    )
    coordinates: dict[str, Any] = {
        name: list(labels)
        for name, labels in COORDINATES.items()
        if any(name in variable.dims for variable in variables.values())
    }
    if result.spikes is not None:
        coordinates["unit"] = list(result.spikes.names)
        coordinates["unit_type"] = ("unit", list(result.spikes.types))
    if result.sites is not None:
        coordinates["site_type"] = ("site", list(result.sites.types))
    title = f"{result.scene.name}: {result.plan.mechanics}"
    return xr.Dataset(variables, coordinates, {"format": FORMAT, "title": title})


def _encode(value: Any, place: str, variables: dict[str, Any]) -> Any:
    """Encode `value` as JSON values, with its arrays moved into `variables`.

    Tuples become JSON lists, lists {"list": [...]}, arrays {"array": name}, records
    {"record": class, field: ...}; a tuple of arrays becomes one array and {"ragged": name}.
    """
    if isinstance(value, Scene):
        return {"scene": "scene"}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        kind = type(value).__name__
        fields = {
            f.name: _encode_field(getattr(value, f.name), (kind, f.name), variables)
            for f in dataclasses.fields(value)
        }
        return {"record": kind} | fields
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
    message = f"{place}: expected numbers, text or records to save, received {type(value)}"
    raise TypeError(message)


def _encode_field(value: Any, key: tuple[str, str], variables: dict[str, Any]) -> Any:
    """Encode one field of a record: arrays by LAYOUT, ragged where it is a tuple of arrays."""
    import xarray as xr

    if isinstance(value, np.ndarray):
        label = LAYOUT[key]
        attributes = {"units": label.units, "long_name": label.long_name}
        variables[label.name] = xr.Variable(label.dims, value, attributes)
        return {"array": label.name}
    if isinstance(value, tuple) and key in LAYOUT:
        label = LAYOUT[key]
        rows = np.repeat(np.arange(len(value)), [len(row) for row in value])
        flat = np.concatenate([np.empty(0), *value])
        attributes = {"units": label.units, "long_name": label.long_name}
        variables[label.name] = xr.Variable(label.dims, flat, attributes)
        index = {"units": "1", "long_name": f"unit that each {label.name} belongs to"}
        variables[f"{label.name}_unit"] = xr.Variable(label.dims, rows, index)
        return {"ragged": label.name, "rows": len(value)}
    return _encode(value, ".".join(key), variables)


def _decode(value: Any, arrays: "xr.Dataset") -> Any:
    """Decode the JSON values of `_encode`."""
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
        return arrays[value["array"]].values
    if "ragged" in value:
        flat, rows = arrays[value["ragged"]].values, arrays[value["ragged"] + "_unit"].values
        return tuple(flat[rows == row] for row in range(value["rows"]))
    if "list" in value:
        return [_decode(v, arrays) for v in value["list"]]
    return {key: _decode(v, arrays) for key, v in value["dict"].items()}
