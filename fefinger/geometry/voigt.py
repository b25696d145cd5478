"""Symmetric tensors by their six components."""

from fefinger.support.arrays import Array


VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Order of the six components: xx yy zz xy yz xz, tensor (not engineering) shear."""

PLACES = [0, 3, 5, 3, 1, 4, 5, 4, 2]
"""Number of the component at every place of the tensor, row by row."""


def tensor_from_voigt(components: Array) -> Array:
    """Return symmetric tensors (..., 3, 3) from components (..., 6) in the order of VOIGT."""
    return components[..., PLACES].reshape(*components.shape[:-1], 3, 3)
