"""
A finger in a real-time loop
============================

A finger at finite strain and its afferents, driven step by step by a loop of your own: here by a
hand that trembles at 8 Hz.
"""

import time

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff


finger = ff.Loop(ff.Finger.subject("a.h."), ff.Flat(30))
units = finger.afferents()

dt, n = 1e-3, 1500
t = dt * np.arange(1, n + 1)  # ends of the steps, which begin at rest at 0
depth = 0.8 * np.clip(t / 0.2, 0, 1) + 0.15 * np.sin(2 * np.pi * 8 * (t - 0.3)) * (t > 0.3)
force, fired = np.empty(n), []
began = time.perf_counter()
for k in range(n):
    step = finger.step(dt, depth=max(depth[k], 0.0))
    units.step(step.strain, dt)
    force[k] = step.force
    fired += units.fired()  # (unit, time in s) of each spike
each = (time.perf_counter() - began) / n
print(f"{1e6 * each:.0f} us a step, for a step of {1e6 * dt:.0f} us")

fig, (top, below) = plt.subplots(2, sharex=True, figsize=(7, 4), layout="constrained")
top.plot(t, force)
top.set_ylabel("force / N")
types = finger.sites.types
below.eventplot([[at for unit, at in fired if unit == i] for i in range(len(types))])
below.set_yticks(range(len(types)), types)
below.set_xlabel("time / s")
plt.show()
