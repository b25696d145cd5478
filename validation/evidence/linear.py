"""Measure the mesh error and the cost of `linear` and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence.linear reports`; it takes ten minutes, and as long
again if the meshes that are fine where other plates than that of 30 degrees touch have to be built.
With `costs` behind it, it measures those of the coarse and the standard mesh alone, in ten seconds,
of set up and area by the scenes of development (`taken.py`), and leaves the errors; those of the
fine mesh are taken to this machine.
"""

import json
import resource
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.evidence.scene_costs import setup_and_area
from fefinger.validation.problems import published
from fefinger.validation.provenance import compact, provenance

from fefinger.mechanics import linear
from fefinger.mechanics.evidence.table import LINEAR
from fefinger.mechanics.press.time_steps import moving
from fefinger.results.records import Response
from fefinger.support.checks import InputError
from fefinger.support.package_data import report as reported


RESOLUTIONS = ("coarse", "standard", "fine")

TIMED = RESOLUTIONS[:2]
"""Meshes whose costs are measured alone."""

ORDER = 2.0
"""Order in the cell length that the extrapolation assumes; contact limits it to about two."""


PRESSES: dict[str, dict[str, Any]] = {
    "flat-30": {"indenter": {"kind": "flat", "angle": 30}, "motion.depth": 1.5},
    "flat-15": {"indenter": {"kind": "flat", "angle": 15}, "motion.depth": 0.8},
    "flat-0": {"indenter": {"kind": "flat", "angle": 0}, "motion.depth": 0.8},
    "flat-45": {"indenter": {"kind": "flat", "angle": 45}, "motion.depth": 0.8},
    "flat-60": {"indenter": {"kind": "flat", "angle": 60}, "motion.depth": 0.8},
    "sphere-5": {"indenter": {"kind": "sphere", "radius": 5}, "motion.depth": 1.0},
    "sphere-2": {"indenter": {"kind": "sphere", "radius": 2}, "motion.depth": 0.6},
    "edge": {"indenter": {"kind": "bar", "width": 2, "corner": 1}, "motion.depth": 1.0},
    "grating": {
        "indenter": {"kind": "grating", "period": 4, "ridge": 2, "depth": 0.6},
        "motion.depth": 1.0,
    },
    "pin": {"indenter": {"kind": "pin", "width": 1}, "motion.depth": 0.5},
}
"""Indenters for which the mesh error is measured, all on the finger of flat-press."""


def measure(resolution: str, press: str) -> Response:
    """Return the response to a press on a resolution."""
    settings = {"finger.resolution": resolution, **PRESSES[press]}
    return linear.respond(published.load("flat-press", settings))


def peak(resolution: str, press: str) -> tuple[float | None, int]:
    """Return the peak force in N and the number of unknowns.

    The force is None where the mesh is too coarse for the indenter.
    """
    try:
        response = measure(resolution, press)
    except InputError:
        return None, 0
    return float(response.force.max()), int(response.numbers["unknowns"])


def extrapolated(unknowns: list[int], forces: list[float | None]) -> float:
    """Return the limit of the force from the two finest meshes, the cells being n^(-1/3) long."""
    coarse, fine = forces[-2:]
    assert coarse is not None
    assert fine is not None
    ratio = (unknowns[-1] / unknowns[-2]) ** (ORDER / 3)
    return fine + (fine - coarse) / (ratio - 1)


def report(resolutions: tuple[str, ...] = RESOLUTIONS) -> dict[str, Any]:
    """Return force, mesh error and cost for every resolution, coarsest first."""
    rows = spent(resolutions)
    for press in PRESSES:
        found = {resolution: peak(resolution, press) for resolution in resolutions}
        forces, unknowns = [one[0] for one in found.values()], [one[1] for one in found.values()]
        limit = extrapolated(unknowns, forces)
        for resolution, force in zip(resolutions, forces, strict=True):
            rows[resolution].setdefault("peak_force_N", {})[press] = force
            error = None if force is None else round(abs(force / limit - 1), 5)
            rows[resolution].setdefault("force_error", {})[press] = error
    return {
        **provenance("python -m fefinger.validation.evidence.linear reports"),
        "scene": "flat-press, with the presses " + json.dumps(PRESSES),
        "extrapolation": f"order {ORDER:g} in the cell length from the two finest meshes",
        "resolutions": rows,
    }


def spent(resolutions: tuple[str, ...] = RESOLUTIONS) -> dict[str, dict[str, Any]]:
    """Return the costs and answers of flat-press by resolution."""
    measure("coarse", "flat-30")  # compiles
    rows = {}
    for resolution in resolutions:
        started = time.process_time()
        response = measure(resolution, "flat-30")
        rows[resolution] = _row(response, time.process_time() - started)
    return rows


def _row(response: Response, seconds: float) -> dict[str, Any]:
    assert response.sites is not None
    assert response.contact_area is not None
    return {
        "unknowns": int(response.numbers["unknowns"]),
        "mesh": response.sources,
        "peak_area_mm2": float(response.contact_area.max()),
        "compressive_strain": dict(zip(response.sites.types, _drives(response), strict=True)),
        **costs(response, seconds),
        "memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
    }


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


def _drives(response: Response) -> list[float]:
    """Return the largest compressive strain at each site at the end."""
    assert response.strain is not None
    return [float(-np.linalg.eigvalsh(tensor)[0]) for tensor in response.strain[-1]]


def main(folder: str, *asked: str) -> None:
    """Write the report, or only the costs in it."""
    target = Path(folder) / LINEAR
    if asked == ("costs",):
        old = json.loads(reported(LINEAR))
        made = provenance("python -m fefinger.validation.evidence.linear reports costs")
        of_errors = old.get("errors", {name: old[name] for name in made if name in old})
        new = {**old, **made, "errors": of_errors}
        machine, rows = made["machine_seconds"], spent(TIMED)
        for name, row in rows.items():
            row |= setup_and_area(f"linear {name}", row["step_seconds"], machine)
        new["resolutions"] = timed(old, rows, machine)
    else:
        new = report()
    target.write_text(compact(new), encoding="utf-8")
    print(target.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main(*sys.argv[1:])
