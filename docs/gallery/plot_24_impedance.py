"""
Impedance, and vibration in frequency
=====================================

The mechanical impedance of a finger under a plate at 0.5 N, with inertia, how much of the motion
reaches the end organs, and the lowest modes. Published tissue hardly damps above 40 Hz; the set
that ends in ``_viscous`` has a faster branch of relaxation (`how good it is
<../vibration.html>`_).
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pyvista as pv

import fefinger as ff


frequency = np.geomspace(5, 400, 60)
fig, axes = plt.subplots(1, 3, figsize=(10, 3.2), layout="constrained")
for tissue in ("maeno1998", "maeno1998_viscous"):
    soft = ff.Finger.subject("a.h.", tissue=tissue, resolution="coarse")
    finger = ff.Vibrations(soft, ff.Flat(30))
    answer = finger.harmonic(frequency, force=0.5)
    axes[0].loglog(frequency, np.abs(answer.impedance), label=tissue)
    axes[1].semilogx(frequency, answer.phase - 90)
    (at_200,) = finger.harmonic([200], force=0.5).impedance
    print(
        f"{tissue}: {abs(at_200):.2f} N s/m at 200 Hz, {np.degrees(np.angle(at_200)):.0f} degrees"
    )
axes[0].set(xlabel="frequency / Hz", ylabel="impedance / (N s/m)")
axes[0].legend()
axes[1].set(xlabel="frequency / Hz", ylabel="phase of the impedance / degrees")
for site, kind in enumerate(finger.sites.types):
    strain = np.linalg.norm(answer.strain[:, site], axis=(-2, -1))
    axes[2].semilogx(frequency, 100 * strain, label=kind)
axes[2].set(xlabel="frequency / Hz", ylabel="strain per mm of the plate / %", ylim=(0, None))
axes[2].set_title(tissue, fontsize=10)
axes[2].legend(loc="lower left", ncols=2)
plt.show()

# %%
# The three lowest modes, cut along the finger and colored by their displacement, whose scale is
# arbitrary. ``mode.vtkhdf`` is one cycle: ParaView plays it.
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
