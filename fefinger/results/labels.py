"""Names, dimensions, units and coordinates of the arrays in `result.nc`."""

import tomllib
from collections.abc import Mapping
from importlib import resources
from typing import TYPE_CHECKING, NamedTuple

from fefinger.support.arrays import Array


if TYPE_CHECKING:
    import xarray as xr


class Variable(NamedTuple):
    """Label of an array of a record in `result.nc`: name, dimensions, units and long name."""

    name: str
    dims: tuple[str, ...]
    units: str
    long_name: str


_FILE = resources.files("fefinger.results").joinpath("netcdf.toml")
LAYOUT = {
    (record, field): Variable(name, tuple(dims), units, long_name)
    for record, fields in tomllib.loads(_FILE.read_text(encoding="utf-8")).items()
    for field, (name, dims, units, long_name) in fields.items()
}
"""Labels of all arrays, by record and field."""

COORDINATES = {
    "axis": ("x", "y", "z"),
    "axis_2": ("x", "y", "z"),
    "plane_axis": ("x", "y"),
    "lateral_axis": ("distal", "radial"),
    "component": ("xx", "yy", "zz", "xy", "yz", "xz"),
    "part": ("real", "imaginary"),
    "limit": ("relaxed", "elastic"),
}


def labeled(key: tuple[str, str], values: Array) -> "xr.Variable":
    """Return the values of an array with its label; `key`: its record and field."""
    import xarray as xr

    label = LAYOUT[key]
    return xr.Variable(label.dims, values, {"units": label.units, "long_name": label.long_name})


def coordinates(variables: "Mapping[str, xr.Variable]") -> dict[str, list[str]]:
    """Return the names of axes and components along the dimensions of some variables."""
    dims = {name for variable in variables.values() for name in variable.dims}
    return {name: list(names) for name, names in COORDINATES.items() if name in dims}
