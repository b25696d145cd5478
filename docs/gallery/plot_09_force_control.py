"""
Hold a force: the finger creeps
===============================

Where the force is prescribed, the depth is the answer.
"""

import matplotlib.pyplot as plt

import fefinger as ff


finger = ff.Finger.subject("a.h.")
fig, axis = plt.subplots(figsize=(6, 3.2), layout="constrained")
for force in (0.25, 0.5, 1.0):
    scene = ff.Scene(
        finger=finger,
        motion=ff.Trapezoid(loading_rate=5, force=force, hold=2),
        ask=ff.Ask(strain=False, fields=False, rel_error=0.1),
    )
    result = ff.run(scene)
    error = result.plan.chosen.errors.get("depth", float("nan"))
    axis.plot(result.time, result.depth, label=f"{force:g} N (within {100 * error:.0f} %)")
axis.set(xlabel="time / s", ylabel="depth / mm")
axis.legend()
plt.show()
