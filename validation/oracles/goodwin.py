"""Hertz contact of Goodwin's spheres with a finger, and friction about the axis of a contact.

Source: Pawluk (1997), sections 3.1 and 3.6, Eq. 3.22 to 3.25.
"""

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support.arrays import Array


FINGER = 15.0
"""Radius in mm that the thesis assumes for the pad under Goodwin's spheres (section 3.6)."""


def peak_at_force(
    curvature: ArrayLike,
    force: ArrayLike,
    *,
    finger: float = FINGER,
    reference: tuple[float, float] = (0.7, 20.0),
) -> Array:
    """Peak pressure under spheres relative to that at `reference` (Eq. 3.23).

    curvature of the sphere in 1/mm, force in any one unit, radius of the finger in mm; `reference`
    is a curvature and a force. At fixed force p0 follows P^(1/3) (C_finger + C_sphere)^(2/3).
    """
    ratio = _relative(finger, curvature) / _relative(finger, reference[0])
    return np.asarray(np.cbrt(np.asarray(force) / reference[1]) * np.cbrt(ratio) ** 2)


def peak_at_depth(curvature: ArrayLike, *, finger: float = FINGER, reference: float = 0.7) -> Array:
    """Peak pressure at one depth relative to that at the curvature `reference` 1/mm.

    It follows (C_finger + C_sphere)^(1/2); 0.295 at zero curvature is near the printed 0.3.
    """
    return np.asarray(np.sqrt(_relative(finger, curvature) / _relative(finger, reference)))


def contact_radius(curvature: ArrayLike, *, finger: float = FINGER) -> Array:
    """Contact radius at one force over the radius under a plate (Eq. 3.25)."""
    return np.asarray(1 / np.cbrt(finger * _relative(finger, curvature)))


def _relative(finger: float, curvature: ArrayLike) -> Array:
    """Relative curvature in 1/mm of a finger and spheres."""
    return np.asarray(1 / finger + np.asarray(curvature))


def torsional_friction(friction: float, force: float, contact_radius: float) -> float:
    """Largest frictional torque 3/16 pi mu P a of a Hertz contact about its axis, in mN mm.

    `friction` mu, force P in mN, contact radius a in mm. The integral of mu p r over the contact:
    proportional to the contact radius at a given force, as section 3.1 says.
    """
    return 3 / 16 * np.pi * friction * force * contact_radius
