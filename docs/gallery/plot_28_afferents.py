"""
Afferents of your own
=====================

A linear-nonlinear-Poisson unit: the strain or its velocity is the rate of a Poisson process. A
family has a name, the component of strain that drives each type, and spikes.
"""

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff


GAINS = {"SAI": 500.0, "SAII": 200.0, "FAI": 10.0, "FAII": 20.0}  # impulses/s, or impulses


@ff.register
class LinearNonlinearPoisson(ff.Family):
    """Rate of SA units by strain, of FA units by its velocity."""

    name = "lnp"

    def simulate(self, time, x_in, units):
        spikes = []
        for kind, x, random in zip(units.types, x_in.T, units.random, strict=True):
            signal = x if kind.startswith("SA") else np.abs(np.gradient(x, time))
            rate = GAINS[kind] * np.maximum(signal, 0.0)
            expected = np.append(0.0, np.cumsum(rate[1:] * np.diff(time)))
            at = np.sort(random.uniform(0.0, expected[-1], random.poisson(expected[-1])))
            spikes.append(np.unique(np.interp(at, expected, time)))
        return spikes


for trial in range(5):
    scene = {"ask.afferents": "lnp", "finger.resolution": "coarse", "ask.trial": trial}
    trains = ff.run("flat-press", changes=scene).spikes
    plt.eventplot(trains.times, lineoffsets=np.arange(4) + trial / 8, linelengths=0.1)
plt.gca().set(xlabel="time / s", yticks=np.arange(4) + 0.25, yticklabels=trains.types)
plt.show()
