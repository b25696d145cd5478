"""Fit the finger of a.h. with a round tip; write the report of suite `calibration` on it.

Run as `python -m fefinger.validation.evidence.round_tip reports`, some 6 minutes of presses.
"""

import sys
from pathlib import Path

from fefinger.validation.calibration import tip_shape
from fefinger.validation.calibration.report import ROUND_TIP
from fefinger.validation.provenance import save


if __name__ == "__main__":
    save(Path(sys.argv[1]) / ROUND_TIP, {"rows": tip_shape.measured()})
