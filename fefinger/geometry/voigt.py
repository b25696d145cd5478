"""Symmetric tensors by their six components, and logarithmic strain."""

import numpy as np

from fefinger.support.arrays import Array


VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Order of the six components: xx yy zz xy yz xz, tensor (not engineering) shear."""

PLACES = [0, 3, 5, 3, 1, 4, 5, 4, 2]
"""Number of the component at every place of the tensor, row by row."""


def tensor_from_voigt(components: Array) -> Array:
    """Return symmetric tensors (..., 3, 3) from components (..., 6) in the order of VOIGT."""
    return components[..., PLACES].reshape(*components.shape[:-1], 3, 3)


def logarithmic(gradient: Array) -> Array:
    """Return ln(F'F) / 2 (..., 3, 3) of a displacement gradient H (..., 3, 3), F = I + H.

    It is in the directions of the undeformed body (Hencky 1928), and taken from the Green-Lagrange
    strain by its principal values, log1p(2 e) / 2, so that small strains keep their digits.
    """
    h = np.asarray(gradient)
    across = np.swapaxes(h, -1, -2)
    green = (h + across + across @ h) / 2
    values, vectors = np.linalg.eigh(green)
    return np.asarray(
        (vectors * (np.log1p(2 * values) / 2)[..., None, :]) @ np.swapaxes(vectors, -1, -2)
    )
