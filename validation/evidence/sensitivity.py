"""Measure causes of differences in R, m and c0 b; write the report of suite `calibration`.

Run as `python -m fefinger.validation.evidence.sensitivity reports [finger]`, after
`fefinger.validation.evidence.calibration`. Changes of the finger itself are tried where "finger" is
given, some 10 minutes of presses; otherwise those in the report are kept.
"""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fefinger.validation.calibration import sensitivity
from fefinger.validation.calibration.report import SENSITIVITY, calibrated, rows
from fefinger.validation.provenance import save, saved


SUBJECT = "a.h."
"""Whose finger is changed."""


def report(finger: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the report, with the changes of the finger."""
    calibrations = {name: calibrated(name) for name in rows()}
    reading, force = sensitivity.of_reading, sensitivity.of_force
    return {
        "subject": SUBJECT,
        "finger": finger,
        "reading": {
            name: [asdict(row) for row in reading(one)] for name, one in calibrations.items()
        },
        "force": {name: [asdict(row) for row in force(one)] for name, one in calibrations.items()},
    }


if __name__ == "__main__":
    target = Path(sys.argv[1]) / SENSITIVITY
    anew = sys.argv[2:] == ["finger"]
    tried = sensitivity.of_fingers(SUBJECT) if anew else saved(target).get("finger", [])
    save(target, report(tried))
