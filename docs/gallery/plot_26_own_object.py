"""
An object of your own
=====================

The edge of a key, as a class with its heights. A scene reads it as a plugin (:doc:`/extend`).
"""

from dataclasses import dataclass
from typing import Annotated

import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff


@dataclass(frozen=True)
class KeyEdge(ff.Indenter):
    """A wedge of two sides that fall by `slope` degrees, and a rounded edge."""

    radius: Annotated[float, ff.Key("Radius of the edge", unit="mm", above=0)]
    slope: Annotated[float, ff.Key("Slope of the sides", unit="degrees", above=0, below=75)] = 45
    roll: float = 0.0

    def surface(self, x, y):
        """Heights in mm toward the finger: a hyperbola."""
        side = np.tan(np.radians(self.slope))
        return -side * (np.hypot(x, self.radius * side) - self.radius * side)


fig, axis = plt.subplots(layout="constrained")
finger = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
for radius in (0.3, 3.0):
    scene = ff.Scene(finger=finger, indenter=KeyEdge(radius), motion=ff.Ramp(20, 0.8))
    result = ff.run(scene, mechanics="condensed")
    axis.plot(result.depth, result.force, label=scene.indenter.describe())
print(result)  # no such object was measured, so its error is not known
axis.set(xlabel="depth / mm", ylabel="force / N")
axis.legend()
plt.show()
