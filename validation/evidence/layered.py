"""Measure the cost of `layered` and write the report that the planner reads.

Run as `python -m fefinger.validation.evidence.layered reports`; it takes some seconds.
"""

import sys
import time
from pathlib import Path
from typing import Any

from fefinger.validation.problems import published
from fefinger.validation.provenance import compact, provenance

from fefinger.mechanics import layered
from fefinger.mechanics.evidence.table import LAYERED


ALONE = {"ask.fields": False, "ask.spikes": []}


def seconds() -> dict[str, float]:
    """Return the wall time in s of an answer to flat-press, and of each of its time steps.

    `again_seconds` is that of a second one, whose contacts and fields are kept from the first.
    """
    # Another tissue first: it loads what is loaded once and leaves no contact of this one behind.
    layered.respond(published.load("flat-press", {"finger.tissue": "saal2017", **ALONE}))
    flat_press = published.load("flat-press", {"ask.fields": False})
    taken = []
    for _ in range(2):
        started = time.perf_counter()
        response = layered.respond(flat_press)
        taken.append(time.perf_counter() - started - response.seconds["contact"])
    return {
        "setup_seconds": round(taken[0], 3),
        "again_seconds": round(taken[1], 3),
        "step_seconds": round(response.seconds["contact"] / len(response.time), 7),
    }


def report() -> dict[str, Any]:
    """Return the cost of `layered`."""
    command = "python -m fefinger.validation.evidence.layered reports"
    return {**provenance(command), "scene": "flat-press with fields off", **seconds()}


if __name__ == "__main__":
    target = Path(sys.argv[1]) / LAYERED
    target.write_text(compact(report()), encoding="utf-8")
    print(target.read_text(encoding="utf-8"))
