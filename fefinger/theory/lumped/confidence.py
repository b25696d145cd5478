"""Uncertainty and warnings of a least-squares fit to a ramp and hold."""

import numpy as np

from fefinger.theory.contact.elastic import Array
from fefinger.theory.lumped.ramp_hold import RampHold
from fefinger.theory.relaxation import Prony


def deviations(jacobian: Array, covariance: Array) -> list[float]:
    """Return the standard deviations (n,) of quantities with the `jacobian` (n, k) by k parameters.

    The parameters have the `covariance` (k, k); infinite entries give infinite deviations.
    """
    with np.errstate(invalid="ignore"):
        spread = np.sqrt(np.einsum("ij,jk,ik->i", jacobian, covariance, jacobian))
    return [float(value) if np.isfinite(value) else np.inf for value in spread]


def covariance(jacobian: Array, residual: Array, at_least: float = 0.0) -> Array:
    """Covariance (n, n) of fitted parameters; infinite where one has no influence on the data.

    jacobian (n_data, n); residual (n_data,). It is scaled by the variance of the residual, but at
    least by `at_least`: 1 for residuals in units of a known noise, which smoothing has reduced.
    """
    size = np.linalg.norm(jacobian, axis=0)
    seen = size > 0
    scale = np.where(seen, size, 1.0)
    _, singular, vectors = np.linalg.svd((jacobian / scale)[:, seen], full_matrices=False)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = (vectors.T / singular**2) @ vectors
    unscaled = np.full((len(scale), len(scale)), np.inf)
    unscaled[np.ix_(seen, ~seen)] = unscaled[np.ix_(~seen, seen)] = 0.0
    unscaled[np.ix_(seen, seen)] = np.where(np.isfinite(inverse), inverse, np.inf)
    scatter = max(at_least, float(residual @ residual) / max(1, len(residual) - len(scale)))
    return unscaled * scatter / np.outer(scale, scale)


def terms(
    record: RampHold, prony: Prony, spread: dict[str, float], advice: str = "fit fewer terms"
) -> tuple[str, ...]:
    """Warnings on terms of G that the data do not identify; `advice` ends most of them."""
    warnings = []
    for i, (weight, rate) in enumerate(zip(prony.weights[1:], prony.v, strict=True), start=1):
        deviation = spread[f"v{i}"]
        # A rate with a standard deviation of half of it is not identified.
        if not deviation < 0.5 * rate or weight < 2 * spread[f"c{i}"]:
            warnings.append(
                f"term {i} is not identified: v{i} = {rate:.3g} +- {deviation:.2g} 1/s, c{i} = "
                f"{weight:.3g} +- {spread[f'c{i}']:.2g}; {advice}"
            )
        if rate * record.hold_seconds < 1:
            warnings.append(
                f"term {i} is slower than the hold: 1/v{i} = {1 / rate:.3g} s > "
                f"{record.hold_seconds:.3g} s; it cannot be separated from c0, hold longer"
            )
    for i, (fast, slow) in enumerate(zip(prony.v, prony.v[1:], strict=False), start=1):
        # Rates closer than a factor of two cannot be separated.
        if fast < 2.0 * slow:
            warnings.append(
                f"terms {i} and {i + 1} are too close: v = {fast:.3g} and {slow:.3g} 1/s; "
                f"only their sum is identified, {advice}"
            )
    return tuple(warnings)


def misfit(missed: Array, noise: Array, size: Array, largest: float) -> tuple[str, ...]:
    """Warning if the misfit of a model exceeds the noise of the record.

    missed (n,) N: misfit of averages of `size` (n,) samples; noise (n,) N: standard deviations of
    one sample; largest force N. Filtered noise leaves more in averages than white noise.
    """
    worst = int(np.argmax(np.abs(missed) / noise))
    times = float(np.abs(missed[worst]) / noise[worst])
    scatter = float(np.sqrt(np.mean(size * (missed / noise) ** 2)))
    # Noise alone hardly ever exceeds 5 standard deviations; a misfit of 1e-3 does not matter.
    if max(times, scatter) <= 5.0 or np.abs(missed).max() <= 1e-3 * largest:
        return ()
    return (
        f"the model misses the record by {abs(missed[worst]):.2g} N, {times:.2g} times the "
        f"noise of a sample, and averages by {scatter:.2g} times theirs: the stated deviations "
        "are too small; fit more terms, tare the force, or check for drift or a lag of the force",
    )


def bias(record: RampHold, prony: Prony, x0: float, spread: dict[str, float]) -> tuple[str, ...]:
    """Warnings on errors of a fit to ramp and hold beyond its stated deviations.

    `spread` holds the standard deviations of the parameters (of `x0` in mm).
    """
    return _hidden(record, prony, spread) + _gaps(record, prony) + _touch(record, x0, spread["x0"])


def _hidden(record: RampHold, prony: Prony, spread: dict[str, float]) -> tuple[str, ...]:
    """Warning if the ramp is too slow for the fastest term.

    The fit then underestimates its rate; the test therefore takes it two deviations faster.
    """
    lasts = float(record.time[record.hold] - record.time[record.touch])
    fastest = min(prony.v[0] + 2 * spread["v1"], 2 * prony.v[0]) if prony.v else 0.0
    # Noise of the position hides a term of which 25 time constants pass within the ramp.
    if fastest * lasts <= 25.0 or record.position_noise == 0:
        return ()
    return (
        f"term 1 has faded: the ramp of {lasts:.3g} s is {fastest * lasts:.2g} time constants; "
        "position noise hides it and makes the stiffness, c1 and v1 too small; ramp faster",
    )


def _gaps(record: RampHold, prony: Prony) -> tuple[str, ...]:
    """Return a warning on missing samples at the corner, where the fastest term is visible."""
    # The corner lasts three time constants of the fastest term.
    until = 3.0 / max(prony.v, default=np.inf)
    time = record.time[record.touch :]
    time = time[: np.searchsorted(time, record.time[record.hold] + until, "right") + 1]
    apart = np.diff(time)
    widest = int(np.argmax(apart))
    # An interval is a gap from five median ones on.
    if apart[widest] <= 5.0 * np.median(apart):
        return ()
    return (
        f"no samples from {time[widest]:.4g} to {time[widest + 1]:.4g} s, about the corner of the "
        "ramp: stiffness and the fastest term are biased; record it without gaps",
    )


def _touch(record: RampHold, x0: float, spread: float) -> tuple[str, ...]:
    """Warnings on a force before touch at `x0` mm, and on touch before the record begins."""
    warnings = []
    free = record.force[: record.touch][record.position[: record.touch] < x0]
    free = free[: len(free) // 4 + 1]  # x0 is biased too where they are not 0
    if free.size:
        off, sure = float(free.mean()), 5 * record.force_noise / np.sqrt(free.size)
        # A record that is tared well begins within 0.2 % of its largest force.
        if abs(off) > max(sure, 0.002 * float(record.force.max())):
            warnings.append(
                f"the force is {off:.3g} N before touch, where it should be 0: stiffness and touch "
                "are biased; tare the force"
            )
    first = float(record.position[0])
    if first - x0 > 3 * float(np.hypot(spread, record.position_noise)):
        warnings.append(
            f"touch is {first - x0:.2g} mm before the record begins: stiffness and touch are "
            "biased; begin the record before touch, and tare the force"
        )
    return tuple(warnings)
