"""
Vibration in frequency
======================

The dynamic stiffness of the finger under a plate, with inertia, and how much of the motion reaches
the end organs.
"""

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff


soft = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
finger = ff.Modal(soft, ff.Flat(30))
frequency = np.geomspace(5, 400, 60)
answer = finger.harmonic(frequency, force=0.5)
print("lowest modes / Hz:", np.round(answer.modes[:5]))

fig, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.2), layout="constrained")
left.semilogx(frequency, np.abs(answer.stiffness))
left.set(xlabel="frequency / Hz", ylabel="dynamic stiffness / (N/mm)")
for site, kind in enumerate(finger.sites.types):
    strain = np.linalg.norm(answer.strain[:, site], axis=(-2, -1))
    right.semilogx(frequency, 100 * strain, label=kind)
right.set(xlabel="frequency / Hz", ylabel="strain per mm of the plate / %")
right.legend()
plt.show()
