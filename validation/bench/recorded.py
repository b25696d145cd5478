"""Speed of the afferents `recorded`: whole series, and in a loop with a finger at 1 kHz."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from time import perf_counter, process_time

import numpy as np
from fefinger.validation.bench import condensed
from fefinger.validation.bench.suites import Figure, Progress
from fefinger.validation.bench.timing import Clock, fastest, load, timed
from fefinger.validation.problems import published

from fefinger.neural.recorded import fitted, simulate_recorded
from fefinger.neural.streaming import RecordedAfferents
from fefinger.neural.variation import Variation
from fefinger.support.arrays import Array
from fefinger.support.processes import one_thread


SHARES = {"SAI": 290, "SAII": 25, "FAI": 580, "FAII": 105}
"""Units of each type: a thousand, in the proportions of the fingertip."""

TIME = np.linspace(0.0, 1.0, 1001)

REPEATS = 40
"""Runs, of which the fastest counts."""


def figures(progress: Progress) -> list[Figure]:
    """Measure wall seconds of 1000 units for 1 s, and milliseconds of a step with a finger."""
    busy = load()
    rows = series()
    progress("recorded", 0.3)
    rows += _loop()
    progress("recorded", 1.0)
    return [*rows, busy]


def inputs() -> tuple[tuple[str, ...], Array]:
    """Return types (n,), and inputs (n_t, n) mm: a press of 0.5 mm, and 20 Hz upon it."""
    types = tuple(kind for kind, count in SHARES.items() for _ in range(count))
    wave = 0.5 * np.minimum(TIME / 0.05, 1.0) + 0.05 * np.sin(2 * np.pi * 20.0 * TIME)
    return types, np.outer(wave, np.linspace(0.3, 1.0, len(types)))


def series() -> list[Figure]:
    """Time whole series, against the same units stepped one after another."""
    types, x = inputs()
    vary = Variation(seed=1, spread=None, noise=None)
    run = partial(simulate_recorded, TIME, x, types=types, variation=vary)
    single, name = partial(run, check=False), f"{len(types)} units for 1 s"
    return [
        Figure(f"{name}: wall", _fastest(single, REPEATS), "s", _stepped(types, x)),
        Figure(f"{name}: processor", _fastest(single, REPEATS, process_time), "s"),
        Figure(f"{name}, with the check of steps and samples: wall", _fastest(run, 9), "s"),
        Figure(f"{name}: spikes", float(run(check=False).count().sum()), "1"),
    ]


def _stepped(types: tuple[str, ...], x: Array) -> float:
    """Seconds of the same units in steps of 1 ms, as in a loop: one after another."""
    table = fitted()
    units = RecordedAfferents(types, np.tile([0.0, 0.0, -1.0], (len(types), 1)), seed=1)
    strain = np.zeros((*x.shape, 6))
    for i, kind in enumerate(types):
        unit = table[kind]
        if unit.drive == "compressive":
            strain[:, i, 2] = -x[:, i] / unit.length
        else:
            strain[:, i, 0] = x[:, i] / unit.length
    return timed(lambda: [units.step(row, TIME[1]) for row in strain], perf_counter)[1]


@one_thread
def _loop() -> list[Figure]:
    """Time contact, strain at 1000 end organs and spikes in steps of 1 ms."""
    finger = replace(published.load("flat-press").finger, resolution="standard")
    sites = condensed.end_organs(condensed.pressed(finger))
    return condensed.spiking(
        condensed.placed(finger, sites, "single"), "recorded", family="recorded"
    )


def _fastest(work: Callable[[], object], repeats: int, clock: Clock = perf_counter) -> float:
    work()  # compiles
    return fastest(work, repeats, clock)[1]
