"""Stages of long work: their wall time, and their progress."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from fefinger.records import Progress


class Stages:
    """Collects the seconds of named stages and reports their progress."""

    def __init__(self, progress: Progress | None = None) -> None:
        self.seconds: dict[str, float] = {}
        self._progress = progress

    @contextmanager
    def stage(self, name: str) -> Iterator[Callable[[float], None]]:
        """Time a stage; yields a function that takes the fraction done."""

        def report(fraction: float) -> None:
            if self._progress is not None:
                self._progress(name, fraction)

        started = time.perf_counter()
        report(0.0)
        yield report
        report(1.0)
        self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - started
