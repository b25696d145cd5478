"""Units of the fields of a scene in names of columns, which end in them."""

from collections.abc import Iterator

from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.key import Key, keys_of, records
from fefinger.scene.toml import KINDS, PRONY
from fefinger.theory.relaxation import Prony


SHORT = {
    **{"kg_per_m3": "kg/m³", "N_per_mm": "N/mm", "N_per_s": "N/s", "mm_per_s": "mm/s"},
    **{"mm2": "mm²", "percent": "%", "uA_per_cm2": "µA/cm²", "per_cm2": "1/cm²", "per_s": "1/s"},
    **{unit: unit for unit in ("kPa", "deg", "mm", "Hz", "N", "s")},
}
"""Units as suffixes of column names, longer ones first, and as they are printed."""

SUFFIX = {unit: suffix for suffix, unit in SHORT.items()} | {"degrees": "deg"}


def column(field: str, kind: str = "") -> str:
    """Return the name of the column of a field of the scene, with its unit.

    `kind`: of the motion, which says whether amplitude and approach are forces or depths.
    """
    found = next((key for key in _keys(field, kind) if key.unit), Key())
    suffix = SUFFIX.get(found.unit_of(kind), "")
    return f"{field}_{suffix}" if suffix else field


def _keys(field: str, kind: str) -> Iterator[Key]:
    """Yield the keys of a field of the scene; of several kinds of a table, `kind` comes first.

    A table by afferent type has the key of the whole table.
    """
    table, _, name = field.rpartition(".")
    if table in KINDS:
        kinds = KINDS[table]
        candidates = [*([kinds[kind]] if kind in kinds else []), *kinds.values()]
    else:
        candidates = list(_records(table))
    for record in candidates:
        if record is Prony:
            yield PRONY.get(name, Key())
        elif name in (known := keys_of(record)):
            yield known[name].key
    if table:
        yield from _keys(table, kind)


def _records(table: str) -> Iterator[type[object]]:
    """Yield the records that a table of the finger or of `ask` is read to."""
    path = table.split(".")
    here: list[type[object]] = [each for each in (Finger, Ask) if each.table == path[0]]
    for name in path[1:]:
        hints = [keys_of(each)[name].hint for each in here if name in keys_of(each)]
        here = [each for hint in hints for each in records(hint)]
    yield from here


def split(name: str) -> tuple[str, str]:
    """Return the name of a column without its unit, and the unit as it is written, if any."""
    for ending, unit in SHORT.items():
        if name.endswith(f"_{ending}"):
            return name.removesuffix(f"_{ending}"), unit
    return name, ""
