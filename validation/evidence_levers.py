"""Measure what moves R, m and c0 b, and write the report that suite `calibration` reads.

Run as `python -m fefinger.validation.evidence_levers reports` after `evidence_calibration`; the
presses take some minutes, less where they are kept.
"""

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fefinger.validation import calibration_levers
from fefinger.validation.calibration_report import LEVERS, calibrated, rows
from fefinger.validation.provenance import provenance


SUBJECT = "a.h."
"""Whose finger the levers are tried in."""


def report() -> dict[str, Any]:
    """Return the report."""
    found = {name: calibrated(name) for name in rows()}
    reading, force = calibration_levers.of_reading, calibration_levers.of_force
    return {
        **provenance("python -m fefinger.validation.evidence_levers reports"),
        "subject": SUBJECT,
        "finger": calibration_levers.of_fingers(SUBJECT),
        "reading": {name: [asdict(row) for row in reading(one)] for name, one in found.items()},
        "force": {name: [asdict(row) for row in force(one)] for name, one in found.items()},
    }


if __name__ == "__main__":
    text = json.dumps(report(), indent=1, allow_nan=False) + "\n"
    (Path(sys.argv[1]) / LEVERS).write_text(text, encoding="utf-8")
