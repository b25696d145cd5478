"""Fields on a mesh as a VTK time series (VTKHDF) that ParaView and PyVista open.

One HDF5 file of type UnstructuredGrid, format version 2.2, written with h5py alone. The mesh is
stored once and every step points to it; only the values change from step to step.
Source: VTK file formats, "VTKHDF File Format", sections Unstructured Grid and Temporal Data.
"""

from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from fefinger.results.records import Fields
from fefinger.support.arrays import Integers


VERSION = (2, 2)
TETRAHEDRON = 10


def write(fields: Fields, path: str | PathLike[str]) -> None:
    """Write `fields` to `path` in single precision, one step per stored time.

    Point data: displacement (3 components, mm), strain (xx yy zz xy yz xz, the order of VTK and of
    `Fields` alike), pressure (kPa); cell data: region (1 skin, 2 subcutaneous tissue, 3 bone).
    """
    import h5py

    steps, buffer = fields.times.size, BytesIO()  # in memory: see `writing.netcdf`
    with h5py.File(buffer, "w") as file:
        root = file.create_group("VTKHDF", track_order=True)
        root.attrs["Version"] = VERSION
        root.attrs["Type"] = np.bytes_("UnstructuredGrid")
        _write_mesh(root, fields)
        stacked = {
            "displacement": fields.displacement.reshape(-1, 3),
            "strain": fields.strain.reshape(-1, 6),
            "pressure": fields.pressure.reshape(-1),
        }
        points = root.create_group("PointData")
        for name, values in stacked.items():
            points.create_dataset(name, data=values.astype(np.float32))
        root.create_group("CellData").create_dataset("region", data=fields.region)
        _write_steps(root, fields, tuple(stacked), steps)
    Path(path).write_bytes(buffer.getbuffer())


def _write_mesh(root: Any, fields: Fields) -> None:
    """Store points, tetrahedra and their sizes as the single part of the grid."""
    n_points, n_cells = len(fields.points), len(fields.cells)
    root["NumberOfPoints"] = np.array([n_points])
    root["NumberOfCells"] = np.array([n_cells])
    root["NumberOfConnectivityIds"] = np.array([4 * n_cells])
    root["Points"] = fields.points.astype(np.float32)
    root["Connectivity"] = fields.cells.astype(np.int64).ravel()
    root["Offsets"] = np.arange(0, 4 * n_cells + 1, 4)
    root["Types"] = np.full(n_cells, TETRAHEDRON, dtype=np.uint8)


def _write_steps(root: Any, fields: Fields, names: tuple[str, ...], steps: int) -> None:
    """Refer every step to the one mesh, and to its own rows of the point data."""
    group = root.create_group("Steps")
    group.attrs["NSteps"] = steps
    same: Integers = np.zeros(steps, dtype=np.int64)
    rows = np.arange(steps, dtype=np.int64) * len(fields.points)
    group["Values"] = fields.times.astype(np.float64)
    group["NumberOfParts"] = same + 1
    for name in ("PartOffsets", "PointOffsets"):
        group[name] = same
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        group[name] = same[:, None]
    for name in names:
        group[f"PointDataOffsets/{name}"] = rows
    group["CellDataOffsets/region"] = same
