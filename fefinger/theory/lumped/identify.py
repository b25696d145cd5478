"""Identification of the lumped finger from a ramp and hold: the thesis's way and an unbiased one.

`thesis` takes the ramp for the instantaneous response and the hold for the relaxation after a step
(Pawluk 1997, section 2.4.1). Neither is: at 60 mm/s a finger has relaxed to 69 to 74 % of T on the
way, so b comes out 33 to 43 % low and c0 high. `joint` fits Eq. 2.3 to ramp and hold together.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.theory.lumped import confidence as doubt
from fefinger.theory.lumped.confidence import covariance as covariance_of
from fefinger.theory.lumped.confidence import deviations
from fefinger.theory.lumped.ramp_hold import (
    RampHold,
    accounted,
    averages,
    deviation_of,
    mse,
    smooth,
    split,
)
from fefinger.theory.lumped.spring import Spring, force
from fefinger.theory.lumped.stiffness_line import stiffness_line, touch
from fefinger.theory.relaxation import Prony


if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

Array = NDArray[np.float64]

TERMS = 3
FASTEST = 300.0  # 1/s, where the search for the rates starts
EVALUATIONS = 500  # of the hold, at most
FAINT = 1e-6  # weight of a term that is none
TYPICAL = 2.0  # 1/mm, of fingers, where the search for m starts if there is no line


@dataclass(frozen=True)
class Identification:
    """What a fit found.

    `uncertainty` holds one standard deviation of b (N/mm), m (1/mm), x0 (mm), c0, c1, ... and v1,
    ... (1/s), from the Jacobian and the scatter about the fit, for white noise: it knows nothing of
    bias, and a pulse of the blood pressure in the hold moves the rates by more than it says. `mse`
    is that of Eq. 2.5 over ramp and hold, as a fraction; `vaf_stiffness` and `vaf_hold` the
    variance accounted for of the stiffness against the force (None where it was not fitted) and of
    the hold. `warnings` are sentences on what the data do not decide, and on searches of `thesis`
    that were cut short.
    """

    spring: Spring
    prony: Prony
    uncertainty: dict[str, float]
    mse: float
    vaf_hold: float
    vaf_stiffness: float | None = None
    warnings: tuple[str, ...] = field(default=())

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters by the names that `uncertainty` uses; x0 and the weights included."""
        weights = {f"c{i}": c for i, c in enumerate(self.prony.weights)}
        rates = {f"v{i}": v for i, v in enumerate(self.prony.v, start=1)}
        spring = {"b": self.spring.b, "m": self.spring.m, "x0": self.spring.x0}
        return spring | weights | rates


def thesis(
    time: ArrayLike, position: ArrayLike, force: ArrayLike, *, terms: int = TERMS
) -> Identification:
    """Return the identification of the thesis from (n_t,) s, mm and N.

    A 9 point average, the derivative by 5 points, a line through stiffness against force (Eq. 2.4)
    for m and b, x0 by least squares with these, and `terms` exponentials through the hold.

    Raises
    ------
    ValueError
        A record without a usable ramp and hold (see `ramphold.split`).
    """
    _check_terms(terms)
    record = split(time, position, force)
    m, b, of_line, vaf_stiffness = stiffness_line(record)
    x0, x0_spread, touch_said = touch(record, m, b, of_line)
    prony, hold_spread, vaf_hold, hold_said = _relaxation(record, terms)
    spring = Spring(b, m, x0)
    return Identification(
        spring=spring,
        prony=prony,
        uncertainty={
            "b": float(np.sqrt(of_line[1, 1])),
            "m": float(np.sqrt(of_line[0, 0])),
            "x0": x0_spread,
        }
        | hold_spread,
        mse=mse(record, spring, prony),
        vaf_hold=vaf_hold,
        vaf_stiffness=vaf_stiffness,
        warnings=touch_said + hold_said + doubt.terms(record, prony, hold_spread),
    )


def joint(
    time: ArrayLike, position: ArrayLike, force: ArrayLike, *, terms: int = TERMS
) -> Identification:
    """Return the fit of Eq. 2.3 to ramp and hold together, from (n_t,) s, mm and N.

    Every sample is weighted by the noise of the force and, through the stiffness, of the position,
    as found in the record itself. The search starts from the rates of the hold, and from spread
    ones.

    Raises
    ------
    ValueError
        A record without a usable ramp and hold.
    RuntimeError
        A fit that does not converge.
    """
    _check_terms(terms)
    record = split(time, position, force)
    t, x, f, size = averages(record)
    spring, of_hold = _start(record), _relaxation(record, terms)[0]
    spaced = _spaced(terms, record.hold_seconds)
    starts = (of_hold, spaced) if _shown(of_hold, record) else (spaced,)
    found = _best(record, [_packed(spring, each) for each in starts])
    if not found.success:
        msg = (
            f"joint: the fit did not converge in {found.nfev} evaluations "
            f"({found.message}); fit fewer terms than {terms}, or a longer hold"
        )
        raise RuntimeError(msg)
    values = found.x
    spring, prony = _unpacked(values)
    covariance = covariance_of(found.jac, found.fun, at_least=1.0)
    order = np.argsort(prony.v)[::-1]
    prony = _sorted(prony, order)
    spread = _spread(spring, prony, covariance, order)
    hold, model = t >= record.time[record.hold], force_of(values, t, x)
    return Identification(
        spring=spring,
        prony=prony,
        uncertainty=spread,
        mse=mse(record, spring, prony),
        vaf_hold=accounted(f[hold], model[hold]),
        warnings=doubt.terms(record, prony, spread)
        + doubt.misfit(model - f, _sigma(record, values) * np.sqrt(size), size, float(f.max()))
        + doubt.bias(record, prony, spring.x0, spread),
    )


def _start(record: RampHold) -> Spring:
    """Return a spring to start from: of the thesis's line, or a typical one that has the peak."""
    try:
        m, b, covariance, _ = stiffness_line(record)
        return Spring(1.5 * b, m, touch(record, m, b, covariance)[0])
    except ValueError:
        x0 = float(smooth(record.position)[record.touch])
        depth = float(record.position[record.hold]) - x0
        peak = float(record.force.max())
        return Spring(peak * TYPICAL / np.expm1(TYPICAL * depth), TYPICAL, x0)


def _shown(prony: Prony, record: RampHold) -> bool:
    """Return whether the samples of a hold can show every term of a G that was found in it."""
    least, most = 0.1 / record.hold_seconds, 1.0 / float(np.median(np.diff(record.time)))
    return min(prony.weights) > FAINT and all(least < v < most for v in prony.v)


def _spaced(terms: int, seconds: float) -> Prony:
    """Return terms of equal weight, their rates evenly apart in what a hold of `seconds` shows.

    A ramp shows terms that have faded by the hold, of which the hold alone tells nothing.
    """
    return Prony(
        (1 / (terms + 1),) * (terms + 1), tuple(np.geomspace(FASTEST, 4.0 / seconds, terms))
    )


def _best(record: RampHold, starts: list[Array]) -> "OptimizeResult":
    """Return the nearest of the fits from `starts`; one that went astray looks good by itself.

    Raises
    ------
    RuntimeError
        If all of them lead beyond what can be computed.
    """
    t, x, f, _ = averages(record)
    found, said = [], ""
    for start in starts:
        try:
            found.append(_together(record, start))
        except ValueError as error:
            said = str(error)
    if not found:
        msg = f"joint: the fit does not converge ({said}); are samples missing at the corner?"
        raise RuntimeError(msg)
    sigma = _sigma(record, found[0].x)

    def rank(each: "OptimizeResult") -> tuple[bool, float]:
        return not each.success, float(np.mean(((force_of(each.x, t, x) - f) / sigma) ** 2))

    return min(found, key=rank)


def _together(record: RampHold, values: Array) -> "OptimizeResult":
    """Return the least squares of Eq. 2.3 through ramp and hold, from the start `values`."""
    from scipy.optimize import least_squares

    t, x, f, _ = averages(record)
    for _ in range(2):  # the weights need the stiffness, and the stiffness the weights
        weight = _sigma(record, values)

        def residual(values: Array, sigma: Array = weight) -> Array:
            return (force_of(values, t, x) - f) / sigma

        found = least_squares(residual, values, x_scale="jac", xtol=1e-12, max_nfev=200)
        values = found.x
    return found


def _sigma(record: RampHold, values: Array) -> Array:
    """Return the standard deviations (n,) N of the averages."""
    return deviation_of(record, *_unpacked(values))


def _check_terms(terms: int) -> None:
    if terms < 1 or terms != int(terms):
        msg = f"terms: expected a whole number of exponentials, 1 or more, received {terms!r}"
        raise ValueError(msg)


def force_of(values: Array, time: Array, position: Array) -> Array:
    """Return Eq. 2.3 for the parameters (log b, log m, x0, log ci/c0 ..., log vi ...)."""
    return force(*_unpacked(values), time, position)


def _relaxation(
    record: RampHold, terms: int
) -> tuple[Prony, dict[str, float], float, tuple[str, ...]]:
    """Return G from the hold alone, its standard deviations and the variance accounted for.

    And a sentence where the search was not done.
    """
    t, _, f, size = (values[-_groups(record) :] for values in averages(record))
    root = np.sqrt(size)
    found = _exponentials(t - record.time[record.hold], f, root, terms, record.hold_seconds)
    order = np.argsort(found.x[terms + 1 :])[::-1]
    amplitudes = np.exp(np.clip(found.x[: terms + 1], -40, 40))
    rates = np.exp(np.clip(found.x[terms + 1 :], -20, 20))
    prony = _sorted(Prony(tuple(amplitudes / amplitudes.sum()), tuple(rates)), order)
    covariance = covariance_of(found.jac, found.fun)
    share = _rows(order, offset=1)
    weights = np.array(prony.weights)
    jacobian = np.diag(weights) - np.outer(weights, weights)
    deviation = deviations(jacobian, covariance[np.ix_(share, share)])
    spread = {f"c{i}": value for i, value in enumerate(deviation)}
    for i, row in enumerate(order, start=1):
        spread[f"v{i}"] = prony.v[i - 1] * float(np.sqrt(covariance.diagonal()[terms + 1 + row]))
    vaf = accounted(f, f + found.fun / root)
    said = (
        f"the {terms} terms had not settled after {found.nfev} evaluations; as they are they "
        f"leave {100 * (1 - vaf):.2g} % of the variance of the hold; fit fewer terms"
    )
    return prony, spread, vaf, () if found.success else (said,)


def _exponentials(t: Array, f: Array, root: Array, terms: int, seconds: float) -> "OptimizeResult":
    """Return the least squares of a constant and `terms` exponentials through a hold of `seconds`.

    t s since its start, f N and the root of their weights, (n,) each; the solution holds the
    logarithms of the amplitudes, that of the constant first, and of the rates.
    """
    from scipy.optimize import least_squares, nnls

    def basis(log_rates: Array) -> Array:
        rates = np.exp(np.append(-np.inf, log_rates))
        return np.exp(-np.multiply.outer(t, rates))

    def residual(values: Array) -> Array:
        amplitudes = np.exp(np.clip(values[: terms + 1], -40, 40))
        return root * (basis(np.clip(values[terms + 1 :], -20, 20)) @ amplitudes - f)

    rates = np.log(np.geomspace(FASTEST, 4.0 / seconds, terms))
    amplitudes, _ = nnls(root[:, None] * basis(rates), root * f)
    start = np.append(np.log(np.maximum(amplitudes, 1e-3 * f[0])), rates)
    return least_squares(residual, start, x_scale="jac", max_nfev=EVALUATIONS)


def _groups(record: RampHold) -> int:
    """Return how many of the averages are in the hold."""
    return int(np.sum(averages(record)[0] >= record.time[record.hold]))


def _packed(spring: Spring, prony: Prony) -> Array:
    weights = np.maximum(prony.weights, 1e-6)
    shares = np.log(weights[1:] / weights[0])
    return np.concatenate([np.log([spring.b, spring.m]), [spring.x0], shares, np.log(prony.v)])


def _unpacked(values: Array) -> tuple[Spring, Prony]:
    terms = (len(values) - 3) // 2
    shares = np.exp(np.clip(np.append(0.0, values[3 : 3 + terms]), -40, 40))
    rates = np.exp(np.clip(values[3 + terms :], -20, 20))
    b, m = np.exp(np.clip(values[:2], -20, 4))
    return Spring(float(b), float(m), float(values[2])), Prony(
        tuple(shares / shares.sum()), tuple(rates)
    )


def _sorted(prony: Prony, order: NDArray[np.intp]) -> Prony:
    """Return the terms in `order`, fastest first as the tables of the thesis have them."""
    c, v = prony.weights, prony.v
    return Prony((c[0], *(c[1 + i] for i in order)), tuple(v[i] for i in order))


def _rows(order: NDArray[np.intp], *, offset: int) -> list[int]:
    """Return the rows of the sorted weights, after `offset` rows of others."""
    return [*range(offset), *(offset + int(i) for i in order)]


def _spread(
    spring: Spring, prony: Prony, covariance: Array, order: NDArray[np.intp]
) -> dict[str, float]:
    """Return one standard deviation of every parameter of `joint`."""
    deviation = np.sqrt(np.diag(covariance))
    terms = len(prony.v)
    shares = [3 + int(i) for i in order]
    weights = np.array(prony.weights)
    jacobian = -np.outer(weights, weights[1:])
    jacobian[1:] += np.diag(weights[1:])
    of_weights = deviations(jacobian, covariance[np.ix_(shares, shares)])
    spread = {
        "b": spring.b * float(deviation[0]),
        "m": spring.m * float(deviation[1]),
        "x0": float(deviation[2]),
    }
    spread |= {f"c{i}": value for i, value in enumerate(of_weights)}
    rates = enumerate(order, start=1)
    return spread | {f"v{i}": prony.v[i - 1] * float(deviation[3 + terms + j]) for i, j in rates}
