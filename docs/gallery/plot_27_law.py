"""
A hyperelastic law of your own
==============================

Gent's law (Rubber Chem. Technol. 69:59, 1996): chains that cannot be stretched beyond a limit. A
law is one function, of I1 - 3 and I2 - 3; the package derives the stress and the tangent.
"""

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff
from fefinger.fem.hyperelastic.continuum import uniaxial


def gent(i1, i2, p):
    """Energy for a shear modulus of 1, and its derivatives by I1, I2, I1 I1, I1 I2, I2 I2."""
    left = np.maximum(1 - i1 / p[0], 0.0)  # at the limit the energy is infinite
    return -p[0] / 2 * np.log(left), 0.5 / left, 0.0, 0.5 / p[0] / left**2, 0.0, 0.0


ff.register(ff.Law("gent", gent, {"limit": None}))
print("order of the Taylor remainder of the tangent:", round(ff.check_law("gent", limit=2.0), 2))

stretch = np.linspace(0.6, 1.6, 41)
closed = 2.0 / (2.0 - (stretch**2 + 2 / stretch - 3)) * (stretch - stretch**-2)
plt.plot(stretch, uniaxial("gent", stretch, limit=2.0), label="elements")
plt.plot(stretch, closed, "k:", label="closed form")
plt.gca().set(xlabel="stretch", ylabel="nominal stress / shear modulus")
plt.legend()
plt.show()

# %%
# From now on tissue can have it, in Python, in a scene file and in every finite-strain mechanics.
skin = {"law": "gent", "parameters": {"limit": 0.5}}
scene = {"finger.resolution": "coarse", "motion.depth": 0.6, "ask.spikes": []}
scene |= {f"finger.skin.{key}": value for key, value in skin.items()}
print(ff.run("flat-press", changes=scene, mechanics="solid"))
