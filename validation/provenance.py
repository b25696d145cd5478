"""Provenance of the numbers in `reports/`, and their format."""

import json
import platform
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

from fefinger.mechanics.evidence import machine
from fefinger.support.provenance import commit


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


def compact(report: Any) -> str:
    """Format a report as one line of JSON, without spaces: `reports/` has a limited size."""
    return json.dumps(report, separators=(",", ":"), allow_nan=False) + "\n"
