"""Where a number that is kept in `reports/` comes from."""

import platform
import subprocess
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fefinger import machine


def provenance(command: str) -> dict[str, Any]:
    """Return the command, the commit (empty if unknown), date, machine, its speed, versions."""
    asked = ["git", "describe", "--always", "--dirty"]
    here = Path(__file__).parent
    described = subprocess.run(asked, cwd=here, capture_output=True, text=True, check=False)
    return {
        "command": command,
        "commit": described.stdout.strip(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": f"{platform.machine()}, Python {platform.python_version()}",
        "machine_seconds": machine.seconds(),
        "versions": {name: version(name) for name in ("fefinger", "numpy", "scipy", "scikit-fem")},
    }
