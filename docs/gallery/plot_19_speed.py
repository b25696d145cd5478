"""
Relaxation: the same depth at four speeds
=========================================

A scene that asks for the force alone is answered in milliseconds by a force law.
"""

import time

import matplotlib.pyplot as plt

import fefinger as ff


fig, axis = plt.subplots(figsize=(6, 3.2), layout="constrained")
for speed in (1, 5, 20, 100):
    scene = ff.Scene(
        finger=ff.Finger.subject("a.h."),
        motion=ff.RampHold(speed=speed, depth=1.2, hold=2),
        ask=ff.Ask(pressure=False, strain=False, fields=False, rel_error=0.2),
    )
    began = time.perf_counter()
    result = ff.run(scene)
    took = 1e3 * (time.perf_counter() - began)
    label = f"{speed} mm/s ({result.plan.mechanics}, in {took:.0f} ms)"
    axis.plot(result.time, result.force, label=label)
axis.set(xlabel="time / s", ylabel="force / N", xlim=(0, 2))
axis.legend(fontsize=8)
plt.show()
