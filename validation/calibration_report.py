"""What `reports/calibrated.json` holds, by subject."""

import json
from functools import cache
from typing import Any

from fefinger.calibration.record import Calibration
from fefinger.data import report
from fefinger.library import CALIBRATED


@cache
def rows() -> dict[str, Any]:
    """Return the rows of the report by subject."""
    found: dict[str, Any] = json.loads(report(CALIBRATED))["rows"]
    return found


@cache
def calibrated(subject: str) -> Calibration:
    """Return the calibration of a subject in the report."""
    return Calibration.from_record(rows()[subject]["calibration"])
