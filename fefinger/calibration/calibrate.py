"""Fit a finger to a subject or a record, by rungs that start one another.

`lumped` is the exact inverse: stiffness, touch and G of the thesis's own model. `condensed` scales
the linear finger by the thesis's t(u); `solid` finds modulus and exponent of tissue that stiffens,
on the coarse mesh first and then by presses of its own on the mesh asked for, and the pad radius by
what the thesis's fit finds in the frames of its array: both are settled together.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fefinger.calibration import pad_radius as pad
from fefinger.calibration import targets
from fefinger.calibration.curve import Family, family
from fefinger.calibration.force import SHAPE, Forces, prony_of
from fefinger.calibration.inverse import solve
from fefinger.calibration.outcome import AGREES, Found, checked, outcome, reach, refuse_gross
from fefinger.calibration.press_store import Work
from fefinger.calibration.record import Calibration
from fefinger.calibration.slow_press import PART
from fefinger.calibration.targets import Bulk, Frames, Record
from fefinger.scene import library
from fefinger.scene.finger import RESOLUTIONS, Finger
from fefinger.support.checks import InputError, choice
from fefinger.support.progress import Progress


Array = NDArray[np.float64]

MECHANICS = ("condensed", "solid")

EXPONENTS = (0.02, 1.5, 3.0, 4.5)
"""Exponents of Demiray's law at which a finger is solved; the first is all but neo-Hookean."""

STIFFER = (7.0, 10.0)
"""Exponents that are solved too where the data want more than the last of these."""

SMALLER, WIDER = 0.8, 1.15
"""The other pad radius at which a finger is pressed, over the one it starts from: wider in `solid`,
where tissue that stiffens draws the pressure together, if a finger of its size can be that flat."""

AGAINST = 2.0
"""Factor on the skin's modulus of the press that shows what the ratio of the moduli does."""

MIDDLE = 3.0
"""Exponent of that press, and of the one at the other pad radius."""

CORRECTIONS = 6
"""Presses on the finer mesh, at most."""

DEEPER = 1.05
"""Depth of these presses over the one that the fit so far reaches in the frames or the ramp."""

SCATTER = 0.13
"""Standard deviation of the logarithm of a pad radius that the frames do not reach: R of the five
subjects."""

MESH = 0.015
"""Standard deviation of the logarithm of a pad radius that the mesh makes: twins of the standard
mesh and subjects miss by 0.5 to 1.6 % on the coarse one (suite `calibration`)."""

NONE = 5e-3
"""Relative difference of two pad radii that counts as none."""

SETTLED = 0.1
"""Change of the exponent between two corrections that counts as none: less than the data leave
open, and over it the force between presses is right within 1e-3."""

CLOSE = 0.02
"""Relative distance of a fitted R from the wanted one that counts as none: the rounding of those
that are printed to the mm."""


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
    """Return a finger that was fitted to a subject of the thesis or to the record of a user.

    Parameters
    ----------
    source
        A subject of Table 2.1, as "a.h.", or a CSV file of time (s), position (mm), force (N) with
        a fast ramp and a hold.
    finger
        Size and tissues to start from; by default those of the subject. A record needs it.
    mechanics
        "condensed" (small strain, times the t(u) of the thesis) or "solid" (finite strain, tissue
        that stiffens).
    resolution
        Mesh that `solid` ends on: "coarse", "standard" or "fine".
    frames
        CSV file of a slow press: time, position (mm from touch), p1 ... p64 (kPa).
    check
        CSV file of a motion with unloading, which is predicted and not fitted; of a record alone.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Raises
    ------
    InputError
        A source that cannot be used.
    ConvergenceError
        A fit or a press that fails, or a finger that does not show the record at all.
    """
    choice("mechanics", mechanics, MECHANICS)
    choice("resolution", resolution, RESOLUTIONS)
    start = finger or Finger.subject(_named(source))
    work = Work(replace(start, resolution=resolution), progress)
    wanted = _target(work, source)
    if check is not None and isinstance(wanted, Bulk):
        msg = (
            "check: expected the record of a user (DATA.csv) beside it, because it is predicted "
            f"with the touch of that record, received the subject {wanted.name!r}; subjects are "
            "checked on sinusoids by themselves"
        )
        raise InputError(msg)
    measured = None if frames is None else targets.frames(frames)
    again = None if check is None else targets.unloading(check)
    rung = {"condensed": condensed, "solid": solid}[mechanics]
    done = rung(work, wanted, measured)
    refuse_gross(done)
    return done if again is None else checked(done, again)


def condensed(work: Work, wanted: Bulk | Record, frames: Frames | None) -> Calibration:
    """Return the fit of the linear finger times t(u), at the pad radius that frames ask for.

    The printed R of a subject is left alone: it is for a finger that itself stiffens.
    """
    start = work.finger
    radius, mesh = start.pad_radius, start.resolution
    with work.stage("condensed") as misfit:
        linear = family((1.0,), radius, lambda _: work.press("condensed", mesh, radius))
        found = _solved(_forces(work, wanted, linear, radius))
        misfit(found.solution.misfit)
    if frames is not None:
        with work.stage("array") as misfit:
            other = SMALLER * radius
            linear = linear.with_radius(work.press("condensed", mesh, other), 1.0, other)
            radius, power = _radius(work, wanted, frames, linear, (other, radius), found)
            found = _solved(_forces(work, wanted, linear, radius), found)
            spread = _spread(wanted, frames, found, radius, power)
            found = _solved(_forces(work, wanted, linear, radius, spread), found)
            misfit(found.solution.misfit)
    adapted = replace(start, pad_radius=radius)
    shape = _array(wanted, frames, found) if frames is not None else {}
    return outcome(wanted, adapted, found, work.stages, "condensed", shape, linear.ripple)


def solid(work: Work, wanted: Bulk | Record, frames: Frames | None) -> Calibration:
    """Return the fit of tissue that stiffens, at the pad radius that the frames ask for."""
    start, power = work.finger, None
    first = radius = start.pad_radius
    seen = frames is not None or isinstance(wanted, Bulk)
    with work.stage("solid, coarse") as misfit:
        coarse = _wide_enough(work, wanted, first)
        part = coarse.deepest / start.thickness
        stiff = work.press("solid", "coarse", first, MIDDLE, AGAINST, part)
        coarse = coarse.with_ratio(stiff, MIDDLE, AGAINST)
        found = _solved(_forces(work, wanted, coarse, first))
        misfit(found.solution.misfit)
    if seen:
        with work.stage("array, coarse"):
            wider = WIDER * first
            other = wider if work.reachable(wider) == wider else SMALLER * first
            flatter = work.press("solid", "coarse", other, MIDDLE, part=part)
            coarse = coarse.with_radius(flatter, MIDDLE, other)
            radius, power = _radius(work, wanted, frames, coarse, (first, other), found)
            found = _solved(_forces(work, wanted, coarse, radius), found)
    again = "solid, coarse, again" if start.resolution == "coarse" else f"solid, {start.resolution}"
    with work.stage(again) as misfit:
        trial = _finished(work, wanted, frames, coarse, radius, power, found)
        found, coarse, radius = trial.found, trial.curves, trial.radius
        misfit(found.solution.misfit)
    with work.stage("array"):
        shape = _array(wanted, frames, found)
    adapted = replace(start, pad_radius=radius)
    early = work.ended(found.curve.deepest)
    return outcome(wanted, adapted, found, work.stages, "solid", shape, coarse.ripple, early)


def _wide_enough(work: Work, wanted: Bulk | Record, radius: float) -> Family:
    """Return the coarse family, with more exponents where the best one is beyond it."""
    found = _row(work, radius, EXPONENTS)
    at_bounds = _solved(_forces(work, wanted, found, radius)).solution.at_bounds
    if SHAPE not in at_bounds:
        return found
    return _row(work, radius, (*EXPONENTS, *STIFFER))


def _row(work: Work, radius: float, exponents: tuple[float, ...]) -> Family:
    """Return the coarse family of some exponents.

    A family is as deep as its shallowest press, so none goes deeper than those before: what costs
    most are the attempts at steps that no press reaches.
    """
    found, part = {}, PART["solid"]
    for each in exponents:
        found[each] = work.press("solid", "coarse", radius, each, part=part)
        part = min(part, float(found[each].depth[-1]) / work.finger.thickness)
    return family(exponents, radius, found.__getitem__)


def _named(source: str | Path) -> str:
    """Return the subject that a source is, whose size a finger has that is not given."""
    names = [each for each in library.pawluk_bulk() if each != "means"]
    if isinstance(source, str) and source in names:
        return source
    msg = (
        f"{source}: expected the size of the finger beside a record, received none; give width "
        "and thickness in mm, or the subject whose size it has"
    )
    if not Path(source).exists():
        known = ", ".join(names)
        msg = f"calibrate: expected a subject ({known}) or a CSV file, received {str(source)!r}"
    raise InputError(msg)


def _target(work: Work, source: str | Path) -> Bulk | Record:
    """Return what is to be met, of a record after its lumped fit."""
    if isinstance(source, str) and source in library.subjects():
        return targets.subject(source)
    with work.stage("lumped") as misfit:
        found = targets.record(source, work.finger.resolution)
        targets.check_depth(found, work.finger)
        misfit(found.lumped_misfit)
    return found


def _forces(
    work: Work,
    wanted: Bulk | Record,
    curves: Family,
    radius: float,
    radius_sd: float | None = None,
) -> Forces:
    skin, rest = work.finger.skin.modulus, work.finger.subcutaneous.modulus
    return Forces(wanted, curves, rest, skin / rest, radius, radius_sd)


def _solved(forces: Forces, near: Found | None = None) -> Found:
    starts = forces.starts() if near is None else [near.solution.values]
    found = solve(forces.residual, forces.unknowns, starts)
    return Found(found, *forces.curve(found.values))


def _radius(
    work: Work,
    wanted: Bulk | Record,
    frames: Frames | None,
    curves: Family,
    radii: tuple[float, float],
    last: Found,
) -> tuple[float, float]:
    """Return the pad radius in mm that the frames ask for, or the nearest one within reach.

    And the power of it that the fitted R grows with, from the curves at two pad radii.
    """
    tried = [_solved(_forces(work, wanted, curves, each), last) for each in radii]
    fits = [_fitted(each) for each in tried]
    radius, power = pad.radius_for(_goal(wanted, frames), radii, fits)
    radius = float(np.clip(radius, min(radii) / pad.WITHIN, max(radii) * pad.WITHIN))
    return round(work.reachable(radius), 2), power


def _goal(wanted: Bulk | Record, frames: Frames | None) -> float:
    """Return the R in mm that the thesis's fit is to find."""
    return (pad.printed(wanted.name) if frames is None else pad.thesis_fit(frames)).radius


def _fitted(found: Found) -> float:
    """Return the R in mm that the thesis's fit finds in the frames of a finger."""
    prony = prony_of(found.solution.values)
    return pad.thesis_fit(pad.simulated(found.curve, found.factor, prony)).radius


def _spread(
    wanted: Bulk | Record, frames: Frames | None, found: Found, radius: float, power: float
) -> float:
    """Return the standard deviation in mm of a pad radius that frames gave.

    From the mesh, and the rounding of a printed R or what the noise of the array makes.
    """
    fitted = _fitted(found)
    if abs(fitted / _goal(wanted, frames) - 1) > AGREES:
        return SCATTER * radius
    prony = prony_of(found.solution.values)
    noise = pad.ROUNDING
    if frames is not None:
        noise = pad.scatter(found.curve, found.factor, prony)
    return radius * math.hypot(noise / fitted / max(power, pad.LEAST), MESH)


@dataclass(frozen=True)
class Trial:
    """A press on the final mesh at a pad radius in mm, and the fit of the curves that hold it.

    fitted: R in mm that the thesis's fit then finds, nan where there are no frames.
    """

    radius: float
    found: Found
    curves: Family
    fitted: float


def _finished(
    work: Work,
    wanted: Bulk | Record,
    frames: Frames | None,
    curves: Family,
    radius: float,
    power: float | None,
    found: Found,
) -> Trial:
    """Return the best of the trials on the final mesh, until exponent and fitted R settle.

    Each shifts the coarse family to a press of its own. Without a power the pad radius is kept.
    Once a press ended early that holds what the target needs, none goes deeper.
    """
    goal = math.nan if power is None else _goal(wanted, frames)
    trials: list[Trial] = []
    end = math.inf
    while len(trials) < CORRECTIONS:
        exponent = round(found.solution.values[SHAPE], 2)
        part = min(_deep_enough(work, wanted, curves, radius, found), end) / work.finger.thickness
        own = work.press("solid", work.finger.resolution, radius, exponent, part=part)
        curves = curves.corrected(own, exponent, radius)
        found = _solved(_forces(work, wanted, curves, radius), found)
        if own.halt and reach(wanted, found) <= own.depth[-1]:
            end = float(own.depth[-1])
        fitted = math.nan if power is None else _fitted(found)
        trials.append(Trial(radius, found, curves, fitted))
        steady = abs(found.solution.values[SHAPE] - exponent) < SETTLED
        asked = radius
        if power is not None and abs(fitted / goal - 1) > CLOSE:
            tried = [each.radius for each in trials], [each.fitted for each in trials]
            asked = round(work.reachable(pad.nearer(goal, *tried, power)), 2)
        if steady and abs(asked / radius - 1) < NONE:
            break
        radius = asked
        found = _solved(_forces(work, wanted, curves, radius), found)
    if power is None:
        return trials[-1]
    best = min(trials, key=lambda each: abs(math.log(each.fitted / goal)))
    spread = _spread(wanted, frames, best.found, best.radius, power)
    forces = _forces(work, wanted, best.curves, best.radius, spread)
    return replace(best, found=_solved(forces, best.found))


def _deep_enough(
    work: Work, wanted: Bulk | Record, curves: Family, radius: float, found: Found
) -> float:
    """Return the depth in mm of a press that holds what is fitted, at most that of the family."""
    whole = _forces(work, wanted, replace(curves, reached=math.inf), radius)
    own = Found(found.solution, *whole.curve(found.solution.values))
    prony = prony_of(found.solution.values)
    frames = float(pad.slow_press(own.curve, own.factor, prony)[-1])
    return min(round(DEEPER * max(frames, reach(wanted, own)), 2), curves.deepest)


def _array(wanted: Bulk | Record, frames: Frames | None, found: Found) -> dict[str, float]:
    """Return the thesis's fit of simulated and of measured frames, by name."""
    if frames is None and not isinstance(wanted, Bulk):
        return {}
    goal = pad.thesis_fit(frames) if frames is not None else pad.printed(wanted.name)
    prony = prony_of(found.solution.values)
    fit = pad.thesis_fit(pad.simulated(found.curve, found.factor, prony))
    names = ("radius", "m", "c0_b")
    both = {f"array {name}": getattr(fit, name) for name in names}
    return both | {f"array {name}, wanted": getattr(goal, name) for name in names}
