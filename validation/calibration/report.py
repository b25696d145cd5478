"""Read `reports/calibrated.json`, `calibration_sensitivity.json` and `round-tip.json`."""

from functools import cache
from typing import Any

from fefinger.calibration.record import Calibration
from fefinger.mechanics.evidence.presses import read
from fefinger.scene.library import CALIBRATED


SENSITIVITY = "calibration_sensitivity.json"
ROUND_TIP = "round-tip.json"


def rows() -> dict[str, Any]:
    """Return the rows of the report by subject."""
    return dict(read(CALIBRATED)["rows"])


@cache
def calibrated(subject: str) -> Calibration:
    """Return the calibration of a subject in the report."""
    return Calibration.from_record(rows()[subject]["calibration"])


def sensitivity() -> dict[str, Any]:
    """Read the causes of differences in R, m and c0 b, as `evidence.sensitivity` measured them."""
    return read(SENSITIVITY)


def round_tip() -> list[dict[str, Any]]:
    """Read the steps from the default finger of a.h. to the one with a round tip."""
    return list(read(ROUND_TIP)["rows"])
