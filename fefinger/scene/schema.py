"""JSON Schema of a scene file, and units of its fields in names of columns.

It is made from the records that the reader of `toml.py` fills, so that the two hold the same keys.
The reader checks more: numbers that must fit together, files, and places on the pad.
"""

import inspect
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, get_args, get_origin, get_type_hints

from fefinger.scene.ask import Ask, Layout, Scatter
from fefinger.scene.file_kinds import FILE_KEYS, FROM_FILE
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.key import Key, KeyField, forms, keys_of, keys_of_kind, needed, records
from fefinger.scene.tissue import Hard, Ridges, Tissue
from fefinger.scene.toml import KINDS, PRONY, SUBJECT
from fefinger.support.vocabulary import TYPES
from fefinger.theory.relaxation import Prony


Schema = dict[str, Any]

DRAFT = "http://json-schema.org/draft-07/schema#"
"""The version of JSON Schema that TOML editors read."""

BOUNDS = {
    "above": "exclusiveMinimum",
    "below": "exclusiveMaximum",
    "at_least": "minimum",
    "at_most": "maximum",
}
"""Names in JSON Schema of the limits of a number."""

PLAIN: dict[Any, str] = {float: "number", int: "integer", bool: "boolean", str: "string"}

ABOUT = {
    "indenter": "The object that touches the finger; a plate unless `kind` says otherwise",
    "motion": "How the object moves: its depth or its force in time",
    "ask.population": "Places of the afferent units; one of each type under first touch without it",
}
"""Meaning of the tables with kinds."""

SIZES = ([SUBJECT], ["surface"], ["width", "thickness"])
"""Keys of [finger], one group of which has to be there."""


def schema() -> Schema:
    """Return the JSON Schema of a scene file."""
    parts = {
        "name": {"type": "string", "description": "Name of the scene; by default that of its file"},
        "plugins": {
            "type": "array",
            "items": {"type": "string"},
            "description": "Modules with objects or models of your own, beside the scene or on the "
            "path of Python; their code is run when the scene is read",
        },
        "finger": _finger(),
        "indenter": _kinds("indenter", Flat.kind),
        "motion": _kinds("motion"),
        "ask": _ask(),
    }
    return {
        "$schema": DRAFT,
        "title": "A scene of fefinger",
        **_table(parts, required=("finger", "motion")),
    }


def _finger() -> Schema:
    keys = _keys(Finger)
    keys[SUBJECT] = keys.pop("subject_name")
    return _table(keys) | {"anyOf": [{"required": group} for group in SIZES]}


def _ask() -> Schema:
    return _table(_keys(Ask) | {"population": _kinds("ask.population", Scatter.kind)})


def _kinds(part: str, default: str | None = None) -> Schema:
    """Return the schema of a table whose `kind` decides on its keys; `default`: where it is none.

    A kind that can be read from a file has a second form, with the file and its other keys.
    """
    kinds: list[Schema] = []
    for kind, record in KINDS[part].items():
        keys = {"kind": {"const": kind}} | _keys(record, kind)
        must = () if kind == default else ("kind",)
        form = {"title": kind, "description": summary(record)}
        kinds.append(form | _table(keys, required=(*must, *needed(record, kind))))
        if part != "ask.population" and kind in FROM_FILE:
            reader = FROM_FILE[kind]
            text = f"{reader.format} file, looked up from the scene's"
            others = {name: keys.get(name) or _of_file(name, kind) for name in reader.keys}
            file = {"file": {"type": "string", "description": text}}
            of_file = {"kind": keys["kind"]} | file | others
            kinds.append(form | _table(of_file, required=("kind", "file")))
    return {"description": ABOUT[part], "type": "object", "oneOf": kinds}


def _of_file(name: str, kind: str) -> Schema:
    """Return the schema of a key that says how a file is read."""
    return _described(FILE_KEYS[name], "", kind)


def _table(keys: Schema, required: Iterable[str] = ()) -> Schema:
    """Return the schema of a table with no other keys."""
    must = {"required": list(required)} if required else {}
    return {"type": "object", "properties": keys, "additionalProperties": False, **must}


def _keys(record: type[object], kind: str = "") -> Schema:
    """Return the schemas of the fields of a record, by name."""
    texts = parameters(record)
    return {
        name: _described(known, texts.get(name, ""), kind)
        for name, known in keys_of_kind(record, kind).items()
    }


def _described(known: KeyField, text: str, kind: str = "") -> Schema:
    """Return the schema of a key, with its default and its meaning."""
    key: Schema = dict(_of_type(known.hint, known.key))
    if isinstance(known.default, str | int | float):
        key["default"] = known.default
    unit = known.key.unit_of(kind)
    return {**key, "description": text or known.key.text + (f" [{unit}]" if unit else "")}


def _of_type(hint: object, key: Key) -> Schema:
    """Return the schema of a type: a number, a word, a list of them, a table."""
    types = forms(hint)
    if len(types) > 1:
        return {"anyOf": [_of_type(each, key) for each in types]}
    (one,) = types
    origin, arguments = get_origin(one), get_args(one)
    if one in PLAIN:
        limits = {BOUNDS[name]: limit for name, limit in key.bounds.items()}
        return {"enum": list(key.words)} if key.words else {"type": PLAIN[one], **limits}
    if origin is tuple:
        length = {} if arguments[-1] is Ellipsis else {"minItems": len(arguments)}
        length |= {"maxItems": len(arguments)} if length else {}
        return {"type": "array", "items": _of_type(arguments[0], key), **length}
    if origin is Mapping:
        return {
            "type": "object",
            **({} if key.free else {"propertyNames": {"enum": list(TYPES)}}),
            "additionalProperties": _of_type(arguments[1], key),
        }
    if one in (Tissue, Hard, Ridges):
        return _table(_keys(one), required=() if one is Tissue else needed(one))
    if one is Prony:
        hints = get_type_hints(Prony)
        keys = {
            name: _described(KeyField(each, hints[name], None, needed=True), "")
            for name, each in PRONY.items()
        }
        return _table(keys, required=keys)
    if one is Layout:
        return {"type": "object"}
    raise NotImplementedError(f"{one!r}: a type that a scene file does not have")


def summary(record: type[object]) -> str:
    """Return the docstring of a record up to its parameters, as one paragraph."""
    text = inspect.cleandoc(record.__doc__ or "")
    return " ".join(text.split("\nParameters\n")[0].split())


def parameters(record: type[object]) -> dict[str, str]:
    """Return the texts of the fields in the section Parameters of a record and of its bases."""
    texts: dict[str, str] = {}
    for base in reversed(record.__mro__):
        doc = inspect.cleandoc(base.__dict__.get("__doc__") or "")
        section = re.search(r"^Parameters\n-+\n(.*?)(?=^\w+\n-+\n|\Z)", doc, re.S | re.M)
        for names, text in re.findall(
            r"^(\w[\w, ]*)\n((?:(?: +.*)?\n?)+)", section[1] if section else "", re.M
        ):
            texts |= dict.fromkeys(names.split(", "), " ".join(text.split()))
    return texts


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
    found = next((key for key in _keys_of(field, kind) if key.unit), Key())
    suffix = SUFFIX.get(found.unit_of(kind), "")
    return f"{field}_{suffix}" if suffix else field


def _keys_of(field: str, kind: str) -> Iterator[Key]:
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
        yield from _keys_of(table, kind)


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
