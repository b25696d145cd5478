"""Wall time, peak memory and progress reports of the stages of a computation."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Protocol

from fefinger.support.checks import InputError, shown


class Progress(Protocol):
    """Callback for progress: the name of a stage and the fraction of it that is done."""

    def __call__(self, stage: str, fraction: float) -> None:
        """Report that `fraction` (0 to 1) of `stage` is done."""


class Stages:
    """Collects the seconds and the memory of named stages and reports their progress."""

    def __init__(self, progress: Progress | None = None) -> None:
        if progress is not None and not callable(progress):
            raise InputError(
                "progress: expected a function of the name of a stage and the fraction done, "
                f"received {shown(progress)}"
            )
        self.seconds: dict[str, float] = {}
        self.megabytes: dict[str, float] = {}
        self._progress = progress

    @contextmanager
    def stage(self, name: str) -> Iterator[Callable[[float], None]]:
        """Time a stage; yield a function that reports the fraction done."""

        def report(fraction: float) -> None:
            if self._progress is not None:
                self._progress(name, fraction)

        started = time.perf_counter()
        report(0.0)
        yield report
        report(1.0)
        self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - started
        with suppress(ImportError):  # Windows
            import resource

            unit = 1024**2 if sys.platform == "darwin" else 1024
            self.megabytes[name] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit

    @property
    def memory(self) -> str:
        """The peak memory of the process by the end of every stage, in words."""
        peaks = [f"{name} {peak:.0f}" for name, peak in self.megabytes.items()]
        if not peaks:
            return "not measured"
        return f"peak of the process in MB, by stage: {', '.join(peaks)}"
