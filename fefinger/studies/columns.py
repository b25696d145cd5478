"""The columns of a study's table: their names with units, what they mean, and their errors."""

from collections.abc import Mapping


UNITS = {
    **dict.fromkeys(("angle", "tilt", "roll"), "deg"),
    **dict.fromkeys(("width", "thickness", "pad_radius", "radius", "radii", "at"), "mm"),
    **dict.fromkeys(("corner", "hold", "settle", "seconds"), "s"),
    **dict.fromkeys(("period", "ridge", "spacing", "depth", "SAI", "SAII", "FAI", "FAII"), "mm"),
    "modulus": "kPa",
    "speed": "mm_per_s",
    "force": "N",
    "loading_rate": "N_per_s",
    "frequency": "Hz",
}
"""Units of the fields of a scene, by the last part of their names."""

IN_OTHERS = {"indenter.corner": "mm", "motion.amplitude": "mm", "ask.population.densities": ""}
"""Units of fields whose last part means something else elsewhere."""


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
    "reach_distal_mm": "reach of 4 kPa, distal",
    "reach_proximal_mm": "reach of 4 kPa, proximal",
}
"""What the measures are that figures show."""

ERRORS = {
    "depth_mm": "depth_rel_error",
    "force_N": "force_rel_error",
    "highest_pressure_1mm2_kPa": "highest_pressure_rel_error",
    "contact_area_mm2": "contact_area_rel_error",
    "strain_rms_percent": "strain_rel_error",
}
"""Columns of the stated relative errors of measures, of the values beside them."""

SHORT = {
    **{"N_per_mm": "N/mm", "N_per_s": "N/s", "mm_per_s": "mm/s", "mm2": "mm²", "percent": "%"},
    **{unit: unit for unit in ("kPa", "deg", "mm", "Hz", "N", "s")},
}
"""Units as names of columns end in them, longer ones first, and as they are written."""


def column(field: str, kind: str = "") -> str:
    """Return the name of the column of a field of the scene, with its unit.

    `kind` is that of the motion, whose amplitude is a force or a depth.
    """
    unit = IN_OTHERS.get(field, UNITS.get(field.rpartition(".")[2], ""))
    if field == "motion.amplitude" and kind.startswith("force"):
        unit = "N"
    if field == "ask.seconds" or not unit:
        return field + ("_s" if unit else "")
    return f"{field}_{unit}"


def split(name: str) -> tuple[str, str]:
    """Return the name of a column without its unit, and the unit as it is written, if any."""
    for ending, unit in SHORT.items():
        if name.endswith(f"_{ending}"):
            return name.removesuffix(f"_{ending}"), unit
    return name, ""


def words(name: str) -> str:
    """Return what a column is with its unit, as on an axis."""
    short, unit = split(name)
    said = MEASURES.get(name, short)
    return f"{said} / {unit}" if unit else said


TWICE = 2.0
"""Times the value at which what a measure may be ends, where its error leaves it more or open."""


def bounds(row: Mapping[str, object], name: str) -> tuple[float, float] | None:
    """Return between which values a measure of a row is by its stated error, None if not known.

    The error is one of what is true, so that is value / (1 + error) to value / (1 - error).
    """
    value, share = row.get(name), row.get(ERRORS.get(name, ""))
    if not isinstance(value, int | float) or not isinstance(share, int | float):
        return None
    most = 1 / (1 - share) if share < 1 else TWICE
    return value / (1 + share), value * min(most, TWICE)
