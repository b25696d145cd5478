"""
A fabric over the ridges of the skin
====================================

A plain weave slides over a pad with ridges, on exact layers that no mesh blurs. Strain at the end
organs of FAII has lines at speed / yarn and its multiples. Ridges raise those about speed / pitch
tenfold and more, as every crown meets one ridge after the other, and the spikes follow. Friction
(`indenter.friction`) would be solved as well, some four times as slowly.
"""

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff


yarn, pitch, speed, distance = 1.0, 0.4, 80.0, 8.0
changes = {"motion.force": 0.2, "motion.distance": distance, "motion.settle": 0.1}
changes |= {"ask.pressure": False, "ask.spikes": ["FAII"]}


def spectra(ridges):
    """Frequencies in Hz, amplitudes of the strain across the skin and of the rate; mean units."""
    result = ff.run("slide-fabric", changes=changes | ridges)
    time = np.arange(result.time[-1] - distance / speed, result.time[-1], 1e-3)
    depth = np.array([np.interp(time, result.time, each) for each in result.strain[..., 2, 2].T])
    window = np.hanning(len(time)) / len(time) * 4
    strain = np.abs(np.fft.rfft((depth - depth.mean(axis=1, keepdims=True)) * window)).mean(axis=0)
    edges = np.append(time, time[-1] + 1e-3) - 0.5e-3
    counts = np.array([np.histogram(train, edges)[0] for train in result.spikes.times])
    rate = np.abs(np.fft.rfft((counts - counts.mean()) * window * 1e3)).mean(axis=0)
    print(f"{counts.sum() / len(counts) / np.ptp(time):.0f} impulses/s of FAII")
    return np.fft.rfftfreq(len(time), 1e-3), strain, rate


figure, axes = plt.subplots(2, sharex=True, figsize=(6.0, 4.6))
skins = {"smooth skin": {"finger.ridges": None}, "ridges": {"finger.ridges.pitch": pitch}}
for name, ridges in skins.items():
    frequency, strain, rate = spectra(ridges)
    axes[0].semilogy(frequency, strain, label=name)
    axes[1].plot(frequency, rate, label=name)
for axis, label in zip(axes, ("strain", "rate / Hz"), strict=True):
    for line, text in ((speed / yarn, "speed / yarn"), (speed / pitch, "speed / pitch")):
        axis.axvline(line, color="0.7", linewidth=1)
        axis.text(line + 4, 0.9, text, transform=axis.get_xaxis_transform(), fontsize=8)
    axis.set(ylabel=label, xlim=(0, 400))
axes[0].legend(loc="upper right")
axes[1].set_xlabel("frequency / Hz")
