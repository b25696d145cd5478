"""Measure whether deviations of a calibration cover: records drawn from stated distributions.

Run as `python -m fefinger.validation.evidence.coverage reports`: some 20 minutes of one core. It
writes the page too, and keeps what is done should it be stopped.
"""

import sys
from pathlib import Path
from typing import Any

from fefinger.validation.calibration import coverage_page
from fefinger.validation.calibration.drawn import row
from fefinger.validation.provenance import save, saved


REPORT = "coverage.json"
FIRST, DRAWN, BY_SOLID = 1000, 100, 12
"""First seed, and numbers of records. Seeds from 0 on were drawn while the model was made."""


def main(folder: Path) -> None:
    """Draw, calibrate and save all."""
    rows: list[dict[str, Any]] = []
    for by_solid, count in ((False, DRAWN), (True, BY_SOLID)):
        for seed in range(FIRST, FIRST + count):
            rows.append(row(seed, by_solid=by_solid))
            print(rows[-1], flush=True)
            save(folder / REPORT, {"rows": rows})
    coverage_page.write(saved(folder / REPORT), (folder / REPORT).with_suffix(".html"))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
