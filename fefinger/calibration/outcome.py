"""Make the record of a calibration: parameters, misfits, what is unidentified, predictions.

Faults of the records or of the rig are recognized by their traces, and said in words.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fefinger.calibration import pad_radius
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.inverse import Solution, Values
from fefinger.calibration.record import (
    LENGTHS,
    Calibration,
    Stage,
    parameters_of,
    tissue,
)
from fefinger.calibration.record_target import RecordTarget
from fefinger.calibration.records_target import presses
from fefinger.calibration.rig import SHARED
from fefinger.calibration.targets import MODULUS, RADIUS, RATIO, SHAPE, Target
from fefinger.results.candidate import MECHANICS
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.tissue import Tissue
from fefinger.support.checks import ConvergenceError
from fefinger.theory.lumped.ramp_hold import SMOOTHING, STEPPED, RampHold, smooth


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


SEEN = {"delay": 0.1, "lag": 0.1, "compliance": 5e-3, "offset": 5.0, "drift": 2.0}
"""Sizes in the units of a Rig below which its faults are not told, as they are in the fit."""

WORDS = {
    "delay": "late force: it is {value:.3g} +- {sd:.2g} ms behind the position",
    "lag": "low-pass: the force passes one of {value:.2g} +- {sd:.2g} ms",
    "compliance": "position of the motor: it includes {value:.2g} +- {sd:.2g} mm/N of rig",
    "offset": "offset: the force reads {value:.3g} +- {sd:.2g} mN without contact",
    "drift": "drift: the force changes by {value:.3g} +- {sd:.2g} mN/s",
}

MORE = {
    "lag": "; turn the filter of the sensor off, or give its time constant as `lag` in --rig",
    "compliance": "; press a stiff block with the rig, and give what you find as `compliance` in "
    "--rig",
}
"""What to do about faults that the fit takes into account less well than a measurement would."""

CONTACT = 0.02
"""Part of the largest force from which a record is in contact, as in `ramp_hold.split`."""

CERTAIN = 6.0
"""Standard deviations of a smoothed force that its noise does not reach in a record."""

AVERAGED = 0.1
"""Time in s of an average by which the color of noise is told."""

AT_TOP = 5
"""Successive samples at the largest force that noise does not give."""


class Finding(NamedTuple):
    """A sentence on a record, and the time in s at which the record shows it, if at one."""

    text: str
    time: float | None = None

    @property
    def name(self) -> str:
        """The first words of the sentence."""
        return self.text.partition(":")[0]


def findings(target: RecordTarget, values: Values, deviations: Values) -> tuple[Finding, ...]:
    """List the faults of a record and its rig; values and deviations of its fit."""
    found = [
        *_of_rig(target, values, deviations),
        *_of_noise(target),
        *_before_touch(target),
        *_on_the_ramp(target, values),
        *_saturated(target.record),
        *_sampled(target, values),
    ]
    return tuple(found)


def told(target: RecordTarget, found: Iterable[Finding]) -> tuple[str, ...]:
    """Return the sentences on a record, which name the press if it is not the first."""
    which = target.press.strip()
    return tuple(f"press {which}: {each.text}" if which else each.text for each in found)


def marks(found: Iterable[Finding]) -> tuple[tuple[float, str], ...]:
    """Return times in s and names of what the record shows at a time."""
    return tuple((each.time, each.name) for each in found if each.time is not None)


def is_seen(name: str, value: float, sd: float) -> bool:
    """Whether a rig does something beyond doubt, and enough to be told; in the units of a Rig."""
    sure = 3.0  # standard deviations from 0 from which a fault of the rig is told
    return abs(value) > max(sure * sd, SEEN[name])


def _of_rig(target: RecordTarget, values: Values, deviations: Values) -> Iterator[Finding]:
    record = target.record
    for each in target.rig.unknowns(target.press):
        what = each.name.removesuffix(target.press)
        value, sd = values[each.name], deviations[each.name]
        if is_seen(what, value, sd) and not (target.press and what in SHARED):
            words = WORDS[what].format(value=value, sd=sd)
            text = f"{words}, which the fit takes into account{MORE.get(what, '')}"
            place = record.hold if what in SHARED else 0
            yield Finding(text, float(record.time[place]))


def _of_noise(target: RecordTarget) -> Iterator[Finding]:
    """Tell of noise that averages do not lessen."""
    noise, record = target.force_noise, target.record
    step = float(np.median(np.diff(record.time)))
    count = min(max(round(AVERAGED / step), 1), len(record.time))
    more = noise.of_average(count) * np.sqrt(count) / noise.sd
    if noise.colored and more > 1:
        yield Finding(
            f"colored noise: an average of the force over {count * step:.2g} s is {more:.2g} times "
            "less sure than with white noise of its size, which the deviations include; look for "
            "hum, a filter, or a sensor that warms up"
        )


def _smoothed_noise(target: RecordTarget) -> float:
    """Return the standard deviation in N of the noise of a smoothed force."""
    return target.force_noise.of_average(SMOOTHING)


def _before_touch(target: RecordTarget) -> Iterator[Finding]:
    """Tell of a missing rest before touch, and of an earlier touch."""
    record = target.record
    limit = max(CERTAIN * _smoothed_noise(target), CONTACT * float(record.force.max()))
    before = smooth(record.force)[: record.touch]
    above = np.flatnonzero(before > limit)
    if above.size and above[-1] < record.touch - SMOOTHING:
        at = int(np.argmax(before))
        when = float(record.time[at])
        yield Finding(
            f"two touches: {before[at]:.2g} N already at {when:.3g} s, and contact for good from "
            f"{record.time[record.touch]:.3g} s on; the tissue has not recovered, so wait longer "
            "between them, or cut the first out",
            when,
        )
    free = float(record.time[max(record.touch - 1, 0)] - record.time[0])
    # Time in s of a rest before touch below which the offset of the force is hardly known.
    short = 0.02
    if free < short:
        yield Finding(
            f"no free stretch: {1e3 * free:.2g} ms before touch; offset and noise of the force are "
            "hardly known, begin the record some 100 ms earlier",
            float(record.time[0]),
        )


def _on_the_ramp(target: RecordTarget, values: Values) -> Iterator[Finding]:
    """Tell of a force that falls while the indenter goes in: it slips, or the finger yields.

    A force that is ahead of the position falls before the hold.
    """
    record = target.record
    ahead = 1e-3 * min(target.rig.at(values, target.press)["delay"], 0.0)
    end = int(np.searchsorted(record.time, record.time[record.beyond] + ahead)) - SMOOTHING
    ramp = slice(record.touch, max(end, record.touch))
    forward = np.diff(smooth(record.position)[ramp]) > 0
    force = smooth(record.force)[ramp]
    if len(force) < SMOOTHING:
        return
    fallen = np.maximum.accumulate(force) - force
    at = int(np.argmax(fallen))
    falls = np.sqrt(2) * CERTAIN * _smoothed_noise(target)
    limit = max(falls, CONTACT * float(record.force.max()))
    if fallen[at] > limit and forward[: max(at, 1)].mean() > 0.5:
        when = float(record.time[ramp][at])
        yield Finding(
            f"slip: the force falls by {fallen[at]:.2g} N until {when:.4g} s, "
            f"{1e3 * (when - record.time[record.touch]):.2g} ms after touch, while the indenter "
            "goes in; fix the finger, or dry it",
            when,
        )


def _saturated(record: RampHold) -> Iterator[Finding]:
    """Tell of a sensor at the end of its range."""
    force = record.force
    largest = float(force.max())
    at_top = np.diff((force == largest).astype(np.int8), prepend=0, append=0)
    starts = np.flatnonzero(at_top > 0)
    lengths = np.flatnonzero(at_top < 0) - starts
    longest = int(lengths.max())
    same = np.diff(force[force > largest / 2]) == 0
    if longest >= AT_TOP and same.mean() < STEPPED:
        yield Finding(
            f"saturated sensor: {longest} successive samples read {largest:.4g} N, its largest; "
            "use a range that is wider, or press less",
            float(record.time[starts[lengths.argmax()]]),
        )


def _sampled(target: RecordTarget, values: Values) -> Iterator[Finding]:
    record = target.record
    count = record.hold - record.touch
    rate = values.get("v1", 0.0)
    step = float(np.median(np.diff(record.time[record.touch : record.hold + 1])))
    few = 60  # samples of a ramp in contact below which its force is coarse, as the corner is
    if count < few or rate * step > 1:
        yield Finding(
            f"sampling: {count} samples on the ramp in contact, one every {1e3 * step:.3g} ms, and "
            f"the fastest term fades in {1e3 / max(rate, 1e-9):.3g} ms; sample faster, or ramp "
            "more slowly"
        )
