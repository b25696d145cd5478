"""
A scan of a fingertip
=====================

A closed surface becomes a finger. Yours comes from a scanner (mm, x distal, z dorsal); here one
is made on the spot: the skin of a shipped finger, stretched by 6 % across, as an STL file.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import pyvista as pv

import fefinger as ff


press = ff.Scene(
    finger=ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse"),
    indenter=ff.Flat(20),
    motion=ff.Ramp(speed=10, depth=0.8),
    ask=ff.Ask(rel_error=0.9),
)
shipped = ff.run(press, mechanics="condensed")

mesh = shipped.fields
half = pv.UnstructuredGrid({pv.CellType.TETRA: mesh.cells}, mesh.points)
whole = half.merge(half.reflect((0, 1, 0)), merge_points=True)
skin = whole.extract_surface(algorithm=None).triangulate().clean()
skin.points[:, 1] *= 1.06
file = Path(tempfile.mkdtemp(), "scan.stl")
skin.save(file)

# %%
# From here on it is any scan.
finger = ff.Finger.from_surface(file, tissue="maeno1998", resolution="coarse")
print(f"{finger.width:.1f} mm wide, {finger.thickness:.1f} mm thick")

scanned = ff.run(replace(press, finger=finger), mechanics="linear")
fig, axes = plt.subplots(1, 2, figsize=(8.5, 3.4), sharey=True, layout="constrained")
fingers = {"shipped": shipped, "scanned": scanned}
for axis, (name, result) in zip(axes, fingers.items(), strict=True):
    pad = result.pad
    x, y, _ = pad.points.T
    shown = axis.tripcolor(x, y, pad.triangles, result.pressure[-1], shading="gouraud")
    fig.colorbar(shown, ax=axis, label="pressure / kPa")
    axis.set(title=f"{name}: {result.force[-1]:.2f} N", xlabel="x / mm", aspect="equal")
axes[0].set_ylabel("y / mm")
plt.show()
