"""Work, power and dissipation of the lumped fingerpad (Pawluk 1997, section 2.4.3).

Forces below zero count as zero: an indenter that leaves the skin recovers no work.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support.arrays import Array
from fefinger.theory.lumped.spring import Spring, contact_force
from fefinger.theory.relaxation import Prony


RAMP_SPEED = 100.0  # mm/s, to the offset
SECONDS = 8.0  # duration of the sinusoid, after which the transient has relaxed
PER_CYCLE = 256  # samples; the work of a cycle is then right to 1e-4


@dataclass(frozen=True)
class Dissipation:
    """Work of one cycle: loading and unloading in mJ (N mm), and its duration in s.

    `unloading` is negative: the work that the skin returns.
    """

    loading: float
    unloading: float
    seconds: float

    @property
    def power(self) -> float:
        """Dissipated power in mW (Eq. 2.14)."""
        return (self.loading + self.unloading) / self.seconds

    @property
    def fraction(self) -> float:
        """Dissipated fraction of the loading work, 0 to 1 (Eq. 2.15)."""
        return (self.loading + self.unloading) / self.loading


@dataclass(frozen=True)
class Vibration:
    """Response to a sinusoid about an offset: first half cycle and last whole cycle.

    Forces in N: `mean` (over time) and `peak_to_peak` of the last cycle, `first_mean` and
    `first_peak_to_peak` of the first cycle, `peak` of all; `contact` is the share of the samples
    of the last cycle in which the indenter touches.
    """

    transient: Dissipation
    steady: Dissipation
    mean: float
    peak_to_peak: float
    first_mean: float
    first_peak_to_peak: float
    peak: float
    contact: float


def dissipation(time: ArrayLike, position: ArrayLike, force: ArrayLike) -> Dissipation:
    """Compute the work of a motion (n_t,) s, mm and N (Eq. 2.16, trapezoids).

    Loading is where the position grows, unloading where it falls; forces below zero count as zero.
    """
    time, position, force = (np.asarray(values, float) for values in (time, position, force))
    push = np.maximum(force, 0.0)
    travel = np.diff(position)
    work = (push[1:] + push[:-1]) / 2 * travel
    loading = float(work[travel > 0].sum())
    return Dissipation(loading, float(work[travel < 0].sum()), float(time[-1] - time[0]))


def vibration(
    spring: Spring,
    prony: Prony,
    *,
    offset: float,
    peak_to_peak: float,
    frequency: float,
    seconds: float = SECONDS,
    speed: float = RAMP_SPEED,
) -> Vibration:
    """Compute forces and dissipation of the simulated task of the thesis.

    A ramp at `speed` mm/s to `offset` mm after first touch, then a sine of `peak_to_peak` mm at
    `frequency` Hz, upward first, for the whole cycles within `seconds`. The transient is the first
    half cycle, the steady state the last whole cycle.
    """
    cycles = math.floor(seconds * frequency + 1e-9)
    turn = np.arange(cycles * PER_CYCLE + 1) / PER_CYCLE
    ramp = np.linspace(0.0, offset, 2)[:-1]
    time = np.concatenate([ramp / speed, offset / speed + turn / frequency])
    position = np.concatenate([ramp, offset + peak_to_peak / 2 * np.sin(2 * np.pi * turn)])
    force = contact_force(spring, prony, time, spring.x0 + position)
    first = slice(len(ramp), len(ramp) + PER_CYCLE + 1)
    half = slice(len(ramp), len(ramp) + PER_CYCLE // 2 + 1)
    last = slice(len(time) - PER_CYCLE - 1, len(time))
    return Vibration(
        transient=dissipation(time[half], position[half], force[half]),
        steady=dissipation(time[last], position[last], force[last]),
        mean=_mean(force[last]),
        peak_to_peak=float(np.ptp(force[last])),
        first_mean=_mean(force[first]),
        first_peak_to_peak=float(np.ptp(force[first])),
        peak=float(force.max()),
        contact=float(np.mean(force[last] > 0)),
    )


def tap(spring: Spring, prony: Prony, *, depth: float, speed: float) -> Dissipation:
    """Compute the work of a tap: in to `depth` mm and out again at `speed` mm/s, from rest."""
    way = np.linspace(0.0, 2 * depth, 8 * PER_CYCLE + 1)
    position = depth - np.abs(depth - way)
    force = contact_force(spring, prony, way / speed, spring.x0 + position)
    return dissipation(way / speed, position, force)


def _mean(force: Array) -> float:
    """Mean over a whole cycle whose first and last samples have the same phase."""
    return float((force[:-1] + force[1:]).mean() / 2)
