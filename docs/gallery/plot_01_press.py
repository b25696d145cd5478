"""
A press, its numbers and their errors
=====================================

The standard scene: the finger of subject a.h. against a plate at 30 degrees.
"""

import matplotlib.pyplot as plt

import fefinger as ff


result = ff.run("flat-press")
print(result)

# %%
# The force peaks at the end of the ramp and relaxes in the hold, in which the contact area stays.
# The band is the expected error.
fig, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
bound = result.plan.chosen.error * result.force.max()
left.fill_between(result.time, result.force - bound, result.force + bound, alpha=0.3)
left.plot(result.time, result.force)
left.set(xlabel="time / s", ylabel="force / N", xlim=(0, 0.5))
right.plot(result.time, result.contact_area)
right.set(xlabel="time / s", ylabel="contact area / mm²", xlim=(0, 0.5))
plt.show()
