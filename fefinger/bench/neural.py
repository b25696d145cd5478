"""How fast and how exactly 1000 afferents fire: ramp and hold, rates / 6, 1 s."""

import os
import time
import tracemalloc
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fefinger.bench import Figure, Progress
from fefinger.neural.membranes import HodgkinHuxley, IntegrateAndFire


UNITS, REPEATS, EXACT = 1000, 15, 16
"""Afferents; runs of each method in turn, of which the fastest counts; units that the adaptive
method integrates too."""

TOLERANCE = 5e-5

DIVISOR = 6.0

TIME = np.linspace(0.0, 1.0, 1001)

BASELINE, FAST = "plain Runge-Kutta 0.05 ms", "splitting, tolerance 0.05 ms"
CHEAP = "integrate-and-fire"

Spikes = list[NDArray[np.float64]]


def currents(units: int) -> NDArray[np.float64]:
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


def plain(current: NDArray[np.float64], *, exponential: bool) -> Spikes:
    """Fire by a plain loop at 0.05 ms, its units shared among a thread per core."""
    from fefinger.bench import _plain

    rest = HodgkinHuxley(DIVISOR).rest()

    def unit(i: int) -> NDArray[np.float64]:
        spikes = np.empty(2000)
        column = np.ascontiguousarray(current[:, i])
        n = _plain.integrate(1e3 * TIME, column, 0.05, exponential, DIVISOR, rest, spikes)
        return 1e-3 * spikes[:n]

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(unit, range(current.shape[1])))


def methods() -> dict[str, Callable[[NDArray[np.float64]], Spikes]]:
    """Return what is timed, by name."""
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
    """Return how long each method takes; they take turns, so that a busy machine slows them all."""
    current, todo = currents(UNITS), methods()
    found = {name: Timing(np.inf, np.inf, fire(current[:, :40])) for name, fire in todo.items()}
    for repeat in range(REPEATS):
        progress("neural", repeat / (REPEATS + 2))
        for name, fire in todo.items():
            best, started, used = found[name], time.perf_counter(), time.process_time()
            best.spikes = fire(current)
            best.wall = min(best.wall, time.perf_counter() - started)
            best.core = min(best.core, time.process_time() - used)
    return found


def speeds(found: dict[str, Timing]) -> list[Figure]:
    """Return wall time and units per core, against the plain loop."""
    base, figures = found[BASELINE], []
    for name, each in found.items():
        figures.append(Figure(f"{name}: wall", each.wall, "s", base.wall))
        rate, plainly = UNITS / each.core, UNITS / base.core
        figures.append(Figure(f"{name}: speed", rate, "unit-s per core-s", plainly))
    cheap, cheapest = found[CHEAP].wall, found[FAST].wall
    figures.append(Figure(f"{CHEAP}: wall, against {FAST}", cheap, "s", cheapest))
    return figures


def errors(found: dict[str, Timing], fine: Spikes) -> list[Figure]:
    """Return the errors of Hodgkin-Huxley spike times, against those of the plain loop."""
    base, figures = compare(found[BASELINE].spikes, fine), []
    for name in (name for name in found if name != CHEAP):
        error = compare(found[name].spikes, fine)
        figures += [
            Figure(f"{name}: median spike-time error", error.median, "ms", base.median),
            Figure(f"{name}: worst spike-time error", error.worst, "ms", base.worst),
            Figure(f"{name}: units miscounted", error.miscounted, f"of {UNITS}", base.miscounted),
        ]
    return figures


def figures(progress: Progress) -> list[Figure]:
    """Return speed and errors of each method, memory, and the load of the machine at the start."""
    load = os.getloadavg()[0]
    found = timed(progress)
    progress("neural", REPEATS / (REPEATS + 2))
    slowed, current = HodgkinHuxley(DIVISOR), currents(UNITS)
    fine = list(slowed.fire(TIME, current, dt=5e-6, stimulus_driven=False).times)
    some = np.linspace(0, UNITS - 1, EXACT).astype(int)
    exact = slowed.fire(TIME, current[:, some], method="adaptive", stimulus_driven=False).times
    check = compare([fine[i] for i in some], list(exact))
    tracemalloc.start()
    slowed.fire(TIME, current, tolerance=TOLERANCE, stimulus_driven=False)
    memory = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    progress("neural", 1.0)
    return [
        *speeds(found),
        *errors(found, fine),
        Figure("reference against order 8: worst spike-time error", check.worst, "ms"),
        Figure("reference against order 8: units miscounted", check.miscounted, f"of {EXACT}"),
        Figure(f"{FAST}: memory beside its input", memory, "MB"),
        Figure("load average of the minute before", load, "processes"),
    ]
