"""Reports of measurements in `reports/`: their provenance, their format, their numbers."""

import json
import platform
import sys
from collections.abc import Iterable
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fefinger.support import machine
from fefinger.support.atomic_write import moved
from fefinger.support.machine import commit


def provenance(command: str) -> dict[str, Any]:
    """Return the command, the commit (empty if unknown), date, machine, its speed, versions."""
    return {
        "command": command,
        "commit": commit(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": f"{platform.machine()}, Python {platform.python_version()}",
        "machine_seconds": machine.seconds(),
        "versions": {name: version(name) for name in ("fefinger", "numpy", "scipy", "scikit-fem")},
    }


def save(path: Path, report: dict[str, Any], arguments: str = "reports") -> None:
    """Write a report of the module that runs, behind its provenance, as one line of JSON.

    Without spaces, as `reports/` has a limited size. arguments: those of the command that makes all
    of it.
    """
    module = sys.modules["__main__"].__spec__
    name = module.name if module is not None else "fefinger"
    record = provenance(f"python -m {name} {arguments}") | report
    with moved(path) as new:
        text = json.dumps(record, separators=(",", ":"), allow_nan=False)
        new.write_text(text + "\n", encoding="utf-8")


def saved(path: Path) -> dict[str, Any]:
    """Return a report that was saved before; it is empty where there is none."""
    return dict(json.loads(path.read_text(encoding="utf-8"))) if path.exists() else {}


def short(values: Iterable[float], digits: int = 4) -> list[float]:
    """Round numbers to so many digits, for a report."""
    return [float(f"{value:.{digits}g}") for value in values]
