"""Measure what the operator of `condensed` costs and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence_condensed reports`; it takes about five minutes.
"""

import json
import os
import resource
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from fefinger.validation.provenance import provenance

from fefinger import scenes
from fefinger.mechanics import condensed
from fefinger.mechanics._evidence import CONDENSED_REPORT
from fefinger.records import Response


def measure(resolution: str) -> tuple[Response, float]:
    """Return the response to flat-press on a resolution, and its wall time in s."""
    started = time.perf_counter()
    response = condensed.respond(scenes.load("flat-press", {"finger.resolution": resolution}))
    return response, time.perf_counter() - started


def report(resolutions: tuple[str, ...] = ("coarse", "standard", "fine")) -> dict[str, Any]:
    """Return the cost of half a finger for every resolution: first built, then at hand."""
    rows = {}
    with tempfile.TemporaryDirectory() as cache:
        os.environ["XDG_CACHE_HOME"] = cache
        measure("coarse")  # compiles
        for resolution in resolutions:
            rows[resolution] = _row(resolution, Path(cache))
    return {
        **provenance("python -m fefinger.validation.evidence_condensed reports"),
        "scene": "flat-press",
        "resolutions": rows,
    }


def _row(resolution: str, cache: Path) -> dict[str, Any]:
    """Build the operator again, and use it again."""
    shutil.rmtree(cache / "fefinger")
    built, _ = measure(resolution)
    size = sum(file.stat().st_size for file in cache.rglob("*.npy"))
    again, seconds = measure(resolution)
    return {
        "build_seconds": round(built.seconds["factor"] - again.seconds["factor"], 3),
        "setup_seconds": round(seconds - again.seconds["contact"], 3),
        "step_seconds": round(again.seconds["contact"] / len(again.time), 7),
        "stages": {name: round(value, 3) for name, value in again.seconds.items()},
        "cache_MB": size // 2**20,
        "memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
    }


if __name__ == "__main__":
    target = Path(sys.argv[1]) / CONDENSED_REPORT
    target.write_text(json.dumps(report(), indent=1) + "\n", encoding="utf-8")
    print(target.read_text(encoding="utf-8"))
