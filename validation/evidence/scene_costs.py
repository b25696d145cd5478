"""Costs of a first answer by the CPU seconds that the scenes of development took, in one run.

One press tells little of them: reading the area of its contact costs more the wider that is.
"""

import json

import numpy as np
from fefinger.validation.tradeoff import scenes

from fefinger.mechanics.situation import Situation
from fefinger.support.package_data import report


REPORT = "held-out.json"

STEEP = 45.0
"""Angle in degrees beyond which `condensed` solves the whole mesh too; such scenes are left out."""


def setup_and_area(label: str, step: float, machine: float) -> dict[str, float]:
    """Return CPU seconds of all that is done once, and of reading an area, by candidate.

    label: candidate; step: seconds of a time step that are known; machine: benchmark time of the
    machine that seconds are wanted on. Least squares of the relative errors; an area takes no less
    than a time step.
    """
    development = json.loads(report(REPORT))["development"]
    drawn, rows, seconds = scenes.development(), [], []
    for name, taken in development["taken"].items():
        plate = drawn[name].indenter.plate
        if label in taken and not (plate is not None and plate.angle > STEEP):
            case = Situation.of(drawn[name])
            spent = taken[label] - step * len(case.times)
            rows.append(np.array([1.0, case.changes]) / taken[label])
            seconds.append(spent / taken[label])
    setup, area = np.linalg.lstsq(np.array(rows), np.array(seconds), rcond=None)[0]
    slower = machine / development["machine_seconds"]
    return {
        "setup_seconds": round(float(slower * setup), 3),
        "area_seconds": round(max(float(slower * area), step), 7),
    }
