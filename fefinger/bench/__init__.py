"""Benchmarks: what is fast, by how much, against what, measured in one run.

A suite is a module of this package with `figures(progress)`. Nothing here is a test: a time is
never checked.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any

from fefinger.checks import choice


SUITES = ("neural",)

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Figure:
    """A measured number beside the one to compare it with, None where there is none."""

    name: str
    value: float
    unit: str
    baseline: float | None = None

    @property
    def ratio(self) -> float | None:
        """`value` over `baseline`, None without a baseline or where that is zero."""
        return self.value / self.baseline if self.baseline else None


def run(suites: Sequence[str] = (), *, progress: Progress = lambda stage, part: None) -> Any:
    """Measure the suites (all by default); return the record that `bench --json` prints."""
    chosen = [choice("suite", suite, SUITES) for suite in suites] or list(SUITES)
    modules = [import_module(f"fefinger.bench.{suite}") for suite in chosen]
    figures = [figure for module in modules for figure in module.figures(progress)]
    return {"figures": [asdict(figure) | {"ratio": figure.ratio} for figure in figures]}
