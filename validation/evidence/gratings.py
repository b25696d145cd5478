"""Measure how rates over a moved grating change with its period and with its speed.

Run as `python -m fefinger.validation.evidence.gratings reports`: some fifteen minutes. Nothing is
fitted. Recorded of monkeys, over gratings moved back and forth (Goodwin et al. 1987, J Neurosci
7:2168): slowly adapting afferents fire more the larger the period is and as much at any speed,
Pacinian ones more the faster it moves and nearly as much at any period, rapidly adapting ones more
with both. Rates of FAII under a smooth skin, which the report has too, count points of the grid and
fall as it gets finer: they show nothing.
"""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.provenance import save, short

from fefinger.pipeline import run
from fefinger.result import Result
from fefinger.scene import builtin
from fefinger.scene.sliding import Slide
from fefinger.scene.textured import Grating
from fefinger.scene.tissue import Ridges


REPORT = "gratings.json"

PERIODS = (1.0, 1.5, 2.25, 3.0)
RIDGE = 0.5
"""Periods in mm of gratings, and the width of their ridges, which are 0.5 mm high."""

SPEEDS = (20.0, 40.0, 80.0)
"""mm/s."""

FORCE, DISTANCE = 0.6, 20.0
"""N with which the grating is held, as in recordings over dots, and mm that it moves."""

SKINS = {"ridges": None, "smooth": Ridges(height=0.0)}
"""Ridges of the skin, None for those of the built-in scene."""


def pressed(period: float, speed: float, ridges: Ridges | None) -> Result:
    """Return the answer of layers to a grating that moves along the finger."""
    scene = builtin.load("slide-grating")
    if ridges is not None:
        scene = replace(scene, finger=replace(scene.finger, ridges=ridges))
    scene = replace(
        scene,
        indenter=Grating(period=period, ridge=RIDGE, depth=0.5),
        motion=Slide(force=FORCE, speed=speed, direction=180.0, distance=DISTANCE, settle=0.3),
        ask=replace(scene.ask, force=True, pressure=False, strain=False, check=False),
    )
    return run(scene, mechanics="layered")


def rates(result: Result, speed: float) -> dict[str, float]:
    """Return the mean rate in Hz of each type while the grating moves at a speed in mm/s."""
    spikes = result.spikes
    assert spikes is not None
    types, counts = np.array(spikes.types), spikes.count()
    return {
        kind: float(counts[types == kind].mean() * speed / DISTANCE)
        for kind in dict.fromkeys(types)
    }


def of_skin(ridges: Ridges | None) -> dict[str, Any]:
    """Return the rates (periods, speeds) of each type, and how they change.

    period, speed: rate at the largest over that at the least one, means over speeds and periods.
    """
    found = [
        [rates(pressed(period, speed, ridges), speed) for speed in SPEEDS] for period in PERIODS
    ]
    out = {}
    for kind in found[0][0]:
        each = np.array([[one[kind] for one in row] for row in found])
        out[kind] = {
            "Hz": [short(row) for row in each],
            "period": round(float(np.mean(each[-1] / each[0])), 3),
            "speed": round(float(np.mean(each[:, -1] / each[:, 0])), 3),
        }
    return out


def report() -> dict[str, Any]:
    """Return the report."""
    skins = {name: of_skin(ridges) for name, ridges in SKINS.items()}
    return {"period_mm": list(PERIODS), "speed_mm_per_s": list(SPEEDS), **skins}


if __name__ == "__main__":
    save(Path(sys.argv[1]) / REPORT, report())
