"""Whether a plate comes so near the proximal cut that the finger is continued behind it."""

from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter, Plate, direction
from fefinger.scene.motion import Motion


ALONG = 15.0
"""Degrees up to which a plate may come near the cut: at 10 it is 3.5 mm away from the finger of
a.h. there."""

FORCE_DEPTH = 0.22
"""First guess of the depth under force control, over the thickness of the finger."""

CLOSE = 0.75
"""Depth over the gap at the cut beyond which the finger is continued. Tissue that is fixed at the
cut makes the press stiffer: there by 2 (d.s.) to 5 % (d.p.), less at smaller depths.
"""

NEAR = 0.93
"""Depth over the gap at the cut from which contact may have reached it: on fingers of published
tissue at 0 and 5 degrees `linear` reached it at 0.94 to 0.99, on six other coarse meshes of d.p. at
1.05 to 1.15, `solid` at 0.97 to 0.99, on the tissue calibrated_ah at 1.19.
"""


def continued(finger: Finger, indenter: Indenter, motion: Motion) -> bool:
    """Whether a scene needs the finger of `mesh.extend`, longer behind the proximal cut.

    Under force control the depth is a guess.
    """
    plate = indenter.flat
    if plate is None or plate.angle > ALONG:
        return False
    by_depth = motion.control == "depth"
    deepest = motion.peak if by_depth else FORCE_DEPTH * finger.thickness
    return deepest > CLOSE * gap(finger, plate)


def gap(finger: Finger, plate: Plate, *, continued: bool = False) -> float:
    """Return the distance in mm of a plate at first touch from the skin at the proximal end."""
    from fefinger.mesh.first_touch import at_cut
    from fefinger.mesh.recipe import Recipe

    x, y, z = direction(plate).tolist()
    return at_cut(Recipe.of(finger), (x, y, z), continued=continued)
