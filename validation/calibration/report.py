"""What `reports/calibrated.json` and `calibration_levers.json` hold."""

import json
from functools import cache
from typing import Any

from fefinger.calibration.record import Calibration
from fefinger.scene.library import CALIBRATED
from fefinger.support.package_data import report


LEVERS = "calibration_levers.json"


@cache
def rows() -> dict[str, Any]:
    """Return the rows of the report by subject."""
    found: dict[str, Any] = json.loads(report(CALIBRATED))["rows"]
    return found


@cache
def calibrated(subject: str) -> Calibration:
    """Return the calibration of a subject in the report."""
    return Calibration.from_record(rows()[subject]["calibration"])


@cache
def levers() -> dict[str, Any]:
    """Return what moves R, m and c0 b, as `evidence_levers` measured it."""
    found: dict[str, Any] = json.loads(report(LEVERS))
    return found
