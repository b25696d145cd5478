"""Hodgkin-Huxley membrane by SciPy's DOP853 (order 8): reference of the compiled integrators."""

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import DOP853
from scipy.optimize import brentq

from fefinger.neural.membranes import HodgkinHuxley
from fefinger.support.arrays import Array


_RTOL, _ATOL = 1e-10, 1e-12  # spike times are then right to some 1e-9 s
_STRAIGHT = 1e-12  # relative change of slope below which samples lie on one line: rounding


@dataclass(frozen=True)
class Exact:
    """Spike times in s, final (V, n, m, h), highest potential in mV, s in depolarization block."""

    times: Array
    final: Array
    peak_mV: float
    block_seconds: float


def slope(y: Array, current: float, speed: float) -> tuple[float, ...]:
    """Return d(V, n, m, h)/dt per ms; rates times `speed`. Hodgkin & Huxley (1952)."""
    v, n, m, h = y.tolist()  # plain floats: five times as fast as those of NumPy

    def linoid(x: float) -> float:
        return x / math.expm1(x) if abs(x) > 1e-9 else 1.0 - x / 2

    a_n, b_n = 0.1 * linoid((10 - v) / 10), 0.125 * math.exp(-v / 80)
    a_m, b_m = linoid((25 - v) / 10), 4 * math.exp(-v / 18)
    a_h, b_h = 0.07 * math.exp(-v / 20), 1 / (math.exp((30 - v) / 10) + 1)
    ionic = 36 * n**4 * (v + 12) + 120 * m**3 * h * (v - 115) + 0.3 * (v - 10.613)
    gates = zip((n, m, h), (a_n, a_m, a_h), (b_n, b_m, b_h), strict=True)
    return current - ionic, *(speed * (a * (1 - x) - b * x) for x, a, b in gates)


def exact(membrane: HodgkinHuxley, time: ArrayLike, current: ArrayLike) -> list[Exact]:
    """Integrate units from rest: time (n_t,) s, current (n_t,) or (n_t, n_units) µA/cm².

    The solver restarts where the slope of the current changes. Peak and block are read at the ends
    of its steps.
    """
    time = 1e3 * np.asarray(time, float)
    columns = np.asarray(current, float).reshape(len(time), -1).T
    return [_unit(membrane, time, column) for column in columns]


def _unit(membrane: HodgkinHuxley, time: Array, current: Array) -> Exact:
    y, step, armed, above = membrane.rest(), None, True, 0.0
    peak, blocked = float(y[0]), 0.0
    level, least, longest = membrane.block
    spikes: list[float] = []
    for t0, t1, i0, i1 in pieces(time, current):
        rate = (i1 - i0) / (t1 - t0)

        def rise(
            t: float, y: Array, t0: float = t0, i0: float = i0, rate: float = rate
        ) -> tuple[float, ...]:
            return slope(y, i0 + rate * (t - t0), membrane.speed)

        first = None if step is None else min(step, t1 - t0)
        solver: Any = DOP853(rise, t0, y, t1, first_step=first, max_step=5, rtol=_RTOL, atol=_ATOL)
        while solver.status == "running":
            message = solver.step()
            assert solver.status != "failed", message
            v, step = float(solver.y[0]), solver.step_size
            high = v > level and i0 + rate * (solver.t_old - t0) > least
            above = above + step if high else 0.0
            if armed and v >= 40.0:
                inside = solver.dense_output()
                ends = solver.t_old, solver.t
                spikes.append(brentq(lambda t, f=inside: f(t)[0] - 40.0, *ends, xtol=1e-11))
                armed, above = False, 0.0
            armed = armed or v < 20.0
            peak = max(peak, v)
            blocked += min(step, max(above - longest, 0.0))
        y = solver.y
    return Exact(1e-3 * np.array(spikes), y, peak, 1e-3 * blocked)


def pieces(time: Array, current: Array) -> list[tuple[float, float, float, float]]:
    """Longest straight pieces (start, stop, current at start, current at stop) of a current."""
    apart = np.diff(time)
    moving = np.flatnonzero(apart > 0)
    slopes = np.diff(current)[moving] / apart[moving]
    # Relative to both neighbors: relative to the largest, a steep edge would hide all other bends.
    size = np.maximum(np.abs(slopes[1:]), np.abs(slopes[:-1]))
    jumps = current[moving[1:]] != current[moving[:-1] + 1]
    bends = np.flatnonzero((np.abs(np.diff(slopes)) > _STRAIGHT * size) | jumps) + 1
    ends = itertools.pairwise([0, *bends.tolist(), len(moving)])
    spans = [(moving[first], moving[last - 1] + 1) for first, last in ends]
    return [(float(time[a]), float(time[b]), current[a], current[b]) for a, b in spans]
