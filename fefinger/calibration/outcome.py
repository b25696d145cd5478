"""Make the record of a calibration: parameters, misfits, unidentified parameters, predictions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from fefinger.calibration import pad_radius
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.force import MODULUS, RADIUS, SHAPE, TOUCH
from fefinger.calibration.inverse import Solution
from fefinger.calibration.record import LENGTHS, Calibration, Stage, parameters_of, tissue
from fefinger.calibration.targets import RecordTarget, SubjectTarget
from fefinger.results.candidate import MECHANICS
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.motions import RampSinusoid
from fefinger.scene.tissue import Tissue
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError
from fefinger.theory.lumped import confidence
from fefinger.theory.lumped.identify import TERMS
from fefinger.theory.lumped.spring import contact_force


LAW = "demiray"
GROSS = 0.1
"""Largest squared error over the variance of a record for a fit to be accepted. That of the thesis
on its predicted sinusoids is 0.07."""

AGREES = 0.05
"""Relative error of the fitted R up to which the pad radius counts as identified."""

ONE_G = (
    "one G relaxes the force, where the stress relaxes and strain is finite: weights of a twin "
    "come back 2 to 3 % off, its exponent 4 %, its fastest rate 5 %, which their deviations do not "
    "count"
)
"""Bias of fits by `solid` (suite `calibration`, twin of solid)."""

RADIUS_KNOWN = (
    "modulus, exponent: their deviations take the pad radius as known; the record of a twin whose "
    "radius was 8 % smaller than that of the fit gave 0.85 of its modulus and 0.8 of its exponent"
)
"""Effect of a pad radius that no frames determine: `solid` on the coarse mesh, a finger 15 mm wide
and 11 mm thick, 1.6 mm deep, fitted with and without its own radius. Subjects scatter by 13 %."""

APART = 0.1
"""Difference in mm of two estimates of the touch above which it is reported."""

FREQUENCIES = (2, 4, 8, 16)
"""Hz of the sinusoids of the thesis (section 2.2.2), which are predicted and not fitted."""

OPERATING = 2.0
"""Instantaneous force in N about which they oscillate; in the thesis 0 to 2 N."""

SWING = 0.5
"""Their amplitude times m: the stiffness varies by a factor e over a cycle."""


@dataclass(frozen=True)
class FitResult:
    """Result of a fit: the solution, and the force law of its values."""

    solution: Solution
    law: ForceLaw


def layer(tissue: Tissue, exponent: float) -> Tissue:
    """Return a layer with Demiray's law."""
    return replace(tissue, law=LAW, exponent=exponent, share=None, parameters={})


def stiffening(finger: Finger, exponent: float | None, factor: float = 1.0) -> Finger:
    """Return a finger with `factor` times the moduli and an exponent in its pulp, if there is one.

    The skin has SKIN_EXPONENT_RATIO times that exponent.
    """
    skin, pulp = (
        replace(each, modulus=factor * each.modulus) for each in (finger.skin, finger.subcutaneous)
    )
    if exponent is not None:
        skin = layer(skin, library.SKIN_EXPONENT_RATIO * exponent)
        pulp = layer(pulp, exponent)
    return replace(finger, skin=skin, subcutaneous=pulp)


def outcome(
    wanted: SubjectTarget | RecordTarget,
    finger: Finger,
    result: FitResult,
    stages: Sequence[Stage],
    mechanics: str,
    array: dict[str, float],
    ripple: float,
    fit_remarks: Sequence[str] = (),
) -> Calibration:
    """Make the record of a fit on a finger.

    array: results of the thesis's fit, by name; ripple: distance of the last press from its curve;
    fit_remarks: on presses that ended early, where the curve ends, and on the pad radius.
    """
    solution = result.solution
    factor, exponent, sentences = 1.0, None, list(fit_remarks)
    if MECHANICS[mechanics].finite:
        factor = solution.values[MODULUS] / finger.subcutaneous.modulus
        exponent = round(solution.values[SHAPE], 4)
        if isinstance(wanted, RecordTarget):
            sentences.append(f"exponent, c0, c1, v1 ...: {ONE_G}")
            if not array:
                sentences.append(RADIUS_KNOWN)
    fitted, curve = stiffening(finger, exponent, factor), result.law.curve
    parameters, correlations = parameters_of(solution)
    residuals = {"misfit": solution.misfit, **_misfits(wanted, result), **array}
    residuals["distance of the curve from the last press"] = ripple
    return Calibration(
        target=wanted.name,
        mechanics=mechanics,
        finger={name: getattr(finger, name) for name in (*LENGTHS, "resolution")},
        parameters=parameters,
        correlations=correlations,
        residuals=residuals,
        unidentified=(*_unidentified(wanted, result, array), *sentences),
        stages=tuple(stages),
        status=_status(wanted, solution, residuals, stages),
        skin=tissue(fitted.skin),
        subcutaneous=tissue(fitted.subcutaneous),
        prony=result.law.prony,
        deepest=curve.deepest,
        q=tuple((curve.q + math.log(result.law.factor)).tolist()),
        shares=tuple(tuple(row) for row in np.round(curve.shares, 9).tolist()),
        growth=curve.growth,
        checks=sinusoids(wanted, result) if isinstance(wanted, SubjectTarget) else {},
    )


def checked(done: Calibration, motion: tuple[Array, Array, Array]) -> Calibration:
    """Add the errors of the prediction of a motion (n_t,) s, mm, N that was not fitted.

    The touch is taken from the record that was fitted.
    """
    time, position, force = motion
    model = done.predict(time, position - done[TOUCH].value)
    return replace(done, checks=done.checks | {"record that was not fitted": errors(force, model)})


def refuse_gross(done: Calibration, wanted: SubjectTarget | RecordTarget) -> None:
    """Raise ConvergenceError for a finger that does not reproduce the record it was fitted to."""
    error = done.residuals.get("mse", 0.0)
    if isinstance(wanted, SubjectTarget) or error <= GROSS:
        return
    less, deep = "", float(wanted.position.max()) - done[TOUCH].value
    if deep > done.deepest:
        less = f"press less deep than {done.deepest:.2g} mm, where its presses end, and "
    lumped = [f"in the lumped fit of the record, {each}" for each in wanted.lumped.warnings]
    rest = "".join(f"; {each}" for each in (*lumped, *done.unidentified))
    raise ConvergenceError(
        f"{done.target}: expected a fit with an error of at most {100 * GROSS:g} % of the record's "
        f"variance, received {100 * error:.3g} %; {less}check the size of the finger, the units "
        f"and the touch{rest}"
    )


def errors(measured: Array, model: Array) -> dict[str, float]:
    """Compute the squared error of Eq. 2.5 and the error at the peaks, both as fractions.

    The error at the peaks is the mean over the largest quarter of the forces.
    """
    about = float(np.sum((measured - measured.mean()) ** 2))
    high = measured >= np.quantile(measured, 0.75)
    peak = np.abs(model[high] - measured[high]).mean() / measured[high].mean()
    return {"mse": float(np.sum((model - measured) ** 2)) / about, "peak": float(peak)}


def sinusoids(wanted: SubjectTarget, result: FitResult) -> dict[str, dict[str, float]]:
    """Errors of the prediction of the subject's sinusoids, by frequency.

    The subject is represented by the lumped model, which can lose contact. Its touch is set for
    equal elastic force at the operating point, as the thesis shifts its x0 by up to 80 um.
    """
    spring, deep = wanted.spring, float(wanted.spring.position(OPERATING))
    offset = float(result.law.depth(OPERATING)) - deep
    out = {}
    for frequency in FREQUENCIES:
        motion = RampSinusoid(
            20.0, deep, amplitude=SWING / spring.m, frequency=frequency, cycles=5, corner=0.0
        )
        time = np.linspace(0.0, motion.duration, 1201)
        depth = motion.value(time)
        measured = contact_force(spring, wanted.prony, time, depth)
        model = result.law.predicted(time, depth + offset)
        out[f"{frequency} Hz"] = errors(measured, model)
    return out


def line(force: ArrayLike, stiffness: ArrayLike) -> tuple[float, float]:
    """Return m in 1/mm and b in N/mm of the line k = m T + b through stiffness against force."""
    slope, start = np.polyfit(np.asarray(force, float), np.asarray(stiffness, float), 1)
    return float(slope), float(start)


def _misfits(wanted: SubjectTarget | RecordTarget, result: FitResult) -> dict[str, float]:
    if isinstance(wanted, RecordTarget):
        depth = wanted.position - result.solution.values[TOUCH]
        model = result.law.loading(wanted.time, depth)
        return {"force rms in N": float(np.sqrt(np.mean((model - wanted.force) ** 2)))} | errors(
            wanted.force, model
        )
    fitted = result.law.stiffness(wanted.force)
    m, b = line(wanted.force, fitted)
    return {
        "m": m,
        "m, wanted": wanted.spring.m,
        "b": b,
        "b, wanted": wanted.spring.b,
        "stiffness rms over its mean": float(
            np.sqrt(np.mean((fitted - wanted.stiffness) ** 2)) / wanted.stiffness.mean()
        ),
    }


def reach(wanted: SubjectTarget | RecordTarget, result: FitResult) -> float:
    """Largest depth in mm of the target."""
    if isinstance(wanted, RecordTarget):
        return float(wanted.position.max() - result.solution.values[TOUCH])
    return float(result.law.depth(wanted.force[-1]))


def _unidentified(
    wanted: SubjectTarget | RecordTarget, result: FitResult, array: dict[str, float]
) -> tuple[str, ...]:
    sentences = list(result.solution.weak)
    sentences += [
        f"{name}: at its bound, the data favor values beyond it"
        for name in result.solution.at_bounds
    ]
    deep, deepest = reach(wanted, result), result.law.curve.deepest
    if deep > deepest:
        sentences.append(
            f"the presses reach {deepest:.3g} mm, the target {deep:.3g} mm: beyond "
            "the presses the logarithm of the force is extrapolated linearly"
        )
    if isinstance(wanted, RecordTarget):
        lumped = wanted.lumped
        if len(lumped.prony.v) < TERMS:
            sentences.append(
                f"relaxation: the lumped fit of the record converges with {len(lumped.prony.v)} "
                f"of {TERMS} terms only, the priors determine the rest; ramp faster or hold longer"
            )
        sentences += [
            f"relaxation, in the lumped fit of the record: {each}"
            for each in confidence.terms(
                wanted.record, lumped.prony, lumped.uncertainty, "here the priors determine it"
            )
        ]
        sentences += confidence.bias(
            wanted.record, lumped.prony, lumped.spring.x0, lumped.uncertainty
        )
        touch = result.solution.values[TOUCH]
        if abs(touch - lumped.spring.x0) >= APART:
            sentences.append(
                f"x0: this finger touches at {touch:.2g} mm, the lumped law of the same record at "
                f"{lumped.spring.x0:.2g} mm: the touch depends on the model, which the deviation "
                "of x0 does not include"
            )
    if RADIUS not in result.solution.values:
        sentences.append("pad_radius: there are no frames, so it is not fitted")
    if array and abs(array["array radius"] / array["array radius, wanted"] - 1) > AGREES:
        sentences.append(
            f"pad_radius: the thesis's fit finds R = {array['array radius']:.3g} mm in the frames "
            f"of this finger instead of {array['array radius, wanted']:.3g} mm; no pad radius that "
            "was tried is closer"
        )
    if array:
        top = pad_radius.heaviest(result.law)
        if top < pad_radius.HEAVIEST:
            sentences.append(
                f"pad_radius: the frames of this finger end at {top:.2g} N, where its presses end, "
                f"instead of {pad_radius.HEAVIEST:g} N as in the thesis"
            )
    return tuple(sentences)


def _status(
    wanted: SubjectTarget | RecordTarget,
    solution: Solution,
    residuals: dict[str, float],
    stages: Sequence[Stage],
) -> str:
    if isinstance(wanted, RecordTarget):
        good = f"squared error {100 * residuals['mse']:.2g} % of the variance"
    else:
        good = (
            f"m {residuals['m']:.3g} of {residuals['m, wanted']:.3g} 1/mm, b {residuals['b']:.2g} "
            f"of {residuals['b, wanted']:.2g} N/mm"
        )
    within = "within the scatter of the data"
    beyond = "model error exceeds the scatter of the data, and the true uncertainties are larger"
    if isinstance(wanted, RecordTarget):
        beyond += "; tare the force, and check for drift or a lag of the force"
    spent = sum(each.cpu for each in stages)
    return (
        f"Fitted {wanted.name} in {solution.evaluations} evaluations and {spent:.0f} s of CPU: "
        f"{good}; misfit {solution.misfit:.2g} ({beyond if solution.misfit > 2 else within})."
    )
