"""Study of the contact angle from 0 to 60 degrees, with other meshes, tissues and finite strain.

Run as `python -m fefinger.validation.contact_angle WORK reports`; it takes about ten minutes on two
cores and goes on where it was stopped. It writes contact-angle.csv and contact-angle.json, the
record of how the table was made; docs/studies.md and the gallery say what the table shows.
"""

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from fefinger.validation.provenance import provenance

from fefinger.scene.library import PUBLISHED
from fefinger.studies.study import study
from fefinger.support import atomic_write


ANGLES = tuple(float(angle) for angle in range(0, 61, 5))
AT = ("0.25N", "0.5N", "1N", "0.5mm", "1mm")
"""Forces and depths on the loading at which there are rows, besides the peak and the end."""

COARSE: Mapping[str, Any] = {"finger.resolution": "coarse", "finger.tissue": PUBLISHED}
SHORT: Mapping[str, Any] = {
    **COARSE,
    "ask.spikes": [],
    "motion.depth": 1.0,
    "motion.hold": 0.2,
}
FORCE: Mapping[str, Any] = {
    **COARSE,
    "ask.spikes": [],
    "motion.kind": "force-ramp",
    "motion.loading_rate": 40.0,
}
RAMP: Mapping[str, Any] = {
    **COARSE,
    "ask.spikes": [],
    "motion.kind": "ramp",
    "motion.depth": 1.0,
}
STANDARD: Mapping[str, Any] = {**SHORT, "finger.resolution": "standard"}
PW: Mapping[str, Any] = {"finger.subject": "p.w."}

STUDIES: dict[str, tuple[str, Mapping[str, Any], str, tuple[float, ...]]] = {
    "a.h. to 1 mm": ("flat-press", SHORT, "linear", ANGLES),
    "a.h. to 1 N": ("press-to-1N", FORCE, "linear", ANGLES),
    "p.w. to 1 mm": ("flat-press", {**SHORT, **PW}, "linear", ANGLES),
    "p.w. to 1 N": ("press-to-1N", {**FORCE, **PW}, "linear", ANGLES),
    "dandekar2003": ("flat-press", {**SHORT, "finger.tissue": "dandekar2003"}, "linear", ANGLES),
    "saal2017": ("flat-press", {**SHORT, "finger.tissue": "saal2017"}, "linear", ANGLES),
    "standard mesh": ("flat-press", STANDARD, "linear", ANGLES),
    "finite strain": ("flat-press", RAMP, "solid", ANGLES),
    "a.h. held at 1 mm": ("flat-press", {**COARSE, "motion.depth": 1.0}, "linear", ANGLES),
    "a.h. held at 1 N": ("press-to-1N", COARSE, "linear", ANGLES),
}
"""Scene, changes, mechanics and angles of each part of the work; all but one on coarse meshes."""


def collect(work: Path) -> list[dict[str, Any]]:
    """Return the rows of the studies, with the column "case"; finished scenes stay in `work`."""
    rows: list[dict[str, Any]] = []
    for name, (scene, changes, mechanics, angles) in STUDIES.items():
        over = {"indenter.angle": angles}
        result = study(scene, over, changes=changes, mechanics=mechanics, folder=work, at=AT)
        rows += [{"case": name, **_rounded(row)} for row in result.rows]
        print(f"{name}: {result.scenes - len(result.failures)} of {result.scenes}", file=sys.stderr)
    return rows


def _rounded(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row with numbers of six digits."""
    return {k: float(f"{v:.6g}") if isinstance(v, float) else v for k, v in row.items()}


def table(rows: list[dict[str, Any]]) -> pd.DataFrame:
    """Return the rows without what is long: notes, readings and where the error is from."""
    long = ("notes", "evidence", "scene", "stiffness_note")
    plain = [
        {k: v for k, v in row.items() if not isinstance(v, list) and k not in long} for row in rows
    ]
    return pd.DataFrame(plain, columns=list(dict.fromkeys(key for row in plain for key in row)))


def main() -> None:
    """Answer the studies and write their table and record."""
    work, folder = Path(sys.argv[1]), Path(sys.argv[2])
    rows = collect(work)
    made = provenance("python -m fefinger.validation.contact_angle WORK reports")
    record = {"data": "contact-angle.csv", "provenance": made}
    texts = {
        "contact-angle.csv": table(rows).to_csv(index=False, float_format="%.6g"),
        "contact-angle.json": json.dumps(record, indent=1) + "\n",
    }
    atomic_write.write(folder, texts)


if __name__ == "__main__":
    main()
