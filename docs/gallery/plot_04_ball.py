"""
A ball: from small to large
===========================

Pressure under balls of three radii at the same depth.
"""

import matplotlib.pyplot as plt

import fefinger as ff


finger = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
fig, axes = plt.subplots(1, 3, figsize=(9, 3), sharey=True, layout="constrained")
for axis, radius in zip(axes, (2, 5, 12), strict=True):
    scene = ff.Scene(
        finger=finger,
        indenter=ff.Sphere(radius=radius),
        motion=ff.Ramp(speed=10, depth=1.0),
        ask=ff.Ask(fields=False, rel_error=0.9),
    )
    result = ff.run(scene, mechanics="condensed")
    pad = result.pad
    shown = axis.tricontourf(
        pad.points[:, 0], pad.points[:, 1], pad.triangles, result.pressure[-1], levels=12
    )
    fig.colorbar(shown, ax=axis, label="pressure / kPa")
    axis.set(title=f"R = {radius} mm: {result.force[-1]:.2f} N", xlabel="x / mm", aspect="equal")
    axis.set(xlim=(-6, 6), ylim=(-5, 5))
axes[0].set_ylabel("y / mm")
plt.show()
