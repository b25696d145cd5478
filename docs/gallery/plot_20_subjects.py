"""
Four subjects under the same plate
==================================

Calibrated fingers, with the presses that are shipped with the package.
"""

import matplotlib.pyplot as plt

import fefinger as ff


fig, axis = plt.subplots(figsize=(6, 3.2), layout="constrained")
for subject in ("a.h.", "d.p.", "d.s.", "p.w."):
    scene = ff.Scene(
        finger=ff.Finger.subject(subject),
        indenter=ff.Flat(30),
        motion=ff.Trapezoid(speed=20, depth=1.0, hold=0.2),
        ask=ff.Ask(strain=False, fields=False, rel_error=0.1),
    )
    result = ff.run(scene)
    axis.plot(result.depth, result.force, label=f"{subject}, {result.scene.finger.width:g} mm wide")
axis.set(xlabel="depth / mm", ylabel="force / N")
axis.legend()
plt.show()
