"""
A grating, and a relief of your own
===================================

Skin bulges into the grooves of a grating. Any heights that you have are an object too.
"""

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff


finger = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
x = np.linspace(-6, 6, 61)
egg = ff.Relief.of(lambda x, y: 0.3 * np.cos(1.6 * x) * np.cos(1.6 * y), x, x)
fig, axes = plt.subplots(1, 2, figsize=(8.5, 3.6), sharey=True, layout="constrained")
objects = {"a grating": ff.Grating(period=3, ridge=1.5, depth=0.5), "a relief": egg}
for axis, (name, indenter) in zip(axes, objects.items(), strict=True):
    scene = ff.Scene(
        finger=finger,
        indenter=indenter,
        motion=ff.Ramp(speed=10, depth=0.8),
        ask=ff.Ask(fields=False, rel_error=0.9),
    )
    result = ff.run(scene, mechanics="condensed")
    pad = result.pad
    shown = axis.tripcolor(
        pad.points[:, 0], pad.points[:, 1], pad.triangles, result.pressure[-1], shading="gouraud"
    )
    fig.colorbar(shown, ax=axis, label="pressure / kPa")
    axis.set(title=name, xlabel="x / mm", aspect="equal")
    axis.set(xlim=(-8, 5), ylim=(-6, 6))
axes[0].set_ylabel("y / mm")
plt.show()
