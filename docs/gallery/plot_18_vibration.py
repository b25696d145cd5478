"""
A vibrating probe
=================

A pin on the fingertip of a macaque vibrates: rates of the three types, and whether their spikes
lock to it.
"""

import matplotlib.pyplot as plt

import fefinger as ff
from fefinger.neural.statistics import locking


frequencies = (5, 10, 20, 40, 80, 160, 300)
rates = {kind: [] for kind in ("SAI", "FAI", "FAII")}
for frequency in frequencies:
    changes = {
        "motion.frequency": frequency,
        "motion.amplitude": 0.05,
        "motion.held": 10.0,
        "motion.seconds": 0.5,
    }
    spikes = ff.run("probe-vibration", changes=changes).spikes
    for kind, times in zip(spikes.types, spikes.times, strict=True):
        rates[kind].append(len(times) / 0.5)
    if frequency == 40:
        fai = spikes.times[spikes.types.index("FAI")]
        locked = locking(fai, 40.0)
        print(f"FAI at 40 Hz: vector strength {locked.strength:.2f} (1: every spike at one phase)")

fig, axis = plt.subplots(figsize=(6, 3.4), layout="constrained")
for kind, values in rates.items():
    axis.plot(frequencies, values, "o-", label=kind)
axis.plot(frequencies, frequencies, "k:", label="one spike a cycle")
axis.set(xscale="log", xlabel="frequency / Hz", ylabel="rate / Hz", ylim=(0, 320))
axis.legend()
plt.show()
