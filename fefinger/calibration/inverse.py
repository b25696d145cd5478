"""Least squares with bounds and priors: values, covariance, and what the data do not decide."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fefinger.support.checks import ConvergenceError


Array = NDArray[np.float64]
Values = dict[str, float]
Residual = Callable[[Values], Array]

STEP = 1e-4
"""Step of the central differences, of the logarithm of a parameter or in its own unit."""

EVALUATIONS = 200

WEAK = 1.0
"""Standard deviations of the data that a direction of the parameters moves them by at most, per
standard deviation of its prior, for the prior to decide it more than the data."""


@dataclass(frozen=True)
class Unknown:
    """A parameter to be found.

    start and bounds in `unit`; log: searched by its logarithm; prior: center and its standard
    deviation, which is of the logarithm where log (a factor 2 is 0.69), or None; source: where the
    prior or the bounds are from; held: kept at its start, as the data cannot find it, and counted
    among what is uncertain; elsewhere: found from other data, whose result is the prior here.
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
        """Return the number that is searched for."""
        return math.log(value) if self.log else value

    def outside(self, number: float) -> float:
        """Return the parameter from the number that is searched for."""
        return math.exp(number) if self.log else number


@dataclass(frozen=True)
class Solution:
    """What was found: values and standard deviations by name, correlations, and how good it is.

    deviations are those of the parameters in their units; correlation (n, n) in the order of the
    unknowns; misfit: sum of squares over the degrees of freedom, 1 where the noise explains all;
    weak: sentences on what the data do not decide; at_bounds: names.
    """

    unknowns: tuple[Unknown, ...]
    values: Values
    deviations: Values
    covariance: Array
    correlation: Array
    misfit: float
    weak: tuple[str, ...]
    at_bounds: tuple[str, ...]
    evaluations: int


def solve(
    residual: Residual, unknowns: Sequence[Unknown], starts: Sequence[Values] = ()
) -> Solution:
    """Return the best fit over several starts; `residual` in standard deviations of the data.

    Raises
    ------
    ConvergenceError
        If no start converges.
    """
    free = [each for each in unknowns if not each.held]
    start = {each.name: each.start for each in unknowns}

    def whole(numbers: Array) -> Array:
        values = start | {
            each.name: each.outside(number)
            for each, number in zip(free, numbers.tolist(), strict=True)
        }
        return np.concatenate([residual(values), _about_priors(free, values)])

    low, high = (np.array([each.inside(v) for each, v in _bounds(free, end)]) for end in (0, 1))
    firsts = [
        [each.inside((start | first)[each.name]) for each in free] for first in starts or ({},)
    ]
    best, count = _best(whole, firsts, low, high)
    found_values = start | {
        each.name: each.outside(number) for each, number in zip(free, best.tolist(), strict=True)
    }
    at_bounds = [
        each.name
        for each, number, lo, hi in zip(free, best, low, high, strict=True)
        if min(number - lo, hi - number) < 1e-6 * (hi - lo)
    ]
    return _judged(residual, tuple(unknowns), found_values, tuple(at_bounds), count)


def _best(
    whole: Callable[[Array], Array], firsts: Sequence[Sequence[float]], low: Array, high: Array
) -> tuple[Array, int]:
    """Return the numbers (n,) of the best search of `whole` over its starts, and all evaluations.

    Raises
    ------
    ConvergenceError
        If no start converges.
    """
    from scipy.optimize import least_squares

    best, count = None, 0
    for first in firsts:
        found = least_squares(
            whole,
            np.clip(first, low + 1e-9 * (high - low), high - 1e-9 * (high - low)),
            bounds=(low, high),
            x_scale="jac",
            xtol=1e-10,
            ftol=1e-10,
            max_nfev=EVALUATIONS,
        )
        count += found.nfev
        if found.success and (best is None or found.cost < best.cost):
            best = found
    if best is None:
        message = (
            f"calibration: the fit did not converge in {EVALUATIONS} evaluations from any of "
            f"{len(firsts)} starts; check the record, or give a nearer start"
        )
        raise ConvergenceError(message)
    return best.x, count


def jacobian(residual: Residual, unknowns: Sequence[Unknown], values: Values) -> Array:
    """Return the derivative (n, n_unknowns) by the numbers that are searched for (see `STEP`)."""
    columns = []
    for each in unknowns:
        here = each.inside(values[each.name])
        ends = [values | {each.name: each.outside(here + side * STEP)} for side in (1, -1)]
        columns.append((residual(ends[0]) - residual(ends[1])) / (2 * STEP))
    return np.stack(columns, axis=1)


def taylor(residual: Residual, unknowns: Sequence[Unknown], values: Values) -> Array:
    """Return the remainders (3,) of the first-order Taylor series at steps of 0.02, 0.01, 0.005.

    They fall four times at every step where the Jacobian is right.
    """
    matrix = jacobian(residual, unknowns, values)
    way = np.random.default_rng(0).normal(size=len(unknowns))
    here, out = residual(values), []
    for size in (0.02, 0.01, 0.005):
        moved = values | {
            each.name: each.outside(each.inside(values[each.name]) + size * w)
            for each, w in zip(unknowns, way.tolist(), strict=True)
        }
        out.append(np.linalg.norm(residual(moved) - here - size * matrix @ way))
    return np.array(out)


def _bounds(free: Sequence[Unknown], end: int) -> list[tuple[Unknown, float]]:
    return [(each, (each.low, each.high)[end]) for each in free]


def _about_priors(free: Sequence[Unknown], values: Values) -> Array:
    return np.array(
        [
            (each.inside(values[each.name]) - each.inside(each.prior[0])) / each.prior[1]
            for each in free
            if each.prior is not None
        ]
    )


def _judged(
    residual: Residual,
    unknowns: tuple[Unknown, ...],
    values: Values,
    at_bounds: tuple[str, ...],
    count: int,
) -> Solution:
    matrix = jacobian(residual, unknowns, values)
    missed = residual(values)
    free = sum(not each.held for each in unknowns)
    misfit = float(missed @ missed) / max(1, len(missed) - free)
    # A model that misses by more than the noise knows its parameters no better than it misses.
    scale = max(1.0, misfit)
    information = matrix.T @ matrix / scale
    prior = np.array([0.0 if each.prior is None else each.prior[1] ** -2 for each in unknowns])
    covariance = _inverse(information + np.diag(prior))
    deviation = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(deviation, deviation)
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
        correlation,
        misfit,
        _weak(unknowns, information),
        at_bounds,
        count,
    )


def _inverse(matrix: Array) -> Array:
    """Return the inverse of a symmetric matrix, scaled; infinite where it is singular."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    values = np.maximum(values, 1e-14)
    return np.asarray((vectors / values) @ vectors.T / np.outer(scale, scale))


def _even(each: Unknown) -> float:
    """Return the standard deviation of what may be anywhere between the bounds."""
    return (each.inside(each.high) - each.inside(each.low)) / math.sqrt(12)


def _weak(unknowns: Sequence[Unknown], information: Array) -> tuple[str, ...]:
    """Return a sentence for every direction that the data decide less than the priors do.

    Where there is no prior the width of the bounds, taken as even, stands for one.
    """
    asked = [i for i, each in enumerate(unknowns) if not each.elsewhere]
    unknowns = [unknowns[i] for i in asked]
    prior = np.array([each.prior[1] if each.prior else _even(each) for each in unknowns])
    values, vectors = np.linalg.eigh(information[np.ix_(asked, asked)] * np.outer(prior, prior))
    found = []
    for value, vector in zip(values, vectors.T, strict=True):
        if value > WEAK**2:
            continue
        power = vector / prior
        power = power / power[np.argmax(np.abs(power))]
        terms = [
            f"{each.name}{'' if abs(p - 1) < 0.05 else f'^{p:.2g}' if each.log else f' x {p:.2g}'}"
            for each, p in zip(unknowns, power, strict=True)
            if abs(p) > 0.1
        ]
        ways = " with ".join(terms)
        found.append(
            f"{ways}: the data move by {math.sqrt(max(value, 0.0)):.2g} of their standard "
            "deviation as this goes by that of its prior, which is kept"
        )
    return tuple(found)
