"""Measure the scatter of responses over meshes of one finger: the mesher is random.

Run as `python -m fefinger.validation.evidence.scatter reports`; it builds each mesh anew, in a
process and a cache of its own, and takes some twenty minutes of two cores.
"""

import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.empty_cache import empty_cache
from fefinger.validation.provenance import compact, provenance
from fefinger.validation.tradeoff import runs
from fefinger.validation.tradeoff.runs import Run

from fefinger.mechanics.evidence.table import SCATTER
from fefinger.mechanics.evidence.tradeoff import STATED
from fefinger.results import pressure


MESHES, DRAWS = ("coarse", "standard"), 24

PLATES = ("flat-0", "flat-15")
"""Presses by `linear`: contacts that grow along the pad, and ones that stay small."""

BESIDE = 1e-3
"""mm by which fingers are wider than the one whose meshes are shipped, so that they are built."""


def drawn(run: Run) -> dict[str, list[float]]:
    """Quantities of a press at its depths in mm, on a newly built mesh."""
    from fefinger.mechanics import linear

    with empty_cache():
        finger = replace(run.scene.finger, width=run.scene.finger.width + BESIDE)
        response = linear.respond(replace(run.scene, finger=finger))
    assert response.pad is not None
    assert response.pressure is not None
    assert response.contact_area is not None
    assert response.strain is not None
    wanted = response.depth.max() * np.arange(1, runs.DEPTHS + 1) / runs.DEPTHS
    at = np.searchsorted(response.depth, wanted * (1 - 1e-9))
    values = {
        "depth_mm": wanted,
        "force": response.force[at],
        "pressure": pressure.peaks(response.pad, response.pressure)[at],
        "area": response.contact_area[at],
        "strain": np.sqrt((response.strain[at] ** 2).sum(axis=(1, 2, 3))),
    }
    return {name: [float(x) for x in each] for name, each in values.items()}


def row(name: str, mesh: str, pool: ProcessPoolExecutor) -> dict[str, Any]:
    """Return the standard deviation over the mean of every quantity, by depth over thickness."""
    run = Run("press", name, "linear", mesh)
    draws = list(pool.map(drawn, [run] * DRAWS))
    part = np.array(draws[0]["depth_mm"]) / run.scene.finger.thickness
    record = {"part": [float(f"{x:.4g}") for x in part]}
    for quantity in STATED:
        values = np.array([each[quantity] for each in draws])
        spread = values.std(axis=0, ddof=1) / values.mean(axis=0)
        record[quantity] = [float(f"{x:.3g}") for x in spread]
    return record


def main(folder: Path) -> None:
    """Measure, and write the report."""
    command = "python -m fefinger.validation.evidence.scatter reports"
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=fresh, max_tasks_per_child=1) as pool:
        rows = {mesh: {name: row(name, mesh, pool) for name in PLATES} for mesh in MESHES}
    report = provenance(command) | {"draws": DRAWS, "rows": rows}
    (folder / SCATTER).write_text(compact(report), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
