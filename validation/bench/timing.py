"""Seconds of a piece of work by a clock, and of each of many steps."""

import os
import time
from collections.abc import Callable, Iterable
from typing import TypeVar

import numpy as np
from fefinger.validation.bench.suites import Figure

from fefinger.support.arrays import Array


Clock = Callable[[], float]
In = TypeVar("In")
Out = TypeVar("Out")


def timed(work: Callable[[], Out], clock: Clock = time.process_time) -> tuple[Out, float]:
    """Run `work`; return its result, and its seconds by a clock: of the processor by default."""
    started = clock()
    answer = work()
    return answer, clock() - started


def fastest(
    work: Callable[[], Out], repeats: int, clock: Clock = time.process_time
) -> tuple[Out, float]:
    """Run `work` several times; return its last result, and the seconds of the fastest run."""
    runs = [timed(work, clock) for _ in range(repeats)]
    return runs[-1][0], min(seconds for _, seconds in runs)


def of_each(
    step: Callable[[In], object], inputs: Iterable[In], clock: Clock = time.thread_time
) -> Array:
    """Return the milliseconds (n,) of every step: by default of the processor, of this thread."""
    spent = []
    for given in inputs:
        started = clock()
        step(given)
        spent.append(1e3 * (clock() - started))
    return np.array(spent)


def quantiles(name: str, spent: Array, clock: str = "processor") -> list[Figure]:
    """Return the median and the 99th percentile of the milliseconds (n,) of steps."""
    median, slow = np.quantile(spent, (0.5, 0.99)).tolist()
    return [
        Figure(f"{name}: step, median, {clock}", median, "ms"),
        Figure(f"{name}: step, 99th percentile, {clock}", slow, "ms"),
    ]


def load() -> Figure:
    """Return how busy the machine was in the minute before."""
    return Figure("load average of the minute before", os.getloadavg()[0], "processes")
