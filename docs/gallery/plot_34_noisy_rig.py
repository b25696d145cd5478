"""
Your own finger, from a noisy rig
=================================

A record as rigs give them: noise in both channels, a force that is 1 ms late, an offset and a
drift. The rig is fitted together with the finger, and what is wrong is told. Here the finger is
linear, which is quick; ``mechanics="solid"`` fits stiffening tissue.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff


touch = ff.Scene(
    finger=ff.Finger.subject("a.h."),
    indenter=ff.Flat(30),
    motion=ff.RampHold(speed=60, depth=1.4, hold=3, corner=0.0),
    ask=ff.Ask(pressure=False, strain=False, fields=False, rel_error=0.9),
)
truth = ff.run(touch, mechanics="lumped")
t, rng = np.arange(0, 3, 4e-4), np.random.default_rng(1)
begins = 0.11  # s of rest, and of travel to the skin
force = np.interp(t - begins - 1e-3, truth.time, truth.force, left=0)  # late
force += 0.02 + 5e-3 * t + rng.normal(0, 0.01, len(t))
position = np.clip(60 * (t - 0.1), 0, 2.0) + rng.normal(0, 0.005, len(t))

file = Path(tempfile.mkdtemp()) / "press.csv"
rows = np.column_stack([t, position, force])
np.savetxt(file, rows, delimiter=",", header="time,position,force", comments="")
finger = ff.Finger.subject("a.h.")
found = ff.calibrate(file, finger=finger, mechanics="condensed", resolution="coarse")
for name in ("delay", "offset", "drift"):
    print(f"{name}: {found[name].value:.2f} ± {found[name].sd:.2f} {found[name].unit}")
print(*found.findings, sep="\n")

press = found.presses[0]
noise = 1960 * np.array(press.noise)
fig, axis = plt.subplots(figsize=(6, 3.2), layout="constrained")
axis.fill_between(press.time, -noise, noise, color="0.85", label="95 % of the noise")
axis.plot(press.time, 1e3 * np.subtract(press.model, press.force), ".", ms=3)
axis.set(xlabel="time / s", ylabel="residual / mN", xlim=(0, 0.5), ylim=(-40, 40))
axis.legend()
plt.show()
