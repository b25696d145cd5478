"""What made a result: version, commit, libraries, system and date."""

import subprocess
from functools import cache
from pathlib import Path
from typing import Any


PACKAGES = ("numpy", "scipy", "scikit-fem", "numba")
"""Libraries that the numbers depend on."""


@cache
def commit() -> str:
    """Return the commit of the source tree that runs; empty where it is in no repository.

    One that has the program installed somewhere inside is not meant.
    """
    tree = Path(__file__).resolve().parents[2]
    try:
        found = _git(tree, "rev-parse", "--show-toplevel")
        known = found and Path(found).resolve() == tree
        return _git(tree, "describe", "--always", "--dirty") if known else ""
    except OSError:  # no git
        return ""


def _git(tree: Path, *asked: str) -> str:
    done = subprocess.run(["git", *asked], cwd=tree, capture_output=True, text=True, check=False)
    return done.stdout.strip()


def software() -> dict[str, Any]:
    """Return version, commit, Python, system and libraries, and the date in UTC."""
    import platform
    from datetime import UTC, datetime
    from importlib.metadata import version

    from fefinger.support.version import VERSION

    return {
        "fefinger": VERSION,
        "commit": commit(),
        "python": platform.python_version(),
        "system": platform.platform(),
        "packages": {package: version(package) for package in PACKAGES},
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }
