"""
A press, its numbers and their errors
=====================================

The standard scene: the finger of subject a.h. against a plate at 30 degrees.
"""

import matplotlib.pyplot as plt

import fefinger as ff


result = ff.run("flat-press")
for sentence in (result.plan.trust, *result.notes[:2]):
    print(sentence)

# %%
# The force overshoots and relaxes; the contact area stays.
fig, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
bound = result.plan.chosen.error * result.force.max()
left.fill_between(result.time, result.force - bound, result.force + bound, alpha=0.3)
left.plot(result.time, result.force)
left.set(xlabel="time / s", ylabel="force / N", title="force, and what it is expected within")
right.plot(result.depth, result.contact_area)
right.set(xlabel="depth / mm", ylabel="contact area / mm²")
plt.show()
