"""Curved objects: the relative curvature of two surfaces in contact.

Lengths in mm. Source: Pawluk (1997), section 3.5, Eq. 3.19 and 3.20; Johnson, Contact Mechanics,
1985.
"""

import math

from fefinger.theory.contact import elastic


def relative_radius(*radii: float) -> float:
    """Relative radius R in mm with 1/R = sum of 1/Ri (Eq. 3.9 and 3.19).

    A flat surface has an infinite Ri, a hollow one a negative Ri.

    Raises
    ------
    ValueError
        A radius of 0, or conforming surfaces, which do not touch first in a point.
    """
    if not radii or any(radius == 0 or math.isnan(radius) for radius in radii):
        raise ValueError(f"radii: expected radii in mm other than 0, received {list(radii)}")
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
