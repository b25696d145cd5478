"""Logarithmic strain of a displacement gradient H: F = I + H, C = F'F."""

import numpy as np

from fefinger.support.arrays import Array


def logarithmic(gradient: Array) -> Array:
    """Return ln(C) / 2 (..., 3, 3), in the directions of the undeformed body (Hencky 1928).

    It is taken from the Green-Lagrange strain by its principal values, log1p(2 e) / 2, so that
    small strains keep their digits.
    """
    h = np.asarray(gradient)
    across = np.swapaxes(h, -1, -2)
    green = (h + across + across @ h) / 2
    values, vectors = np.linalg.eigh(green)
    return np.asarray(
        (vectors * (np.log1p(2 * values) / 2)[..., None, :]) @ np.swapaxes(vectors, -1, -2)
    )
