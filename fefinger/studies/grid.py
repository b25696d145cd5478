"""Grid of a study: values of fields, forces and depths of rows, and the columns of its table."""

import itertools
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from fefinger.results.result_record import true_range
from fefinger.scene.schema import split
from fefinger.support.checks import InputError, number
from fefinger.support.inputs import NoSingleValueError, parse_value
from fefinger.support.text import plain


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
    "least_spikes_": "least number of spikes of {} in runs with another step, trial, gain or mesh",
    "largest_spikes_": "largest number of spikes of {} in these runs",
}
"""Meanings of columns with a prefix; {} is the rest of the name, or its meaning."""

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
            return of.format((MEANINGS.get(name) or MEANINGS[rest]) if prefix == "hertz_" else rest)
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


Values = tuple[Any, ...]
"""Values of a field: numbers, texts, or whatever else TOML has."""

EACH = "each"
"""Value of `mechanics` that takes the cheapest one for each scene."""

MOST = 10_000
"""Largest number of scenes of a study: at seconds each they take hours."""

OVER = "expected FIELD=START:STOP:COUNT or FIELD=A,B,C, as in indenter.angle=0:60:13"

AT = "expected a force or a depth, as in 1N or 0.5mm"

MESH = "finger.resolution"

DIGITS = 12
"""Significant digits of the values of a range: steps of 0.1 give 0.3, not 0.30000000000000004."""


def parse_over(texts: Iterable[str]) -> dict[str, Values]:
    """Parse the values of each field, from texts such as "indenter.angle=0:60:13".

    Raises InputError for a text of another form, or a field or value that appears twice.
    """
    values: dict[str, Values] = {}
    for text in texts:
        field, equals, listed = (part.strip() for part in text.partition("="))
        if not field or not equals or not listed:
            raise InputError(f"--over {text!r}: {OVER}")
        if field in values:
            raise InputError(f"--over {text!r}: expected every field once, received {field} again")
        values[field] = _range(text, listed) if ":" in listed else _list(text, field, listed)
    return checked(values)


def checked(over: Mapping[str, Sequence[object]]) -> dict[str, Values]:
    """Return the values of each field as plain Python; InputError for none, or two alike."""
    for field, values in over.items():
        if isinstance(values, str) or not isinstance(values, Collection):
            raise InputError(f"--over {field}: expected a list of values, received {values!r}")
    grid: dict[str, Values] = {}
    count = math.prod(len(values) for values in over.values())
    if count > MOST:
        msg = f"--over: expected at most {MOST} scenes, received {count}; take fewer values"
        raise InputError(msg)
    for field, values in over.items():
        plain = tuple(v.item() if hasattr(v, "item") else v for v in values)
        for value in plain:
            if isinstance(value, float):
                number(f"--over {field}", value)
        twice = [v for i, v in enumerate(plain) if v in plain[:i]]
        if not plain or twice:
            what = f"{twice[0]!r} twice" if twice else "none"
            raise InputError(f"--over {field}: expected different values, received {what}")
        grid[field] = plain
    return grid


def _range(text: str, listed: str) -> tuple[float, ...]:
    parts = listed.split(":")
    try:
        start, stop, count = float(parts[0]), float(parts[1]), int(parts[2])
    except (ValueError, IndexError):
        start, stop, count = 0.0, 0.0, 0
    if len(parts) != 3 or not 2 <= count <= MOST:
        raise InputError(f"--over {text!r}: {OVER}; COUNT is a whole number from 2 to {MOST}")
    for name, value in (("START", start), ("STOP", stop)):
        number(f"--over {text!r}: {name}", value)
    step = (stop - start) / (count - 1)
    return tuple(float(f"{start + i * step:.{DIGITS}g}") for i in range(count))


def _list(text: str, field: str, listed: str) -> Values:
    """Parse a list of TOML, or of numbers and texts without quotes."""
    try:
        return tuple(parse_value(f"--over {field}", f"[{listed}]"))
    except NoSingleValueError:
        values = [part.strip() for part in listed.split(",")]
    if not all(values):
        raise InputError(f"--over {text!r}: {OVER}; a value is missing")
    return tuple(plain(value) for value in values)


def parse_at(texts: Iterable[str]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Parse forces in N and depths in mm, from texts such as "1N" and "0.5 mm".

    Raises InputError for a text that is neither, a duplicate, or one text in place of a list.
    """
    if isinstance(texts, str):
        raise InputError(f"--at: expected a list of forces and depths, received {texts!r} alone")
    levels: dict[str, list[float]] = {"N": [], "mm": []}
    for text in map(str, texts):
        unit = next((unit for unit in levels if text.strip().endswith(unit)), None)
        try:
            value = float(text.strip().removesuffix(unit or ""))
        except ValueError:
            unit = None
        if unit is None:
            raise InputError(f"--at {text!r}: {AT}")
        level = number(f"--at {text!r}", value, above=0, unit=unit)
        if f"{level:g}" in [f"{other:g}" for other in levels[unit]]:
            msg = f"--at {text!r}: expected every level once, received {level:g} {unit} again"
            raise InputError(msg)
        levels[unit].append(level)
    return tuple(levels["N"]), tuple(levels["mm"])


def product(over: Mapping[str, Sequence[object]]) -> list[dict[str, object]]:
    """List every combination of the values, the last field changing fastest."""
    return [dict(zip(over, values, strict=True)) for values in itertools.product(*over.values())]


def remarks(rows: Sequence[Row], over: Sequence[str]) -> list[str]:
    """Return sentences on forces and depths not reached, and on rows of several mechanics."""
    levels: dict[str, list[str]] = {}
    for row in rows:
        if row["status"].startswith(MISSED):
            where = ", ".join(f"{name} = {row[name]}" for name in over)
            levels.setdefault(row["at"], []).append(f"{where}, at {row['at']}: {row['status']}")
    sentences = []
    for at, missed in levels.items():
        many = f"{len(missed)} scenes have no row at {at}, the first of them: "
        sentences.append(f"{many if len(missed) > 1 else ''}{missed[0]}")
    answered = [row for row in rows if row.get("mechanics")]
    if MESH in over:  # several meshes are wanted
        names = [row["mechanics"] for row in answered]
    else:
        names = [f"{row['mechanics']} {row.get('mesh') or ''}" for row in answered]
    used = list(dict.fromkeys(name.strip() for name in names))
    if len(used) > 1:
        sentences.append(
            f"The rows are answers of {', '.join(used)}: what changes between them may be the "
            "mechanics or its mesh. --mechanics NAME takes one for all, on one mesh unless scenes "
            "state theirs; --set finger.resolution=NAME states it for all."
        )
    return sentences
