"""
Fit your own record
===================

A ramp and hold in a CSV file (time, position, force) identifies the lumped finger, with
uncertainties. Here the record is made by the law itself, with noise, so that the truth is known.
``fefinger calibrate`` fits a finite-element finger to the same file, which takes minutes.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff
from fefinger.calibration import lumped_fit


record = ff.Scene(
    finger=ff.Finger.subject("a.h."),
    indenter=ff.Flat(30),
    motion=ff.RampHold(speed=60, depth=1.5, hold=3),
    ask=ff.Ask(pressure=False, strain=False, fields=False, rel_error=0.9),
)
truth = ff.run(record, mechanics="lumped")
t = np.arange(0, truth.time[-1], 5e-4)
noise = np.random.default_rng(1).normal(0, 0.01, len(t))
force = np.maximum(np.interp(t, truth.time, truth.force) + noise, 0)
depth = np.interp(t, truth.time, truth.depth)

folder = Path(tempfile.mkdtemp())
file = folder / "press.csv"
rows = np.column_stack([t, depth, force])
np.savetxt(file, rows, delimiter=",", header="time,position,force", comments="")
fitted = lumped_fit.fit(file)
print(lumped_fit.summary(fitted))
lumped_fit.save(fitted, folder)
law = np.genfromtxt(folder / "fit.csv", delimiter=",", names=True)

fig, axis = plt.subplots(figsize=(6, 3.2), layout="constrained")
axis.plot(t, force, ".", ms=2, color="0.6", label="record")
axis.plot(truth.time, truth.force, label="truth")
axis.plot(law["time_s"], law["joint_N"], "--", label="fit")
axis.set(xlabel="time / s", ylabel="force / N", xlim=(0, 0.5))
axis.legend()
plt.show()
