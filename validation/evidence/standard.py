"""Press the calibrated fingers on the standard mesh, which most of them were not fitted on.

Run as `python -m fefinger.validation.evidence.standard reports [SUBJECT ...]`; a press takes two to
twenty minutes. Subjects that are not named are kept.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.calibration.report import calibrated
from fefinger.validation.calibration.subjects import STANDARD, fresh
from fefinger.validation.problems.chain import SUBJECTS
from fefinger.validation.provenance import compact, provenance

from fefinger.calibration import pad_radius, targets
from fefinger.calibration.force import stiffness
from fefinger.calibration.outcome import line


DEPTHS = 12


def row(subject: str) -> dict[str, Any]:
    """Compare a calibrated finger on the standard mesh with its report.

    depth_mm, force_N and report_N: of relaxed tissue, down to where the press ends; m in 1/mm and b
    in N/mm of stiffness against force, and R in mm of the thesis's own fit of frames, of both over
    the forces and depths that both reach.
    """
    started = time.process_time()
    calibration, one = calibrated(subject), fresh(subject, "standard")
    spent = time.process_time() - started
    deep = min(one.deepest, calibration.deepest)
    depth = deep * np.arange(1, DEPTHS + 1) / DEPTHS
    wanted = targets.subject(subject)
    last = float(one.force(one.deepest)) / calibration.prony.long_time
    force = wanted.force[wanted.force <= last]
    lines = [
        line(force, stiffness(c, 1.0, calibration.prony, force)) for c in (one, calibration.curve)
    ]
    frames = [
        pad_radius.simulated(c.until(deep), 1.0, calibration.prony)
        for c in (one, calibration.curve)
    ]
    fits = [pad_radius.thesis_fit(each).radius for each in frames]
    columns = {"m": [each[0] for each in lines], "b": [each[1] for each in lines], "R": fits}
    return {
        "fitted on": calibration.finger["resolution"],
        "deepest_mm": float(one.deepest),
        "report_deepest_mm": float(calibration.deepest),
        "depth_mm": _listed(depth),
        "force_N": _listed(one.force(depth)),
        "report_N": _listed(calibration.curve.force(depth)),
        **{
            name: dict(zip(("standard", "report"), _listed(x), strict=True))
            for name, x in columns.items()
        },
        "cpu_s": round(spent, 1),
    }


def _listed(values: Any) -> list[float]:
    return [float(f"{value:.5g}") for value in values]


if __name__ == "__main__":
    file = Path(sys.argv[1]) / STANDARD
    rows = json.loads(file.read_text(encoding="utf-8"))["rows"] if file.exists() else {}
    for name in sys.argv[2:] or SUBJECTS:
        rows[name] = row(name)
        report = {
            **provenance("python -m fefinger.validation.evidence.standard reports"),
            "rows": {each: rows[each] for each in SUBJECTS if each in rows},
        }
        file.write_text(compact(report), encoding="utf-8")
