"""Least squares with bounds and priors, unidentified directions, and sizes of model errors.

Errors of a model beside noise are Gaussian processes of given shapes, whose sizes have the largest
marginal likelihood. With their fitted sizes in the covariance a
least-squares fit has deviations that include the error of the model (Kennedy and O'Hagan 2001).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError


if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult


Values = dict[str, float]
Residual = Callable[[Values], Array]

EVALUATIONS = 200  # of one search; LONGER ones follow along directions that the data leave flat

LONGER, LEVEL = 2000, 1e-6
"""Evaluations of a search along a direction that the data hardly determine, and the relative change
of the misfit at which it ends: far below the scatter of the data."""


@dataclass(frozen=True)
class Unknown:
    """A parameter of a fit, with its bounds and prior.

    start and bounds in `unit`; log: fitted by its logarithm; prior: center and standard deviation,
    of the logarithm where log (a factor 2 is 0.69), or None; source: of the prior or the bounds;
    held: fixed at its start, because the data cannot determine it, but included in the covariance;
    elsewhere: determined from other data, whose result is the prior here.
    """

    name: str
    start: float
    low: float
    high: float
    unit: str
    source: str
    log: bool = True
    prior: tuple[float, float] | None = None
    held: bool = False
    elsewhere: bool = False

    def inside(self, value: float) -> float:
        """Convert the parameter to the fitted number."""
        return math.log(value) if self.log else value

    def outside(self, number: float) -> float:
        """Convert the fitted number to the parameter."""
        return math.exp(number) if self.log else number


@dataclass(frozen=True)
class Solution:
    """Result of a fit: values and standard deviations by name, covariance and misfit.

    deviations: of the parameters, in their units; covariance (n, n) of the fitted numbers,
    in the order of the unknowns; misfit: sum of squares over the degrees of freedom, 1 where noise
    explains it; weak: sentences on unidentified directions; at_bounds: names of parameters at
    their bounds.
    """

    unknowns: tuple[Unknown, ...]
    values: Values
    deviations: Values
    covariance: Array
    misfit: float
    weak: tuple[str, ...]
    at_bounds: tuple[str, ...]
    evaluations: int

    def widened(self, systematic: Values) -> Self:
        """Return the solution with systematic errors of fitted numbers, as standard deviations.

        By name; they are independent of each other and of all else.
        """
        added = np.array([systematic.get(each.name, 0.0) for each in self.unknowns])
        covariance = self.covariance + np.diag(added**2)
        deviations = {
            each.name: math.hypot(
                self.deviations[each.name],
                more * (self.values[each.name] if each.log else 1.0),
            )
            for each, more in zip(self.unknowns, added.tolist(), strict=True)
        }
        return replace(self, covariance=covariance, deviations=deviations)


def solve(
    residual: Residual, unknowns: Sequence[Unknown], starts: Sequence[Values] = ({},)
) -> Solution:
    """Fit the unknowns from several starts; `residual` is in standard deviations of the data.

    Raises ConvergenceError if no start converges.
    """
    from scipy.optimize import least_squares

    free = [each for each in unknowns if not each.held]
    start = {each.name: each.start for each in unknowns}
    low = np.array([each.inside(each.low) for each in free])
    high = np.array([each.inside(each.high) for each in free])

    def values_of(numbers: Array) -> Values:
        pairs = zip(free, numbers.tolist(), strict=True)
        return start | {each.name: each.outside(number) for each, number in pairs}

    def whole(numbers: Array) -> Array:
        values = values_of(numbers)
        return np.concatenate([residual(values), _about_priors(free, values)])

    margin = 1e-9 * (high - low)

    @np.errstate(over="ignore")  # of steps too far, which are rejected
    def search(numbers: Array, most: int, change: float) -> "OptimizeResult":
        begin = np.clip(numbers, low + margin, high - margin)
        return least_squares(
            whole,
            begin,
            bounds=(low, high),
            x_scale="jac",
            xtol=1e-10,
            ftol=change,
            max_nfev=most,
        )

    begins = [np.array([each.inside((start | s)[each.name]) for each in free]) for s in starts]
    ends = [search(numbers, EVALUATIONS, 1e-10) for numbers in begins]
    if not any(each.success for each in ends):
        ends.append(search(min(ends, key=lambda each: each.cost).x, LONGER, LEVEL))
    best = min(ends, key=lambda each: (not each.success, each.cost))
    count = sum(each.nfev for each in ends)
    if not best.success:
        flat = judged(residual, tuple(unknowns), values_of(best.x), (), count).weak
        raise ConvergenceError(
            f"calibration: expected the fit to converge within {LONGER} evaluations, it did not "
            f"from any of {len(starts)} starts; check the record: a fast ramp, a hold of several "
            "seconds, force and position of the same finger, sampled often"
            + "".join(f"; not identified: {each}" for each in flat)
        )
    at_bounds = [
        each.name
        for each, number, lo, hi in zip(free, best.x, low, high, strict=True)
        if min(number - lo, hi - number) < 1e-6 * (hi - lo)
    ]
    return judged(residual, tuple(unknowns), values_of(best.x), tuple(at_bounds), count)


def jacobian(residual: Residual, unknowns: Sequence[Unknown], values: Values) -> Array:
    """Jacobian (n, n_unknowns) with respect to the fitted numbers, by central differences."""
    columns = []
    step = 1e-4  # step of the central differences, in the logarithm of a parameter or in its unit
    for each in unknowns:
        here = each.inside(values[each.name])
        ends = [values | {each.name: each.outside(here + side * step)} for side in (1, -1)]
        columns.append((residual(ends[0]) - residual(ends[1])) / (2 * step))
    return np.stack(columns, axis=1)


def _about_priors(free: Sequence[Unknown], values: Values) -> Array:
    return np.array(
        [
            (each.inside(values[each.name]) - each.inside(each.prior[0])) / each.prior[1]
            for each in free
            if each.prior is not None
        ]
    )


def judged(
    residual: Residual,
    unknowns: tuple[Unknown, ...],
    values: Values,
    at_bounds: tuple[str, ...],
    count: int,
) -> Solution:
    """Return the solution at the values of a search that took `count` evaluations.

    Its covariance is by the derivatives of the residual there, and by the priors.
    """
    matrix = jacobian(residual, unknowns, values)
    residuals = residual(values)
    free = sum(not each.held for each in unknowns)
    misfit = float(residuals @ residuals) / max(1, len(residuals) - free)
    # Where the misfit exceeds the noise, model error dominates: scale the covariance by it.
    scale = max(1.0, misfit)
    information = matrix.T @ matrix / scale
    covariance = _covariance(unknowns, information)
    deviation = np.sqrt(np.diag(covariance))
    stretch = [values[each.name] if each.log else 1.0 for each in unknowns]
    deviations = {
        each.name: float(abs(d * s))
        for each, d, s in zip(unknowns, deviation, stretch, strict=True)
    }
    return Solution(
        unknowns,
        values,
        deviations,
        covariance,
        misfit,
        _weak(unknowns, information),
        at_bounds,
        count,
    )


def _covariance(unknowns: Sequence[Unknown], information: Array) -> Array:
    """Covariance (n, n) of the fitted numbers, by the information (n, n) of the data.

    A number that is held keeps the variance of its prior, since the data did not move it, and adds
    to the others what they would change with it (Schmidt's consider covariance). The posterior
    variance of a joint fit, which is smaller, belongs to another estimate.
    """
    variance = np.array([0.0 if each.prior is None else each.prior[1] ** 2 for each in unknowns])
    weight = np.divide(1.0, variance, out=np.zeros_like(variance), where=variance > 0)
    held = np.array([each.held for each in unknowns])
    free = ~held
    own = _inverse((information + np.diag(weight))[np.ix_(free, free)])
    change = np.zeros((len(unknowns), int(held.sum())))
    change[held] = np.eye(int(held.sum()))
    change[free] = -own @ information[np.ix_(free, held)]
    covariance = (change * variance[held]) @ change.T
    covariance[np.ix_(free, free)] += own
    return np.asarray(covariance)


def _inverse(matrix: Array) -> Array:
    """Invert a symmetric matrix after scaling; singular directions get a very large variance."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    values = np.maximum(values, 1e-14)
    return np.asarray((vectors / values) @ vectors.T / np.outer(scale, scale))


def _weak(unknowns: Sequence[Unknown], information: Array) -> tuple[str, ...]:
    """Describe every direction that the priors determine more than the data, as sentences.

    Without a prior, a uniform distribution between the bounds takes its place.
    """
    judged = [i for i, each in enumerate(unknowns) if not each.elsewhere]
    unknowns = [unknowns[i] for i in judged]
    even = [(each.inside(each.high) - each.inside(each.low)) / math.sqrt(12) for each in unknowns]
    prior = np.array(
        [each.prior[1] if each.prior else sd for each, sd in zip(unknowns, even, strict=True)]
    )
    values, vectors = np.linalg.eigh(information[np.ix_(judged, judged)] * np.outer(prior, prior))
    sentences = []
    # A direction of the parameters counts as unidentified if a change by one standard deviation of
    # its prior changes the model by at most this many standard deviations of the data.
    weak = 1.0
    for value, vector in zip(values, vectors.T, strict=True):
        if value > weak**2:
            continue
        power = vector / prior
        power = power / power[np.argmax(np.abs(power))]
        terms = [
            f"{each.name}{'' if abs(p - 1) < 0.05 else f'^{p:.2g}' if each.log else f' x {p:.2g}'}"
            for each, p in zip(unknowns, power, strict=True)
            if abs(p) > 0.1
        ]
        ways = " with ".join(terms)
        sentences.append(
            f"{ways}: a change by the standard deviation of the prior changes the data by "
            f"{math.sqrt(max(value, 0.0)):.2g} of theirs, so the prior determines it"
        )
    return tuple(sentences)


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
