"""Fit a finger to a subject or a record, by rungs that start one another.

`lumped` is the exact inverse: stiffness, touch and G of the thesis's own model. `condensed` scales
the linear finger by the thesis's t(u); `solid` finds modulus and exponent of tissue that stiffens,
on the coarse mesh first and then by presses of its own on the mesh asked for, and the pad radius by
what the thesis's fit finds in the frames of its array: both are settled together.
"""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fefinger import library
from fefinger.calibration import pad, target
from fefinger.calibration.curve import Family, family
from fefinger.calibration.force import SHAPE, Forces, prony_of
from fefinger.calibration.inverse import solve
from fefinger.calibration.outcome import Found, checked, layer, outcome
from fefinger.calibration.press import Press, press, shapable, small
from fefinger.calibration.record import Calibration, Stage
from fefinger.calibration.target import Bulk, Frames, Record
from fefinger.checks import InputError, choice
from fefinger.finger import Finger
from fefinger.records import Progress


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

CORRECTIONS = 2
"""Presses on the finer mesh, at most."""

WITHIN = 1.15
"""Factor beyond the pad radii of the presses up to which their effect is taken to first order.
Frames that ask for more get no more."""

SCATTER = 0.13
"""Standard deviation of the logarithm of a pad radius that the frames do not reach: R of the five
subjects."""

HALVINGS = 6
"""Steps, each half of the one before, from a pad that is too flat for the finger's size."""

REACHED = 0.02
"""Relative difference of two pad radii that counts as none."""

SETTLED = 0.05
"""Change of the exponent between two corrections that counts as none."""


class Work:
    """Presses of one finger, with their progress and their cost by stage."""

    def __init__(self, finger: Finger, progress: Progress | None) -> None:
        self.finger, self.progress = finger, progress
        self.stages: list[Stage] = []
        self._presses: dict[tuple[Finger, str], Press] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[Callable[[float], None]]:
        """Measure a stage; yields a function that takes its misfit."""
        started, misfits = time.process_time(), list[float]()
        self._presses = {}
        if self.progress is not None:
            self.progress(name, 0.0)
        yield misfits.append
        spent = time.process_time() - started
        kept = sum(each.seconds for each in self._presses.values())
        misfit = misfits[-1] if misfits else None
        self.stages.append(Stage(name, spent, len(self._presses), kept, misfit))
        if self.progress is not None:
            self.progress(name, 1.0)

    def press(
        self,
        mechanics: str,
        resolution: str,
        radius: float,
        exponent: float | None = None,
        ratio: float = 1.0,
    ) -> Press:
        """Return a press of the finger with another radius, exponent and skin."""
        finger = replace(
            self.finger,
            resolution=resolution,
            pad_radius=radius,
            skin=layer(self.finger.skin, exponent, ratio),
            subcutaneous=layer(self.finger.subcutaneous, exponent),
        )
        wanted = finger, mechanics
        if wanted not in self._presses:
            finite = mechanics == "solid"
            self._presses[wanted] = press(finger, mechanics) if finite else small(finger)
        return self._presses[wanted]

    def reachable(self, radius: float) -> float:
        """Return a pad radius in mm, or the nearest one on the way to it that the size allows."""
        start = self.finger.pad_radius
        for _ in range(HALVINGS):
            if shapable(replace(self.finger, pad_radius=radius)):
                return radius
            radius = math.sqrt(radius * start)
        return start


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
        CSV file of a motion with unloading, which is predicted and not fitted.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Raises
    ------
    InputError
        A source that cannot be used.
    ConvergenceError
        A fit or a press that fails.
    """
    choice("mechanics", mechanics, MECHANICS)
    wanted = _target(source, finger)
    start = finger or Finger.subject(wanted.name)
    measured = None if frames is None else target.frames(frames)
    again = None if check is None else target.unloading(check)
    work = Work(replace(start, resolution=resolution), progress)
    if isinstance(wanted, Record):
        with work.stage("lumped") as misfit:
            misfit(math.sqrt(wanted.lumped.mse))
    rung = {"condensed": condensed, "solid": solid}[mechanics]
    done = rung(work, wanted, measured)
    return done if again is None else checked(done, again)


def condensed(work: Work, wanted: Bulk | Record, frames: Frames | None) -> Calibration:
    """Return the fit of the linear finger times t(u), at the pad radius that frames ask for.

    The printed R of a subject is left alone: it is for a finger that itself stiffens.
    """
    start, spread = work.finger, None
    radius, mesh = start.pad_radius, start.resolution
    with work.stage("condensed") as misfit:
        linear = family((1.0,), radius, lambda _: work.press("condensed", mesh, radius))
        found = _solved(_forces(work, wanted, linear, radius))
        misfit(found.solution.misfit)
    if frames is not None:
        with work.stage("array") as misfit:
            other = SMALLER * radius
            linear = linear.with_radius(work.press("condensed", mesh, other), 1.0, other)
            radius, spread = _radius(work, wanted, frames, linear, (other, radius), found)
            found = _solved(_forces(work, wanted, linear, radius, spread), found)
            misfit(found.solution.misfit)
    adapted = replace(start, pad_radius=radius)
    shape = _array(wanted, frames, found) if frames is not None else {}
    return outcome(wanted, adapted, found, work.stages, "condensed", shape, linear.ripple)


def solid(work: Work, wanted: Bulk | Record, frames: Frames | None) -> Calibration:
    """Return the fit of tissue that stiffens, at the pad radius that the frames ask for."""
    start, spread = work.finger, None
    first = radius = start.pad_radius
    seen = frames is not None or isinstance(wanted, Bulk)
    with work.stage("solid, coarse") as misfit:
        coarse = _wide_enough(work, wanted, first)
        stiff = work.press("solid", "coarse", first, MIDDLE, AGAINST)
        coarse = coarse.with_ratio(stiff, MIDDLE, AGAINST)
        found = _solved(_forces(work, wanted, coarse, first))
        misfit(found.solution.misfit)
    if seen:
        with work.stage("array, coarse"):
            wider = WIDER * first
            other = wider if work.reachable(wider) == wider else SMALLER * first
            flatter = work.press("solid", "coarse", other, MIDDLE)
            coarse = coarse.with_radius(flatter, MIDDLE, other)
            radius, spread = _radius(work, wanted, frames, coarse, (first, other), found)
            found = _solved(_forces(work, wanted, coarse, radius, spread), found)
    again = "solid, coarse, again" if start.resolution == "coarse" else f"solid, {start.resolution}"
    with work.stage(again) as misfit:
        start_at = radius, spread
        found, coarse, radius = _finished(work, wanted, frames, coarse, start_at, found)
        misfit(found.solution.misfit)
    with work.stage("array"):
        shape = _array(wanted, frames, found)
    adapted = replace(start, pad_radius=radius)
    return outcome(wanted, adapted, found, work.stages, "solid", shape, coarse.ripple)


def _wide_enough(work: Work, wanted: Bulk | Record, radius: float) -> Family:
    """Return the coarse family, with more exponents where the best one is beyond it."""

    def pressed(exponent: float) -> Press:
        return work.press("solid", "coarse", radius, exponent)

    found = family(EXPONENTS, radius, pressed)
    at_bounds = _solved(_forces(work, wanted, found, radius)).solution.at_bounds
    if SHAPE not in at_bounds:
        return found
    return family((*EXPONENTS, *STIFFER), radius, pressed)


def _target(source: str | Path, finger: Finger | None) -> Bulk | Record:
    if isinstance(source, str) and source in library.subjects():
        return target.subject(source)
    if finger is None:
        msg = (
            f"{source}: expected the size of the finger beside a record, received none; give width "
            "and thickness in mm, or the subject whose size it has"
        )
        if not Path(source).exists():
            names = ", ".join(each for each in library.pawluk_bulk() if each != "means")
            msg = f"calibrate: expected a subject ({names}) or a CSV file, received {str(source)!r}"
        raise InputError(msg)
    return target.record(source)


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
    """Return the pad radius that the frames ask for, and its standard deviation, in mm.

    The fitted R of two pad radii gives its slope; its scatter is the rounding of a printed R, or
    what the noise of the array makes. Where the radius is beyond reach it is the nearest one.
    """
    goal = pad.thesis_fit(frames) if frames is not None else pad.printed(wanted.name)
    tried = [_solved(_forces(work, wanted, curves, each), last) for each in radii]
    presses = [(each.curve, each.factor, prony_of(each.solution.values)) for each in tried]
    fits = [pad.thesis_fit(pad.simulated(*each)).radius for each in presses]
    radius, slope = pad.radius_for(goal.radius, radii, fits)
    near = float(np.clip(radius, min(radii) / WITHIN, max(radii) * WITHIN))
    near = round(work.reachable(near), 2)
    if abs(near / radius - 1) > REACHED:
        return near, SCATTER * near
    noise = pad.ROUNDING if frames is None else pad.scatter(*presses[0])
    return near, noise / slope


def _finished(
    work: Work,
    wanted: Bulk | Record,
    frames: Frames | None,
    curves: Family,
    pad_radius: tuple[float, float | None],
    found: Found,
) -> tuple[Found, Family, float]:
    """Return the fit on the finer mesh, its curves and its pad radius in mm.

    The coarse family is shifted until exponent and radius settle.
    """
    radius, spread = pad_radius
    for last in (False,) * (CORRECTIONS - 1) + (True,):
        exponent = round(found.solution.values[SHAPE], 2)
        better = work.press("solid", work.finger.resolution, radius, exponent)
        curves = curves.corrected(better, exponent, radius)
        found = _solved(_forces(work, wanted, curves, radius, spread), found)
        asked = radius
        if spread is not None and not last:
            radii = radius, curves.radius if radius != curves.radius else curves.other
            asked, spread = _radius(work, wanted, frames, curves, radii, found)
        steady = abs(found.solution.values[SHAPE] - exponent) < SETTLED
        if last or (steady and abs(asked / radius - 1) < REACHED):
            break
        radius = asked
        found = _solved(_forces(work, wanted, curves, radius, spread), found)
    return found, curves, radius


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
