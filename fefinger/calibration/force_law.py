"""Force of a finger at any rate: its relaxed force curve P and one G.

T = P / c0 is the instantaneous force, and the force at any rate is the integral of G(t - s) dT(s)
while the contact grows.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.calibration.curve import Curve
from fefinger.support.arrays import Array
from fefinger.theory.contact.ting import press_by_depth, radius_nodes
from fefinger.theory.relaxation import Prony, hereditary_integral


NODES = 96
"""Number of depths at which a curve is tabulated for a contact history."""


@dataclass(frozen=True)
class ForceLaw:
    """The relaxed force curve of presses, G, and a factor on the force of the curve."""

    curve: Curve
    prony: Prony
    factor: float = 1.0

    def relaxed(self, depth: ArrayLike) -> Array:
        """Compute the relaxed force (n,) in N at depths (n,) in mm."""
        return self.factor * self.curve.force(depth)

    def array_pressure(self, depth: ArrayLike) -> Array:
        """Compute the relaxed readings (n, 64) in kPa of the array at depths (n,) in mm."""
        return self.factor * self.curve.array_pressure(depth)

    def depth(self, force: ArrayLike) -> Array:
        """Compute the depths (n,) in mm at which the instantaneous force T is `force` (n,) in N."""
        return self.curve.depth(self.prony.long_time * np.asarray(force, float) / self.factor)

    def stiffness(self, force: ArrayLike) -> Array:
        """Compute dT/dx (n,) in N/mm where the instantaneous force T is `force` (n,) in N."""
        return self.curve.stiffness(self.depth(force)) * self.factor / self.prony.long_time

    def loading(self, time: Array, depth: Array) -> Array:
        """Compute the force (n_t,) in N of a growing contact, at depths (n_t,) in mm."""
        return hereditary_integral(self.prony, time, self.relaxed(depth)) / self.prony.long_time

    def predicted(self, time: Array, depth: Array) -> Array:
        """Predict the force (n_t,) in N of any motion with depths (n_t,) mm from first touch.

        Valid on unloading, detachment and renewed contact (`theory/contact/ting.py`).
        """
        nodes = radius_nodes(max(float(depth.max()), 1e-6), NODES)
        history = press_by_depth(self.prony, time, depth, nodes)
        return history.stress(self.relaxed(nodes) / self.prony.long_time)
