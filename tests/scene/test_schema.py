"""The JSON Schema of scene files, held against their reader."""

import tomllib
from dataclasses import fields
from pathlib import Path

import jsonschema
import pytest

from fefinger.scene import builtin
from fefinger.scene.ask import LAYOUTS, Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import INDENTERS
from fefinger.scene.key import keys_of
from fefinger.scene.scene import Scene
from fefinger.scene.schema import parameters, schema
from fefinger.scene.tissue import Hard, Tissue
from fefinger.scene.toml import FROM_FILE, MOTIONS, keys
from fefinger.support.checks import InputError


SCHEMA = schema()
VALIDATOR = jsonschema.Draft7Validator(SCHEMA)
KINDS = {"indenter": INDENTERS, "motion": MOTIONS, "ask.population": LAYOUTS}

DOTS = {"indenter.kind": "dots", "indenter.spacing": 3.0}

MINIMAL = {"finger": {"subject": "a.h."}, "motion": {"kind": "ramp", "speed": 10, "depth": 1}}


def accepted(tables):
    """Whether the schema and the reader accept the tables of a scene."""
    try:
        Scene.from_dict(tables, folder=Path())
    except InputError:
        read = False
    else:
        read = True
    return VALIDATOR.is_valid(tables), read


def forms(part):
    """Return the forms of a table that has kinds."""
    table = SCHEMA
    for name in part.split("."):
        table = table["properties"][name]
    return table["oneOf"]


def test_is_a_schema():
    jsonschema.Draft7Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("name", builtin.names())
def test_accepts_every_built_in_scene(name):
    VALIDATOR.validate(tomllib.loads(builtin.text(name)))


@pytest.mark.parametrize("name", builtin.names())
def test_accepts_what_a_scene_writes_of_itself(name):
    VALIDATOR.validate(tomllib.loads(builtin.load(name).to_toml()))


@pytest.mark.parametrize(
    ("part", "kind"), [(part, kind) for part, kinds in KINDS.items() for kind in kinds]
)
def test_has_the_keys_that_the_reader_takes(part, kind):
    of_kind = [form["properties"] for form in forms(part) if form["title"] == kind]
    assert set(of_kind[0]) == set(keys(part, kind))
    if len(of_kind) > 1:
        assert set(of_kind[1]) == {"kind", "file", *FROM_FILE[kind].keys}


def test_has_the_keys_of_a_finger_and_of_its_layers():
    finger = SCHEMA["properties"]["finger"]["properties"]
    assert set(finger) == {f.name for f in fields(Finger)} - {"subject_name"} | {"subject"}
    assert set(finger["skin"]["properties"]) == {field.name for field in fields(Tissue)}


def test_describes_every_key():
    def check(table):
        for name, key in table.get("properties", {}).items():
            assert "const" in key or key["description"], name
            check(key)
        for form in (*table.get("oneOf", ()), *table.get("anyOf", ())):
            check(form)

    for part in SCHEMA["properties"].values():
        check(part)


REFUSED = [
    pytest.param({"fingers": {}}, id="unknown table"),
    pytest.param({"finger.subject": "x.y."}, id="unknown subject"),
    pytest.param({"finger.with": 14}, id="unknown key of the finger"),
    pytest.param({"finger.skin.modul": 14}, id="unknown key of a layer"),
    pytest.param({"finger.skin.law": "hooke"}, id="unknown law"),
    pytest.param({"finger.prony": {"c": [0.5, 0.5]}}, id="weights without rates"),
    pytest.param({"finger.bone": {"poisson": 0.3}}, id="bone without a modulus"),
    pytest.param({"finger.nail": "loose"}, id="unknown nail"),
    pytest.param({"finger.width": "wide"}, id="word for a number"),
    pytest.param({"finger.width": True}, id="truth for a number"),
    pytest.param({"indenter.kind": "ball", "indenter.radius": 3}, id="unknown indenter"),
    pytest.param({"indenter.kind": "sphere"}, id="sphere without a radius"),
    pytest.param({"indenter.radius": 3}, id="plate with a radius"),
    pytest.param({"indenter.kind": "sphere", "indenter.radius": [3]}, id="list for a number"),
    pytest.param(
        {"indenter.kind": "ellipsoid", "indenter.radii": [3, 3]}, id="two half axes of three"
    ),
    pytest.param({"motion.kind": "jump"}, id="unknown motion"),
    pytest.param({"motion.hold": 1}, id="ramp with a hold"),
    pytest.param({"motion.depth": 0}, id="no depth"),
    pytest.param({"motion.speed": -1}, id="speed backward"),
    pytest.param({"ask.spikes": ["SAI", "PC"]}, id="unknown type"),
    pytest.param({"ask.spikes": "SAI"}, id="word for a list"),
    pytest.param({"ask.force": 1}, id="number for a truth"),
    pytest.param({"ask.generator": "cubic"}, id="unknown generator"),
    pytest.param({"ask.depths": {"PC": 1.0}}, id="depth of an unknown type"),
    pytest.param({"ask.drives": {"SAI": "heat"}}, id="unknown drive"),
    pytest.param(
        {"ask.spikes": ["SAI"], "ask.population": {"kind": "ring"}}, id="unknown population"
    ),
    pytest.param(
        {"ask.spikes": ["SAI"], "ask.population": {"seed": 0.5}}, id="seed that is not whole"
    ),
]


@pytest.mark.parametrize("overrides", REFUSED)
def test_refuses_what_the_reader_refuses(overrides):
    assert accepted(builtin.changed(MINIMAL, overrides)) == (False, False)


ACCEPTED = [
    pytest.param({}, id="minimal"),
    pytest.param({"finger": {"width": 14, "thickness": 11.5}}, id="sizes, whole or not"),
    pytest.param({"finger.skin.modulus": 100}, id="a key of a layer"),
    pytest.param({"finger.prony": {"c": [0.5, 0.5], "v": [10]}}, id="relaxation"),
    pytest.param({"finger.bone": {"modulus": 17e6}}, id="elastic bone"),
    pytest.param({"finger.nail": "free"}, id="free nail"),
    pytest.param({"indenter": {"angle": 20}}, id="plate without its kind"),
    pytest.param({"indenter": {"kind": "sphere", "radius": 5, "at": [1, 0]}}, id="sphere"),
    pytest.param({"ask": {"spikes": ["SAI"], "population": {"radius": 3}}}, id="scatter"),
]


@pytest.mark.parametrize("overrides", ACCEPTED)
def test_accepts_what_the_reader_accepts(overrides):
    assert accepted(builtin.changed(MINIMAL, overrides)) == (True, True)


WORDS = {
    "ask.afferents": ("recorded", "thesis"),
    "ask.generator": ("saturating", "linear"),
    "ask.population.rule": ("mean", "max"),
    "finger.bone": ("rigid",),
    "finger.nail": ("free",),
    "finger.relaxation": ("whole", "deviatoric"),
    "finger.resolution": ("auto", "coarse", "standard", "fine"),
    "finger.skin.law": ("neo-hookean",),
    "indenter.arrangement": ("grid", "random"),
}


@pytest.mark.parametrize(("path", "words"), WORDS.items(), ids=list(WORDS))
def test_words_are_those_of_the_reader(path, words):
    thesis = {"ask.spikes": ["SAI"], "ask.afferents": "thesis"}
    others = {"ask": thesis, "indenter": DOTS}.get(path.partition(".")[0], {})
    assert accepted(builtin.changed(MINIMAL, {**others, path: "neither"})) == (False, False)
    for word in words:
        assert accepted(builtin.changed(MINIMAL, {**others, path: word})) == (True, True)


LIMITS = {
    "motion.speed": (1e-3, 0),
    "motion.corner": (0, -1e-3),
    "ask.rel_error": (1, 1.001),
    "ask.depths.SAI": (0.5, 0),
    "ask.population.seed": (0, -1),
    "finger.skin.poisson": (0.5, 0.501),
    "indenter.angle": (60, 60.1),
    "indenter.tilt": (-45, -45.1),
    "finger.nail": ({"modulus": 2e6}, {"modulus": 0}),
}
"""A value within a limit, and one beyond it."""


@pytest.mark.parametrize(("path", "values"), LIMITS.items(), ids=list(LIMITS))
def test_limits_are_those_of_the_reader(path, values):
    others = {"ask.spikes": ["SAI"]} if path.startswith("ask") else {}
    for value, allowed in zip(values, (True, False), strict=True):
        tables = builtin.changed(MINIMAL, {path: value, **others})
        assert accepted(tables) == (allowed, allowed)


@pytest.mark.parametrize("part", ["finger", "motion"])
def test_needs_the_tables_that_the_reader_needs(part):
    assert accepted({name: table for name, table in MINIMAL.items() if name != part}) == (
        False,
        False,
    )


def test_the_meaning_of_a_key_stands_in_one_place():
    """In the docstring of its record, or with its unit and limits."""
    records = (Finger, Tissue, Hard, Ask, *(each for k in KINDS.values() for each in k.values()))
    for record in records:
        for name, known in keys_of(record).items():
            assert bool(known.key.text) != (name in parameters(record)) or name == "kind", name
