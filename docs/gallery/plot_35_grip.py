"""
Grip and slip
=============

A plate is pressed to 2 N, as in a grip, and pulled until it slips, at finite strain and on the
subject's own tissue. The rim of the contact slips first. The part of the contact that sticks was
seen to fall about as a line with the pull (dotted; André et al., J. R. Soc. Interface 8:1574,
2011); the dashed line is Mindlin's for a ball on an elastic half-space.
"""

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff


changes = {"motion.distance": 3.0, "ask.spikes": [], "ask.strain": False}
result = ff.run("grip-and-slip", changes=changes)
lateral, pulling = result.lateral, result.time > result.scene.motion.recorded_from
area, force = result.contact_area[pulling], result.force[pulling]
pull = -lateral.force[pulling, 0] / (0.8 * force)
print(lateral.outcome)

fig, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
q = np.linspace(0, 1, 50)
left.plot(pull, lateral.stick_area[pulling] / area)
left.plot(q, 1 - q, ls=":", color="0.5")
left.plot(q, (1 - q) ** (2 / 3), ls="--", color="0.5")
left.set(xlabel="pull over friction of the whole contact", ylabel="part of the area that sticks")
right.plot(-lateral.shift[pulling, 0], area)
right.set(xlabel="path of the plate / mm", ylabel="contact area / mm²", ylim=(0, None))
plt.show()
