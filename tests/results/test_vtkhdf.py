"""The VTK series reads back through VTK's own reader, with one mesh for all times."""

import h5py
import numpy as np
import pytest

from fefinger.results import netcdf


def read_step(path, step):
    """Return all times, and the grid at one of them, from vtkHDFReader."""
    import pyvista as pv
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(Pipeline.TIME_STEPS())
    reader.UpdateTimeStep(times[step])
    return times, pv.wrap(reader.GetOutputDataObject(0)).copy()


@pytest.mark.parametrize("step", [0, 1, 2])
def test_vtk_reads_times_mesh_and_values(synthetic, tmp_path, step):
    fields = synthetic.fields
    netcdf.write_vtkhdf(fields, tmp_path / "a.vtkhdf")
    times, grid = read_step(tmp_path / "a.vtkhdf", step)
    assert times == pytest.approx(fields.times)
    np.testing.assert_allclose(grid.points, fields.points, atol=1e-5)
    assert np.array_equal(grid.cells.reshape(-1, 5)[:, 1:], fields.cells)
    assert np.array_equal(grid["region"], fields.region)
    for name in ("displacement", "strain", "pressure"):
        expected = getattr(fields, name)[step]
        atol = 1e-6 * np.abs(expected).max()
        np.testing.assert_allclose(grid[name], expected, atol=atol, err_msg=name)


def test_the_mesh_is_stored_once(synthetic, tmp_path):
    netcdf.write_vtkhdf(synthetic.fields, tmp_path / "a.vtkhdf")
    with h5py.File(tmp_path / "a.vtkhdf") as file:
        root = file["VTKHDF"]
        assert root["Points"].shape == synthetic.fields.points.shape
        assert root["Connectivity"].size == synthetic.fields.cells.size
        assert root["CellData/region"].shape == synthetic.fields.region.shape
