"""The columns of a study's table: their names with units, what they mean, and their errors."""

from collections.abc import Mapping


_TYPES = ("SAI", "SAII", "FAI", "FAII")

_LAYER = {"modulus": "kPa", "thickness": "mm"}

_RELAXING = {"v": "per_s"}

UNITS: dict[str, dict[str, str]] = {
    "finger": dict.fromkeys(("width", "thickness", "pad_radius"), "mm"),
    "finger.skin": _LAYER,
    "finger.subcutaneous": _LAYER,
    "finger.bone": {"modulus": "kPa"},
    "finger.nail": {"modulus": "kPa"},
    "finger.prony": _RELAXING,
    "finger.skin.prony": _RELAXING,
    "finger.subcutaneous.prony": _RELAXING,
    "indenter": {
        **dict.fromkeys(("angle", "tilt", "roll"), "deg"),
        **dict.fromkeys(("radius", "radii", "at", "width", "corner"), "mm"),
        **dict.fromkeys(("period", "ridge", "depth", "shift", "x", "y", "heights"), "mm"),
    },
    "motion": {
        **{"speed": "mm_per_s", "depth": "mm", "loading_rate": "N_per_s", "force": "N"},
        **{"amplitude": "mm", "frequency": "Hz"},
        **dict.fromkeys(("hold", "settle", "corner", "time"), "s"),
    },
    "ask": {"seconds": "s"},
    "ask.depths": dict.fromkeys(_TYPES, "mm"),
    "ask.population": {
        **dict.fromkeys(("radius", "spacing", "start", "stop", "places", "distance"), "mm"),
        "noise": "uA_per_cm2",
    },
    "ask.population.densities": dict.fromkeys(_TYPES, "per_cm2"),
}
"""Units of the fields of a scene, by their table: a name means something else in another."""


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
    **{"uA_per_cm2": "uA/cm²", "per_cm2": "1/cm²", "per_s": "1/s"},
    **{unit: unit for unit in ("kPa", "deg", "mm", "Hz", "N", "s")},
}
"""Units as names of columns end in them, longer ones first, and as they are written."""


def column(field: str, kind: str = "") -> str:
    """Return the name of the column of a field of the scene, with its unit.

    `kind` is that of the motion, whose amplitude is a force or a depth.
    """
    table, _, name = field.rpartition(".")
    unit = UNITS.get(table, {}).get(name, "")
    if field == "motion.amplitude" and kind.startswith("force"):
        unit = "N"
    return f"{field}_{unit}" if unit else field


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
