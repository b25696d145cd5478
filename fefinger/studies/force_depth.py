"""Times of the rows of a study, and stiffness at them, from force and depth."""

from typing import NamedTuple

import numpy as np

from fefinger.scene.motion import Motion
from fefinger.studies.grid import MISSED
from fefinger.support.arrays import Array, Flags
from fefinger.support.vocabulary import Control


SAME = 1e-9
"""Relative difference up to which two forces or depths are the same level."""

WINDOW = 1.3
"""The fit covers depths from 1 / WINDOW to WINDOW times the depth; if the loading ends before, it
begins that much lower."""

POINTS = 5
"""Fewest time steps of a fit."""

MOVING = 0.5
"""Share of the top rate below which the motion counts as a hold, in which the force relaxes."""

RESTING = "none: not on the loading, or slower than half the top rate of the motion"


class NamedTime(NamedTuple):
    """A time of a row: its name, and where it is as a fractional index of the time steps.

    `where` is nan if the time is never reached; then `missed` is the reason. given: "force" or
    "depth" at a given level of it, "" for peak and end.
    """

    name: str
    where: float
    missed: str
    given: str = ""


def named_times(
    force: Array, depth: Array, forces: tuple[float, ...], depths: tuple[float, ...]
) -> list[NamedTime]:
    """Find the peak and the end of force (n_t,) N and depth (n_t,) mm, and crossings of levels.

    A crossing is the first on the loading, by linear interpolation between two steps.
    """
    top, deepest = first(force, force.max()), first(depth, depth.max())
    times = [NamedTime("peak", float(top), ""), NamedTime("end", float(len(force) - 1), "")]
    for name, unit, signal, levels in (
        ("force", "N", force[: top + 1], forces),
        ("depth", "mm", depth[: deepest + 1], depths),
    ):
        for level in levels:
            where = _reached(signal, level)
            reason = f"{MISSED}: {name} = {signal[-1]:.4g} {unit} at most"
            missed = reason if np.isnan(where) else ""
            times.append(NamedTime(f"{level:g} {unit}", where, missed, given=name))
    return times


def first(signal: Array, level: float) -> int:
    """Return the index at which a signal first reaches a level, within rounding."""
    return int(np.argmax(signal >= level - SAME * abs(level)))


def _reached(signal: Array, level: float) -> float:
    """Return the fractional index at which a signal first reaches a level; nan if it does not."""
    if signal.max() < level * (1 - SAME):
        return float("nan")
    after = first(signal, level)
    if after == 0:
        return 0.0
    low, high = signal[after - 1], signal[after]
    return after - 1 + min(float((level - low) / (high - low)), 1.0)


def at(signal: Array, where: float) -> Array:
    """Interpolate a signal (n_t, ...) at a fractional index."""
    low, part = int(where), where - int(where)
    return signal[low] if part == 0 else (1 - part) * signal[low] + part * signal[low + 1]


def until(signal: Array, where: float) -> Array:
    """Return a signal (n_t,) up to a fractional index, where it is interpolated."""
    return np.append(signal[: int(where) + 1], at(signal, where))


class Slope(NamedTuple):
    """A slope in N/mm, the number of fitted time steps, and the reason if the slope is nan."""

    value: float
    points: int
    note: str


def stiffness(time: Array, depth: Array, force: Array, where: float, *, control: str) -> Slope:
    """Fit the slope of force over depth at a fractional index.

    The logarithm of the force is a parabola of the logarithm of the depth. The fit is exact for a
    power law, and within 1 % inside and 3 % at the end for an exponential law, for any spacing of
    the steps. Under plates at 0 to 60 degrees to 1 N, `linear` on the coarse and the standard mesh
    differ by 1 % at 0.5 N and 2 % at the end (RMS); slopes of single steps differ by 4 and 5 %.

    time (n_t,) s, depth (n_t,) mm, force (n_t,) N; control: "depth" or "force", which the motion
    prescribes. Fitted are consecutive steps in which both rise, no slower than MOVING.
    """
    driven = Control(control).of(depth, force)
    rate = np.diff(driven) / np.diff(time)
    loading = (np.diff(depth) > 0) & (np.diff(force) > 0) & (rate >= MOVING * np.abs(rate).max())
    step, here = max(int(np.ceil(where)) - 1, 0), float(at(depth, where))
    if not loading[step] or here <= 0:
        return Slope(float("nan"), 0, RESTING)
    low, high = _stretch(loading, step)
    depth, force = depth[low:high], force[low:high]
    away = np.log(np.maximum(depth / here, 1e-300))
    above = min(np.log(WINDOW), away[-1])
    # 1e-9 is for rounding of steps at the ends of the window.
    near = (away >= above - 2 * np.log(WINDOW) - 1e-9) & (away <= above + 1e-9) & (force > 0)
    points = int(near.sum())
    if points < POINTS:
        note = f"none: {points} steps of the loading within a factor of {WINDOW:g} of the depth"
        return Slope(float("nan"), points, f"{note}, expected {POINTS}")
    size, power, _ = np.polynomial.polynomial.polyfit(away[near], np.log(force[near]), 2)
    return Slope(float(power * np.exp(size) / here), points, "")


def _stretch(good: Flags, step: int) -> tuple[int, int]:
    """Return the range of times, first and last + 1, around a step with good steps alone."""
    bad = np.flatnonzero(~good)
    before, after = bad[bad < step], bad[bad > step]
    low = int(before[-1]) + 1 if before.size else 0
    return low, (int(after[0]) if after.size else len(good)) + 1


def dynamic_stiffness(motion: Motion, time: Array, depth: Array, force: Array) -> complex | None:
    """Fit the complex ratio of force and depth, in N/mm, to the last cycles of a vibration.

    Its phase is by how much the force leads. time (n_t,) s, depth (n_t,) mm, force (n_t,) N. Means
    and slow drifts do not count. None without a whole cycle, or where contact opens in a cycle.
    """
    wave = motion.trajectory.wave
    if wave is None:
        return None
    frequency = wave.last_frequency
    # The last four cycles are fitted, or all where there are fewer.
    cycles = min(4, int((motion.duration - wave.start) * frequency * (1 + 1e-9)))
    last = time >= time[-1] - cycles / frequency * (1 + 1e-9)
    if not cycles or not (force[last] > 0).all():
        return None
    angle, drift = wave.angle(time[last] - wave.start), (time[last] - time[-1]) * frequency / cycles
    terms = np.column_stack([np.cos(angle), np.sin(angle), drift**0, drift, drift**2])
    fitted = np.linalg.lstsq(terms, np.column_stack([depth[last], force[last]]), rcond=None)[0]
    moved, pushed = fitted[0] - 1j * fitted[1]
    return complex(pushed / moved)
