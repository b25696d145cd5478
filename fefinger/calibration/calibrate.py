"""Fit a finger to a subject or a record in stages, each of which starts from the one before.

`lumped` identifies stiffness, touch and G of the thesis's own model. `condensed` scales the linear
finger by the thesis's t(u). `solid` fits modulus and exponent of stiffening tissue, on the coarse
mesh first and then with presses on the requested mesh, together with the pad radius, for which the
thesis's fit of simulated frames must agree with that of the measured ones.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fefinger.calibration import pad_radius as pad
from fefinger.calibration import targets
from fefinger.calibration.curve import Family, family
from fefinger.calibration.force import SHAPE, Forces, prony_of
from fefinger.calibration.inverse import solve
from fefinger.calibration.outcome import AGREES, FitResult, checked, outcome, reach, refuse_gross
from fefinger.calibration.press_store import Work
from fefinger.calibration.record import Calibration
from fefinger.calibration.slow_press import PART
from fefinger.calibration.targets import Bulk, Frames, Record
from fefinger.scene import pawluk1997
from fefinger.scene.finger import RESOLUTIONS, Finger
from fefinger.support.checks import InputError, choice
from fefinger.support.progress import Progress


MECHANICS = ("condensed", "solid")

EXPONENTS = (0.02, 1.2, 2.8, 4.8, 7.0)
"""Exponents of Demiray's law at which a finger is solved; the first is nearly neo-Hookean."""

STIFFER = (10.0, 13.0, 16.0)
"""Further exponents, solved where those of EXPONENTS do not suffice (`_wide_enough`)."""

SMALLER, WIDER = 0.9, 1.15
"""Second pad radius at which a finger is pressed, over the first one: larger in `solid`, where
stiffening tissue concentrates the pressure, if a finger of that size can be so flat."""

AGAINST = 2.0
"""Factor on the skin's modulus of the press that measures the effect of the ratio of the moduli."""

MIDDLE = 3.0
"""Exponent of that press, and of the one at the other pad radius."""

CORRECTIONS = 6
"""Largest number of presses on the final mesh."""

DEEPER = 1.05
"""Depth of these presses over the largest depth of the present fit in the frames or the ramp."""

SCATTER = 0.13
"""Standard deviation of the logarithm of a pad radius that the frames do not determine: that of R
over the five subjects."""

MESH = 0.015
"""Standard deviation of the logarithm of a pad radius due to the mesh: errors of simulated twins
and subjects on the coarse mesh are 0.5 to 1.6 % (suite `calibration`)."""

NONE = 5e-3
"""Relative difference below which two pad radii count as equal."""

SETTLED = 0.1
"""Change of the exponent between two corrections that counts as converged: below the uncertainty of
the data; over it the interpolated force is accurate within 1e-3."""

CLOSE = 0.02
"""Relative error of a fitted R that counts as converged: the rounding of an R printed to the mm."""


def calibrate(
    source: str | Path,
    *,
    finger: Finger | None = None,
    mechanics: str = "solid",
    resolution: str = "standard",
    frames: str | Path | None = None,
    check: str | Path | None = None,
    progress: Progress | None = None,
) -> Calibration:
    """Fit a finger to a subject of the thesis or to the record of a user.

    Parameters
    ----------
    source
        A subject of Table 2.1, as "a.h.", or a CSV file of time (s), position (mm), force (N) with
        a fast ramp and a hold.
    finger
        Size and initial tissues; by default those of the subject. Required for a record.
    mechanics
        "condensed" (small strain, times the t(u) of the thesis) or "solid" (finite strain,
        stiffening tissue).
    resolution
        Final mesh of `solid`: "coarse", "standard" or "fine".
    frames
        CSV file of a slow press: time, position (mm from touch), p1 ... p64 (kPa).
    check
        CSV file of a motion with unloading, which is predicted and not fitted; only for a record.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Raises
    ------
    InputError
        If a source cannot be used.
    ConvergenceError
        If a fit or a press fails, or the best finger does not reproduce the record.
    """
    choice("mechanics", mechanics, MECHANICS)
    choice("resolution", resolution, RESOLUTIONS)
    start = finger or targets.finger_of(_named(source))
    work = Work(replace(start, resolution=resolution), progress)
    wanted = _target(work, source)
    if check is not None and isinstance(wanted, Bulk):
        raise InputError(
            "check: expected the record of a user (DATA.csv) to fit, whose touch the prediction "
            f"needs, received the subject {wanted.name!r}; subjects are checked on sinusoids "
            "automatically"
        )
    measured = None if frames is None else targets.frames(frames)
    predicted = None if check is None else targets.unloading(check)
    fit = {"condensed": condensed, "solid": solid}[mechanics]
    calibration = fit(work, wanted, measured)
    refuse_gross(calibration)
    return calibration if predicted is None else checked(calibration, predicted)


def condensed(work: Work, wanted: Bulk | Record, frames: Frames | None) -> Calibration:
    """Fit the linear finger times t(u), at the pad radius that agrees with the frames.

    The printed R of a subject is not used: it is that of a finger of stiffening tissue.
    """
    start = work.finger
    radius, mesh = start.pad_radius, start.resolution
    with work.stage("condensed") as misfit:
        linear = family((1.0,), radius, lambda _: work.press("condensed", mesh, radius))
        result = _solved(_forces(work, wanted, linear, radius))
        misfit(result.solution.misfit)
    if frames is not None:
        with work.stage("array") as misfit:
            other = SMALLER * radius
            linear = linear.with_radius(work.press("condensed", mesh, other), 1.0, other)
            radius, power = _radius(work, wanted, frames, linear, (radius, other), result)
            result = _solved(_forces(work, wanted, linear, radius), result)
            spread = _spread(wanted, frames, result, radius, power)
            result = _solved(_forces(work, wanted, linear, radius, spread), result)
            misfit(result.solution.misfit)
    adapted = replace(start, pad_radius=radius)
    shape = _array(wanted, frames, result) if frames is not None else {}
    return outcome(wanted, adapted, result, work.stages, "condensed", shape, linear.ripple)


def solid(work: Work, wanted: Bulk | Record, frames: Frames | None) -> Calibration:
    """Fit stiffening tissue, at the pad radius that agrees with the frames."""
    start, power = work.finger, None
    first = radius = start.pad_radius
    has_frames = frames is not None or isinstance(wanted, Bulk)
    with work.stage("solid, coarse") as misfit:
        coarse = _wide_enough(work, wanted, first)
        part = coarse.deepest / start.thickness
        stiff = work.press("solid", "coarse", first, MIDDLE, AGAINST, part)
        coarse = coarse.with_ratio(stiff, MIDDLE, AGAINST)
        result = _solved(_forces(work, wanted, coarse, first))
        misfit(result.solution.misfit)
    if has_frames:
        with work.stage("array, coarse"):
            wider = WIDER * first
            other = wider if work.reachable(wider) == wider else SMALLER * first
            flatter = work.press("solid", "coarse", other, MIDDLE, part=part)
            coarse = coarse.with_radius(flatter, MIDDLE, other)
            radius, power = _radius(work, wanted, frames, coarse, (first, other), result)
            result = _solved(_forces(work, wanted, coarse, radius), result)
    again = "solid, coarse, again" if start.resolution == "coarse" else f"solid, {start.resolution}"
    with work.stage(again) as misfit:
        trial = _on_final_mesh(work, wanted, frames, coarse, radius, power, result)
        result, coarse, radius = trial.fit, trial.curves, trial.radius
        misfit(result.solution.misfit)
    with work.stage("array"):
        shape = _array(wanted, frames, result)
    adapted = replace(start, pad_radius=radius)
    told = (*work.ended(result.curve.deepest), *_undetermined(radius, power))
    return outcome(wanted, adapted, result, work.stages, "solid", shape, coarse.ripple, told)


def _undetermined(radius: float, power: float | None) -> tuple[str, ...]:
    """Sentence on a pad radius in mm on which the frames hardly depend; () where they do."""
    if power is None or power >= pad.DETERMINED:
        return ()
    return (
        f"pad_radius: the R of the thesis's fit hardly depends on it (as its power {power:.2g}), "
        f"so it remains {radius:g} mm",
    )


def _wide_enough(work: Work, wanted: Bulk | Record, radius: float) -> Family:
    """Make the coarse family, with more exponents where the best one does not suffice.

    That is the last of them, or one of a finger so soft that the target is beyond its presses.
    """
    curves = _row(work, radius, EXPONENTS)
    result = _solved(_forces(work, wanted, curves, radius))
    if SHAPE not in result.solution.at_bounds and reach(wanted, result) <= curves.deepest:
        return curves
    return _row(work, radius, (*EXPONENTS, *STIFFER))


def _row(work: Work, radius: float, exponents: tuple[float, ...]) -> Family:
    """Make the coarse family of some exponents.

    A family is as deep as its shallowest press, so later presses are limited to the depth of
    earlier ones: failed attempts at steps beyond cost most.
    """
    presses, part = {}, PART["solid"]
    for each in exponents:
        presses[each] = work.press("solid", "coarse", radius, each, part=part)
        part = min(part, float(presses[each].depth[-1]) / work.finger.thickness)
    return family(exponents, radius, presses.__getitem__)


def _named(source: str | Path) -> str:
    """Return the subject that a source names; InputError for a record without a finger."""
    names = list(pawluk1997.bulk())
    if isinstance(source, str) and source in names:
        return source
    msg = (
        f"{source}: expected the size of the finger with a record, received none; give width and "
        "thickness in mm, or the subject whose size it has"
    )
    if not Path(source).exists():
        listed = ", ".join(names)
        msg = f"calibrate: expected a subject ({listed}) or a CSV file, received {str(source)!r}"
    raise InputError(msg)


def _target(work: Work, source: str | Path) -> Bulk | Record:
    """Load the target: a subject, or a record with its lumped fit."""
    if isinstance(source, str) and source in pawluk1997.bulk():
        return targets.subject(source)
    with work.stage("lumped") as misfit:
        record = targets.record(source, work.finger.resolution)
        targets.check_depth(record, work.finger)
        misfit(record.lumped_misfit)
    return record


def _forces(
    work: Work,
    wanted: Bulk | Record,
    curves: Family,
    radius: float,
    radius_sd: float | None = None,
) -> Forces:
    skin, rest = work.finger.skin.modulus, work.finger.subcutaneous.modulus
    return Forces(wanted, curves, rest, skin / rest, radius, radius_sd)


def _solved(forces: Forces, near: FitResult | None = None) -> FitResult:
    starts = forces.starts() if near is None else [near.solution.values]
    solution = solve(forces.residual, forces.unknowns, starts)
    return FitResult(solution, *forces.curve(solution.values))


def _radius(
    work: Work,
    wanted: Bulk | Record,
    frames: Frames | None,
    curves: Family,
    radii: tuple[float, float],
    last: FitResult,
) -> tuple[float, float]:
    """Find the pad radius in mm that agrees with the frames, or the nearest feasible one.

    Also return the exponent of the fitted R as a power of it, from the curves at two pad radii.
    """
    tried = [_solved(_forces(work, wanted, curves, each), last) for each in radii]
    fits, goal = [_fitted(each) for each in tried], _goal(wanted, frames)
    radius, power = pad.radius_for(goal, radii, fits)
    if abs(fits[0] / goal - 1) <= CLOSE:
        radius = radii[0]
    radius = float(np.clip(radius, min(radii) / pad.WITHIN, max(radii) * pad.WITHIN))
    return round(work.reachable(radius), 2), power


def _goal(wanted: Bulk | Record, frames: Frames | None) -> float:
    """R in mm that the thesis's fit of the simulated frames must reproduce."""
    return (pad.printed(wanted.name) if frames is None else pad.thesis_fit(frames)).radius


def _fitted(result: FitResult) -> float:
    """R in mm of the thesis's fit of a finger's simulated frames."""
    prony = prony_of(result.solution.values)
    return pad.thesis_fit(pad.simulated(result.curve, result.factor, prony)).radius


def _spread(
    wanted: Bulk | Record, frames: Frames | None, result: FitResult, radius: float, power: float
) -> float:
    """Estimate the standard deviation in mm of a pad radius from frames.

    It is due to the mesh, and to the rounding of a printed R or the noise of the array; SCATTER
    where the frames do not determine it.
    """
    fitted = _fitted(result)
    if power < pad.DETERMINED or abs(fitted / _goal(wanted, frames) - 1) > AGREES:
        return SCATTER * radius
    prony = prony_of(result.solution.values)
    noise = pad.ROUNDING
    if frames is not None:
        noise = pad.scatter(result.curve, result.factor, prony)
    return radius * math.hypot(noise / fitted / power, MESH)


@dataclass(frozen=True)
class Trial:
    """A press on the final mesh at a pad radius in mm, and the fit with curves corrected by it.

    fitted: R in mm of the thesis's fit of its frames, nan without frames.
    """

    radius: float
    fit: FitResult
    curves: Family
    fitted: float


def _on_final_mesh(
    work: Work,
    wanted: Bulk | Record,
    frames: Frames | None,
    curves: Family,
    radius: float,
    power: float | None,
    result: FitResult,
) -> Trial:
    """Press on the final mesh until exponent and fitted R converge; return the best trial.

    Each trial corrects the coarse family by a new press. Without a `power` of DETERMINED or more
    the pad radius is fixed. Once a press stopped early beyond the depth of the target, later
    presses go no deeper.
    """
    goal = math.nan if power is None else _goal(wanted, frames)
    trials: list[Trial] = []
    end = math.inf
    while len(trials) < CORRECTIONS:
        exponent = round(result.solution.values[SHAPE], 2)
        part = min(_deep_enough(work, wanted, curves, radius, result), end) / work.finger.thickness
        press = work.press("solid", work.finger.resolution, radius, exponent, part=part)
        curves = curves.corrected(press, exponent, radius)
        result = _solved(_forces(work, wanted, curves, radius), result)
        if press.halt and reach(wanted, result) <= press.depth[-1]:
            end = float(press.depth[-1])
        fitted = math.nan if power is None else _fitted(result)
        trials.append(Trial(radius, result, curves, fitted))
        steady = abs(result.solution.values[SHAPE] - exponent) < SETTLED
        next_radius = radius
        if power is not None and power >= pad.DETERMINED and abs(fitted / goal - 1) > CLOSE:
            tried = [each.radius for each in trials], [each.fitted for each in trials]
            next_radius = round(work.reachable(pad.nearer(goal, *tried, power)), 2)
        if steady and abs(next_radius / radius - 1) < NONE:
            break
        radius = next_radius
        result = _solved(_forces(work, wanted, curves, radius), result)
    if power is None:
        return trials[-1]
    best = min(trials, key=lambda each: abs(math.log(each.fitted / goal)))
    spread = _spread(wanted, frames, best.fit, best.radius, power)
    forces = _forces(work, wanted, best.curves, best.radius, spread)
    return replace(best, fit=_solved(forces, best.fit))


def _deep_enough(
    work: Work, wanted: Bulk | Record, curves: Family, radius: float, result: FitResult
) -> float:
    """Depth in mm of a press that covers the fitted data, at most that of the family."""
    whole = _forces(work, wanted, replace(curves, reached=math.inf), radius)
    unlimited = FitResult(result.solution, *whole.curve(result.solution.values))
    prony = prony_of(result.solution.values)
    frames = float(pad.slow_press(unlimited.curve, unlimited.factor, prony)[-1])
    return min(round(DEEPER * max(frames, reach(wanted, unlimited)), 2), curves.deepest)


def _array(wanted: Bulk | Record, frames: Frames | None, result: FitResult) -> dict[str, float]:
    """Parameters of the thesis's fit of simulated and of measured frames, by name."""
    if frames is None and not isinstance(wanted, Bulk):
        return {}
    goal = pad.thesis_fit(frames) if frames is not None else pad.printed(wanted.name)
    prony = prony_of(result.solution.values)
    fit = pad.thesis_fit(pad.simulated(result.curve, result.factor, prony))
    names = ("radius", "m", "c0_b")
    both = {f"array {name}": getattr(fit, name) for name in names}
    return both | {f"array {name}, wanted": getattr(goal, name) for name in names}
