"""
Stick and slip
==============

A plate with friction is pressed and dragged sideways in a loop of your own: the contact first
sticks, slips from its rim inward, and slides. The dotted line is the coefficient of friction.
"""

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff


soft = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
plate = ff.Flat(angle=30, friction=0.5)
finger = ff.Loop(soft, plate, mechanics="condensed", deepest=0.8)
dt, pulled, stuck = 2e-3, [], []
for depth in np.linspace(0, 0.6, 60):
    step = finger.step(dt, depth=depth)
way = np.linspace(0, 1.5, 150)
for x in way:
    step = finger.step(dt, depth=0.6, shift=(x, 0.0))
    pulled.append(np.hypot(*step.lateral_force) / step.force)
    stuck.append(step.stick_area)

fig, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
left.plot(way, pulled)
left.axhline(0.5, ls=":", color="0.5")
left.set(xlabel="shift / mm", ylabel="lateral over normal force")
right.plot(pulled, stuck)
right.set(xlabel="lateral over normal force", ylabel="area that sticks / mm²")
plt.show()
