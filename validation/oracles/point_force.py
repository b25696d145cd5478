"""Displacement by a point force on the surface of a half-space (Boussinesq).

Lengths in mm, moduli in kPa, forces in mN; z points into the body. Source: Johnson, Contact
Mechanics, 1985, 3.2.
"""

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


def point_displacement(
    r: ArrayLike, z: ArrayLike, *, force: float, modulus: float, poisson: float
) -> Array:
    """Displacement u_r, u_z (2, ...) in mm under a normal point force in mN, zero at infinity."""
    r, z = np.broadcast_arrays(np.asarray(r, np.float64), np.asarray(z, np.float64))
    rho = np.hypot(r, z)
    scale = force / (4 * np.pi * elastic.shear_modulus(modulus, poisson))
    outward = r * z / rho**3 - (1 - 2 * poisson) * r / (rho * (rho + z))
    return scale * np.array([outward, z**2 / rho**3 + 2 * (1 - poisson) / rho])
