"""JSON Schema of a scene file, for editors that complete and check TOML.

It is made from the records that the reader of `toml.py` fills, so that the two hold the same keys.
The reader checks more: numbers that must fit together, files, and places on the pad.
"""

import inspect
import re
from collections.abc import Iterable, Mapping
from dataclasses import fields
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from fefinger.scene import pawluk1997
from fefinger.scene.ask import SOLVERS, Ask
from fefinger.scene.finger import AUTO, CUTS, NAILS, RELAXATIONS, RESOLUTIONS, RIGID, Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.key_texts import TEXTS
from fefinger.scene.motion import LIMITS
from fefinger.scene.population import Layout, Scatter
from fefinger.scene.textured import ARRANGEMENTS
from fefinger.scene.tissue import Hard, Tissue
from fefinger.scene.toml import FROM_FILE, KINDS, SUBJECT, needed
from fefinger.support.vocabulary import DRIVES, FAMILIES, GENERATORS, RULES, SHARES, TYPES
from fefinger.theory.relaxation import Prony


Schema = dict[str, Any]

DRAFT = "http://json-schema.org/draft-07/schema#"
"""The version of JSON Schema that TOML editors read."""

CHOICES: dict[str, tuple[str, ...]] = {
    "ask.afferents": FAMILIES,
    "ask.generator": GENERATORS,
    "ask.solver": SOLVERS,
    "ask.population.rule": RULES,
    "finger.relaxation": RELAXATIONS,
    "finger.cut": CUTS,
    "finger.resolution": (AUTO, *RESOLUTIONS),
    "tissue.law": tuple(SHARES),
    "indenter.arrangement": ARRANGEMENTS,
}
"""Values of the keys that are words."""

BOUNDS = {
    "above": "exclusiveMinimum",
    "below": "exclusiveMaximum",
    "at_least": "minimum",
    "at_most": "maximum",
}
"""Names in JSON Schema of the limits of a number."""

PLAIN: dict[Any, str] = {float: "number", int: "integer", bool: "boolean", str: "string"}

SIZES = ([SUBJECT], ["surface"], ["width", "thickness"])
"""Keys of [finger], one group of which has to be there."""


def schema() -> Schema:
    """Return the JSON Schema of a scene file."""
    parts = {
        "name": {"type": "string", "description": "Name of the scene; by default that of its file"},
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
    keys = _keys("finger", Finger)
    keys[SUBJECT] = keys.pop("subject_name") | {"enum": list(pawluk1997.subjects())}
    hard = _table(_keys("hard", Hard), required=("modulus",))
    for name, words in (("bone", (RIGID,)), ("nail", NAILS)):
        either = {"anyOf": [{"enum": list(words)}, hard]}
        keys[name] = _described("finger", name, either, Finger)
    return _table(keys) | {"anyOf": [{"required": group} for group in SIZES]}


def _ask() -> Schema:
    keys = _keys("ask", Ask)
    keys["population"] = _kinds("ask.population", Scatter.kind)
    keys["spikes"]["items"] = {"enum": list(TYPES)}
    keys["drives"]["additionalProperties"] = {"enum": list(DRIVES)}
    return _table(keys)


def _kinds(part: str, default: str | None = None) -> Schema:
    """Return the schema of a table whose `kind` decides on its keys; `default`: where it is none.

    A kind that can be read from a file has a second form, with the file and its other keys.
    """
    forms: list[Schema] = []
    for kind, record in KINDS[part].items():
        keys = {"kind": {"const": kind}} | _keys(part, record)
        must = () if kind == default else ("kind",)
        form = {"title": kind, "description": summary(record)}
        forms.append(form | _table(keys, required=(*must, *needed(record))))
        if part != "ask.population" and kind in FROM_FILE:
            reader = FROM_FILE[kind]
            text = f"{reader.format} file, looked up from the scene's"
            others = {
                name: keys.get(name) or _described(part, name, {"type": "number"})
                for name in reader.keys
            }
            file = {"file": {"type": "string", "description": text}}
            of_file = {"kind": keys["kind"]} | file | others
            forms.append(form | _table(of_file, required=("kind", "file")))
    return {"description": TEXTS[part], "type": "object", "oneOf": forms}


def _table(keys: Schema, required: Iterable[str] = ()) -> Schema:
    """Return the schema of a table with no other keys."""
    must = {"required": list(required)} if required else {}
    return {"type": "object", "properties": keys, "additionalProperties": False, **must}


def _keys(part: str, record: type[Any]) -> Schema:
    """Return the schemas of the fields of a record, by name."""
    hints = get_type_hints(record)
    keys: Schema = {}
    for each in fields(record):
        name, words = each.name, CHOICES.get(f"{part}.{each.name}")
        key: Schema = {"enum": list(words)} if words else _of_type(hints[name])
        if part == "motion":
            limits = LIMITS.get(name, {})
            key |= {BOUNDS[limit]: limits[limit] for limit in BOUNDS if limit in limits}
        if isinstance(each.default, str | int | float):
            key["default"] = each.default
        keys[name] = _described(part, name, key, record)
    return keys


def _described(part: str, name: str, key: Schema, record: type[Any] | None = None) -> Schema:
    """Return the schema of a key with its description: of the docstring, or of `key_texts`."""
    texts = {} if record is None else parameters(record)
    text = texts.get(name) or TEXTS.get(f"{part}.{name}") or TEXTS[name]
    return {**key, "description": text}


def _of_type(hint: Any) -> Schema:
    """Return the schema of a type: a number, a word, a list of them, a table."""
    origin, arguments = get_origin(hint), get_args(hint)
    if hint in PLAIN:
        return {"type": PLAIN[hint]}
    if origin in (UnionType, Union):
        forms = [_of_type(each) for each in arguments if each is not NoneType]
        return forms[0] if len(forms) == 1 else {"anyOf": forms}
    if origin is tuple:
        length = {} if arguments[-1] is Ellipsis else {"minItems": len(arguments)}
        length |= {"maxItems": len(arguments)} if length else {}
        return {"type": "array", "items": _of_type(arguments[0]), **length}
    if origin is Mapping:
        return {
            "type": "object",
            "propertyNames": {"enum": list(TYPES)},
            "additionalProperties": _of_type(arguments[1]),
        }
    if hint in (Tissue, Hard):
        part = "tissue" if hint is Tissue else "hard"
        return _table(_keys(part, hint), required=() if hint is Tissue else needed(hint))
    if hint is Prony:
        numbers = {"type": "array", "items": {"type": "number"}}
        keys = {name: _described("prony", name, numbers) for name in ("c", "v")}
        return _table(keys, required=("c", "v"))
    if hint is Layout:
        return {"type": "object"}
    raise NotImplementedError(f"{hint!r}: a type that a scene file does not have")


def summary(record: type[Any]) -> str:
    """Return the docstring of a record up to its parameters, as one paragraph."""
    text = inspect.cleandoc(record.__doc__ or "")
    return " ".join(text.split("\nParameters\n")[0].split())


def parameters(record: type[Any]) -> dict[str, str]:
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
