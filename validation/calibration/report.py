"""Read `reports/calibrated.json`, `calibration_sensitivity.json` and `round-tip.json`."""

import json
from functools import cache
from typing import Any

from fefinger.calibration.record import Calibration
from fefinger.scene.library import CALIBRATED
from fefinger.support.package_data import report


SENSITIVITY = "calibration_sensitivity.json"
ROUND_TIP = "round-tip.json"


@cache
def rows() -> dict[str, Any]:
    """Return the rows of the report by subject."""
    records: dict[str, Any] = json.loads(report(CALIBRATED))["rows"]
    return records


@cache
def calibrated(subject: str) -> Calibration:
    """Return the calibration of a subject in the report."""
    return Calibration.from_record(rows()[subject]["calibration"])


@cache
def sensitivity() -> dict[str, Any]:
    """Read the causes of differences in R, m and c0 b, as `evidence.sensitivity` measured them."""
    record: dict[str, Any] = json.loads(report(SENSITIVITY))
    return record


@cache
def round_tip() -> list[dict[str, Any]]:
    """Read the steps from the default finger of a.h. to the one with a round tip."""
    rows: list[dict[str, Any]] = json.loads(report(ROUND_TIP))["rows"]
    return rows
