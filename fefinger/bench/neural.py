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

TIME = np.array([0.0, 0.5, 1.0])

Spikes = list[NDArray[np.float64]]


def currents(units: int) -> NDArray[np.float64]:
    """Return (3, units) uA/cm²: 0.5 s of ramp to 2 to 60, held for 0.5 s."""
    return np.outer([0.0, 1.0, 1.0], np.linspace(2.0, 60.0, units))


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
    """Return what is timed, by name; the first is what the others are compared with."""
    slowed, cheap = HodgkinHuxley(DIVISOR), IntegrateAndFire()
    return {
        "plain Runge-Kutta 0.05 ms": lambda current: plain(current, exponential=False),
        "plain exponential Euler 0.05 ms": lambda current: plain(current, exponential=True),
        "splitting, tolerance 0.05 ms": lambda current: list(
            slowed.fire(TIME, current, tolerance=TOLERANCE, stimulus_driven=False).times
        ),
        "Runge-Kutta 0.05 ms": lambda current: list(
            slowed.fire(TIME, current, method="runge-kutta", stimulus_driven=False).times
        ),
        "integrate-and-fire": lambda current: list(cheap.fire(TIME, current).times),
    }


def memory(tolerance: float) -> float:
    """Return the most MB allocated while UNITS with 1000 samples each fire."""
    at = np.linspace(TIME[0], TIME[-1], 1000)
    current = np.outer(np.interp(at, TIME, [0.0, 1.0, 1.0]), np.linspace(2.0, 60.0, UNITS))
    tracemalloc.start()
    HodgkinHuxley(DIVISOR).fire(at, current, tolerance=tolerance, stimulus_driven=False)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def figures(progress: Progress) -> list[Figure]:
    """Return wall and core time of each method, its errors, and the load of the machine."""
    current, todo = currents(UNITS), methods()
    wall = dict.fromkeys(todo, np.inf)
    core = dict.fromkeys(todo, np.inf)
    spikes = {name: fire(current[:, :40]) for name, fire in todo.items()}  # compiles
    for repeat in range(REPEATS):
        progress("neural", repeat / (REPEATS + 2))
        for name, fire in todo.items():
            started, used = time.perf_counter(), time.process_time()
            spikes[name] = fire(current)
            wall[name] = min(wall[name], time.perf_counter() - started)
            core[name] = min(core[name], time.process_time() - used)
    progress("neural", REPEATS / (REPEATS + 2))
    slowed = HodgkinHuxley(DIVISOR)
    fine = list(slowed.fire(TIME, current, dt=5e-6, stimulus_driven=False).times)
    some = np.linspace(0, UNITS - 1, EXACT).astype(int)
    adaptive = slowed.fire(TIME, current[:, some], method="adaptive", stimulus_driven=False)
    exact = list(adaptive.times)
    progress("neural", 1.0)
    first = next(iter(todo))
    found = []
    for name in todo:
        found.append(Figure(f"{name}: wall", wall[name], "s", wall[first]))
        rates = (UNITS * TIME[-1] / core[each] for each in (name, first))
        found.append(Figure(f"{name}: speed", next(rates), "unit-s per core-s", next(rates)))
    base = compare(spikes[first], fine)
    for name in list(todo)[:-1]:
        error = compare(spikes[name], fine)
        found += [
            Figure(f"{name}: median spike-time error", error.median, "ms", base.median),
            Figure(f"{name}: worst spike-time error", error.worst, "ms", base.worst),
            Figure(f"{name}: units miscounted", error.miscounted, f"of {UNITS}", base.miscounted),
        ]
    check = compare([fine[i] for i in some], exact)
    found.append(Figure("reference against order 8: worst spike-time error", check.worst, "ms"))
    found.append(Figure("reference against order 8: miscounted", check.miscounted, f"of {EXACT}"))
    hh = "splitting, tolerance 0.05 ms"
    found.append(
        Figure(f"integrate-and-fire: wall, against {hh}", wall["integrate-and-fire"], "s", wall[hh])
    )
    found.append(Figure(f"{hh}: memory beside its input", memory(TOLERANCE), "MB"))
    found.append(Figure("load average of the last minute", os.getloadavg()[0], "processes"))
    return found
