"""Measure whether deviations of a calibration cover: records drawn from stated distributions.

Run as `python -m fefinger.validation.evidence.coverage reports`: some 20 minutes of one core.
"""

import sys
from pathlib import Path

from fefinger.validation.calibration.drawn import row
from fefinger.validation.provenance import save


REPORT = "coverage.json"
DRAWN, BY_SOLID = 100, 12


def main(folder: Path) -> None:
    """Draw, calibrate and save all."""
    rows = []
    for by_solid, count in ((False, DRAWN), (True, BY_SOLID)):
        for seed in range(count):
            rows.append(row(seed, by_solid=by_solid))
            print(rows[-1], flush=True)
    save(folder / REPORT, {"rows": rows})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
