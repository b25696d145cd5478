"""
A file for ParaView
===================

``result.vtkhdf`` holds displacement, strain and pressure on the mesh through time. Open it in
ParaView, or with PyVista as here.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pyvista as pv

import fefinger as ff


folder = Path(tempfile.mkdtemp())
ff.run("flat-press").save(folder)
reader = pv.get_reader(folder / "result.vtkhdf")
steps = reader.reader.GetNumberOfSteps()
reader.reader.SetStep(steps - 1)
mesh = reader.read()
print(f"{steps} times; arrays {mesh.array_names}; {mesh.n_cells} tetrahedra")

# %%
# Strain has the components xx, yy, zz, xy, yz, xz. Here is the largest compressive strain in a cut
# across the deformed finger, 2 mm behind first touch.
xx, yy, zz, xy, yz, xz = mesh["strain"].T
tensors = np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), 2, 0)
mesh["compression"] = -100 * np.linalg.eigvalsh(tensors)[:, 0]
cut = mesh.warp_by_vector("displacement").slice(normal="x", origin=(-2, 0, 0)).triangulate()
fig, axis = plt.subplots(figsize=(4.6, 3.6), layout="constrained")
_, y, z = cut.points.T
triangles = cut.faces.reshape(-1, 4)[:, 1:]
drawn = axis.tripcolor(y, z, triangles, cut["compression"], shading="gouraud")
fig.colorbar(drawn, label="compressive strain / %")
axis.set(xlabel="y / mm", ylabel="z / mm", aspect="equal")
plt.show()
