"""Calibrate the subjects and write the report that library, suite and figures read.

Run as `python -m fefinger.validation.evidence.calibration reports [SUBJECT ...]`; a subject takes
some minutes, less where presses are kept. Subjects that are not named are kept.
"""

import sys
from pathlib import Path
from typing import Any

from fefinger.validation.calibration import split
from fefinger.validation.calibration.figures import profile
from fefinger.validation.calibration.split import PARTS
from fefinger.validation.calibration.subject_target import calibrate_subject
from fefinger.validation.problems.chain import SUBJECTS
from fefinger.validation.provenance import save, saved

from fefinger.calibration.record import Calibration
from fefinger.scene.library import CALIBRATED
from fefinger.support.arrays import Array


FORCES = (0.54, 1.1, 2.3)
"""N at which the thesis shows profiles (Figure 3-4)."""


def row(subject: str) -> dict[str, Any]:
    """Return the calibration of a subject, its split and its profiles."""
    calibration = calibrate_subject(subject)
    return {
        "calibration": calibration.record(),
        "split": split.table(calibration),
        "profiles": profiles(calibration),
    }


def profiles(calibration: Calibration) -> list[dict[str, Any]]:
    """Return pressure against distance at FORCES, of the calibrated finger and of Table 3.2."""
    made = [profile(calibration.law, calibration.target, force) for force in FORCES]
    return [
        {
            "force_N": round(each.force, 4),
            "distance_mm": _listed(each.distance),
            "finger_kPa": _listed(each.finger),
            "thesis_kPa": _listed(each.thesis),
        }
        for each in made
    ]


def _listed(values: Array) -> list[float]:
    return [round(value, 3) for value in values.tolist()]


if __name__ == "__main__":
    target = Path(sys.argv[1]) / CALIBRATED
    rows = {name: row(name) for name in sys.argv[2:] or SUBJECTS}
    rows = saved(target).get("rows", {}) | rows
    save(target, {"parts": PARTS, "rows": {name: rows[name] for name in SUBJECTS if name in rows}})
