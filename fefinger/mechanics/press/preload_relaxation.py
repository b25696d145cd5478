"""Relaxation of small motions about a preload.

The stiffness k of a pressed finger is that of its material and a smaller, negative one of the
stress at rest, -s k. The first relaxes with G, the second does not: a small motion x has the force
k ((1 + s) G * x - s x), G being 1 at long times. So it relaxes as a finger whose decaying weights
are 1 + s times as large. So does a tabulated press, by its work ratios. Its stiffness is corrected
here, since its force between its depths is interpolated without overshoot, and the slope of that is
off by some percent.
"""

from dataclasses import dataclass, replace

import numpy as np

from fefinger.mechanics.press.tabulated_press import TabulatedPress
from fefinger.scene.finger import Finger
from fefinger.scene.motion import Motion
from fefinger.support.arrays import Array
from fefinger.theory.relaxation import Prony, creep_integral, hereditary_integral


BESIDE = 0.02
"""Half the interval about the preload, relative to it, of the slope of the tabulated press.

A smaller vibration has its own: between two nodes of depth the slope is off by up to a fifth.
"""


def about_preload(finger: Finger, share: float) -> Finger:
    """Return a finger that relaxes as small motions about its preload.

    share: s, the stiffness of the material over the whole one, less 1.
    """
    whole, *decaying = finger.prony.weights
    weights = np.array([whole, *((1.0 + share) * weight for weight in decaying)])
    prony = Prony(tuple((weights / weights.sum()).tolist()), finger.prony.v)
    return replace(finger, prony=prony)


@dataclass(frozen=True)
class PreloadRelaxation:
    """Correction of the stiffness of a tabulated press about a preload, along a vibration.

    table: the press; share: s; preload mm; stiffness N/mm of the relaxed finger there.
    """

    table: TabulatedPress
    share: float
    preload: float
    stiffness: float

    def force(self, motion: Motion, time: Array) -> Array:
        """Change (n_t,) of the force in N at prescribed depth, at times (n_t,) in s."""
        depth, vibration = motion.value(time), motion.vibration(time)
        at, slow = (self.table.elastic_force(x) for x in (depth, depth - vibration))
        swing, prony = np.asarray(at - slow), self.table.press.finger.prony
        relaxing = hereditary_integral(prony, time, swing) / prony.long_time
        stiffer = self.stiffness / self._tabulated_stiffness(float(np.abs(vibration).max()))
        return np.asarray((stiffer - 1.0) * ((1.0 + self.share) * relaxing - self.share * swing))

    def depth(self, motion: Motion, time: Array) -> Array:
        """Change (n_t,) of the depth in mm at prescribed force, at times (n_t,) in s."""
        swing = motion.vibration(time)
        prony = about_preload(self.table.press.finger, self.share).prony
        moved = prony.long_time * creep_integral(prony, time, swing) / self.stiffness
        covered = float(np.abs(swing).max()) / self.stiffness
        return np.asarray(moved * (1.0 - self.stiffness / self._tabulated_stiffness(covered)))

    def _tabulated_stiffness(self, covered: float) -> float:
        """Stiffness in N/mm of the tabulated press within a vibration of some mm at the preload."""
        widest = BESIDE * self.preload
        beside = min(covered, widest) or widest
        low = self.preload - beside
        high = min(self.preload + beside, self.table.table.deepest)
        softer, harder = self.table.elastic_force(np.array([low, high])).tolist()
        return float((harder - softer) / (high - low))
