"""Benchmark suites by name, and their records: ratios measured in one run.

A suite is a module of this package with `figures(progress)`. Nothing here is a test: a time is
never checked.
"""

import json
import os
import platform
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fefinger.support.atomic_write import moved
from fefinger.support.checks import choice
from fefinger.support.machine import commit


SUITES = (
    "fem",
    "solid",
    "pressed",
    "condensed",
    "modal",
    "neural",
    "recorded",
    "sliding",
    "tactile",
)

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


def run(
    suites: Sequence[str] = (), *, progress: Progress = lambda stage, part: None
) -> dict[str, list[Figure]]:
    """Measure the suites, all of them by default."""
    chosen = [choice("suite", suite, SUITES) for suite in suites] or list(SUITES)
    modules = {suite: import_module(f"fefinger.validation.bench.{suite}") for suite in chosen}
    return {suite: module.figures(progress) for suite, module in modules.items()}


def as_json(figures: Iterable[Figure]) -> dict[str, Any]:
    """Return figures as plain records, in the form that `bench --json` prints."""
    return {"figures": [asdict(figure) | {"ratio": figure.ratio} for figure in figures]}


def write(suite: str, figures: Iterable[Figure], folder: Path) -> Path:
    """Write bench-SUITE.json, with command, commit, machine and versions; return its path."""
    record = {
        "command": f"fefinger bench {suite} -o {folder.name}",
        "commit": commit(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "versions": {name: version(name) for name in ("fefinger", "numba", "numpy", "scipy")},
        **as_json(figures),
    }
    path = folder / f"bench-{suite}.json"
    with moved(path) as new:
        new.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    return path
