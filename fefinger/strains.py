"""Measures of finite strain, from one to another; `fem/strain.py` makes the logarithmic one."""

import numpy as np
from numpy.typing import NDArray


Array = NDArray[np.float64]


def green_lagrange(logs: Array) -> Array:
    """Return (C - I) / 2 (..., 3, 3) of the logarithmic strain ln(C) / 2, C = F'F."""
    values, vectors = np.linalg.eigh(logs)
    return np.asarray(
        (vectors * (np.expm1(2 * values) / 2)[..., None, :]) @ np.swapaxes(vectors, -1, -2)
    )
