"""Derivatives by differences, to check closed forms by."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray


def derivative(function: Callable[[NDArray], NDArray], x: NDArray, step: float = 1e-3) -> NDArray:
    """Return the derivative at x by the fourth-order central difference."""
    near = function(x + step) - function(x - step)
    far = function(x + 2 * step) - function(x - 2 * step)
    return (8 * near - far) / (12 * step)


Field = Callable[[NDArray, NDArray], NDArray]
"""Function of r (n,) and z (n,) around an axis, with components along the first axis."""


def divergence(stress: Field, r: NDArray, z: NDArray, step: float = 1e-3) -> NDArray:
    """Return the forces r and z (2, n), 0 in equilibrium, of a stress r, theta, z, rz (4, n)."""
    by_r = derivative(lambda s: stress(s, z), r, step)
    by_z = derivative(lambda s: stress(r, s), z, step)
    radial, hoop, _, shear = stress(r, z)
    return np.array([by_r[0] + by_z[3] + (radial - hoop) / r, by_r[3] + by_z[2] + shear / r])


def gradient(moved: Field, r: NDArray, z: NDArray, step: float = 1e-3) -> NDArray:
    """Return the strain r, theta, z, rz (4, n) of a displacement u_r, u_z (2, n)."""
    by_r = derivative(lambda s: moved(s, z), r, step)
    by_z = derivative(lambda s: moved(r, s), z, step)
    return np.array([by_r[0], moved(r, z)[0] / r, by_z[1], (by_z[0] + by_r[1]) / 2])
