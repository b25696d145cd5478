"""Contact modulus of two compliant solids: their compliances in series.

Moduli in kPa. Source: Pawluk (1997), Eq. 3.21; Johnson, Contact Mechanics, 1985.
"""

import math


def series_modulus(*solids: tuple[float, float]) -> float:
    """Contact modulus E* in kPa with 1/E* = sum of (1 - nu²) / E over (E, nu) (Eq. 3.21 and A.3).

    A rigid solid has an infinite E.
    """
    if not solids or not all(e > 0 and 0 <= nu <= 0.5 for e, nu in solids):
        raise ValueError(f"solids: expected pairs (E > 0 kPa, nu in 0 to 0.5), received {solids}")
    compliance = math.fsum((1 - poisson**2) / modulus for modulus, poisson in solids)
    if compliance == 0:
        raise ValueError("solids: expected at least one that deforms, received rigid ones only")
    return 1 / compliance
