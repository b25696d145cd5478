"""Measure the cost of `linear` and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence.linear reports`; it takes ten seconds. It measures
the coarse and the standard mesh, of set up and area by the scenes of development
(`scene_costs.py`); costs of the fine mesh are taken to this machine.
"""

import json
import resource
import sys
import time
from pathlib import Path
from typing import Any

from fefinger.validation.evidence.scene_costs import setup_and_area
from fefinger.validation.problems import published
from fefinger.validation.provenance import compact, provenance

from fefinger.mechanics import linear
from fefinger.mechanics.evidence.table import LINEAR
from fefinger.mechanics.press.time_steps import moving
from fefinger.results.records import Response
from fefinger.support.package_data import report as reported


RESOLUTIONS = ("coarse", "standard", "fine")

TIMED = RESOLUTIONS[:2]
"""Meshes whose costs are measured."""


def measure(resolution: str) -> Response:
    """Return the response to flat-press on a resolution."""
    return linear.respond(published.load("flat-press", {"finger.resolution": resolution}))


def spent() -> dict[str, dict[str, Any]]:
    """Return the costs of flat-press by resolution."""
    measure("coarse")  # compiles
    rows = {}
    for resolution in TIMED:
        started = time.process_time()
        response = measure(resolution)
        seconds = time.process_time() - started
        unknowns = {"unknowns": int(response.numbers["unknowns"])}
        memory = {"memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024}
        rows[resolution] = unknowns | costs(response, seconds) | memory
    return rows


def costs(response: Response, seconds: float) -> dict[str, Any]:
    """Split the CPU `seconds` of a response to flat-press by stage, whose own are wall time.

    A step has its contact solved; where contact changed, its area is read.
    """
    share, time = seconds / sum(response.seconds.values()), response.time
    spent = {name: share * each for name, each in response.seconds.items()}
    areas = moving(published.load("flat-press").motion, time)
    parts = {name: spent[name] for name in ("contact", "pressure", "fields")}
    return {
        "setup_seconds": round(seconds - sum(parts.values()), 3),
        "fields_seconds": round(parts["fields"], 3),
        "step_seconds": round(parts["contact"] / len(time), 7),
        "area_seconds": round(parts["pressure"] / areas, 7),
        "stages": {name: round(value, 3) for name, value in spent.items()},
    }


def timed(
    old: dict[str, Any], measured: dict[str, dict[str, Any]], machine: float
) -> dict[str, dict[str, Any]]:
    """Return the rows of a report with costs that were measured; all others are taken over.

    Seconds of another machine are those of this one by the ratio of their benchmark times.
    """
    slower = machine / old["machine_seconds"]
    rows = {}
    for name, row in old["resolutions"].items():
        taken_over = {
            key: round(slower * value, 7) if key.endswith("_seconds") else value
            for key, value in row.items()
        }
        rows[name] = taken_over | measured.get(name, {})
    return rows


def main(folder: str) -> None:
    """Write the report."""
    old = json.loads(reported(LINEAR))
    made = provenance("python -m fefinger.validation.evidence.linear reports")
    machine, rows = made["machine_seconds"], spent()
    for name, row in rows.items():
        row |= setup_and_area(f"linear {name}", row["step_seconds"], machine)
    report = {**made, "scene": "flat-press", "resolutions": timed(old, rows, machine)}
    target = Path(folder) / LINEAR
    target.write_text(compact(report), encoding="utf-8")
    print(target.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main(sys.argv[1])
