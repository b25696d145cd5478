"""Curved and compliant objects: relative curvature, compliance in series, Goodwin's spheres.

Lengths in mm, moduli and pressures in kPa, forces in mN, curvatures in 1/mm.
Source: Pawluk (1997), sections 3.5 and 3.6, Eq. 3.19 to 3.25; Johnson, Contact Mechanics, 1985.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


GOODWIN_FINGER = 15.0
"""Radius in mm that the thesis assumes for the pad under Goodwin's spheres (section 3.6)."""


def relative_radius(*radii: float) -> float:
    """Relative radius R in mm with 1/R = sum of 1/Ri (Eq. 3.9 and 3.19).

    A flat surface has an infinite Ri, a hollow one a negative Ri.

    Raises
    ------
    ValueError
        A radius of 0, or conforming surfaces, which do not touch first in a point.
    """
    if not radii or any(radius == 0 or math.isnan(radius) for radius in radii):
        msg = f"radii: expected radii in mm other than 0, received {list(radii)}"
        raise ValueError(msg)
    curvature = math.fsum(1 / radius for radius in radii)
    if curvature <= 0:
        msg = f"radii: expected surfaces that touch in a point, received {list(radii)} mm"
        raise ValueError(msg)
    return 1 / curvature


def equivalent_radius(first: float, second: float) -> float:
    """Radius sqrt(R' R'') in mm of the circular contact equivalent to an elliptic one.

    For R'/R'' up to 5 the mean contact radius is then within 3.3 %, the depth within 3.4 % and the
    peak pressure within 7 % of the elliptic contact.
    """
    elastic.require_positive("equivalent_radius", first=first, second=second)
    return math.sqrt(first * second)


def series_modulus(*solids: tuple[float, float]) -> float:
    """Contact modulus E* in kPa with 1/E* = sum of (1 - nu²) / E over (E, nu) (Eq. 3.21 and A.3).

    A rigid solid has an infinite E.
    """
    if not solids or not all(e > 0 and 0 <= nu <= 0.5 for e, nu in solids):
        msg = f"solids: expected pairs (E > 0 kPa, nu in 0 to 0.5), received {solids}"
        raise ValueError(msg)
    compliance = math.fsum((1 - poisson**2) / modulus for modulus, poisson in solids)
    if compliance == 0:
        msg = "solids: expected at least one that deforms, received rigid ones only"
        raise ValueError(msg)
    return 1 / compliance


@dataclass(frozen=True)
class HertzContact:
    """Hertz contacts: radius a mm, peak pressure p0 kPa, depth mm and force mN, as arrays."""

    radius: Array
    peak_pressure: Array
    depth: Array
    force: Array


def at_depth(depth: ArrayLike, radius: ArrayLike, plane_modulus: float) -> HertzContact:
    """Return the contact at a depth in mm (Eq. 3.8 and 3.20); radius R in mm, E* in kPa."""
    elastic.require_positive("at_depth", plane_modulus=plane_modulus)
    depth = elastic.numbers("at_depth", "depth", depth, least=0.0)
    radius = elastic.numbers("at_depth", "radius", radius, above=0.0)
    depth, radius = np.broadcast_arrays(depth, radius)
    peak = 2 * plane_modulus / np.pi * np.sqrt(depth / radius)
    force = 4 / 3 * plane_modulus * np.sqrt(radius) * depth**1.5
    return HertzContact(np.sqrt(radius * depth), peak, np.array(depth), force)


def goodwin(
    curvature: ArrayLike,
    force: ArrayLike,
    *,
    finger: float = GOODWIN_FINGER,
    reference: tuple[float, float] = (0.7, 20.0),
) -> Array:
    """Peak pressure under spheres relative to that at `reference` (Eq. 3.23).

    curvature of the sphere in 1/mm, force in any one unit, radius of the finger in mm; `reference`
    is a curvature and a force. At fixed force p0 follows P^(1/3) (C_finger + C_sphere)^(2/3).
    """
    ratio = _against(finger, curvature) / _against(finger, reference[0])
    elastic.require_positive("goodwin", reference=reference[1])
    relative = elastic.numbers("goodwin", "force", force, least=0.0) / reference[1]
    return np.asarray(np.cbrt(relative) * np.cbrt(ratio) ** 2)


def goodwin_at_depth(
    curvature: ArrayLike, *, finger: float = GOODWIN_FINGER, reference: float = 0.7
) -> Array:
    """Peak pressure at one depth relative to that at the curvature `reference` 1/mm.

    It follows (C_finger + C_sphere)^(1/2); 0.295 at zero curvature is near the printed 0.3.
    """
    return np.asarray(np.sqrt(_against(finger, curvature) / _against(finger, reference)))


def goodwin_radius(curvature: ArrayLike, *, finger: float = GOODWIN_FINGER) -> Array:
    """Contact radius at one force relative to that of a plate (Eq. 3.25)."""
    return np.asarray(1 / np.cbrt(finger * _against(finger, curvature)))


def _against(finger: float, curvature: ArrayLike) -> Array:
    """Relative curvature in 1/mm of a finger and spheres."""
    elastic.require_positive("goodwin", finger=finger)
    return 1 / finger + elastic.numbers("goodwin", "curvature", curvature, above=-1 / finger)


def torsional_friction(friction: float, force: ArrayLike, contact_radius: ArrayLike) -> Array:
    """Largest frictional torque 3/16 pi mu P a of a Hertz contact about its axis, in mN mm.

    `friction` mu, force P in mN, contact radius a in mm. The integral of mu p r over the contact:
    proportional to the contact radius at a given force, as section 3.1 says.
    """
    elastic.require_not_negative("torsional_friction", friction=friction)
    pressed = elastic.numbers("torsional_friction", "force", force, least=0.0)
    wide = elastic.numbers("torsional_friction", "contact_radius", contact_radius, least=0.0)
    return np.asarray(3 / 16 * np.pi * friction * pressed * wide)
