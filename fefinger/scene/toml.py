"""Conversion between the parts of a scene and nested tables of plain values (TOML)."""

import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, cast

from fefinger.scene import library
from fefinger.scene.ask import LAYOUTS, Ask, Layout, Scatter
from fefinger.scene.file_kinds import FROM_FILE
from fefinger.scene.finger import FROM_TISSUE, LAYERS, Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import INDENTERS, Flat
from fefinger.scene.key import Key, keys_of, keys_of_kind, needed
from fefinger.scene.motion import Motion
from fefinger.scene.motions import (
    FrequencySweep,
    Ramp,
    RampHold,
    RampSinusoid,
    Sinusoid,
    Trapezoid,
    Vibration,
)
from fefinger.scene.samples import Sampled
from fefinger.scene.sliding import SampledPath, Slide
from fefinger.scene.tissue import Hard, Ridges, Tissue
from fefinger.support import registry
from fefinger.support.checks import InputError, choice, names, reject_unknown
from fefinger.support.inputs import parse_toml, read_text
from fefinger.support.vocabulary import Control
from fefinger.theory.relaxation import Prony


SHAPES: tuple[type[Motion], ...] = (
    *(Ramp, RampHold, RampSinusoid, Sinusoid, Trapezoid, Vibration, FrequencySweep),
    *(Sampled, Slide, SampledPath),
)
MOTIONS = {
    **{each.shape: each for each in SHAPES},
    **{f"force-{each.shape}": each for each in SHAPES if each is not Vibration},
}
"""Motions by kind: of depth, and of force."""

KINDS: dict[str, Mapping[str, type[Any]]] = {
    "motion": MOTIONS,
    "indenter": INDENTERS,
    "ask.population": LAYOUTS,
}
"""Records of the tables whose `kind` decides on their keys."""

SUBJECT = "subject"
PARTS = ("finger", "indenter", "motion", "ask")

PLUGINS = "plugins"
"""Key of the names of modules with objects and models of the user's own."""


PRONY = {
    "c": Key("Weights c0, c1, ... of G(t) = c0 + c1 exp(-v1 t) + ..., which add up to 1"),
    "v": Key("Rates v1, v2, ..., one less than the weights", unit="1/s"),
}
"""Keys of a relaxation."""

NOT_IN_SCENE = {
    "mechanics": "a scene names its mechanics in ask.mechanics, a run with --mechanics, or from "
    "Python as ff.run(scene, mechanics=...)",
    "mesh": "the mesh is finger.resolution: coarse, standard, fine or auto",
    "solver": "there is one linear solver, a factor in double precision",
    "diameter": "a sphere and a cylinder have a radius, a pin and a bar a width",
    **dict.fromkeys(
        ("angle", "orientation"),
        "a plate has an angle and a tilt; roll turns a bar, a cylinder or a grating about the "
        "direction of travel",
    ),
}
"""What to do instead of keys that are looked for in a scene."""

OBJECTS = {
    **dict.fromkeys(("ball", "bead"), "sphere"),
    **dict.fromkeys(("plate", "surface", "plane"), "flat"),
    **dict.fromkeys(("edge", "ridge", "line"), "bar"),
    **dict.fromkeys(("probe", "punch", "needle"), "pin"),
    **dict.fromkeys(("texture", "ridges", "gratings"), "grating"),
    **dict.fromkeys(("heights", "heightmap", "stl"), "relief"),
}
"""Everyday words for kinds of indenters."""

MOVEMENTS = {
    **dict.fromkeys(("press", "step", "hold", "indentation"), "ramp-hold"),
    **dict.fromkeys(("scan", "stroke", "sliding"), "slide"),
    **dict.fromkeys(("sine", "cyclic"), "sinusoid"),
    **dict.fromkeys(("force", "load"), "force-ramp-hold"),
}
"""Everyday words for kinds of motions."""


def read(file: str | Path) -> dict[str, Any]:
    """Read the tables of a TOML file; InputError names the invalid line."""
    text = read_text("scene", file, "a TOML file with a scene")
    return parse(text, name=str(file))


def parse(text: str, *, name: str = "scene") -> dict[str, Any]:
    """Parse the tables of TOML text; InputError names the invalid line."""
    if not text.strip():
        msg = f"{name}: empty; expected a scene with at least the tables [finger] and [motion]"
        raise InputError(msg)
    try:
        return parse_toml(name, text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{name}: not TOML: {error}") from None


def parts(table: Mapping[str, object], folder: Path | None) -> dict[str, Any]:
    """Convert the tables of a scene file to the arguments of a Scene.

    Files are looked up relative to `folder`. None reads tables that `tables` wrote, which hold
    every value, without the files.
    """
    _reject("", table, ("name", PLUGINS, *PARTS))
    load_plugins(table, folder)
    sub = {name: _subtable(name, table) for name in PARTS}
    for name, example in (("finger", 'subject = "a.h."'), ("motion", 'kind = "ramp-hold"')):
        if name not in table:
            msg = f"{name}: missing; expected a table [{name}] with, for example, {example}"
            raise InputError(msg)
    if folder is None:
        # Older scenes: without a family they were of the thesis, and solvers could be chosen.
        sub["ask"] = {"afferents": "thesis"} | sub["ask"]
        sub["ask"].pop("solver", None)
    arguments: dict[str, Any] = {
        "finger": _finger(sub["finger"], folder),
        "indenter": indenter_of(sub["indenter"], folder or Path()),
        "motion": _motion(sub["motion"], folder or Path()),
        "ask": _ask(sub["ask"]),
    }
    return arguments | {key: table[key] for key in ("name", PLUGINS) if key in table}


def tables(finger: Finger, indenter: Indenter, motion: Motion, ask: Ask) -> dict[str, object]:
    """Convert the parts of a scene to the tables that `parts` reads."""
    plain = _plain(finger)
    if "subject_name" in plain:
        plain = {SUBJECT: plain.pop("subject_name"), **plain}
    return {
        "finger": plain,
        "indenter": {"kind": indenter.kind, **_plain(indenter)},
        "motion": {"kind": motion.kind, **_plain(motion)},
        "ask": _plain(ask),
    }


def load_plugins(table: Mapping[str, Any], folder: Path | None) -> None:
    """Load the plugins that a scene names: their code is run.

    They are looked up beside the scene, and then on the path of Python; for a stored scene,
    unless they are loaded, in the working folder.
    """
    for module in names(PLUGINS, table.get(PLUGINS, ())):
        if folder is not None or module not in registry.modules():
            registry.load_plugin(module, folder or Path())


def _subtable(name: str, table: Mapping[str, object]) -> dict[str, Any]:
    """Copy the table with the dotted name `name` out of its parent; empty where it is missing."""
    value = table.get(name.rpartition(".")[2], {})
    if not isinstance(value, Mapping):
        raise InputError(f"{name}: expected a table [{name}], received {value!r}")
    return dict(value)


def _finger(table: dict[str, Any], folder: Path | None) -> Finger:
    """Convert the table [finger]; without a folder it holds every value, and no file is read."""
    _reject("finger", table, _finger_keys())
    table |= _prony("finger", table)
    subject = table.pop(SUBJECT, None)
    bases: dict[str, dict[str, Any]] = {}
    if folder is not None:
        for name in ("surface", "bone_surface"):
            if isinstance(table.get(name), str):
                table[name] = str(folder / table[name])
        tissue = table.get("tissue", library.default_tissue(subject))
        if isinstance(tissue, str) and tissue.endswith(library.TISSUE_FILE):
            tissue = table["tissue"] = str(folder / tissue)
        # A saved scene has all values, and the file of its tissue may have moved since.
        if not (library.gone(tissue) and set(FROM_TISSUE) <= table.keys()):
            tissues = library.tissue_set(tissue)
            # A layer keeps its relaxation, as in Python; only the others take that of the finger.
            bases = {layer: vars(getattr(tissues, layer)) for layer in LAYERS}
    for layer in LAYERS:
        name = f"finger.{layer}"
        if layer in table:
            given = _subtable(name, table)
            base = bases.get(layer, {})
            if given.get("law", base.get("law")) != base.get("law"):  # it has other parameters
                base = base | {"exponent": None, "share": None, "parameters": {}}
            table[layer] = _material(Tissue, name, base | given | _prony(name, given))
    for part in ("bone", "nail"):
        if isinstance(table.get(part), Mapping):
            table[part] = _material(Hard, f"finger.{part}", dict(table[part]))
    if isinstance(table.get("ridges"), Mapping):
        table["ridges"] = _material(Ridges, "finger.ridges", dict(table["ridges"]))
    if folder is None:
        return Finger.stored(subject_name=subject, **table)
    if subject is not None:
        finger = Finger.subject(subject, **table)
        if finger.surface is not None:  # a bad one is refused here, not when the mesh is made
            from fefinger.geometry.surface_file import read_surface

            read_surface(finger.surface, field="finger.surface", axes=finger.axes)
        return finger
    surface = table.pop("surface", None)
    if surface is not None:
        return Finger.from_surface(surface, **table)
    for size in ("width", "thickness"):
        if size not in table:
            msg = f"finger.{size}: missing; expected a subject, or width and thickness in mm"
            raise InputError(msg)
    return Finger(**table)


def _material(cls: type[object], name: str, values: dict[str, object]) -> Any:
    """Construct a Tissue, Hard or Ridges from the values of the table `name`."""
    try:
        return _record(cls, name, values)
    except InputError as error:  # which names the field "tissue.modulus" or "hard.modulus"
        raise InputError(re.sub(rf"^{cls.__name__.lower()}\b", name, str(error))) from None


def _reject(name: str, table: Mapping[str, object], allowed: Iterable[str]) -> None:
    """Raise InputError for an unknown key, with the table that it belongs to."""
    keys = tuple(allowed)
    for key in table:
        if key not in keys and (instead := NOT_IN_SCENE.get(key) or _home(key, name)):
            where = f" in [{name}]" if name else ""
            raise InputError(f"{key}: unknown key{where}; {instead}. Known keys: {', '.join(keys)}")
    reject_unknown(name, table, keys)


def _home(key: str, name: str) -> str:
    """Name the table that has the key, and the kinds that know it; empty where none does.

    Kinds of the table `name`, in which it was found, go first.
    """
    if kinds := _kinds(key, name):
        return kinds
    if key in _finger_keys():
        return f"it belongs in [finger], as finger.{key}"
    if key in keys_of(Ask):
        return f"it belongs in [ask], as ask.{key}"
    return _kinds(key, "motion") or _kinds(key, "indenter")


def _kinds(key: str, part: str) -> str:
    """Name the kinds of a part of a scene that know a key; empty where none does."""
    having = [kind for kind, cls in KINDS.get(part, {}).items() if key in keys_of_kind(cls, kind)]
    what = f"{part.rpartition('.')[2]}{'s' if len(having) > 1 else ''}"
    return f"{part}.{key} is a key of the {what} {', '.join(map(repr, having))}" if having else ""


def _finger_keys() -> tuple[str, ...]:
    """Names of the keys in [finger]."""
    return (SUBJECT, *(name for name in keys_of(Finger) if name != "subject_name"))


def _prony(name: str, table: Mapping[str, object]) -> dict[str, Prony]:
    """Convert the relaxation in the table `name`, where it has one."""
    if "prony" not in table:
        return {}
    given = _subtable(f"{name}.prony", table)
    reject_unknown(f"{name}.prony", given, PRONY)
    for key in PRONY:
        if key not in given:
            what = "expected prony = {c = [c0, c1, ..], v = [v1, ..]}"
            raise InputError(f"{name}.prony.{key}: missing; {what}")
    try:
        return {"prony": Prony(**given)}
    except ValueError as error:
        raise InputError(f"{name}.{error}") from None


def _ask(table: dict[str, object]) -> Ask:
    if "population" in table:
        given = _subtable("ask.population", table)
        kind = choice("ask.population.kind", given.pop("kind", Scatter.kind), LAYOUTS)
        table["population"] = _record(LAYOUTS[kind], "ask.population", given, kind)
    return cast(Ask, _record(Ask, "ask", table))


def indenter_of(table: dict[str, Any], folder: Path) -> Indenter:
    """Make the object of a table [indenter]; InputError for another kind, or wrong keys."""
    table |= _prony("indenter", table)
    kind = table.pop("kind", Flat.kind)
    try:
        choice("indenter.kind", kind, INDENTERS, OBJECTS)
    except InputError as error:
        raise InputError(
            f'{error} An object of your own needs plugins = ["its_module"] at the top of the scene.'
        ) from None
    with registry.INDENTERS.guarded(kind):
        return cast(Indenter, _of_kind("indenter", kind, INDENTERS[kind], table, folder))


def _motion(table: dict[str, object], folder: Path) -> Motion:
    if "kind" not in table:
        raise InputError(f"motion.kind: missing; expected one of {', '.join(map(repr, MOTIONS))}")
    kind = choice("motion.kind", table.pop("kind"), MOTIONS, MOVEMENTS)
    return cast(Motion, _of_kind("motion", kind, MOTIONS[kind], table, folder))


def _of_kind(
    part: str, kind: str, cls: type[object], table: dict[str, object], folder: Path
) -> Any:
    """Construct `cls` from the table of a part, or from the file that the table names."""
    reader = FROM_FILE.get(kind)
    if reader is None or "file" not in table:
        return _record(cls, part, table, kind)
    _reject(part, table, ("file", *reader.keys))
    name = table.pop("file")
    if not isinstance(name, str):
        msg = f"{part}.file: expected the name of a {reader.format} file, received {name!r}"
        raise InputError(msg)
    return reader.read(folder / name, **table)


def _record(cls: type[object], name: str, table: dict[str, object], kind: str = "") -> Any:
    """Construct `cls` from a table; InputError for an unknown or missing key."""
    _reject(name, table, keys_of_kind(cls, kind))
    needs = needed(cls, kind)
    for key in needs:
        if key not in table:
            what = f"a {kind!r} {name} needs {', '.join(needs)}"
            raise InputError(f"{name}.{key}: missing; {what}")
    by_kind = {key: Control.of_kind(kind) for key, it in keys_of(cls).items() if it.hint is Control}
    return cls(**table, **by_kind)


def _plain(record: object) -> dict[str, object]:
    """Convert the fields of a record to TOML values; fields that are None or empty are left out.

    So are newer ones at their default, so that a scene keeps its text and what is stored under it.
    """
    table: dict[str, object] = {}
    for name, known in keys_of_kind(type(record), getattr(record, "kind", "")).items():
        value = getattr(record, name)
        if isinstance(value, Tissue | Hard | Prony | Ridges):
            value = _plain(value)
        elif isinstance(value, Layout):
            value = {"kind": value.kind, **_plain(value)}
        elif isinstance(value, Mapping):
            value = dict(value)
        elif isinstance(value, tuple):
            value = list(value)
        newer = not known.key.written and value == known.default
        if value is not None and value != {} and not newer:
            table[name] = value
    return table


def keys_beside_file(kind: object) -> tuple[str, ...]:
    """List the keys of the table of an indenter or motion of a kind that is read from a file."""
    reader = FROM_FILE.get(kind) if isinstance(kind, str) else None
    return () if reader is None else ("kind", "file", *reader.keys)


def keys(part: str, kind: object) -> tuple[str, ...]:
    """List the keys that a table ("indenter", "motion", "ask.population") takes for `kind`."""
    if not isinstance(kind, str):
        return ()
    record = KINDS.get(part, {}).get(kind)
    return () if record is None else ("kind", *keys_of_kind(record, kind))
