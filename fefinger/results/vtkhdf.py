"""Fields on a mesh as a VTK time series (VTKHDF) that ParaView and PyVista open.

One HDF5 file of type UnstructuredGrid, format version 2.2. The mesh is stored once and every step
refers to it.
Source: VTK file formats, "VTKHDF File Format", sections Unstructured Grid and Temporal Data.
"""

from io import BytesIO
from os import PathLike
from pathlib import Path

import numpy as np

from fefinger.results.records import Fields
from fefinger.support.arrays import Integers


def write(fields: Fields, path: str | PathLike[str]) -> None:
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
