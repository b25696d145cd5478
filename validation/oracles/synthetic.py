"""Synthetic trials of the lumped finger with the sensor noise of the thesis, seeded."""

from dataclasses import dataclass

import numpy as np

from fefinger.support.arrays import Array
from fefinger.theory.lumped.spring import Spring, constant_velocity, force
from fefinger.theory.relaxation import Prony


FORCE_NOISE = 3e-3  # N RMS (Pawluk 1997, section 2.2.1)
POSITION_NOISE = 3e-3  # mm RMS
SAMPLE_RATE = 1e4  # Hz
LEAD = 0.3  # mm of free travel before first touch


@dataclass(frozen=True)
class Trial:
    """Samples of one trial: time (n_t,) s, position (n_t,) mm, force (n_t,) N."""

    time: Array
    position: Array
    force: Array


def ramp_and_hold(
    spring: Spring,
    prony: Prony,
    *,
    speed: float = 60.0,
    peak_force: float = 2.5,
    hold: float = 6.0,
    seed: int | None = 0,
    sample_rate: float = SAMPLE_RATE,
) -> Trial:
    """Simulate the ramp-and-hold trial of the thesis (section 2.2.2, experiment 2).

    A sharp ramp at `speed` mm/s until the force is `peak_force` N, then `hold` s at that position,
    sampled at `sample_rate` Hz, with white noise on position and force; without noise if `seed` is
    None.
    """
    depth = _depth_at(spring, prony, speed, peak_force)
    end = (LEAD + depth) / speed
    time = np.arange(0.0, end + hold, 1.0 / sample_rate)
    corner = np.searchsorted(time, end)
    exact = np.insert(time, corner, end)
    position = spring.x0 - LEAD + speed * np.minimum(exact, end)
    pressed = np.delete(force(spring, prony, exact, position), corner)
    position = np.delete(position, corner)
    if seed is None:
        return Trial(time, position, pressed)
    rng = np.random.default_rng(seed)
    noisy = position + rng.normal(0.0, POSITION_NOISE, len(time))
    return Trial(time, noisy, pressed + rng.normal(0.0, FORCE_NOISE, len(time)))


def _depth_at(spring: Spring, prony: Prony, speed: float, peak: float) -> float:
    """Depth in mm at which a ramp at constant speed reaches the force `peak` in N."""
    from scipy.optimize import brentq

    low, high = (float(spring.position(p)) for p in (peak, peak / prony.long_time))

    def excess(position: float) -> float:
        return float(constant_velocity(spring, prony, position, speed)) - peak

    return float(brentq(excess, low, high, xtol=1e-12)) - spring.x0
