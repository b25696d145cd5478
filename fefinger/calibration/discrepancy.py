"""How far a model is off beside noise: sizes of model errors, by their marginal likelihood.

The errors are Gaussian processes of given shapes. With their fitted sizes in the covariance a
least-squares fit has deviations that include the error of the model (Kennedy and O'Hagan 2001).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fefinger.support.arrays import Array


LARGEST = 0.5
"""Largest size, over the force."""

MERGED = 4
"""Neighboring data that are averaged for this: the errors are smooth, and the noise is known."""


def sizes(
    residual: Array,
    by_parameters: Array,
    weight: Array,
    pull: Array,
    base: Array,
    kernels: Sequence[Array],
    least: Sequence[float],
) -> tuple[float, ...]:
    """Return the sizes of the model's errors that make the residual most likely.

    The parameters are integrated over, as in restricted maximum likelihood, by their derivatives.

    Parameters
    ----------
    residual
        (n,) data less model.
    by_parameters
        (n, k) derivatives of the model.
    weight, pull
        (k,) one over the variances of the priors, 0 without, and distances of the parameters from
        their centers.
    base
        (n, n) covariance of what is known: the noise.
    kernels
        (n, n) covariances of errors of size 1.
    least
        Smallest size of each.
    """
    from scipy.optimize import minimize

    low, high = np.log(np.asarray(least, float)), np.log(LARGEST)
    merge = _merging(len(residual), np.diag(base))
    residual, by_parameters, base = merge @ residual, merge @ by_parameters, merge @ base @ merge.T
    kernels = [merge @ each @ merge.T for each in kernels]

    def unlikely(logs: Array) -> float:
        covariance = base.copy()
        for log, kernel in zip(np.clip(logs, low, high).tolist(), kernels, strict=True):
            covariance += np.exp(2 * log) * kernel
        beyond = float(np.sum(np.maximum(low - logs, 0) + np.maximum(logs - high, 0)))
        return _unlikely(residual, by_parameters, weight, pull, covariance) + 1e3 * beyond

    grid = 5  # sizes of a process that are tried before the search, between its least and LARGEST
    axes = [np.linspace(each, high, grid) for each in low]
    starts = np.stack([each.ravel() for each in np.meshgrid(*axes)], axis=1)
    start = min(starts, key=unlikely)
    simplex = np.vstack([start, *(start + 0.5 * row for row in np.eye(len(start)))])
    options: dict[str, Any] = {"xatol": 0.03, "fatol": 0.03, "initial_simplex": simplex}
    found = minimize(unlikely, start, method="Nelder-Mead", options=options)
    return tuple(np.exp(np.clip(found.x, low, high)).tolist())


def _merging(count: int, variance: Array) -> Array:
    """Return the averaging (k, n) of MERGED neighbors, weighted by their variances (n,)."""
    rows = np.arange(count) // MERGED
    merge = np.zeros((int(rows[-1]) + 1, count))
    merge[rows, np.arange(count)] = 1 / variance
    return np.asarray(merge / merge.sum(axis=1, keepdims=True))


def _unlikely(
    residual: Array, by_parameters: Array, weight: Array, pull: Array, covariance: Array
) -> float:
    """Twice the negative logarithm of the marginal likelihood, up to a constant."""
    from scipy.linalg import cho_factor, cho_solve

    factor = cho_factor(covariance, lower=True, check_finite=False)
    both = np.column_stack([residual, by_parameters])
    solved = both.T @ cho_solve(factor, both, check_finite=False)
    information = solved[1:, 1:] + np.diag(weight)
    toward = solved[1:, 0] - weight * pull
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    scaled = information / np.outer(scale, scale) + 1e-10 * np.eye(len(scale))
    gained = float(toward / scale @ np.linalg.solve(scaled, toward / scale))
    determinant = 2 * float(np.log(np.diag(factor[0])).sum())
    determinant += float(np.linalg.slogdet(scaled)[1] + 2 * np.log(scale).sum())
    return float(solved[0, 0] + pull @ (weight * pull)) - gained + determinant
