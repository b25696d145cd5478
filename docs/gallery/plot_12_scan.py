"""
A scan of a fingertip
=====================

A closed surface becomes a finger: here an ellipsoidal one that is made on the spot and written as STL, where yours
comes from a scanner (mm, x distal, z dorsal).
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import trimesh

import fefinger as ff


scan = trimesh.creation.icosphere(subdivisions=4)
scan.apply_scale([14, 7, 5])
scan = scan.slice_plane([-9, 0, 0], [1, 0, 0], cap=True)
file = Path(tempfile.mkdtemp(), "scan.stl")
scan.export(file)

finger = ff.Finger.from_surface(file, tissue="maeno1998", resolution="coarse")
print(f"{finger.width:.1f} mm wide, {finger.thickness:.1f} mm thick")

result = ff.run(
    ff.Scene(
        finger=finger,
        indenter=ff.Flat(20),
        motion=ff.Ramp(speed=10, depth=0.8),
        ask=ff.Ask(rel_error=0.9),
    ),
    mechanics="linear",
)
fig, axis = plt.subplots(figsize=(5, 3.6), layout="constrained")
pad = result.pad
shown = axis.tripcolor(
    pad.points[:, 0], pad.points[:, 1], pad.triangles, result.pressure[-1], shading="gouraud"
)
fig.colorbar(shown, label="pressure / kPa")
axis.set(title=f"{result.force[-1]:.2f} N", xlabel="x / mm", ylabel="y / mm", aspect="equal")
plt.show()
