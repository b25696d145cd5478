"""Displacement of a half-space under a line load that moves steadily over it."""

import math


STILL = 1e-3
"""Speed over that of shear waves below which the limit of the quotient is taken: both its parts
vanish."""


def amplification(speed: float) -> float:
    """Displacement of an incompressible half-space under a moving load over that at rest, less 1.

    As a fraction, for a speed over that of shear waves, M: 2 M² / [4 a - (1 + a²)²] - 1 with
    a = sqrt(1 - M²) (Cole and Huth, J. Appl. Mech. 25:433, 1958); infinite from the speed of
    Rayleigh waves, M = 0.955, on.
    """
    if speed < STILL:
        return 0.75 * speed**2
    a = math.sqrt(max(0.0, 1.0 - speed**2))
    rayleigh = 4 * a - (1 + a**2) ** 2
    return 2 * speed**2 / rayleigh - 1 if rayleigh > 0 else math.inf
