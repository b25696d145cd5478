"""The rows of the study of the contact angle: its cases, and a measure of one by angle."""

from collections.abc import Mapping, Sequence
from typing import Any


Rows = Sequence[Mapping[str, Any]]

ANGLE = "indenter.angle_deg"
MAIN = {"1 mm": "a.h. to 1 mm", "1 N": "a.h. to 1 N"}
OTHER = {"1 mm": "p.w. to 1 mm", "1 N": "p.w. to 1 N"}
TISSUES = ("dandekar2003", "saal2017")
STANDARD, SOLID = "standard mesh", "finite strain"
HELD = {"a.h. held at 1 mm": "1 mm, 5 s", "a.h. held at 1 N": "1 N, 2 s"}

THESIS = (20.0, 40.0)
"""Degrees between which the fingers of the thesis were held (sections 2.2 and 3.2)."""

FORCES = ("0.25 N", "0.5 N", "1 N")
HELD_FORCE = "a.h. held at 1 N"

MEASURES = {
    "force_N": "force / N",
    "depth_mm": "depth / mm",
    "contact_area_mm2": "area / mm²",
    "shift_distal_mm": "shift / mm",
    "asymmetry": "asymmetry",
    "ellipticity": "ellipticity",
    "highest_pressure_1mm2_kPa": "highest pressure over 1 mm² / kPa",
}


def curve(rows: Rows, case: str, at: str, column: str) -> dict[float, float]:
    """Return a measure of a case by angle."""
    return {
        row[ANGLE]: row[column]
        for row in rows
        if row["case"] == case and row["at"] == at and row.get(column) is not None
    }


def percent(value: float) -> str:
    """Return a part as a signed percentage."""
    return f"{100 * value:+.0f} %"
