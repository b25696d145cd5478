"""Where the mesh of a finger has to be fine, by the indenter that touches it."""

import numpy as np

from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD


MESHED_ANGLE = 15.0
"""Degrees between the plates for which meshes differ."""

MESHED_PLACE, MESHED_NEAR = 2.0, 3.0
"""mm between the places for which meshes differ, and from the origin where none is needed."""


def refinement_location(indenter: Indenter) -> float | tuple[float, float] | None:
    """Return where the mesh has to be fine: the angle of a plate, a place (x, y) mm, or None.

    Angles and places are rounded, so that neighboring scenes share a mesh; None is the mesh that is
    fine around the touch of the 30 degree plate.
    """
    if indenter.plate is not None:
        angle = MESHED_ANGLE * round(indenter.plate.angle / MESHED_ANGLE)
        return None if angle == STANDARD.angle else float(angle)
    x, y = indenter.place or (0.0, 0.0)
    if np.hypot(x, y) <= MESHED_NEAR:
        return None
    return (
        float(MESHED_PLACE * round(x / MESHED_PLACE)),
        float(MESHED_PLACE * round(abs(y) / MESHED_PLACE)),
    )
