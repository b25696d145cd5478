"""From a solution to the record: parameters, misfits, what was not found, and predictions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.calibration import pad_radius
from fefinger.calibration.curve import Curve
from fefinger.calibration.force import (
    MODULUS,
    RADIUS,
    SHAPE,
    TOUCH,
    loading,
    predicted,
    prony_of,
    stiffness,
)
from fefinger.calibration.inverse import Solution
from fefinger.calibration.record import Calibration, Stage, correlations_of, parameters_of, tissue
from fefinger.calibration.targets import Bulk, Record
from fefinger.results.candidate import MECHANICS
from fefinger.scene.finger import Finger
from fefinger.scene.motion import RampSinusoid
from fefinger.scene.tissue import Tissue
from fefinger.support.checks import ConvergenceError
from fefinger.theory.lumped import confidence
from fefinger.theory.lumped.spring import contact_force


Array = NDArray[np.float64]

LAW = "demiray"
GROSS = 0.1
"""Squared error over the variance of a record from which on a fit is none. The thesis has 0.07 on
the sinusoids that it predicts."""

AGREES = 0.05
"""Relative error of the fitted R up to which the pad radius counts as found."""

ONE_G = (
    "one G relaxes the force, where the stress relaxes and strain is finite: weights of a twin "
    "come back 2 to 3 % off, its fastest rate 5 %, which their deviations do not count"
)
"""What fits through `solid` do to G (suite `calibration`, twin of solid)."""

APART = 0.1
"""Distance in mm of two touches that is told."""

FREQUENCIES = (2, 4, 8, 16)
"""Hz of the sinusoids of the thesis (section 2.2.2), which are predicted and not fitted."""

OPERATING = 2.0
"""N of instantaneous force about which they go; the thesis has 0 to 2 N."""

SWING = 0.5
"""Their amplitude times m: the stiffness changes by a factor e from end to end."""


@dataclass(frozen=True)
class Found:
    """A rung that has ended: its solution, the curve and the factor on its force."""

    solution: Solution
    curve: Curve
    factor: float


def layer(tissue: Tissue, exponent: float | None, factor: float = 1.0) -> Tissue:
    """Return a layer with another modulus, and with Demiray's law where there is an exponent."""
    stiffer = replace(tissue, modulus=factor * tissue.modulus)
    if exponent is None:
        return stiffer
    return replace(stiffer, law=LAW, exponent=exponent, share=None)


def outcome(
    wanted: Bulk | Record,
    finger: Finger,
    found: Found,
    stages: Sequence[Stage],
    mechanics: str,
    array: dict[str, float] | None = None,
    ripple: float = math.nan,
    early: Sequence[str] = (),
) -> Calibration:
    """Return the record of a solution on a finger.

    array: what the thesis's fit finds, by name; ripple: distance of the last press from its curve;
    early: sentences on presses that ended early, where the curve ends.
    """
    solution = found.solution
    factor, exponent, told = 1.0, None, list(early)
    if MECHANICS[mechanics].finite:
        factor = solution.values[MODULUS] / finger.subcutaneous.modulus
        exponent = round(solution.values[SHAPE], 4)
        told += [f"c0, c1, v1 ...: {ONE_G}"] if isinstance(wanted, Record) else []
    residuals = {"misfit": solution.misfit, **_misfits(wanted, found), **(array or {})}
    if math.isfinite(ripple):
        residuals["distance of the curve from the last press"] = ripple
    return Calibration(
        target=wanted.name,
        mechanics=mechanics,
        finger={
            "width": finger.width,
            "thickness": finger.thickness,
            "pad_radius": finger.pad_radius,
            "resolution": finger.resolution,
        },
        parameters=parameters_of(solution),
        correlations=correlations_of(solution),
        residuals=residuals,
        unidentified=(*_unidentified(wanted, found, array or {}), *told),
        stages=tuple(stages),
        status=_status(wanted, solution, residuals, stages),
        skin=tissue(layer(finger.skin, exponent, factor)),
        subcutaneous=tissue(layer(finger.subcutaneous, exponent, factor)),
        prony=prony_of(solution.values),
        deepest=found.curve.deepest,
        q=tuple((found.curve.q + math.log(found.factor)).tolist()),
        shares=tuple(tuple(row) for row in np.round(found.curve.shares, 9).tolist()),
        growth=found.curve.growth,
        checks=sinusoids(wanted, found) if isinstance(wanted, Bulk) else {},
    )


def checked(done: Calibration, motion: tuple[Array, Array, Array]) -> Calibration:
    """Return the calibration with its prediction of a motion (n_t,) s, mm, N that was not fitted.

    The touch is that of the record that was fitted.
    """
    time, position, force = motion
    model = done.predict(time, position - done[TOUCH].value)
    return replace(done, checks=done.checks | {"record that was not fitted": errors(force, model)})


def refuse_gross(done: Calibration) -> None:
    """Raise ConvergenceError for a finger that does not show the record that it was fitted to."""
    missed = done.residuals.get("mse", 0.0)
    if missed > GROSS:
        rest = "".join(f"; {said}" for said in done.unidentified)
        msg = (
            f"{done.target}: expected a finger that shows the record, but the best one misses "
            f"{100 * missed:.3g} % of its variance, at most {100 * GROSS:g} % being taken; press "
            f"less deep than {done.deepest:.2g} mm, where its presses end, and check the size of "
            f"the finger and the units{rest}"
        )
        raise ConvergenceError(msg)


def errors(measured: Array, model: Array) -> dict[str, float]:
    """Return the squared error of Eq. 2.5 and the error at the peaks, both as fractions.

    That at the peaks is the mean over the largest quarter of the forces.
    """
    about = float(np.sum((measured - measured.mean()) ** 2))
    high = measured >= np.quantile(measured, 0.75)
    peak = np.abs(model[high] - measured[high]).mean() / measured[high].mean()
    return {"mse": float(np.sum((model - measured) ** 2)) / about, "peak": float(peak)}


def sinusoids(wanted: Bulk, found: Found) -> dict[str, dict[str, float]]:
    """Return the errors of the prediction of the subject's sinusoids, by frequency.

    The subject is the lumped model, which can lose contact; its touch is where the finger has the
    same elastic force at the operating point, as the thesis moves its x0 by up to 80 um.
    """
    prony, spring = prony_of(found.solution.values), wanted.spring
    deep = float(spring.position(OPERATING))
    offset = float(found.curve.depth(prony.long_time * OPERATING / found.factor)) - deep
    out = {}
    for frequency in FREQUENCIES:
        motion = RampSinusoid(
            20.0, deep, amplitude=SWING / spring.m, frequency=frequency, cycles=5, corner=0.0
        )
        time = np.linspace(0.0, motion.duration, 1201)
        depth = motion.value(time)
        measured = contact_force(spring, wanted.prony, time, depth)
        model = predicted(found.curve, found.factor, prony, time, depth + offset)
        out[f"{frequency} Hz"] = errors(measured, model)
    return out


def line(force: ArrayLike, stiffness: ArrayLike) -> tuple[float, float]:
    """Return m in 1/mm and b in N/mm of the line k = m T + b through stiffness against force."""
    slope, start = np.polyfit(np.asarray(force, float), np.asarray(stiffness, float), 1)
    return float(slope), float(start)


def _misfits(wanted: Bulk | Record, found: Found) -> dict[str, float]:
    prony = prony_of(found.solution.values)
    if isinstance(wanted, Record):
        depth = wanted.position - found.solution.values[TOUCH]
        model = loading(found.curve, found.factor, prony, wanted.time, depth)
        return {"force rms in N": float(np.sqrt(np.mean((model - wanted.force) ** 2)))} | errors(
            wanted.force, model
        )
    mine = stiffness(found.curve, found.factor, prony, wanted.force)
    m, b = line(wanted.force, mine)
    return {
        "m": m,
        "m, wanted": wanted.spring.m,
        "b": b,
        "b, wanted": wanted.spring.b,
        "stiffness rms over its mean": float(
            np.sqrt(np.mean((mine - wanted.stiffness) ** 2)) / wanted.stiffness.mean()
        ),
    }


def reach(wanted: Bulk | Record, found: Found) -> float:
    """Return the largest depth in mm that the target presses the finger to."""
    if isinstance(wanted, Record):
        return float(wanted.position.max() - found.solution.values[TOUCH])
    relaxed = prony_of(found.solution.values).long_time * wanted.force[-1]
    return float(found.curve.depth(relaxed / found.factor))


def _unidentified(wanted: Bulk | Record, found: Found, array: dict[str, float]) -> tuple[str, ...]:
    said = list(found.solution.weak)
    said += [f"{name}: at its bound, so the data want more" for name in found.solution.at_bounds]
    deep = reach(wanted, found)
    if deep > found.curve.deepest:
        said.append(
            f"the presses go to {found.curve.deepest:.3g} mm, the target to {deep:.3g} mm: beyond, "
            "the logarithm of the force goes on as a straight line"
        )
    if isinstance(wanted, Record):
        lumped = wanted.lumped
        said += confidence.bias(wanted.record, lumped.prony, lumped.spring.x0, lumped.uncertainty)
        said += _other_touch(found.solution.values[TOUCH], lumped.spring.x0)
    if RADIUS not in found.solution.values:
        said.append("pad_radius: there are no frames, so it is kept")
    if array and abs(array["array radius"] / array["array radius, wanted"] - 1) > AGREES:
        said.append(
            f"pad_radius: the thesis's fit finds R = {array['array radius']:.3g} mm in the frames "
            f"of this finger instead of {array['array radius, wanted']:.3g} mm; the pads that were "
            "pressed come no nearer"
        )
    if array:
        top = pad_radius.heaviest(found.curve, found.factor, prony_of(found.solution.values))
        if top < pad_radius.HEAVIEST:
            said.append(
                f"pad_radius: the frames of this finger go to {top:.2g} N, where its presses end, "
                f"instead of {pad_radius.HEAVIEST:g} N as those of the thesis"
            )
    return tuple(said)


def _other_touch(own: float, lumped: float) -> list[str]:
    """Return what there is to say of a finger that touches elsewhere than the lumped law."""
    if abs(own - lumped) < APART:
        return []
    return [
        f"x0: this finger touches at {own:.2g} mm, the lumped law of the same record at "
        f"{lumped:.2g} mm: how a force begins is the model's, and the deviation of x0 does not "
        "count that"
    ]


def _status(
    wanted: Bulk | Record, solution: Solution, residuals: dict[str, float], stages: Sequence[Stage]
) -> str:
    """Return one sentence on how good the fit is and what it took."""
    if isinstance(wanted, Record):
        good = f"squared error {100 * residuals['mse']:.2g} % of the variance"
    else:
        good = (
            f"m {residuals['m']:.3g} of {residuals['m, wanted']:.3g} 1/mm, b {residuals['b']:.2g} "
            f"of {residuals['b, wanted']:.2g} N/mm"
        )
    missed = "the model misses it, and its values are less sure than they say"
    misses = missed if solution.misfit > 2 else "within the scatter of the data"
    spent = sum(each.cpu for each in stages)
    return (
        f"Fitted {wanted.name} in {solution.evaluations} evaluations and {spent:.0f} s of CPU: "
        f"{good}; misfit {solution.misfit:.2g} ({misses})."
    )
