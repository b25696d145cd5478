"""How sure a least-squares fit of a ramp and hold is, and what its data do not decide."""

import numpy as np
from numpy.typing import NDArray

from fefinger.theory.lumped.ramp_hold import RampHold
from fefinger.theory.relaxation import Prony


Array = NDArray[np.float64]

LOOSE = 0.5  # relative standard deviation beyond which a rate is not identified
APART = 2.0  # ratio of successive rates below which they cannot be told apart
PASSED = 25.0  # times that a term may fade on the ramp, from which noise of the position hides it
GAP = 5.0  # of the usual interval between samples, from which one around the corner is a gap
FADES = 3.0  # times that the fastest term has faded where the corner ends
OFF = 5.0  # standard deviations by which noise alone hardly ever misses
SEEN = 1e-3  # part of the largest force that a model has to miss for it to matter
TARED = 0.002  # part of the largest force that there may be before touch


def deviations(jacobian: Array, covariance: Array) -> list[float]:
    """Return the standard deviations (n,) of what has the `jacobian` (n, k) by k parameters.

    These have the `covariance` (k, k). Infinite where that is.
    """
    with np.errstate(invalid="ignore"):
        spread = np.sqrt(np.einsum("ij,jk,ik->i", jacobian, covariance, jacobian))
    return [float(value) if np.isfinite(value) else np.inf for value in spread]


def covariance(jacobian: Array, residual: Array, at_least: float = 0.0) -> Array:
    """Return the covariance (n, n) of parameters; infinite for those of which the data say nothing.

    jacobian (n_data, n); residual (n_data,). The scatter of the residual about the fit scales it,
    but counts as `at_least`: where the noise is known and smoothing has made the residual smaller,
    1 keeps what smoothing cannot remove.
    """
    size = np.linalg.norm(jacobian, axis=0)
    seen = size > 0
    scale = np.where(seen, size, 1.0)
    _, singular, vectors = np.linalg.svd((jacobian / scale)[:, seen], full_matrices=False)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = (vectors.T / singular**2) @ vectors
    found = np.full((len(scale), len(scale)), np.inf)
    found[np.ix_(seen, ~seen)] = found[np.ix_(~seen, seen)] = 0.0
    found[np.ix_(seen, seen)] = np.where(np.isfinite(inverse), inverse, np.inf)
    scatter = max(at_least, float(residual @ residual) / max(1, len(residual) - len(scale)))
    return found * scatter / np.outer(scale, scale)


def terms(record: RampHold, prony: Prony, spread: dict[str, float]) -> tuple[str, ...]:
    """Return what the data do not decide of the terms of G, as sentences."""
    found = []
    for i, (weight, rate) in enumerate(zip(prony.weights[1:], prony.v, strict=True), start=1):
        doubt = spread[f"v{i}"]
        if not doubt < LOOSE * rate or weight < 2 * spread[f"c{i}"]:
            found.append(
                f"term {i} is not identified: v{i} = {rate:.3g} +- {doubt:.2g} 1/s, c{i} = "
                f"{weight:.3g} +- {spread[f'c{i}']:.2g}; fit fewer terms"
            )
        if rate * record.hold_seconds < 1:
            found.append(
                f"term {i} is slower than the hold: 1/v{i} = {1 / rate:.3g} s > "
                f"{record.hold_seconds:.3g} s; it cannot be told from c0, hold longer"
            )
    for i, (fast, slow) in enumerate(zip(prony.v, prony.v[1:], strict=False), start=1):
        if fast < APART * slow:
            found.append(
                f"terms {i} and {i + 1} are too close: v = {fast:.3g} and {slow:.3g} 1/s; "
                "only their sum is known, fit fewer terms"
            )
    return tuple(found)


def misfit(missed: Array, noise: Array, size: Array, largest: float) -> tuple[str, ...]:
    """Return whether a model does not describe the record, as a sentence.

    missed (n,) N: by how much it misses averages of `size` (n,) samples; noise (n,) N: the standard
    deviations of one sample; largest force N. Noise that went through a filter leaves more in
    averages than it says.
    """
    worst = int(np.argmax(np.abs(missed) / noise))
    times = float(np.abs(missed[worst]) / noise[worst])
    scatter = float(np.sqrt(np.mean(size * (missed / noise) ** 2)))
    if max(times, scatter) <= OFF or np.abs(missed).max() <= SEEN * largest:
        return ()
    return (
        f"the model misses the record by {abs(missed[worst]):.2g} N, {times:.2g} times the "
        f"noise of a sample, and averages by {scatter:.2g} times theirs: the deviations say too "
        "little; fit more terms, tare the force, or look for drift, or a force that lags behind",
    )


def bias(record: RampHold, prony: Prony, x0: float, spread: dict[str, float]) -> tuple[str, ...]:
    """Return what moves a fit to ramp and hold by more than its deviations say, as sentences.

    `spread` has the deviations of the parameters, that of `x0` in mm.
    """
    return _hidden(record, prony, spread) + _gaps(record, prony) + _touch(record, x0, spread["x0"])


def _hidden(record: RampHold, prony: Prony, spread: dict[str, float]) -> tuple[str, ...]:
    """Return whether the ramp is too slow for the fastest term, which the fit finds too slow then.

    The rate is therefore taken two deviations faster.
    """
    lasts = float(record.time[record.hold] - record.time[record.touch])
    fastest = min(prony.v[0] + 2 * spread["v1"], 2 * prony.v[0]) if prony.v else 0.0
    if fastest * lasts <= PASSED or record.position_noise == 0:
        return ()
    return (
        f"term 1 has faded some {fastest * lasts:.2g} times over within the ramp of {lasts:.3g} s: "
        "noise of the position hides it and makes the stiffness, c1 and v1 too small; ramp faster",
    )


def _gaps(record: RampHold, prony: Prony) -> tuple[str, ...]:
    """Return whether samples are missing where the fastest term shows, from touch on."""
    until = FADES / max(prony.v, default=np.inf)
    time = record.time[record.touch :]
    time = time[: np.searchsorted(time, record.time[record.hold] + until, "right") + 1]
    apart = np.diff(time)
    widest = int(np.argmax(apart))
    if apart[widest] <= GAP * np.median(apart):
        return ()
    return (
        f"no samples from {time[widest]:.4g} to {time[widest + 1]:.4g} s, about the corner of the "
        "ramp: stiffness and the fastest term come out wrong; record it without gaps",
    )


def _touch(record: RampHold, x0: float, spread: float) -> tuple[str, ...]:
    """Return whether there is a force before touch at `x0` mm, or touch before the record."""
    found = []
    free = record.force[: record.touch][record.position[: record.touch] < x0]
    free = free[: len(free) // 4 + 1]  # x0 is itself off where they are not 0
    if free.size:
        off, sure = float(free.mean()), 5 * record.force_noise / np.sqrt(free.size)
        if abs(off) > max(sure, TARED * float(record.force.max())):
            found.append(
                f"the force is {off:.3g} N before touch, where the finger has none: stiffness "
                "and touch come out wrong; tare the force"
            )
    first = float(record.position[0])
    if first - x0 > 3 * float(np.hypot(spread, record.position_noise)):
        found.append(
            f"touch is found {first - x0:.2g} mm before the record begins: stiffness and touch "
            "come out wrong; begin it before touch, and tare the force"
        )
    return tuple(found)
