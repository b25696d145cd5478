"""The compiled step of `streaming`; imported when units are first stepped."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fefinger.neural.generators import LARGEST_CURRENT
from fefinger.neural.membranes._integrate_and_fire import _eventful


if TYPE_CHECKING:
    from fefinger.neural.streaming import State


@njit(cache=True)
def _compressive(e: NDArray[np.floating]) -> float:
    """Return max(0, -smallest principal value) of xx yy zz xy yz xz, by its closed form."""
    xx, yy, zz = float(e[0]), float(e[1]), float(e[2])
    xy, yz, xz = float(e[3]), float(e[4]), float(e[5])
    mean = (xx + yy + zz) / 3.0
    a, b, c = xx - mean, yy - mean, zz - mean
    size = math.sqrt((a * a + b * b + c * c + 2.0 * (xy * xy + yz * yz + xz * xz)) / 6.0)
    if size == 0.0:
        return max(0.0, -mean)
    determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    angle = math.acos(min(1.0, max(-1.0, determinant / (2.0 * size**3)))) / 3.0
    return max(0.0, -(mean + 2.0 * size * math.cos(angle + 2.0 * math.pi / 3.0)))


@njit(cache=True)
def _along(e: NDArray[np.floating], u: NDArray[np.float64], v: NDArray[np.float64]) -> float:
    """Return u . e v."""
    return (
        u[0] * (e[0] * v[0] + e[3] * v[1] + e[5] * v[2])
        + u[1] * (e[3] * v[0] + e[1] * v[1] + e[4] * v[2])
        + u[2] * (e[5] * v[0] + e[4] * v[1] + e[2] * v[2])
    )


@njit(cache=True)
def _tangent(e: NDArray[np.floating], across: NDArray[np.float64]) -> float:
    """Return the largest strain in the plane of the skin."""
    a, b = _along(e, across[0], across[0]), _along(e, across[0], across[1])
    c = _along(e, across[1], across[1])
    return 0.5 * (a + c) + math.hypot(0.5 * (a - c), b)


@njit(cache=True)
def _current(s: "State", i: int, x: float) -> float:
    """Return the saturating generator's current for the state of the end organ of unit i."""
    out = s.at_rest[i] * x + s.share[i, 0] * s.modes[i, 0] + s.share[i, 1] * s.modes[i, 1]
    return -LARGEST_CURRENT * math.expm1(-s.gain[i] * max(out, 0.0) / LARGEST_CURRENT)


@njit(cache=True)
def step(
    s: "State",
    strain: NDArray[np.floating],
    dt: float,
    substeps: int,
    numbers: tuple[float, float, float],
) -> int:
    """Take every unit on by dt ms; return the number of spikes, or -1 where they had no room.

    numbers: threshold in uA/cm², time constant and refractory time in ms.
    """
    threshold, tau, refractory = numbers
    part, fired, full = dt / substeps, 0, False
    for i in range(len(s.x)):
        s.counts[i] = 0
        before = s.x[i]
        if s.drive[i] == 0:
            s.x[i] = s.length[i] * _compressive(strain[i])
        else:
            s.x[i] = s.length[i] * _tangent(strain[i], s.across[i])
        change = s.x[i] - before
        if dt == 0.0:
            s.modes[i, 0] += change
            s.modes[i, 1] += change
            s.current[i] = _current(s, i, s.x[i])
            continue
        p, q = 1e-3 * s.pole[i, 0], 1e-3 * s.pole[i, 1]
        fade, wane = math.exp(-p * part), math.exp(-q * part)
        grow, rise = change / dt * (1.0 - fade) / p, change / dt * (1.0 - wane) / q
        for k in range(substeps):
            s.modes[i, 0] = fade * s.modes[i, 0] + grow
            s.modes[i, 1] = wane * s.modes[i, 1] + rise
            current = _current(s, i, before + change * (k + 1) / substeps)
            begin, level = s.clock[0] + k * part, s.current[i] / threshold
            steep = (current - s.current[i]) / (threshold * part)
            s.current[i] = current
            s.counts[i] = _eventful(
                s.membrane[i],
                begin,
                begin + part,
                level,
                steep,
                tau,
                refractory,
                s.spikes[i],
                s.counts[i],
            )
        fired += s.counts[i]
        full = full or s.counts[i] > s.spikes.shape[1]
    s.clock[0] += dt
    return -1 if full else fired
