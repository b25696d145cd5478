"""Measure what faults of a rig do to a calibration, and whether its deviations cover them.

Run as `python -m fefinger.validation.evidence.rig_faults reports`: some minutes. The records are
presses by `solid` on the coarse mesh, fast and slow. The report keeps what was measured before the
rig was part of the model.
"""

import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fefinger.validation.calibration.rigs import TRUTH, Faults, solid_press, start
from fefinger.validation.provenance import save, saved, short

from fefinger.calibration.calibrate import calibrate


REPORT = "rig-faults.json"
SPEEDS = {"fast": 60.0, "slow": 5.0}  # mm/s

FAULTS = {
    "none": Faults(),
    "position noise 10 um": Faults(position_noise=0.01),
    "force noise 20 mN": Faults(force_noise=0.02),
    "force 1 ms late": Faults(late=1e-3),
    "force offset 20 mN": Faults(offset=0.02),
    "drift 50 mN": Faults(drift=0.05),
    "all of these": Faults(0.02, 0.01, 1e-3, 0.02, 0.05),
}


def row(fault: str, press: str) -> dict[str, Any]:
    """Return value, deviation and true value of every parameter of a calibration, and its time."""
    record = solid_press(SPEEDS[press]).measured(FAULTS[fault], seed=1)
    with TemporaryDirectory() as folder:
        file = record.save(Path(folder) / "press.csv")
        started = time.process_time()
        try:
            found = calibrate(file, finger=start(), resolution="coarse")
        except (ValueError, RuntimeError) as error:
            return {"fault": fault, "press": press, "refused": str(error).partition(": ")[2]}
    spent = time.process_time() - started
    values = {
        name: short([found[name].value, found[name].sd, true]) for name, true in TRUTH.items()
    }
    return {
        "fault": fault,
        "press": press,
        "parameters": values,
        "misfit": float(f"{found.residuals['misfit']:.3g}"),
        "cpu_s": round(spent, 1),
    }


def main(folder: Path) -> None:
    """Measure all faults and save them."""
    rows = []
    for press in SPEEDS:
        for fault in FAULTS:
            rows.append(row(fault, press))
            print(told(rows[-1]), flush=True)
    path = folder / REPORT
    save(path, {"before": saved(path).get("before", {}), "rows": rows})


def told(row: dict[str, Any]) -> str:
    """Return a row as a line: values, and by how many deviations they miss the truth."""
    head = f"{row['press']}, {row['fault']}: "
    if "refused" in row:
        return head + row["refused"]
    parts = [
        f"{name} {value:.4g} +- {sd:.2g} ({(value - true) / sd:+.1f})"
        for name, (value, sd, true) in row["parameters"].items()
    ]
    return f"{head}{', '.join(parts)}; misfit {row['misfit']}, {row['cpu_s']} s"


if __name__ == "__main__":
    main(Path(sys.argv[1]))
