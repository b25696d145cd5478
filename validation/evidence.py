"""Measure the mesh error and the cost of `linear` and write the report that the planner reads.

python -m fefinger.validation.evidence reports
"""

import json
import platform
import resource
import subprocess
import sys
import time
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from fefinger import scenes
from fefinger.mechanics import linear
from fefinger.mechanics._evidence import LINEAR_REPORT
from fefinger.records import Response


ORDER = 2.0
"""Order in the cell length that the extrapolation assumes; contact limits it to about two."""


def measure(resolution: str) -> tuple[Response, float]:
    """Return the response to flat-press on a resolution, and the seconds it took."""
    scene = scenes.load("flat-press")
    started = time.perf_counter()
    response = linear.respond(replace(scene, finger=replace(scene.finger, resolution=resolution)))
    return response, time.perf_counter() - started


def sizes(response: Response) -> float:
    """Return a length of the cells: unknowns to the power of -1/3."""
    return float(response.numbers["unknowns"] ** (-1 / 3))


def report(resolutions: tuple[str, ...] = ("coarse", "standard", "fine")) -> dict[str, Any]:
    """Return force, mesh error and cost for every resolution, coarsest first."""
    linear.respond(scenes.load("flat-press", {"finger.resolution": "coarse"}))  # compiles
    rows: dict[str, dict[str, Any]] = {}
    answers = {}
    for resolution in resolutions:
        response, seconds = measure(resolution)
        answers[resolution] = response
        contact = response.seconds["contact"]
        rows[resolution] = {
            "unknowns": int(response.numbers["unknowns"]),
            "peak_force_N": float(response.force.max()),
            "final_force_N": float(response.force[-1]),
            "peak_area_mm2": float(np.max(response.contact_area)),
            "strain": dict(zip(response.sites.types, _drives(response), strict=True)),
            "setup_seconds": round(seconds - contact, 3),
            "step_seconds": round(contact / len(response.time), 6),
            "stages": {name: round(value, 3) for name, value in response.seconds.items()},
            "memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
        }
    coarse, fine = (answers[name] for name in resolutions[-2:])
    ratio = (sizes(coarse) / sizes(fine)) ** ORDER
    limit = fine.force.max() + (fine.force.max() - coarse.force.max()) / (ratio - 1)
    for resolution, row in rows.items():
        row["force_error"] = float(abs(answers[resolution].force.max() / limit - 1))
    return {
        "command": "python -m fefinger.validation.evidence reports",
        "scene": "flat-press",
        "extrapolated_peak_force_N": float(limit),
        "extrapolation": f"order {ORDER:g} in the cell length from the two finest meshes",
        "commit": _commit(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": f"{platform.machine()}, one BLAS thread",
        "versions": {name: version(name) for name in ("fefinger", "numpy", "scipy", "scikit-fem")},
        "resolutions": rows,
    }


def _drives(response: Response) -> list[float]:
    """Return the largest compressive strain at each site at the end."""
    assert response.strain is not None
    return [float(-np.linalg.eigvalsh(tensor)[0]) for tensor in response.strain[-1]]


def _commit() -> str:
    asked = ["git", "describe", "--always", "--dirty"]
    return subprocess.run(asked, capture_output=True, text=True, check=False).stdout.strip()


if __name__ == "__main__":
    target = Path(sys.argv[1]) / LINEAR_REPORT
    target.write_text(json.dumps(report(), indent=1) + "\n", encoding="utf-8")
    print(target.read_text(encoding="utf-8"))
