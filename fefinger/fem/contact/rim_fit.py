"""Compiled least-squares fits of the gap near the rim of a contact: see `contact_area`."""

from math import hypot, sqrt

import numpy as np
from numba import njit

from fefinger.fem.contact.obstacle import FAR
from fefinger.support.arrays import Array, Flags, Integers


REACH = 2.0  # radius of a fit in edges
LEAST, FIRST = 5, 8  # fewest points of a fit; with fewer within REACH, it takes the nearest 8
RIDGE = 1e-9  # ridge regularization over the trace, for points that do not determine the fit


@njit(cache=True)
def fit_rims(
    near: Integers, offset: Array, pressed: Flags, gap: Array, fits: Array, fitted: Flags
) -> None:
    """Fit phi = gap^(2/3) around the vertices near the rim, as c0 + c1 s + c2 t + c3 t².

    near (n_rim, k): the neighbors of each, nearest first; offset (n_rim, k, 2): their offsets in
    edge lengths; pressed (n,) and gap (n_t, n) mm of all vertices. Output: fits (n_t, n_rim, 2), c0
    and the curvature 2 c3 / c1 of the zero level in 1/edge; fitted (n_t, n_rim), whether they hold.
    """
    count = near.shape[1]
    used, values, weights = np.empty(count, np.bool_), np.empty(count), np.empty(count)
    basis = np.empty((count, 4))
    for t in range(len(gap)):
        for r in range(len(near)):
            points = _choose(near[r], offset[r], pressed, gap[t], used)
            _weigh(near[r], gap[t], used, values, weights)
            c0, c1, c3 = _fit(offset[r], used, values, weights, basis)
            fitted[t, r] = points >= LEAST and c1 > 0
            fits[t, r, 0] = c0
            fits[t, r, 1] = 2 * c3 / c1 if fitted[t, r] else 0.0


@njit(cache=True)
def _choose(near: Integers, offset: Array, pressed: Flags, gap: Array, used: Flags) -> int:
    """Mark the neighbors (k,) outside the contact that the fit uses; return their number."""
    left = 0.0  # residual gap of pressed vertices: smaller gaps are numerical noise
    for i in range(len(near)):
        if pressed[near[i]] and hypot(offset[i, 0], offset[i, 1]) < REACH:
            left = max(left, abs(gap[near[i]]))
    close = first = 0
    for i in range(len(near)):
        outside = not pressed[near[i]] and left < gap[near[i]] < FAR
        used[i] = outside and hypot(offset[i, 0], offset[i, 1]) < REACH
        close += used[i]
    if close >= LEAST:
        return close
    for i in range(len(near)):
        outside = not pressed[near[i]] and left < gap[near[i]] < FAR
        used[i] = outside and first < FIRST
        first += used[i]
    return first


@njit(cache=True)
def _weigh(near: Integers, gap: Array, used: Flags, values: Array, weights: Array) -> None:
    """Fill phi and the weights (k,) of the points used: phi², divided by the largest."""
    most = 1e-300
    for i in range(len(near)):
        values[i] = max(gap[near[i]], 0.0) ** (2 / 3) if used[i] else 0.0
        weights[i] = values[i] ** 2
        most = max(most, weights[i])
    for i in range(len(near)):
        weights[i] /= most


@njit(cache=True)
def _fit(
    offset: Array, used: Flags, values: Array, weights: Array, basis: Array
) -> tuple[float, float, float]:
    """Return c0, c1 and c3; the direction of s is the gradient of a plane fitted first."""
    for i in range(len(offset)):
        basis[i, 0], basis[i, 1], basis[i, 2] = 1.0, offset[i, 0], offset[i, 1]
    plane = _least_squares(basis, used, values, weights, 3)
    steep = max(sqrt(plane[1] ** 2 + plane[2] ** 2), 1e-300)
    x, y = plane[1] / steep, plane[2] / steep
    for i in range(len(offset)):
        across = offset[i, 1] * x - offset[i, 0] * y
        basis[i, 1] = offset[i, 0] * x + offset[i, 1] * y
        basis[i, 2], basis[i, 3] = across, across**2
    fit = _least_squares(basis, used, values, weights, 4)
    return fit[0], fit[1], fit[3]


@njit(cache=True)
def _least_squares(basis: Array, used: Flags, values: Array, weights: Array, n: int) -> Array:
    """Return the coefficients (n,) of the first n columns of the basis (k, 4)."""
    matrix, right, trace = np.zeros((n, n)), np.zeros(n), 0.0
    for k in range(len(values)):
        if used[k]:
            for i in range(n):
                weighted = weights[k] * basis[k, i]
                right[i] += weighted * values[k]
                for j in range(i + 1):
                    matrix[i, j] += weighted * basis[k, j]
    for i in range(n):
        trace += matrix[i, i]
    for i in range(n):
        matrix[i, i] += RIDGE * trace + 1e-300
    return _solve(matrix, right)


@njit(cache=True)
def _solve(matrix: Array, right: Array) -> Array:
    """Return the solution (n,), from the lower half of a positive definite matrix (n, n).

    By its factors L D L', in its place.
    """
    n = len(right)
    for j in range(n):
        for k in range(j):
            matrix[j, j] -= matrix[j, k] ** 2 * matrix[k, k]
        for i in range(j + 1, n):
            for k in range(j):
                matrix[i, j] -= matrix[i, k] * matrix[j, k] * matrix[k, k]
            matrix[i, j] /= matrix[j, j]
    for i in range(n):
        for k in range(i):
            right[i] -= matrix[i, k] * right[k]
    for i in range(n):
        right[i] /= matrix[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            right[i] -= matrix[k, i] * right[k]
    return right
