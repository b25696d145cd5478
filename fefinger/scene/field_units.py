"""Units of the fields of a scene, and names of columns that end in them."""

from fefinger.support.vocabulary import TYPES


_LAYER = {"modulus": "kPa", "thickness": "mm", "density": "kg_per_m3"}

_RELAXING = {"v": "per_s"}

UNITS: dict[str, dict[str, str]] = {
    "finger": dict.fromkeys(("width", "thickness", "pad_radius", "tip_tissue", "tip_radius"), "mm"),
    "finger.skin": _LAYER,
    "finger.subcutaneous": _LAYER,
    "finger.bone": {"modulus": "kPa"},
    "finger.nail": {"modulus": "kPa"},
    "finger.prony": _RELAXING,
    "finger.skin.prony": _RELAXING,
    "finger.subcutaneous.prony": _RELAXING,
    "indenter": {
        **dict.fromkeys(("angle", "tilt", "roll"), "deg"),
        **dict.fromkeys(("spacing", "height", "diameter", "edge", "cell", "start", "size"), "mm"),
        **dict.fromkeys(("radius", "radii", "at", "width", "corner"), "mm"),
        **dict.fromkeys(("period", "ridge", "depth", "shift", "x", "y", "heights"), "mm"),
    },
    "motion": {
        **{"speed": "mm_per_s", "depth": "mm", "loading_rate": "N_per_s", "force": "N"},
        **{"amplitude": "mm", "preload": "mm", "approach": "mm_per_s"},
        **dict.fromkeys(("direction", "angle", "tilt"), "deg"),
        **dict.fromkeys(("frequency", "start", "stop"), "Hz"),
        **dict.fromkeys(("distance", "x", "y"), "mm"),
        **dict.fromkeys(("hold", "settle", "held", "seconds", "corner", "time"), "s"),
    },
    "ask": {"seconds": "s"},
    "ask.depths": dict.fromkeys(TYPES, "mm"),
    "ask.population": {
        **dict.fromkeys(("radius", "spacing", "start", "stop", "places", "distance"), "mm"),
        "noise": "uA_per_cm2",
    },
    "ask.population.densities": dict.fromkeys(TYPES, "per_cm2"),
}
"""Units of the fields of a scene, by table: a name may have different units in two tables."""

FORCED = {"motion.amplitude": "N", "motion.approach": "N_per_s"}
"""Units that differ where the motion prescribes the force."""

SHORT = {
    **{"kg_per_m3": "kg/m³", "N_per_mm": "N/mm", "N_per_s": "N/s", "mm_per_s": "mm/s"},
    **{"mm2": "mm²", "percent": "%", "uA_per_cm2": "µA/cm²", "per_cm2": "1/cm²", "per_s": "1/s"},
    **{unit: unit for unit in ("kPa", "deg", "mm", "Hz", "N", "s")},
}
"""Units as suffixes of column names, longer ones first, and as they are printed."""


def column(field: str, kind: str = "") -> str:
    """Return the name of the column of a field of the scene, with its unit.

    `kind` is that of the motion, whose amplitude and approach are those of a force or a depth.
    """
    table, _, name = field.rpartition(".")
    unit = UNITS.get(table, {}).get(name, "")
    if kind.startswith("force"):
        unit = FORCED.get(field, unit)
    return f"{field}_{unit}" if unit else field


def split(name: str) -> tuple[str, str]:
    """Return the name of a column without its unit, and the unit as it is written, if any."""
    for ending, unit in SHORT.items():
        if name.endswith(f"_{ending}"):
            return name.removesuffix(f"_{ending}"), unit
    return name, ""
