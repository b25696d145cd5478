"""Adaptive Hodgkin-Huxley integration of order 8 (DOP853): reference for the other methods."""

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from fefinger.neural.membranes.equations import REARM_MV, SPIKE_MV, slope
from fefinger.neural.membranes.firing import Run
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError, InputError


_RTOL, _ATOL = 1e-10, 1e-12

_STRAIGHT = 1e-12
"""Relative change of slope below which three samples lie on one line."""

_JUMP = 10.0
"""Intervals up to so many floating-point spacings are jumps: the solver takes no shorter steps."""

MOST = 1_000_000
"""Number of straight pieces from which a current is rejected: each takes about a millisecond."""


def integrate(
    time: Array,
    slow: float,
    frozen: bool,
    rest: Array,
    block: tuple[float, float, float],
    current: Array,
) -> Run:
    """Integrate one unit, current (n_t, 1); results as in `vectorized.integrate`.

    The solver restarts at every kink of the current; peak and block are read at the ends of steps.
    InputError for MOST straight pieces or more, ConvergenceError where the solver gives up.
    """
    m_rate_factor = 0.0 if frozen else 1.0
    y, step, armed, above, peak, blocked = rest, None, True, 0.0, float(rest[0]), 0.0
    spikes: list[float] = []
    for t0, t1, i0, i1 in _straight(time, current[:, 0]):
        rate = (i1 - i0) / (t1 - t0)

        def rise(
            t: float, y: Array, t0: float = t0, i0: float = i0, rate: float = rate
        ) -> tuple[float, float, float, float]:
            return slope(y[0], y[1], y[2], y[3], i0 + rate * (t - t0), slow, m_rate_factor)

        first = None if step is None else min(step, t1 - t0)
        solver = DOP853(rise, t0, y, t1, first_step=first, max_step=5.0, rtol=_RTOL, atol=_ATOL)
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                msg = f"membrane: the adaptive integration stopped at {solver.t:g} ms: {message}"
                raise ConvergenceError(msg)
            v, high = solver.y[0], i0 + rate * (solver.t_old - t0) > block[1]
            above = above + solver.step_size if high and v > block[0] else 0.0
            if armed and v >= SPIKE_MV:
                inside = solver.dense_output()
                ends = solver.t_old, solver.t
                spikes.append(brentq(lambda t, f=inside: f(t)[0] - SPIKE_MV, *ends, xtol=1e-11))
                armed, above = False, 0.0
            armed = armed or v < REARM_MV
            peak = max(peak, float(v))
            blocked += min(solver.step_size, max(above - block[2], 0.0))
            step = solver.step_size
        y = solver.y
    return [np.array(spikes)], np.array([[*y, peak, blocked]])


def _straight(time: Array, current: Array) -> list[tuple[float, float, float, float]]:
    """Split a current into its longest straight pieces (t0, t1, i0, i1).

    InputError for MOST pieces or more. A jump is a repeated time, or an interval of a few spacings
    of floating point; of several such intervals in a row only the first is skipped, or their sum
    would be lost.
    """
    apart = np.diff(time)
    short = (apart > 0) & (apart <= _JUMP * np.spacing(np.abs(time[1:])))
    short[1:] &= ~short[:-1]
    pieces_at = np.flatnonzero((apart > 0) & ~short)
    if len(pieces_at) == 0:
        return []
    slopes = np.diff(current)[pieces_at] / apart[pieces_at]
    starts, ends = current[pieces_at], current[pieces_at + 1]
    # Relative to both neighbors: relative to the largest, a steep edge would hide all other bends.
    size = np.maximum(np.abs(slopes[1:]), np.abs(slopes[:-1]))
    bends = (np.abs(np.diff(slopes)) > _STRAIGHT * size) | (starts[1:] != ends[:-1])
    first = np.append(0, np.flatnonzero(bends) + 1)
    if len(first) >= MOST:
        raise InputError(
            f"current: expected fewer than {MOST} straight pieces for the adaptive method, "
            f"received {len(first)}; take fewer samples, 'runge-kutta', or a larger tolerance"
        )
    last = np.append(first[1:], len(pieces_at)) - 1
    spans = zip(
        time[pieces_at[first]], time[pieces_at[last] + 1], starts[first], ends[last], strict=True
    )
    return [(float(a), float(b), float(c), float(d)) for a, b, c, d in spans]
