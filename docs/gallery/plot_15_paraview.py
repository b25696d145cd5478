"""
A file for ParaView
===================

``result.vtkhdf`` holds displacement, strain and pressure on the mesh through time. ParaView and
PyVista open it.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOHDF import vtkHDFReader

import fefinger as ff


folder = Path(tempfile.mkdtemp())
ff.run("flat-press").save(folder)
reader = vtkHDFReader()
reader.SetFileName(str(folder / "result.vtkhdf"))
reader.UpdateInformation()
times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
print(len(times), "times up to", times[-1], "s")
reader.UpdateTimeStep(times[-1])
mesh = pv.wrap(reader.GetOutputDataObject(0))
print(mesh.array_names, mesh.n_cells, "tetrahedra")

# %%
# A cut at x = 0 with PyVista, drawn by matplotlib.
cut = mesh.slice(normal="x", origin=(0, 0, 0)).triangulate()
triangles = cut.faces.reshape(-1, 4)[:, 1:]
shown = np.linalg.norm(cut["displacement"], axis=1)
fig, axis = plt.subplots(figsize=(4.6, 3.6), layout="constrained")
_, y, z = cut.points.T
drawn = axis.tripcolor(y, z, triangles, shown, shading="gouraud")
fig.colorbar(drawn, label="displacement / mm")
axis.set(xlabel="y / mm", ylabel="z / mm", aspect="equal")
plt.show()
