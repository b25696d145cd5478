"""
Trials of one unit
==================

A pin is pressed and held 20 times. The unit stays the same, its noise does not: raster and
peristimulus time histogram. The mechanics is solved once.
"""

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff
from fefinger.neural import psth


result = ff.run("pin-hold", changes={"finger.resolution": "coarse", "motion.hold": 0.3})
trials = [result.fire(trial=k) for k in range(20)]
times = [trains.times[trains.index("SAI")] for trains in trials]

edges = np.linspace(0, result.time[-1], 41)
rate = psth(times, edges)
most, mean = rate.max(), np.mean([len(each) for each in times])
print(f"SAI: {mean:.3g} impulses a trial, at most {most:.3g} Hz")

fig, (top, below) = plt.subplots(2, sharex=True, figsize=(6, 4), layout="constrained")
top.eventplot(times, linelengths=0.8)
top.set_ylabel("trial")
below.stairs(rate, edges)
below.set(xlabel="time / s", ylabel="rate / Hz")
plt.show()
