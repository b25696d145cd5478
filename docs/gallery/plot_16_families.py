"""
The two families of afferents
=============================

The same press through ``recorded`` afferents and through the chain of the thesis.
"""

import matplotlib.pyplot as plt

import fefinger as ff


fig, axes = plt.subplots(2, sharex=True, figsize=(7, 4), layout="constrained")
for axis, family in zip(axes, ("recorded", "thesis"), strict=True):
    changes = {"ask.afferents": family, "motion.hold": 1.0}
    spikes = ff.run("flat-press", changes=changes).spikes
    axis.eventplot(spikes.times, linelengths=0.8)
    axis.set_yticks(range(len(spikes)), spikes.types)
    axis.set_title(f"{family}: {spikes.summary()}", fontsize=9)
axes[-1].set_xlabel("time / s")
plt.show()
