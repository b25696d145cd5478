"""Derivatives by differences, to check closed forms by."""

from collections.abc import Callable

from numpy.typing import NDArray


def derivative(function: Callable[[NDArray], NDArray], x: NDArray, step: float = 1e-3) -> NDArray:
    """Return the derivative at x by the fourth-order central difference."""
    near = function(x + step) - function(x - step)
    far = function(x + 2 * step) - function(x - 2 * step)
    return (8 * near - far) / (12 * step)
