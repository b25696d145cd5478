"""Speed of this machine relative to the one of the reports, and the provenance of a result.

The measure of speed is the CPU time of one fixed piece of work, taken once and kept in the user's
cache. Reports hold the time of the machine that measured them as `machine_seconds`.
"""

import functools
import hashlib
import platform
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fefinger.support import cache


REPORTED = 0.068
"""Seconds of the work on the machine of the reports, for those that do not say."""

_unkept: dict[str, Any] = {}
"""What was measured here and could not be kept: `seconds`, and the `reason`."""

ROUNDS = 5
"""Times that the work is done; the fastest counts."""


FILE = "seconds.txt"
"""File of the cached time."""


def kept_path() -> Path:
    """Return the folder of the benchmark time of this machine in the user's cache."""
    return cache.root() / "machine" / hashlib.sha256(_name().encode()).hexdigest()[:16]


def measure() -> float:
    """Return the CPU time in s of the work: dense factors, gathered sums and plain loops.

    BLAS has one thread: CPU time counts the others, also while they wait.
    """
    from threadpoolctl import threadpool_limits

    rng = np.random.default_rng(1)
    dense = rng.random((500, 500)) + 500 * np.eye(500)
    where, values = rng.integers(0, 100_000, 1_000_000), rng.random(1_000_000)
    taken = []
    with threadpool_limits(1, user_api="blas"):
        for _ in range(ROUNDS):
            started = time.process_time()
            for _ in range(4):
                np.linalg.inv(dense)
            np.bincount(where, values[where], minlength=100_000)
            total = 0.0
            for number in range(300_000):
                total += 0.5 * number
            taken.append(time.process_time() - started)
    return min(taken)


def seconds() -> float:
    """Return the benchmark time of this machine, from the cache or measured and then cached."""
    before = known()
    if before is not None:
        return before
    measured = measure()
    try:
        with cache.appearing(kept_path(), f"speed of the machine {_name()}") as new:
            (new / FILE).write_text(repr(measured), encoding="utf-8")
    except OSError as error:  # without a cache another process measures it again
        _unkept.update(seconds=measured, reason=error.strerror or str(error))
    return measured


def known() -> float | None:
    """Return the benchmark time of this machine if it was measured before, else None."""
    cached = kept()
    return _unkept.get("seconds") if cached is None else cached


def kept() -> float | None:
    """Return the cached time of this machine, or None."""
    return cache.load(
        kept_path(), lambda folder: float((folder / FILE).read_text(encoding="utf-8"))
    )


def slowness(report: Mapping[str, Any]) -> float:
    """Return by what the times of a report are to be multiplied on this machine; 1 if not known."""
    here = known()
    return 1.0 if here is None else here / float(report.get("machine_seconds", REPORTED))


def sentence() -> str:
    """Return the sentence on the machine that expected times are for."""
    here = known()
    if here is None:
        return (
            "Times are those of the machine of the reports; `fefinger explain` measures this one."
        )
    where = f"kept in {kept_path()}"
    if kept() is None:
        where = f"measured again every time, as {kept_path()} cannot be written: "
        where += _unkept["reason"]
    return (
        f"Times are for this machine, {REPORTED / here:.2g} times as fast as that of the reports "
        f"({where})."
    )


def _name() -> str:
    return f"{platform.node()} {platform.machine()} {platform.processor()} numpy {np.__version__}"


PACKAGES = ("numpy", "scipy", "scikit-fem", "numba")
"""Libraries that the numbers depend on."""


@functools.cache
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
