"""Speed and accuracy of 1000 afferents: ramp and hold, and sinusoids, rates / 6, 1 s.

Membranes alone, then the integrators that a requested error of spike times chooses, then the whole
chain from skin displacement to spikes with the memory that it takes. Plain fixed-step integrators,
one unit at a time with library exponentials, are what a compiler makes of the textbook.
"""

import math
import os
import time
import tracemalloc
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from fefinger.validation.bench.suites import Figure, Progress
from fefinger.validation.bench.timing import fastest, load
from fefinger.validation.oracles.membrane import exact
from numpy.typing import NDArray

from fefinger.neural.membranes import HodgkinHuxley, IntegrateAndFire
from fefinger.neural.membranes import equations as squid
from fefinger.support.arrays import Array
from fefinger.support.compiled import njit


UNITS, REPEATS, EXACT = 1000, 15, 16
"""Afferents; runs of each method in turn, of which the fastest counts; units that the adaptive
method integrates too."""

TOLERANCE = 5e-5

TOLERANCES = (1e-3, 1e-4, 5e-5, 1e-5, 1e-7)
"""s: errors of spike times that integrators are chosen by."""

TONES = (2.0, 8.0, 20.0, 64.0)
"""Hz; slower ones are exponentially sensitive near threshold, whatever the method."""

DIVISOR = 6.0

TIME = np.linspace(0.0, 1.0, 1001)

BASELINE, FAST = "plain Runge-Kutta 0.05 ms", "splitting, tolerance 0.05 ms"
CHEAP = "integrate-and-fire"

WALL = time.perf_counter

Spikes = list[Array]


def currents(units: int) -> Array:
    """Return (n_t, units) uA/cm²: 0.5 s of ramp to 2 to 60, held for 0.5 s."""
    return np.outer(np.minimum(2 * TIME, 1.0), np.linspace(2.0, 60.0, units))


@dataclass(frozen=True)
class Error:
    """Spike times against a reference: error in ms, and units whose count is another."""

    median: float
    worst: float
    miscounted: int


def compare(spikes: Spikes, reference: Spikes) -> Error:
    """Return the errors of spike times in s; only equal counts have times to compare.

    Without any the errors are not a number.
    """
    pairs = [(a, b) for a, b in zip(spikes, reference, strict=True) if len(a) == len(b)]
    errors = np.abs(np.concatenate([np.empty(0), *(1e3 * (a - b) for a, b in pairs)]))
    if not len(errors):
        errors = np.array([np.nan])
    return Error(float(np.median(errors)), float(errors.max()), len(spikes) - len(pairs))


def plain(current: Array, *, exponential: bool) -> Spikes:
    """Fire by a plain loop at 0.05 ms, its units shared among a thread per core."""
    rest = HodgkinHuxley(DIVISOR).rest()

    def unit(i: int) -> Array:
        spikes = np.empty(2000)
        column = np.ascontiguousarray(current[:, i])
        n = integrate(1e3 * TIME, column, 0.05, exponential, DIVISOR, rest, spikes)
        return 1e-3 * spikes[:n]

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(unit, range(current.shape[1])))


def methods() -> dict[str, Callable[[Array], Spikes]]:
    """Benchmarked methods by name."""
    slowed, cheap = HodgkinHuxley(DIVISOR), IntegrateAndFire()
    return {
        BASELINE: lambda current: plain(current, exponential=False),
        "plain exponential Euler 0.05 ms": lambda current: plain(current, exponential=True),
        FAST: lambda current: list(
            slowed.fire(TIME, current, tolerance=TOLERANCE, stimulus_driven=False).times
        ),
        "Runge-Kutta 0.05 ms": lambda current: list(
            slowed.fire(TIME, current, method="runge-kutta", stimulus_driven=False).times
        ),
        CHEAP: lambda current: list(cheap.fire(TIME, current).times),
    }


@dataclass
class Timing:
    """The fastest of several runs in seconds of wall and of all cores, and its spike times in s."""

    wall: float
    core: float
    spikes: Spikes


def timed(progress: Progress) -> dict[str, Timing]:
    """Time each method; they run in turns, so that a busy machine slows all alike."""
    current, todo = currents(UNITS), methods()
    timings = {name: Timing(np.inf, np.inf, fire(current[:, :40])) for name, fire in todo.items()}
    for repeat in range(REPEATS):
        progress("neural", repeat / (REPEATS + 2))
        for name, fire in todo.items():
            best, started, used = timings[name], time.perf_counter(), time.process_time()
            best.spikes = fire(current)
            best.wall = min(best.wall, time.perf_counter() - started)
            best.core = min(best.core, time.process_time() - used)
    return timings


def speeds(timings: dict[str, Timing]) -> list[Figure]:
    """Return wall time and units per core, against the plain loop."""
    base, figures = timings[BASELINE], []
    for name, each in timings.items():
        figures.append(Figure(f"{name}: wall", each.wall, "s", base.wall))
        rate, plainly = UNITS / each.core, UNITS / base.core
        figures.append(Figure(f"{name}: speed", rate, "unit-s per core-s", plainly))
    cheap, cheapest = timings[CHEAP].wall, timings[FAST].wall
    figures.append(Figure(f"{CHEAP}: wall, against {FAST}", cheap, "s", cheapest))
    return figures


def errors(timings: dict[str, Timing], fine: Spikes) -> list[Figure]:
    """Return the errors of Hodgkin-Huxley spike times, against the plain loop."""
    base, figures = compare(timings[BASELINE].spikes, fine), []
    for name in (name for name in timings if name != CHEAP):
        error = compare(timings[name].spikes, fine)
        figures += [
            Figure(f"{name}: median spike-time error", error.median, "ms", base.median),
            Figure(f"{name}: worst spike-time error", error.worst, "ms", base.worst),
            Figure(f"{name}: units miscounted", error.miscounted, f"of {UNITS}", base.miscounted),
        ]
    return figures


def swings(units: int) -> Array:
    """Return (n_t, units) uA/cm²: A (1 - cos) / 2 at TONES in turn, A from 2 to 60."""
    tones = np.array(TONES)[np.arange(units) % len(TONES)]
    waves = 0.5 * (1.0 - np.cos(2.0 * np.pi * np.outer(TIME, tones)))
    return np.asarray(waves * np.linspace(2.0, 60.0, units), np.float64)


def sinusoids() -> list[Figure]:
    """Return speed and errors on sinusoids, of the chosen integrator and of Runge-Kutta."""
    current, slowed = swings(UNITS), HodgkinHuxley(DIVISOR)
    fine = list(slowed.fire(TIME, current, dt=5e-6, stimulus_driven=False).times)
    base = fastest(lambda: plain(current, exponential=False), 3, WALL)[1]
    rows = []
    choices: tuple[tuple[str, dict[str, Any]], ...] = (
        (f"sinusoids, {FAST}", {"tolerance": TOLERANCE}),
        ("sinusoids, Runge-Kutta 0.05 ms", {}),
    )
    for label, options in choices:
        fire = partial(slowed.fire, TIME, current, stimulus_driven=False, **options)
        firing, wall = fastest(fire, 3, WALL)
        error = compare(list(firing.times), fine)
        rows += [
            Figure(f"{label}: wall", wall, "s", base),
            Figure(f"{label}: median spike-time error", error.median, "ms"),
            Figure(f"{label}: worst spike-time error", error.worst, "ms"),
            Figure(f"{label}: units miscounted", error.miscounted, f"of {UNITS}"),
        ]
    return rows


def ladder(fine: Spikes) -> list[Figure]:
    """Return, for each requested error, its 95th percentile and the speed of what it chooses."""
    slowed, current, rows = HodgkinHuxley(DIVISOR), currents(UNITS), []
    for tolerance in TOLERANCES:
        method, dt = slowed.integrator(tolerance)
        fire = partial(slowed.fire, TIME, current, tolerance=tolerance, stimulus_driven=False)
        firing, wall = fastest(fire, 3, WALL)
        pairs = [(a, b) for a, b in zip(firing.times, fine, strict=True) if len(a) == len(b)]
        error = 1e3 * float(np.quantile(np.abs(np.concatenate([a - b for a, b in pairs])), 0.95))
        name = f"asked {1e3 * tolerance:g} ms: {method}, {1e6 * dt:.3g} us"
        rows += [
            Figure(f"{name}: 95 % of spike-time errors below", error, "ms"),
            Figure(f"{name}: speed", UNITS / wall, "unit-s per s"),
        ]
    return rows


def chain() -> list[Figure]:
    """Return speed and memory from skin displacement to spikes, units of all four types."""
    from fefinger.neural.afferent_units import simulate_units

    types = tuple(np.tile(("SAI", "SAII", "FAI", "FAII"), UNITS // 4).tolist())
    press = np.outer(np.clip(TIME / 0.05, 0.0, 1.0), np.linspace(0.1, 1.5, len(types)))
    run = partial(simulate_units, TIME, press, types=types, check=False)
    _, wall = fastest(run, 3, WALL)
    return [
        Figure("skin to spikes: wall", wall, "s"),
        Figure("skin to spikes: memory beside its input", held(run), "MB"),
    ]


def held(work: Callable[[], object]) -> float:
    """Return the most memory in MB that work holds at a time."""
    tracemalloc.start()
    work()
    memory = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    return memory


def figures(progress: Progress) -> list[Figure]:
    """Return speed and errors of each method, memory, and the load of the machine at the start."""
    busy = load()
    timings = timed(progress)
    progress("neural", REPEATS / (REPEATS + 2))
    slowed, current = HodgkinHuxley(DIVISOR), currents(UNITS)
    fine = list(slowed.fire(TIME, current, dt=5e-6, stimulus_driven=False).times)
    some = np.linspace(0, UNITS - 1, EXACT).astype(int)
    order8 = [each.times for each in exact(slowed, TIME, current[:, some])]
    check = compare([fine[i] for i in some], order8)
    memory = held(partial(slowed.fire, TIME, current, tolerance=TOLERANCE, stimulus_driven=False))
    progress("neural", 1.0)
    return [
        *speeds(timings),
        *errors(timings, fine),
        *sinusoids(),
        *ladder(fine),
        *chain(),
        Figure("reference against order 8: worst spike-time error", check.worst, "ms"),
        Figure("reference against order 8: units miscounted", check.miscounted, f"of {EXACT}"),
        Figure(f"{FAST}: memory beside its input", memory, "MB"),
        busy,
    ]


State = tuple[float, float, float, float]


@njit(cache=True)
def _exponential_euler(y: State, dt: float, current: float, slow: float) -> State:
    """Relax each variable exactly with all others held at the start of the step: first order."""
    v, n, m, h = y
    a_n, b_n, a_m, b_m, a_h, b_h = squid.rates(v)
    g_k, g_na = squid.G_K * n * n * n * n, squid.G_NA * m * m * m * h
    total = g_k + g_na + squid.G_LEAK
    end = (current + g_k * squid.V_K + g_na * squid.V_NA + squid.G_LEAK * squid.V_LEAK) / total
    n_end, m_end, h_end = a_n / (a_n + b_n), a_m / (a_m + b_m), a_h / (a_h + b_h)
    return (
        end + (v - end) * math.exp(-total * dt / squid.CAPACITANCE),
        n_end + (n - n_end) * math.exp(-slow * (a_n + b_n) * dt),
        m_end + (m - m_end) * math.exp(-slow * (a_m + b_m) * dt),
        h_end + (h - h_end) * math.exp(-slow * (a_h + b_h) * dt),
    )


@njit(cache=True, nogil=True)
def integrate(
    time: NDArray[np.float64],
    current: NDArray[np.float64],
    dt_max: float,
    exponential: bool,
    divisor: float,
    rest: NDArray[np.float64],
    spikes: NDArray[np.float64],
) -> int:
    """Fill `spikes` with the crossing times in ms of one unit; return their number.

    time (n_t,) ms, current (n_t,) uA/cm² linear in between, Runge-Kutta unless `exponential`.
    """
    slow, y, armed, count = 1.0 / divisor, (rest[0], rest[1], rest[2], rest[3]), True, 0
    for k in range(len(time) - 1):
        interval = time[k + 1] - time[k]
        steps = math.ceil(interval / dt_max - 1e-9)
        for j in range(steps):
            dt, per_step = interval / steps, (current[k + 1] - current[k]) / steps
            start = current[k] + j * per_step
            k1 = squid.slope(y[0], y[1], y[2], y[3], start, slow, 1.0)
            if exponential:
                new = _exponential_euler(y, dt, start, slow)
            else:
                new = squid.step(y, k1, dt, start + 0.5 * per_step, start + per_step, slow, 1.0)
            if armed and new[0] >= squid.SPIKE_MV:
                d1 = squid.slope(new[0], new[1], new[2], new[3], start + per_step, slow, 1.0)[0]
                spikes[count] = time[k] + dt * (j + squid.crossing(y[0], new[0], k1[0], d1, dt))
                count += 1
                armed = False
            elif new[0] < squid.REARM_MV:
                armed = True
            y = new
    return count
