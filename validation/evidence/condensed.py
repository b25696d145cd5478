"""Measure what `condensed` costs and errs by, and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence.condensed reports`; it takes about five minutes, and
as long again with `errors` behind it, which measures the errors of the force and leaves the rest.
With `costs` it measures those of the coarse and the standard mesh alone, in a quarter of a minute,
of building and area by the scenes of development (`taken.py`).
"""

import json
import resource
import shutil
import sys
import time
from pathlib import Path
from typing import Any

from fefinger.validation.empty_cache import empty_cache
from fefinger.validation.evidence.linear import PRESSES, TIMED, costs, timed
from fefinger.validation.evidence.scene_costs import setup_and_area
from fefinger.validation.problems import published
from fefinger.validation.provenance import compact, provenance

from fefinger.mechanics import condensed
from fefinger.mechanics.evidence.table import CONDENSED, LINEAR, read
from fefinger.results.records import Response
from fefinger.support.checks import InputError
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


def errors(resolutions: tuple[str, ...] = RESOLUTIONS) -> dict[str, Any]:
    """Return the errors of the peak force for every resolution and press."""
    presses = {
        resolution: {press: force_error(resolution, press) for press in PRESSES}
        for resolution in resolutions
    }
    command = "python -m fefinger.validation.evidence.condensed reports errors"
    return {**provenance(command), "presses": presses}


def force_error(resolution: str, press: str) -> float | None:
    """Return the error of the peak force, None where the mesh is too coarse for the indenter.

    The operator is that of the 30 degree plate, whose mesh does not follow the touch. The error is
    the difference to `linear` on the fine mesh that does, and the error that is known of that.
    """
    fine = read(LINEAR)["resolutions"]["fine"]
    settings = {"finger.resolution": resolution, "ask.fields": False, **PRESSES[press]}
    try:
        force = float(condensed.respond(published.load("flat-press", settings)).force.max())
    except InputError:
        return None
    known = float(fine["force_error"][press])
    return round(abs(force / fine["peak_force_N"][press] - 1) + known, 5)


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
    """Write the report, or only the errors in it, or the costs but for the fine mesh."""
    target = Path(folder) / CONDENSED
    old = json.loads(reported(CONDENSED))
    if asked == ("errors",):
        new = {**old, "force_error": errors()}
    elif asked == ("costs",):
        new = {**old, **report(TIMED)}
        machine, rows = new["machine_seconds"], new["resolutions"]
        for name, row in rows.items():
            taken = setup_and_area(f"condensed {name}", row["step_seconds"], machine)
            row["build_seconds"] = round(taken["setup_seconds"] - row["setup_seconds"], 3)
            row["area_seconds"] = taken["area_seconds"]
        new["resolutions"] = timed(old, rows, machine)
    else:
        new = {**report(), "force_error": old["force_error"]}
    target.write_text(compact(new), encoding="utf-8")
    print(target.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main(*sys.argv[1:])
