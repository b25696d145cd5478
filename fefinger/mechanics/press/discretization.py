"""What a scene asks of its mesh: where it is fine, and whether it goes on behind the proximal cut.

A plate that comes near the cut needs a finger that is continued there.
"""

import numpy as np

from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter, Plate, direction
from fefinger.scene.indenters import STANDARD
from fefinger.scene.motion import Motion


MESHED_PLACE, MESHED_NEAR = 2.0, 3.0
"""mm between the places for which meshes differ, and from the origin where none is needed."""

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


def refinement_location(indenter: Indenter) -> float | tuple[float, float] | None:
    """Return where the mesh has to be fine: the angle of a plate, a place (x, y) mm, or None.

    Angles and places are rounded, so that neighboring scenes share a mesh; None is the mesh that is
    fine around the touch of the 30 degree plate.
    """
    if indenter.plate is not None:
        meshed_angle = 15.0  # degrees between the plates for which meshes differ
        angle = meshed_angle * round(indenter.plate.angle / meshed_angle)
        return None if angle == STANDARD.angle else float(angle)
    x, y = indenter.place or (0.0, 0.0)
    if np.hypot(x, y) <= MESHED_NEAR:
        return None
    return (
        float(MESHED_PLACE * round(x / MESHED_PLACE)),
        float(MESHED_PLACE * round(abs(y) / MESHED_PLACE)),
    )


def needs_continuation(finger: Finger, indenter: Indenter, motion: Motion) -> bool:
    """Whether a scene needs the finger of `mesh.extend`, longer behind the proximal cut.

    Under force control the depth is a guess.
    """
    plate = indenter.flat
    if plate is None or plate.angle > ALONG:
        return False
    deepest = motion.control.of(motion.peak, FORCE_DEPTH * finger.thickness)
    return deepest > CLOSE * gap(finger, plate)


def gap(finger: Finger, plate: Plate, *, with_continuation: bool = False) -> float:
    """Return the distance in mm of a plate at first touch from the skin at the proximal end."""
    from fefinger.mesh.first_touch import at_cut
    from fefinger.mesh.recipe import Recipe

    x, y, z = direction(plate).tolist()
    return at_cut(Recipe.of(finger), (x, y, z), with_continuation=with_continuation)
