"""Built-in scenes, and loading of scenes by name or file with changed values."""

import os
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from copy import deepcopy
from dataclasses import fields, replace
from importlib.resources import files
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fefinger.support.checks import InputError, suggestion
from fefinger.support.inputs import NoSingleValueError, bounded, parse_value
from fefinger.support.text import plain


if TYPE_CHECKING:
    from fefinger.scene.scene import Scene


def names() -> tuple[str, ...]:
    """Names of the built-in scenes, sorted."""
    entries = (entry.name for entry in files(__name__).iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in entries if name.endswith(".toml")))


def text(name: str) -> str:
    """TOML text of a built-in scene; InputError suggests the nearest name."""
    if name not in names():
        msg = f"scene {name!r}: expected one of {', '.join(names())}.{suggestion(name, names())}"
        raise InputError(msg)
    return (files(__name__) / f"{name}.toml").read_text(encoding="utf-8")


def summary(name: str) -> str:
    """First sentence of the comment at the top of a built-in scene."""
    lines = takewhile(lambda line: line.startswith("#"), text(name).splitlines())
    return re.split(r"(?<=\.) (?=[A-Z])", " ".join(line.lstrip("# ") for line in lines))[0]


WHOLE = ("finger.subject", "finger.surface", "finger.tissue")
"""Fields that determine others, which a Scene object has already resolved."""


def given(scene: object, changes: Mapping[str, object] | None = None) -> "Scene":
    """Take a Scene, or load a built-in name or TOML file, with changes; errors as `load`.

    A Scene has already resolved the fields WHOLE, which cannot be changed in it. A number that it
    has filled in, as the corner of a short ramp or the pad radius of a finger's width, follows a
    change of what it comes from, as in a file that leaves it out.
    """
    from fefinger.scene.scene import Scene

    if isinstance(scene, str | Path):
        return load(scene, changes)
    if not isinstance(scene, Scene):
        what = "a Scene, the name of a built-in one or a TOML file"
        raise InputError(f"scene: expected {what}, received {scene!r}")
    for field in WHOLE:
        if field in (changes or {}):
            raise InputError(
                f"{field}: expected the name or file of a scene to change this field in, received "
                "a Scene, in which it is already resolved to other fields"
            )
    return Scene.from_dict(changed(_left_out(scene), changes)) if changes else scene


def _left_out(scene: "Scene") -> dict[str, Any]:
    """Tables of a scene without the numbers that it fills in by itself where they are left out."""
    tables = scene.to_dict()
    for part in ("finger", "indenter", "motion"):
        record = getattr(scene, part)
        for each in fields(record):
            value = getattr(record, each.name)
            if each.default is not None or not isinstance(value, float):
                continue
            with suppress(InputError):  # where the file that it came from is gone, it stays
                if getattr(replace(record, **{each.name: None}), each.name) == value:
                    del tables[part][each.name]
    return tables


def load(name: str | Path, overrides: Mapping[str, object] | None = None) -> "Scene":
    """Load a Scene: a built-in one, or from a TOML file.

    Parameters
    ----------
    name
        Name of a built-in scene or path of a file.
    overrides
        Values by their dotted path in the file, such as {"motion.depth": 2.0}. A new `kind` drops
        the keys of its table that it does not have.

    Raises
    ------
    InputError
        No such scene or file, or invalid contents.
    """
    from fefinger.scene.scene import Scene
    from fefinger.scene.toml import load_plugins, parse, read

    if not str(name).strip():
        msg = f"scene: expected a TOML file or one of {', '.join(names())}, received no name"
        raise InputError(msg)
    if str(name) in names():
        tables, folder = parse(text(str(name)), name=str(name)), Path()
    elif os.path.exists(name):
        tables, folder = read(name), Path(name).parent
    else:
        raise InputError(_missing(str(name)))
    tables.setdefault("name", Path(name).stem)
    load_plugins(tables, folder)
    _check_tissue(tables, overrides or {})
    return Scene.from_dict(changed(tables, overrides or {}), folder=folder)


def _missing(name: str) -> str:
    """Error message for a name that is no scene and no file, with the nearest one."""
    path = Path(name)
    if path.suffix or len(path.parts) > 1:
        folder = path.parent
        files = [str(folder / each.name) for each in folder.glob("*.toml")]
        return (
            f"scene {name!r}: no such file in {str(folder.resolve())!r}.{suggestion(name, files)}"
        )
    advice = f"{suggestion(name, names())} `fefinger scenes` lists the built-in ones."
    return f"scene {name!r}: no built-in scene and no file of that name.{advice}"


def _check_tissue(tables: Mapping[str, object], overrides: Mapping[str, object]) -> None:
    """Reject a new tissue set for a scene with explicit layers: only the name would change."""
    from fefinger.scene.finger import LAYERS, Finger

    finger, wanted = tables.get("finger"), overrides.get("finger.tissue")
    if wanted is None or not isinstance(finger, Mapping):
        return
    written = [f"[finger.{layer}]" for layer in LAYERS if layer in finger]
    if written and wanted != finger.get("tissue", Finger.tissue):
        raise InputError(
            f"finger.tissue: expected a scene that takes its layers from the set, received "
            f"one with {' and '.join(written)}, which would not change; remove them from the scene"
        )


def changed(tables: Mapping[str, Any], overrides: Mapping[str, object]) -> dict[str, Any]:
    """Copy `tables` with the values of `overrides`, by dotted path: kinds, files, then others."""
    result = deepcopy(dict(tables))
    order = {"kind": 0, "file": 1}
    for path in sorted(overrides, key=lambda path: order.get(path.rpartition(".")[2], 2)):
        *parents, key = path.split(".")
        table = result
        for i, parent in enumerate(parents):
            table = table.setdefault(parent, {})
            if not isinstance(table, dict):
                where = ".".join(parents[: i + 1])
                raise InputError(f"{path}: expected a table at {where}, which is {table!r}")
        if key in order and table.get(key) != overrides[path]:
            _forget_others(".".join(parents), table, key, overrides[path])
        table[key] = overrides[path]
    bounded("scene", result)
    return result


def settings(texts: Iterable[str]) -> dict[str, Any]:
    """Parse overrides such as "motion.depth=2": TOML values, numbers (".3"), bare text or lists."""
    overrides: dict[str, Any] = {}
    for line in texts:
        path, equals, value = (part.strip() for part in line.partition("="))
        if not equals or not path:
            raise InputError(f"--set {line!r}: expected FIELD=VALUE, as in motion.depth=2")
        try:
            overrides[path] = parse_value(f"--set {path}", value)
        except NoSingleValueError:
            # As a shell leaves it without quotes: a number, a text, or a list of them.
            listed = value.startswith("[") and value.endswith("]")
            parts = [plain(part.strip()) for part in value[1:-1].split(",")]
            overrides[path] = parts if listed else plain(value)
    return overrides


def _forget_others(part: str, table: dict[str, object], key: str, value: object) -> None:
    """Drop what a new kind of indenter or motion does not have, or one that is read from a file."""
    from fefinger.scene.toml import keys, keys_beside_file

    allowed = keys(part, value) if key == "kind" else keys_beside_file(table.get("kind"))
    for key in list(table):
        if allowed and key not in allowed:
            del table[key]
