"""Identification of the lumped finger from a ramp and hold: method of Pawluk (1997), and unbiased.

`thesis` treats the ramp as the instantaneous response and the hold as the relaxation after a step
(Pawluk 1997, section 2.4.1). Both are approximations: during a ramp of 60 mm/s a finger relaxes to
69 to 74 % of T, which makes b 33 to 43 % too low and c0 too high. `joint` fits Eq. 2.3 to ramp and
hold together.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact.elastic import Array
from fefinger.theory.lumped import confidence
from fefinger.theory.lumped.confidence import covariance as covariance_of
from fefinger.theory.lumped.confidence import deviations
from fefinger.theory.lumped.ramp_hold import (
    RAMP_POINTS,
    SMOOTHING,
    RampHold,
    accounted,
    derivative,
    deviation_of,
    mse,
    smooth,
    split,
)
from fefinger.theory.lumped.spring import Spring, force
from fefinger.theory.relaxation import Prony


if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

TERMS = 3  # exponentials of G in Table 3.1 of Pawluk (1997)
FASTEST = 300.0  # 1/s, initial value of the fastest rate
CUT = SMOOTHING // 2 + 1  # samples before the hold that smoothing mixes with it


@dataclass(frozen=True)
class Identification:
    """Identified parameters with uncertainty, quality of the fit and warnings.

    `uncertainty` holds one standard deviation of b (N/mm), m (1/mm), x0 (mm), c0, c1, ... and v1,
    ... (1/s), from the Jacobian and the scatter about the fit, for white noise. It excludes bias:
    a pulse of the blood pressure in the hold moves the rates by more than that. `mse`
    is that of Eq. 2.5 over ramp and hold, as a fraction; `vaf_stiffness` and `vaf_hold` the
    variance accounted for of the stiffness against the force (None where it was not fitted) and of
    the hold. `warnings` are sentences on parameters that the data do not identify, and on
    fits of `thesis` that did not converge.
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
        """Parameters by the names in `uncertainty`, including x0 and the weights."""
        weights = {f"c{i}": c for i, c in enumerate(self.prony.weights)}
        rates = {f"v{i}": v for i, v in enumerate(self.prony.v, start=1)}
        spring = {"b": self.spring.b, "m": self.spring.m, "x0": self.spring.x0}
        return spring | weights | rates


def thesis(
    time: ArrayLike, position: ArrayLike, force: ArrayLike, *, terms: int = TERMS
) -> Identification:
    """Identify the lumped finger by the method of Pawluk (1997) from (n_t,) s, mm and N.

    A 9 point average, the derivative by 5 points, a line through stiffness against force (Eq. 2.4)
    for m and b, x0 by least squares with these, and `terms` exponentials through the hold.

    Raises ValueError for a record without a usable ramp and hold (see `ramp_hold.split`).
    """
    _check_terms(terms)
    record = split(time, position, force)
    m, b, of_line, vaf_stiffness = stiffness_line(record)
    x0, x0_spread, touch_warnings = _touch(record, m, b, of_line)
    prony, hold_spread, vaf_hold, hold_warnings = _relaxation(record, terms)
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
        warnings=touch_warnings + hold_warnings + confidence.terms(record, prony, hold_spread),
    )


def stiffness_line(record: RampHold) -> tuple[float, float, Array, float]:
    """Fit m and b of Eq. 2.4; also return their covariance (2, 2) and variance accounted for."""
    part, each = _steady(record), -(-(record.beyond - record.touch) // RAMP_POINTS)
    # | 1 makes it odd, and the window symmetric; a wider one mixes more of the corner in.
    width = SMOOTHING * each | 1
    steady = slice(part.start, part.stop - (width - SMOOTHING) // 2, each)
    x, f = (smooth(values, width)[steady] for values in (record.position, record.force))
    k, f = derivative(x, f), f[2:-2]
    design = np.column_stack([f, np.ones_like(f)])
    (m, b), *_ = np.linalg.lstsq(design, k, rcond=None)
    if not min(m, b) > 0:
        raise ValueError(
            f"stiffness against force: expected a rising line above 0, received m = {m:.3g} 1/mm "
            f"and b = {b:.3g} N/mm; check that the force is 0 before touch, the ramp sampled fast "
            f"enough, and that noise ({record.force_noise:.2g} N) is small enough for slopes"
        )
    rest = k - design @ (m, b)
    covariance = np.linalg.inv(design.T @ design) * (rest @ rest) / (len(k) - 2)
    return float(m), float(b), covariance, accounted(k, k - rest)


def _steady(record: RampHold) -> slice:
    """Find the samples of the ramp in contact with steady speed, between the corners."""
    part = slice(record.touch, record.beyond - CUT)
    if part.stop - part.start < SMOOTHING:
        raise ValueError(
            f"ramp: expected {SMOOTHING + CUT} samples or more from touch to the depth of the "
            f"hold, received {record.beyond - record.touch}; sample faster, or ramp with less "
            "overshoot"
        )
    speed = np.gradient(smooth(smooth(record.position)), record.time)[part]
    # Below 0.8 of the median speed the indenter starts or stops.
    fast = np.flatnonzero(speed >= 0.8 * np.median(speed))
    return slice(part.start + int(fast[0]), part.start + int(fast[-1]) + 1)


def _touch(
    record: RampHold, m: float, b: float, covariance: Array
) -> tuple[float, float, tuple[str, ...]]:
    """Fit x0 of Eq. 2.1 to the ramp with m and b fixed: x0, standard deviation, and warnings.

    Most of the deviation is due to that of m and b, by their `covariance`. The warning is on a fit
    that did not converge.
    """
    from scipy.optimize import least_squares

    x, f = record.position[: record.beyond], record.force[: record.beyond]
    start = float(x[record.touch :].min())

    def residual(x0: Array) -> Array:
        return Spring(b, m, float(x0[0])).force(x) - f

    fit = least_squares(residual, [start], x_scale="jac")
    spring, by_x0 = Spring(b, m, float(fit.x[0])), fit.jac[:, 0]
    pressed, y = spring.force(x), spring.depth(x)
    by_line = np.stack([(b * y * np.exp(m * y) - pressed) / m, pressed / b], axis=1)
    by_m_and_b = by_x0 @ by_line / (by_x0 @ by_x0)
    variance = covariance_of(fit.jac, fit.fun)[0, 0]
    spread = float(np.sqrt(variance + by_m_and_b @ covariance @ by_m_and_b))
    warning = f"x0 = {fit.x[0]:.4g} mm had not converged after {fit.nfev} evaluations"
    return float(fit.x[0]), spread, () if fit.success else (warning,)


def joint(
    time: ArrayLike, position: ArrayLike, force: ArrayLike, *, terms: int = TERMS
) -> Identification:
    """Fit Eq. 2.3 to ramp and hold together, from (n_t,) s, mm and N.

    Every sample is weighted by the noise of the force and, through the stiffness, of the position;
    both are estimated from the record. The search starts from the rates of the hold and from rates
    at equal ratios.

    Raises ValueError for a record without a usable ramp and hold, and RuntimeError for a fit that
    does not converge.
    """
    _check_terms(terms)
    record = split(time, position, force)
    t, x, f, size = record.averages
    spring, of_hold = _start(record), _relaxation(record, terms)[0]
    spaced = _spaced(terms, record.hold_seconds)
    starts = (of_hold, spaced) if _shown(of_hold, record) else (spaced,)
    fit = _best(record, [_packed(spring, each) for each in starts])
    if not fit.success:
        raise RuntimeError(
            f"joint: the fit did not converge in {fit.nfev} evaluations "
            f"({fit.message}); fit fewer terms than {terms}, or a longer hold"
        )
    order = _sorted(3, terms, fit.x)
    values, covariance = fit.x[order], covariance_of(fit.jac, fit.fun, at_least=1.0)
    spring, prony = _unpacked(values)
    of_spring = (np.sqrt(np.diag(covariance)[:3]) * (spring.b, spring.m, 1.0)).tolist()
    spread = dict(zip(("b", "m", "x0"), of_spring, strict=True))
    spread |= _spread(prony, covariance[np.ix_(order[3:], order[3:])])
    hold, model = t >= record.time[record.hold], force_of(values, t, x)
    return Identification(
        spring=spring,
        prony=prony,
        uncertainty=spread,
        mse=mse(record, spring, prony),
        vaf_hold=accounted(f[hold], model[hold]),
        warnings=confidence.terms(record, prony, spread)
        + confidence.misfit(model - f, _sigma(record, values) * np.sqrt(size), size, float(f.max()))
        + confidence.bias(record, prony, spring.x0, spread),
    )


def _start(record: RampHold) -> Spring:
    """Choose the initial spring: from Pawluk's stiffness line, or a typical one with that peak."""
    try:
        m, b, covariance, _ = stiffness_line(record)
        # b of the line is 33 to 43 % too low, see the head of the module.
        return Spring(1.5 * b, m, _touch(record, m, b, covariance)[0])
    except ValueError:
        x0 = float(smooth(record.position)[record.touch])
        depth = float(record.position[record.hold]) - x0
        peak = float(record.force.max())
        typical = 2.0  # 1/mm, typical m of fingers: the initial value without a stiffness line
        return Spring(peak * typical / np.expm1(typical * depth), typical, x0)


def _shown(prony: Prony, record: RampHold) -> bool:
    """Test whether the samples of a hold resolve every term of a G that was fitted to it."""
    least, most = 0.1 / record.hold_seconds, 1.0 / float(np.median(np.diff(record.time)))
    faint = 1e-6  # weight below which a term counts as missing
    return min(prony.weights) > faint and all(least < v < most for v in prony.v)


def _spaced(terms: int, seconds: float) -> Prony:
    """Choose an initial G: equal weights, rates at equal ratios down to the rate of the hold.

    The ramp contains terms that have decayed by the hold, so the fastest rate is beyond the hold.
    """
    return Prony(
        (1 / (terms + 1),) * (terms + 1), tuple(np.geomspace(FASTEST, 4.0 / seconds, terms))
    )


@np.errstate(over="ignore")  # of steps too far, which are rejected
def _best(record: RampHold, starts: list[Array]) -> "OptimizeResult":
    """Return the fit, of those from `starts`, with the smallest misfit under common weights.

    Each fit has its own weights, by which a diverged fit may look good.

    Raises RuntimeError if all fits leave the range that can be computed.
    """
    t, x, f, _ = record.averages
    fits, reason = [], ""
    for start in starts:
        try:
            fits.append(_together(record, start))
        except ValueError as error:
            reason = str(error)
    if not fits:
        raise RuntimeError(
            f"joint: the fit did not converge ({reason}); check for missing samples at the corner "
            "of the ramp"
        )
    sigma = _sigma(record, fits[0].x)

    def rank(each: "OptimizeResult") -> tuple[bool, float]:
        return not each.success, float(np.mean(((force_of(each.x, t, x) - f) / sigma) ** 2))

    return min(fits, key=rank)


def _together(record: RampHold, values: Array) -> "OptimizeResult":
    """Fit Eq. 2.3 to ramp and hold by least squares, from the start `values`."""
    from scipy.optimize import least_squares

    t, x, f, _ = record.averages
    for _ in range(2):  # the weights need the stiffness, and the stiffness the weights
        weight = _sigma(record, values)

        def residual(values: Array, sigma: Array = weight) -> Array:
            return (force_of(values, t, x) - f) / sigma

        fit = least_squares(residual, values, x_scale="jac", xtol=1e-12, max_nfev=200)
        values = fit.x
    return fit


def _sigma(record: RampHold, values: Array) -> Array:
    """Return the standard deviations (n,) N of the averages for these parameters."""
    return deviation_of(record, *_unpacked(values))


def _check_terms(terms: int) -> None:
    if terms < 1 or terms != int(terms):
        msg = f"terms: expected a whole number of exponentials, 1 or more, received {terms!r}"
        raise ValueError(msg)


def force_of(values: Array, time: Array, position: Array) -> Array:
    """Force of Eq. 2.3 for the parameters (log b, log m, x0, log ci/c0 ..., log vi ...)."""
    return force(*_unpacked(values), time, position)


def _relaxation(
    record: RampHold, terms: int
) -> tuple[Prony, dict[str, float], float, tuple[str, ...]]:
    """Fit G to the hold alone: G, standard deviations, variance accounted for, and warnings.

    The warning is on a fit that did not converge.
    """
    start = int(np.sum(record.averages[0] < record.time[record.hold]))
    t, _, f, size = (values[start:] for values in record.averages)
    if np.ptp(record.force[record.hold :]) == 0:
        raise ValueError(
            f"hold: expected a force that falls, because a finger relaxes, received {f[0]:.4g} N "
            "in all its samples; check that the force is the right column"
        )
    root = np.sqrt(size)
    fit = _exponentials(t - record.time[record.hold], f, root, terms, record.hold_seconds)
    order = _sorted(1, terms, fit.x)
    amplitudes = np.exp(np.clip(fit.x[order[: terms + 1]], -40, 40))
    rates = np.exp(np.clip(fit.x[order[terms + 1 :]], -20, 20))
    prony = Prony(tuple(amplitudes / amplitudes.sum()), tuple(rates))
    spread = _spread(prony, covariance_of(fit.jac, fit.fun)[np.ix_(order, order)])
    vaf = accounted(f, f + fit.fun / root)
    warning = (
        f"the {terms} terms had not converged after {fit.nfev} evaluations; they leave "
        f"{100 * (1 - vaf):.2g} % of the variance of the hold unexplained; fit fewer terms"
    )
    return prony, spread, vaf, () if fit.success else (warning,)


@np.errstate(over="ignore")  # of steps too far, which are rejected
def _exponentials(t: Array, f: Array, root: Array, terms: int, seconds: float) -> "OptimizeResult":
    """Fit a constant and `terms` exponentials to a hold of `seconds` by least squares.

    t s since its start, f N and the root of their weights, (n,) each; the solution holds the
    logarithms of the amplitudes, that of the constant first, and of the rates.
    """
    from scipy.optimize import least_squares, nnls

    def basis(log_rates: Array) -> Array:
        # exp(-inf) = 0: the constant is the exponential that never decays.
        rates = np.exp(np.append(-np.inf, log_rates))
        return np.exp(-np.multiply.outer(t, rates))

    def residual(values: Array) -> Array:
        amplitudes = np.exp(np.clip(values[: terms + 1], -40, 40))
        return root * (basis(np.clip(values[terms + 1 :], -20, 20)) @ amplitudes - f)

    rates = np.log(np.geomspace(FASTEST, 4.0 / seconds, terms))
    amplitudes, _ = nnls(root[:, None] * basis(rates), root * f)
    # NNLS leaves some amplitudes at 0, which have no logarithm to start from.
    start = np.append(np.log(np.maximum(amplitudes, 1e-3 * f[0])), rates)
    return least_squares(residual, start, x_scale="jac", max_nfev=500)


def _packed(spring: Spring, prony: Prony) -> Array:
    """Convert parameters to the vector of `force_of`."""
    weights = np.maximum(prony.weights, 1e-6)
    shares = np.log(weights[1:] / weights[0])
    return np.concatenate([np.log([spring.b, spring.m]), [spring.x0], shares, np.log(prony.v)])


def _unpacked(values: Array) -> tuple[Spring, Prony]:
    """Convert the vector of `force_of` to parameters; clipped, so that a search cannot overflow."""
    terms = (len(values) - 3) // 2
    shares = np.exp(np.clip(np.append(0.0, values[3 : 3 + terms]), -40, 40))
    rates = np.exp(np.clip(values[3 + terms :], -20, 20))
    b, m = np.exp(np.clip(values[:2], -20, 4))
    return Spring(float(b), float(m), float(values[2])), Prony(
        tuple(shares / shares.sum()), tuple(rates)
    )


def _sorted(first: int, terms: int, values: Array) -> list[int]:
    """Order of parameters with the fastest term first, as in the tables of Pawluk (1997).

    values: `first` others, then the logarithms of the weights of the terms and of their rates.
    """
    fastest = np.argsort(values[first + terms :])[::-1]
    return [*range(first), *(first + fastest), *(first + terms + fastest)]


def _spread(prony: Prony, covariance: Array) -> dict[str, float]:
    """Return the standard deviations of weights and rates by name.

    covariance: of the logarithms of the weights, with or without that of c0, and of the rates.
    """
    weights, count = np.array(prony.weights), len(covariance) - len(prony.v)
    jacobian = (np.diag(weights) - np.outer(weights, weights))[:, -count:]
    spread = {
        f"c{i}": value for i, value in enumerate(deviations(jacobian, covariance[:count, :count]))
    }
    of_rates = (np.sqrt(np.diag(covariance)[count:]) * prony.v).tolist()
    return spread | {f"v{i}": value for i, value in enumerate(of_rates, start=1)}
