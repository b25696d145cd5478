"""
A fabric over the ridges of the skin
====================================

A plain weave slides over a pad with ridges, on exact layers that no mesh blurs. Strain at the end
organs of FAII has lines at speed / yarn and its multiples. Ridges raise those about speed / pitch
tenfold and more, as every crown meets one ridge after the other, and the spikes follow. Friction
(`indenter.friction`) would be solved as well, some four times as slowly.
"""

import matplotlib.pyplot as plt

import fefinger as ff
from fefinger.neural import mean_rates, signal_spectrum, spike_spectrum


yarn, pitch, speed, distance = 1.0, 0.4, 80.0, 8.0
changes = {"motion.force": 0.2, "motion.distance": distance, "motion.settle": 0.1}
changes |= {"ask.pressure": False, "ask.spikes": ["FAII"]}


def spectra(ridges):
    """Spectra of the strain across the skin, the mean over units, and of the rate."""
    result = ff.run("slide-fabric", changes=changes | ridges)
    span = result.time[-1] - distance / speed, result.time[-1]
    print(f"{mean_rates(result.spikes, *span).mean():.0f} impulses/s of FAII")
    frequency, strain = signal_spectrum(result.time, result.strain[..., 2, 2], *span)
    return (frequency, strain.mean(axis=1)), spike_spectrum(result.spikes.times, *span)


figure, axes = plt.subplots(2, sharex=True, figsize=(6.0, 4.6))
skins = {"smooth skin": {"finger.ridges": None}, "ridges": {"finger.ridges.pitch": pitch}}
for name, ridges in skins.items():
    strain, rate = spectra(ridges)
    axes[0].semilogy(*strain, label=name)
    axes[1].plot(*rate, label=name)
for axis, label in zip(axes, ("strain", "rate / Hz"), strict=True):
    for line, text in ((speed / yarn, "speed / yarn"), (speed / pitch, "speed / pitch")):
        axis.axvline(line, color="0.7", linewidth=1)
        axis.text(line + 4, 0.9, text, transform=axis.get_xaxis_transform(), fontsize=8)
    axis.set(ylabel=label, xlim=(0, 400))
axes[0].set_ylim(1e-8)
axes[0].legend(loc="lower right", ncols=2)
axes[1].set_xlabel("frequency / Hz")
