"""
An edge across and along the finger
===================================

A bar with rounded corners, turned by 90 degrees: what an SAI population sees.
"""

import matplotlib.pyplot as plt

import fefinger as ff


finger = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
fig, axes = plt.subplots(1, 2, figsize=(8, 3.6), sharey=True, layout="constrained")
for axis, roll in zip(axes, (0, 90), strict=True):
    scene = ff.Scene(
        finger=finger,
        indenter=ff.Bar(width=1.0, corner=0.25, roll=roll),
        motion=ff.RampHold(speed=20, depth=0.8, hold=0.3),
        ask=ff.Ask(
            spikes=("SAI",), fields=False, rel_error=0.9, population=ff.Grid(spacing=1, radius=4)
        ),
    )
    result = ff.run(scene, mechanics="condensed")
    spikes = result.spikes
    shown = axis.scatter(*spikes.positions[:, :2].T, c=spikes.count(), s=80)
    axis.set(title=f"roll {roll} degrees: {spikes.count().sum()} spikes", xlabel="x / mm")
    axis.set_aspect("equal")
fig.colorbar(shown, ax=axes, label="spikes of a unit in 0.3 s")
axes[0].set_ylabel("y / mm")
plt.show()
