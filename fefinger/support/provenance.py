"""Provenance of a result: version, commit, libraries, system and date."""

import subprocess
from functools import cache
from pathlib import Path


PACKAGES = ("numpy", "scipy", "scikit-fem", "numba")
"""Libraries that the numbers depend on."""


@cache
def commit() -> str:
    """Return the git commit of the source tree that runs; "" unless the tree is a repository.

    A repository around an installation does not count.
    """
    tree = Path(__file__).resolve().parents[2]
    try:
        top = _git(tree, "rev-parse", "--show-toplevel")
        if top and Path(top).resolve() == tree:
            return _git(tree, "describe", "--always", "--dirty")
    except OSError:  # no git
        pass
    return ""


def _git(tree: Path, *arguments: str) -> str:
    done = subprocess.run(
        ["git", *arguments], cwd=tree, capture_output=True, text=True, check=False
    )
    return done.stdout.strip()


def software() -> dict[str, object]:
    """Return version, commit, Python, system and libraries, and the date in UTC."""
    import platform
    from datetime import UTC, datetime
    from importlib.metadata import version

    from fefinger.support import VERSION

    return {
        "fefinger": VERSION,
        "commit": commit(),
        "python": platform.python_version(),
        "system": platform.platform(),
        "packages": {package: version(package) for package in PACKAGES},
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }
