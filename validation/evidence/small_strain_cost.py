"""Measure what the mechanics at small strain cost, and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence.small_strain_cost reports` on a machine that does
nothing else; some six minutes, most of them for the operator of the fine mesh. Set up and building
are those that the scenes of development took on the meshes that they were run on.
"""

import shutil
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.empty_cache import empty_cache
from fefinger.validation.evidence.cost_table import SMALL_STRAIN as SMALL_STRAIN_COST
from fefinger.validation.problems import published
from fefinger.validation.provenance import save
from fefinger.validation.tradeoff import held_out, scenes

from fefinger.mechanics import get
from fefinger.mechanics.evidence.costs import STEEPEST
from fefinger.mechanics.evidence.presses import read
from fefinger.mechanics.press.time_steps import moving
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.results.records import Response
from fefinger.scene.finger import RESOLUTIONS
from fefinger.support import machine


ALONE = {"ask.fields": False, "ask.spikes": []}


def measure(candidate: Candidate) -> tuple[Response, float]:
    """Return the response to flat-press, and its CPU time in s."""
    scene = published.load("flat-press", {"finger.resolution": candidate.resolution})
    started = time.process_time()
    response = get(candidate.mechanics).respond(scene)
    return response, time.process_time() - started


def costs(response: Response, seconds: float) -> dict[str, float]:
    """Split the CPU `seconds` of a response to flat-press by stage, whose own are wall time."""
    share = seconds / sum(response.seconds.values())
    parts = {name: share * response.seconds[name] for name in ("contact", "pressure", "fields")}
    return {
        "setup_seconds": round(seconds - sum(parts.values()), 3),
        "fields_seconds": round(parts["fields"], 3),
        "step_seconds": round(parts["contact"] / len(response.time), 7),
    }


def area_seconds(resolution: str) -> float:
    """Return the time in s of reading the area of contact once, under the plate of flat-sinusoid.

    It is read where contact changes.
    """
    scene = published.load("flat-sinusoid", {"finger.resolution": resolution, **ALONE})
    response = get("condensed").respond(scene)
    return round(response.seconds["pressure"] / moving(scene.motion, response.time), 7)


def meshed(cache: Path, resolution: str) -> dict[str, dict[str, Any]]:
    """Return the costs on a mesh: of `linear`, and of `condensed`, first built, then at hand."""
    whole, reduced = Candidate("linear", resolution), Candidate("condensed", resolution)
    response, seconds = measure(whole)
    rows: dict[str, dict[str, Any]] = {whole.label: costs(response, seconds)}
    rows[whole.label]["unknowns"] = int(response.numbers["unknowns"])
    shutil.rmtree(cache / "fefinger")
    _, first = measure(reduced)
    again, seconds = measure(reduced)
    built = {"build_seconds": round(first - seconds, 3)}
    rows[reduced.label] = costs(again, seconds) | built
    area = {"area_seconds": area_seconds(resolution)}
    return {label: row | area for label, row in rows.items()}


def in_scenes(label: str, row: dict[str, float], speed: float) -> dict[str, float]:
    """Return the costs of a candidate as the scenes of development took them; none where not run.

    speed: benchmark time of the machine that seconds are wanted on. Least squares of the relative
    errors, without steep plates, under which `condensed` solves the whole mesh too.
    """
    report, shares, seconds = read(held_out.REPORT), [], []
    slower = speed / report["machine_seconds"]
    for name, scene in scenes.development().items():
        plate, taken = scene.indenter.plate, report["taken"][name].get(label)
        if taken is not None and not (plate is not None and plate.angle > STEEPEST):
            case = Situation.of(scene)
            known = row["step_seconds"] * len(case.times) + row["area_seconds"] * case.changes
            shares.append(1.0 / taken)
            seconds.append((taken - known / slower) / taken)
    if not shares:
        return {}
    weights = np.array(shares)
    once = slower * float(weights @ seconds / (weights @ weights))
    if "build_seconds" in row:
        return {"build_seconds": round(once - row["setup_seconds"], 3)}
    return {"setup_seconds": round(once, 3)}


def main(folder: Path) -> None:
    """Write the report."""
    rows: dict[str, dict[str, Any]] = {}
    with empty_cache() as cache:
        for mechanics in ("linear", "condensed"):
            measure(Candidate(mechanics, "coarse"))  # compiles
        for resolution in RESOLUTIONS:
            rows |= meshed(cache, resolution)
    for label in rows:
        rows[label] |= in_scenes(label, rows[label], machine.seconds())
    save(folder / SMALL_STRAIN_COST, {"scene": "flat-press", "rows": rows})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
