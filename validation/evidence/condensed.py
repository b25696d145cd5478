"""Measure what `condensed` costs and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence.condensed reports`; it takes a quarter of a minute
for the coarse and the standard mesh, of building and area by the scenes of development
(`scene_costs.py`); costs of the fine mesh are taken to this machine. With `all` behind it, the fine
mesh is measured too, in five minutes.
"""

import json
import resource
import shutil
import sys
import time
from pathlib import Path
from typing import Any

from fefinger.validation.empty_cache import empty_cache
from fefinger.validation.evidence.linear import TIMED, costs, timed
from fefinger.validation.evidence.scene_costs import setup_and_area
from fefinger.validation.problems import published
from fefinger.validation.provenance import compact, provenance

from fefinger.mechanics import condensed
from fefinger.mechanics.evidence.table import CONDENSED
from fefinger.results.records import Response
from fefinger.support.package_data import report as reported


RESOLUTIONS = ("coarse", "standard", "fine")


def measure(resolution: str) -> tuple[Response, float]:
    """Return the response to flat-press on a resolution, and its CPU time in s."""
    started = time.process_time()
    response = condensed.respond(published.load("flat-press", {"finger.resolution": resolution}))
    return response, time.process_time() - started


def report(resolutions: tuple[str, ...] = RESOLUTIONS) -> dict[str, Any]:
    """Return the cost of half a finger for every resolution: first built, then at hand."""
    rows = {}
    with empty_cache() as cache:
        measure("coarse")  # compiles
        for resolution in resolutions:
            rows[resolution] = _row(resolution, cache)
    return {
        **provenance("python -m fefinger.validation.evidence.condensed reports"),
        "scene": "flat-press",
        "resolutions": rows,
    }


def _row(resolution: str, cache: Path) -> dict[str, Any]:
    """Build the operator again, and use it again."""
    shutil.rmtree(cache / "fefinger")
    _, first = measure(resolution)
    size = sum(file.stat().st_size for file in cache.rglob("*.npy"))
    again, seconds = measure(resolution)
    return {
        "build_seconds": round(first - seconds, 3),
        **costs(again, seconds),
        "cache_MB": size // 2**20,
        "memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
    }


def main(folder: str, *asked: str) -> None:
    """Write the report."""
    old = json.loads(reported(CONDENSED))
    new = report(RESOLUTIONS if asked == ("all",) else TIMED)
    machine, rows = new["machine_seconds"], new["resolutions"]
    for name in TIMED:
        row = rows[name]
        spent = setup_and_area(f"condensed {name}", row["step_seconds"], machine)
        row["build_seconds"] = round(spent["setup_seconds"] - row["setup_seconds"], 3)
        row["area_seconds"] = spent["area_seconds"]
    new["resolutions"] = timed(old, rows, machine)
    target = Path(folder) / CONDENSED
    target.write_text(compact(new), encoding="utf-8")
    print(target.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main(*sys.argv[1:])
