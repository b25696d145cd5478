"""
Vibration in frequency
======================

The dynamic stiffness of the finger under a plate, with inertia, how much of the motion reaches
the end organs, and the lowest modes.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pyvista as pv

import fefinger as ff


soft = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
finger = ff.Modal(soft, ff.Flat(30))
frequency = np.geomspace(5, 400, 60)
answer = finger.harmonic(frequency, force=0.5)
print("lowest modes / Hz:", np.round(answer.modes[:5]))

fig, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.2), layout="constrained")
left.semilogx(frequency, np.abs(answer.stiffness))
left.set(xlabel="frequency / Hz", ylabel="dynamic stiffness / (N/mm)")
for site, kind in enumerate(finger.sites.types):
    strain = np.linalg.norm(answer.strain[:, site], axis=(-2, -1))
    right.semilogx(frequency, 100 * strain, label=kind)
right.set(xlabel="frequency / Hz", ylabel="strain per mm of the plate / %")
right.legend()
plt.show()

# %%
# The three lowest modes, cut along the finger. ``mode.vtkhdf`` is one cycle: ParaView plays it.
file = Path(tempfile.mkdtemp(), "mode.vtkhdf")
fig, axes = plt.subplots(1, 3, figsize=(8.5, 2.2), layout="constrained", sharey=True)
for which, axis in enumerate(axes):
    finger.save_shape(file, which)
    mesh = pv.get_reader(file).read()
    mesh["moved"] = np.linalg.norm(mesh["displacement"], axis=1)
    moved = mesh.warp_by_vector("displacement", factor=2)
    cut = moved.slice(normal="y", origin=(0, 0.4, 0)).triangulate()
    x, _, z = cut.points.T
    axis.tripcolor(x, z, cut.faces.reshape(-1, 4)[:, 1:], cut["moved"], shading="gouraud")
    axis.set(title=f"{finger.frequencies[which]:.0f} Hz", xlabel="x / mm", aspect="equal")
axes[0].set_ylabel("z / mm")
plt.show()
