"""Columns of a study's table: their labels, meanings, and the columns of their errors."""

from collections.abc import Mapping
from typing import Any

from fefinger.results.plan_text import true_range
from fefinger.scene.field_units import split


Row = Mapping[str, Any]
"""A row of the table: numbers, texts and None by column."""

MISSED = "not reached"
"""Beginning of the `status` of a row at a force or depth that its scene does not reach."""

MEASURES = {
    "force_N": "force",
    "depth_mm": "depth",
    "contact_area_mm2": "contact area",
    "highest_pressure_1mm2_kPa": "highest pressure over 1 mm²",
    "strain_rms_percent": "strain at the end organs, RMS norm",
    "shift_distal_mm": "centroid shift, distal",
    "asymmetry": "asymmetry of the force",
    "ellipticity": "ellipticity 1 - b/a",
    "stiffness_N_per_mm": "stiffness",
    "dynamic_stiffness_N_per_mm": "dynamic stiffness",
    "phase_deg": "phase of force before depth",
    "reach_distal_mm": "reach of 4 kPa, distal",
    "reach_proximal_mm": "reach of 4 kPa, proximal",
}
"""Labels of the measures that figures show."""

MEANINGS = {
    "at": "which time: of the largest force (peak), the end, or first at a force or depth",
    "status": "done, or why the scene has no such row",
    "time_s": "time from the start of the motion",
    "depth_mm": "depth of the object from first touch",
    "force_N": "force on the object",
    "stiffness_N_per_mm": "slope of force over depth on the loading",
    "stiffness_points": "number of times that the slope is taken from",
    "stiffness_note": "why there is no slope",
    "dynamic_stiffness_N_per_mm": "amplitude of the force over that of the depth in a vibration",
    "phase_deg": "phase of the force before the depth in a vibration",
    "contact_area_mm2": "area of contact on the skin",
    "highest_pressure_1mm2_kPa": "highest mean pressure over 1 mm²",
    "strain_rms_percent": "root mean square over the end organs of the norm of the strain",
    "depth_rel_error": "expected error of the depth over its value, of a motion of the force",
    "force_rel_error": "expected error of the force over its value",
    "highest_pressure_rel_error": "expected error of the highest pressure over its value",
    "contact_area_rel_error": "expected error of the area over its value",
    "strain_rel_error": "expected error of the strain over its value",
    "spikes": "spikes of all units, at the end organs, up to the time of the row",
    "shift_distal_mm": "center of pressure from first touch, toward the tip",
    "shift_side_mm": "center of pressure from first touch, sideways",
    "asymmetry": "force distal of first touch minus that proximal, over the force: -1 to 1",
    "ellipticity": "1 - b/a of the axes of the pressure, by its second moments: 0 if round",
    "long_axis_deg": "direction of the long axis from that of the finger",
    "reach_distal_mm": "outermost place with 4 kPa, toward the tip",
    "reach_proximal_mm": "outermost place with 4 kPa, away from the tip",
    "hertz_radius_distal_mm": "effective radius of the contact at first touch along the finger",
    "hertz_radius_side_mm": "effective radius of the contact at first touch across the finger",
    "hertz_peak_pressure_kPa": "pressure in the middle of the contact",
    "mechanics": "the mechanics that answered",
    "mesh": "resolution of its mesh",
    "evidence": "measurements that the expected errors are taken from",
    "seconds": "time that the scene took, in s",
    "seed": "seed of the population",
    "notes": "notes on the spikes",
    "scene": "hash of the inputs of the scene",
}
"""Meanings of the columns, without the columns of the grid."""

PREFIXES = {
    "hertz_": "by elliptic Hertz contact on a half-space: {}",
    "spikes_": "spikes of the units of {}, at the end organs, up to the time of the row",
}
"""Meanings of columns with a prefix; {} is the meaning of the rest of the name."""

ERRORS = {
    "depth_mm": "depth_rel_error",
    "force_N": "force_rel_error",
    "highest_pressure_1mm2_kPa": "highest_pressure_rel_error",
    "contact_area_mm2": "contact_area_rel_error",
    "strain_rms_percent": "strain_rel_error",
}
"""Columns of the expected relative errors, by measure."""


def meaning(name: str) -> str:
    """Return the meaning of a column; KeyError for one that is not described."""
    for prefix, of in PREFIXES.items():
        if name.startswith(prefix):
            rest = name.removeprefix(prefix)
            return of.format(rest if prefix == "spikes_" else MEANINGS.get(name) or MEANINGS[rest])
    return MEANINGS[name]


def words(name: str) -> str:
    """Return the label of a column with its unit, for an axis."""
    short, unit = split(name)
    label = MEASURES.get(name, short)
    return f"{label} / {unit}" if unit else label


def bounds(row: Row, name: str) -> tuple[float, float] | None:
    """Return bounds of the true value of a measure by its expected error; None if not known."""
    value, share = row.get(name), row.get(ERRORS.get(name, ""))
    if not isinstance(value, int | float) or not isinstance(share, int | float):
        return None
    least, most = true_range(share)
    # Large or unlimited errors are drawn up to twice the value.
    return value * least, value * min(most, 2.0)
