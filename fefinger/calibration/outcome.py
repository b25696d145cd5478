"""Make the record of a calibration: parameters, misfits, unidentified parameters, predictions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike

from fefinger.calibration import pad_radius
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.inverse import Solution
from fefinger.calibration.record import (
    LENGTHS,
    Calibration,
    Stage,
    parameters_of,
    tissue,
)
from fefinger.calibration.record_checks import findings, marks, told
from fefinger.calibration.record_target import RecordTarget
from fefinger.calibration.records_target import presses
from fefinger.calibration.targets import MODULUS, RADIUS, RATIO, SHAPE, Target
from fefinger.results.candidate import MECHANICS
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.tissue import Tissue
from fefinger.support.checks import ConvergenceError


LAW = "demiray"
GROSS = 0.1
"""Largest squared error over the variance of a record for a fit to be accepted. That of the thesis
on its predicted sinusoids is 0.07."""

TOLD = 2
"""Reasons that the sentence of a refused fit names, before it says how many more there are."""

AGREES = 0.05
"""Relative error of the fitted R up to which the pad radius counts as identified."""


@dataclass(frozen=True)
class FitResult:
    """Result of a fit: the solution, the force law of its values, and the target as weighed."""

    solution: Solution
    law: ForceLaw
    target: Target


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
    solution, wanted = result.solution, result.target
    factor, exponent = 1.0, None
    finite, values = MECHANICS[mechanics].finite, solution.values
    if finite:
        factor = values[MODULUS] / finger.subcutaneous.modulus
        exponent = round(values[SHAPE], 4)
    own = wanted.remarks(values, finite=finite, with_frames=bool(array))
    fitted, curve = stiffening(finger, exponent, factor), result.law.curve
    if finite:
        skin = values[RATIO] * fitted.subcutaneous.modulus
        fitted = replace(fitted, skin=replace(fitted.skin, modulus=skin))
    parameters, correlations = parameters_of(solution)
    residuals = {"misfit": solution.misfit, **wanted.misfits(result.law, values), **array}
    residuals["distance of the curve from the last press"] = ripple
    records = presses(wanted)
    found = [findings(each, values, solution.deviations) for each in records]
    return Calibration(
        target=wanted.name,
        mechanics=mechanics,
        finger={name: getattr(finger, name) for name in (*LENGTHS, "resolution")},
        parameters=parameters,
        correlations=correlations,
        residuals=residuals,
        unidentified=(*_unidentified(result, array), *own, *fit_remarks),
        stages=tuple(stages),
        status=_status(wanted, solution, residuals, stages),
        skin=tissue(fitted.skin),
        subcutaneous=tissue(fitted.subcutaneous),
        prony=result.law.prony,
        deepest=curve.deepest,
        q=tuple((curve.q + math.log(result.law.factor)).tolist()),
        shares=tuple(tuple(row) for row in np.round(curve.shares, 9).tolist()),
        growth=curve.growth,
        checks=wanted.checks(result.law),
        findings=tuple(chain.from_iterable(map(told, records, found))),
        presses=tuple(
            each.fitted(result.law, values, marks(wrong))
            for each, wrong in zip(records, found, strict=True)
        ),
    )


def refuse_gross(done: Calibration, wanted: RecordTarget) -> None:
    """Raise ConvergenceError for a finger that does not reproduce the record it was fitted to."""
    error = done.residuals.get("mse" + wanted.press, 0.0)
    if error <= GROSS:
        return
    less, deep = "", float(wanted.position.max()) - done[wanted.touch].value
    if deep > done.deepest:
        less = f"press less deep than {done.deepest:.2g} mm, where its presses end, and "
    lumped = [f"in the lumped fit of the record, {each}" for each in wanted.lumped.warnings]
    reasons = [*lumped, *done.unidentified]
    more = [f"and {len(reasons) - TOLD} more"] if len(reasons) > TOLD else []
    rest = "".join(f"; {each}" for each in (*reasons[:TOLD], *more))
    raise ConvergenceError(
        f"{done.target}: expected a fit with an error of at most {100 * GROSS:g} % of the record's "
        f"variance, received {100 * error:.3g} %; {less}check the size of the finger, the units "
        f"and the touch{rest}"
    )


def line(force: ArrayLike, stiffness: ArrayLike) -> tuple[float, float]:
    """Return m in 1/mm and b in N/mm of the line k = m T + b through stiffness against force."""
    slope, start = np.polyfit(np.asarray(force, float), np.asarray(stiffness, float), 1)
    return float(slope), float(start)


def _unidentified(result: FitResult, array: dict[str, float]) -> tuple[str, ...]:
    sentences = list(result.solution.weak)
    sentences += [
        f"{name}: at its bound, the data favor values beyond it"
        for name in result.solution.at_bounds
    ]
    deepest = result.law.curve.deepest
    deep = result.target.reach(result.law, result.solution.values)
    if deep > deepest:
        sentences.append(
            f"the presses reach {deepest:.3g} mm, the target {deep:.3g} mm: beyond "
            "the presses the logarithm of the force is extrapolated linearly"
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
    wanted: Target,
    solution: Solution,
    residuals: dict[str, float],
    stages: Sequence[Stage],
) -> str:
    scatter = "within the scatter of the data"
    if solution.misfit > 2:
        scatter = (
            "model error exceeds the scatter of the data, and the true uncertainties are larger"
            f"{wanted.advice}"
        )
    spent = sum(each.cpu for each in stages)
    return (
        f"Fitted {wanted.name} in {solution.evaluations} evaluations and {spent:.0f} s of CPU: "
        f"{wanted.quality(residuals)}; misfit {solution.misfit:.2g} ({scatter})."
    )
