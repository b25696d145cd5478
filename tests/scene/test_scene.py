"""Scenes: exact round trips, the built-in ones, and the sentences for what cannot be used."""

import pickle
import tomllib
from dataclasses import replace
from datetime import date
from functools import cache
from pathlib import Path

import pytest
from fefinger.validation.problems import published
from refusals import refused

from fefinger.scene import builtin
from fefinger.scene.ask import Ask, Scatter
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Ellipsoid, Flat, Sphere
from fefinger.scene.motions import Ramp, RampHold
from fefinger.scene.samples import Sampled
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Tissue
from fefinger.scene.toml import MOTIONS, keys, parts
from fefinger.support.checks import InputError


FINGER = Finger.subject("a.h.", tissue="maeno1998")
ODD = 0.1 + 0.2  # a float whose short form is another number
MOTION_VALUES = {
    "speed": 60 / 7,
    "loading_rate": ODD,
    "depth": ODD,
    "force": 2 / 3,
    "hold": ODD,
    "corner": 1e-3 / 3,
    "amplitude": 1e-2 / 3,
    "frequency": 100 / 7,
    "cycles": 3,
    "settle": ODD,
    "preload": ODD,
    "held": 100 / 3,
    "seconds": 1 / 7,
    "start": 40 / 3,
    "stop": 700 / 3,
    "distance": 10 / 3,
    "direction": 100 / 3,
    "approach": 10 / 7,
}


def motion_of(kind):
    values = MOTION_VALUES
    if "sampled" in kind:
        rising = dict.fromkeys(("depth", "force"), (0, 1 / 3, ODD))
        values = rising | {"time": (0, ODD, 2 / 3), "x": (0, -ODD, 1 / 7), "y": (0, 0, 1 / 3)}
    wanted = keys("motion", kind)
    made = {"kind": kind, **{name: value for name, value in values.items() if name in wanted}}
    motion = parts({"finger": {"subject": "a.h."}, "motion": made}, Path())["motion"]
    assert motion.kind == kind
    return motion


@pytest.mark.parametrize("kind", MOTIONS)
@pytest.mark.parametrize(
    "indenter",
    [Flat(), Flat(100 / 3, -7 / 3), Sphere(5), Sphere(5, at=(ODD, -1 / 3)), Ellipsoid((3, 4, ODD))],
    ids=str,
)
def test_a_scene_survives_toml_exactly(kind, indenter):
    scene = Scene(
        name='a "name"',
        finger=Finger.subject("p.w.", skin=Tissue(100 / 3, 0.5, ODD), cut="nail"),
        indenter=indenter,
        motion=motion_of(kind),
        ask=Ask(
            spikes=("FAI", "SAI"),
            afferents="thesis",
            depths={"SAI": ODD},
            drives={"FAI": "energy"},
            seconds=9,
        ),
    )
    again = Scene.from_toml(scene.to_toml())
    assert again == scene  # exact: TOML keeps every digit
    assert hash(again) == hash(scene)
    assert again.to_toml() == scene.to_toml()  # exact: TOML keeps every digit
    assert pickle.loads(pickle.dumps(scene)) == scene  # exact: pickle keeps every bit


@pytest.mark.parametrize("name", builtin.names())
def test_every_built_in_scene_loads_under_its_own_name_and_round_trips(name):
    scene = builtin.load(name)
    assert scene.name == name
    assert Scene.from_toml(scene.to_toml()) == scene  # exact: TOML keeps every digit
    message = " ".join(builtin.text(name).replace("\n# ", " ").split())
    assert message.startswith(f"# {builtin.summary(name)}")
    assert builtin.summary(name).endswith(".")


def test_flat_press_is_the_scene_of_the_issue():
    scene = published.load("flat-press")
    assert scene == Scene(
        name="flat-press",
        finger=Finger.subject("a.h.", tissue="maeno1998"),
        indenter=Flat(angle=30),
        motion=RampHold(speed=60, depth=1.5, hold=5, corner=0.01),
        ask=Ask(spikes=("SAI", "SAII", "FAI", "FAII"), rel_error=0.4),
    )


def test_a_file_and_its_text_give_the_same_scene_named_after_the_file(tmp_path):
    text = '[finger]\nsubject = "d.p."\n[motion]\nkind = "ramp"\nspeed = 20\ndepth = 1\n'
    file = tmp_path / "mine.toml"
    file.write_text(text)
    assert builtin.load(file).name == "mine"
    assert (
        Scene.from_toml(file) == builtin.load(file) == replace(Scene.from_toml(text), name="mine")
    )
    assert Scene.from_toml(str(file)) == Scene.from_toml(file)


def test_samples_are_read_beside_the_scene_file_and_then_belong_to_the_scene(tmp_path):
    (tmp_path / "samples.csv").write_text("time,force\n0,0\n1,0.5\n")
    file = tmp_path / "scene.toml"
    file.write_text(
        '[finger]\nsubject = "d.p."\n[motion]\nkind = "force-sampled"\nfile = "samples.csv"\n'
    )
    scene = builtin.load(file)
    assert scene.motion == Sampled((0, 1), force=(0, 0.5))
    (tmp_path / "samples.csv").unlink()
    assert Scene.from_toml(scene.to_toml()) == scene


@pytest.mark.parametrize(
    ("head", "usable"),
    [
        ("time,depth", True),
        ("time_s,depth_mm", True),
        ("Time (s), Depth [mm]", True),
        ("time,depth_in", False),
        ("times,depth", False),
        ("time,depth,force", False),
    ],
)
def test_samples_in_other_units_are_not_taken_for_seconds_and_millimeters(tmp_path, head, usable):
    (tmp_path / "samples.csv").write_text(f"{head}\n0,0\n1,0.5\n")
    file = tmp_path / "scene.toml"
    file.write_text(
        '[finger]\nsubject = "d.p."\n[motion]\nkind = "sampled"\nfile = "samples.csv"\n'
    )
    if usable:
        assert builtin.load(file).motion.depth == (0, 0.5)
    else:
        with refused("motion.file"):
            builtin.load(file)


def test_samples_in_other_units_of_their_header_are_converted(tmp_path):
    (tmp_path / "samples.csv").write_text("Time [ms],depth (um)\n0,0\n1000,500\n")
    assert Sampled.from_csv(tmp_path / "samples.csv") == Sampled((0, 1), (0, 0.5))


def test_overrides_are_set_by_dotted_path_and_a_new_kind_drops_foreign_keys():
    texts = [
        "indenter.radius=3",
        "indenter.kind=sphere",
        "motion.depth = 1",
        "motion.speed=.5",
        "finger.subject=d.s.",
        "ask.spikes=['FAI']",
        "ask.depths.FAI=0.6",
    ]
    scene = published.load("flat-press", builtin.settings(texts))
    assert scene.indenter == Sphere(3)
    assert scene.motion == RampHold(0.5, 1, hold=5, corner=0.01)
    assert scene.finger == Finger.subject("d.s.", tissue="maeno1998")
    assert (scene.ask.spikes, scene.ask.depths) == (("FAI",), {"FAI": 0.6})


def test_what_was_checked_of_a_question_cannot_be_changed_afterwards():
    given = {"SAI": 0.5}
    ask = Ask(
        spikes=("SAI",),
        afferents="thesis",
        depths=given,
        drives={"SAI": "energy"},
        population=Scatter(densities={"SAI": 70}),
    )
    for held in (ask.depths, ask.drives, ask.population.densities):
        with pytest.raises(TypeError, match="item assignment"):
            held["FAI"] = -1.0
    given["SAI"] = -1.0
    assert (ask.depths, ask.drives) == ({"SAI": 0.5}, {"SAI": "energy"})
    assert pickle.loads(pickle.dumps(ask)) == replace(ask) == ask
    scene = Scene(finger=FINGER, motion=Ramp(60, 1), ask=ask)
    assert Scene.from_toml(scene.to_toml()) == scene
    assert hash(Scene.from_toml(scene.to_toml())) == hash(scene)


def scene_of(**tables):
    motion = {"kind": "ramp", "speed": 60, "depth": 1}
    return Scene.from_dict({"finger": {"subject": "a.h."}, "motion": motion} | tables)


def at_places(**keys):
    return {"ask": {"population": {"kind": "places", "places": [[0, 0]], **keys}}}


def press(**changes):
    return {"motion": {"kind": "ramp-hold", "speed": 60, "depth": 1, "hold": 1} | changes}


def skin(**changes):
    return {"finger": {"subject": "a.h.", "skin": changes}}


def relaxing(c, v):
    return {"finger": {"subject": "a.h.", "prony": {"c": c, "v": v}}}


BAD_TABLES = [
    ({"fingr": {}}, r"fingr: unknown key. Did you mean 'finger'\?"),
    ({"finger": {"subject": "a.h.", "widht": 3}}, r"in \[finger\]. Did you mean 'width'\?"),
    ({"finger": 3}, r"finger: expected a table \[finger\], received 3"),
    ({"finger": {}}, r"finger.width: missing; expected a subject, or width and thickness in mm"),
    ({"finger": {"width": 14}}, r"finger.thickness: missing"),
    ({"finger": {"subject": "f.c."}}, r"no size of subject 'f.c.': give width and thickness"),
    ({"finger": {"subject": "a.h"}}, r"finger.subject: .*Did you mean 'a.h.'\?"),
    ({"finger": {"subject": "a.h.", "width": -1}}, r"finger.width: .*above 0, received -1"),
    ({"finger": {"subject": "a.h.", "width": "a"}}, r"finger.width: .*received 'a'"),
    ({"finger": {"subject": "a.h.", "tissue": "maeno"}}, r"Did you mean 'maeno1998'\?"),
    ({"finger": {"subject": "a.h.", "cut": "free"}}, r"finger.cut: expected one of 'fixed'"),
    ({"finger": {"subject": "a.h.", "bone": "soft"}}, r"finger.bone: expected one of 'rigid'"),
    ({"finger": {"subject": "a.h.", "resolution": "finer"}}, r"Did you mean 'fine'\?"),
    ({"finger": {"subject": "a.h.", "tip_tissue": 0}}, r"finger.tip_tissue: .*above 0, received 0"),
    ({"finger": {"subject": "a.h.", "tip_radius": 0}}, r"finger.tip_radius: .*above 0, received 0"),
    (skin(poisson=0.51), r"finger.skin.poisson: .*at most 0.5, received 0.51"),
    (skin(poisson=-0.1), r"finger.skin.poisson: .*at least 0 and at most 0.5, received -0.1"),
    (skin(modulus=0), r"finger.skin.modulus: .*kPa above 0, received 0"),
    (skin(thickness=5), r"finger.skin.thickness: .*less than 5 mm, .*received 5"),
    (skin(stiffness=5), r"stiffness: unknown key in \[finger.skin\]"),
    (
        {"finger": {"subject": "a.h.", "subcutaneous": {"thickness": 4}}},
        r"finger.subcutaneous.thickness: expected none",
    ),
    (relaxing([0.3, 0.6], [10]), r"finger.prony.c: expected weights that sum to 0.98 to 1.02"),
    (relaxing([0.4, 0.6], [-10]), r"finger.prony.v: expected rates above 0"),
    (relaxing([0.4, 0.6], [10, 20]), r"finger.prony: expected one weight more than rates"),
    (relaxing([0.4, float("nan")], [10]), r"finger.prony.c: expected finite numbers"),
    ({"finger": {"subject": "a.h.", "prony": {"c": [1]}}}, r"finger.prony.v: missing"),
    ({"finger": {"subject": "a.h.", "prony": 3}}, r"finger.prony: expected a table"),
    ({"indenter": {"kind": "cone"}}, r"indenter.kind: expected one of 'flat'"),
    ({"indenter": {"kind": "Ball"}}, r"received 'Ball'. Did you mean 'sphere'\?"),
    ({"indenter": {"kind": "edge"}}, r"Did you mean 'bar'\?"),
    ({"indenter": {"kind": "sphere", "diameter": 4}}, r"diameter: unknown key .* have a radius"),
    ({"indenter": {"kind": "bar", "angle": 30}}, r"angle: unknown key in \[indenter\]; .* roll"),
    ({"motion": {"kind": "scan"}}, r"motion.kind: .*Did you mean 'slide'\?"),
    ({"indenter": {"angle": 61}}, r"indenter.angle: .*at most 60, received 61"),
    ({"indenter": {"angle": -1}}, r"indenter.angle: .*degrees at least 0"),
    ({"indenter": {"tilt": 46}}, r"indenter.tilt: .*at most 45"),
    ({"indenter": {"kind": "flat", "radius": 3}}, r"radius: unknown key in \[indenter\]"),
    ({"indenter": {"kind": "sphere"}}, r"indenter.radius: missing; a 'sphere' indenter needs rad"),
    ({"indenter": {"kind": "sphere", "radius": 0}}, r"indenter.radius: .*above 0"),
    ({"indenter": {"kind": "sphere", "radius": 3, "at": [1]}}, r"indenter.at: .*2 numbers"),
    ({"indenter": {"kind": "sphere", "radius": 3, "at": [0, 10]}}, r"indenter.at: .*a part of the"),
    ({"indenter": {"kind": "cylinder", "radius": 3, "at": [0, 1e30]}}, r"at\[1\]: .* at most 1"),
    ({"indenter": {"kind": "ellipsoid", "radii": [1, 2]}}, r"indenter.radii: .*3 numbers"),
    ({"motion": {}}, r"motion.kind: missing; expected one of 'ramp'"),
    ({"motion": {"kind": "rampe"}}, r"motion.kind: .*Did you mean 'ramp'\?"),
    ({"motion": {"kind": "ramp", "speed": 3}}, r"motion.depth: missing; a 'ramp' motion needs spe"),
    (press(sped=3), r"sped: unknown key in \[motion\]. Did you mean 'speed'\?"),
    (press(rel_error=0.1), r"rel_error: unknown key in \[motion\]; it belongs in \[ask\]"),
    (press(radius=3), r"indenter.radius is a key of the indenters 'sphere', 'cylinder'"),
    (at_places(places=[[0, 0]] * 31_417), r"ask.population.places: expected 1 to 31416 places"),
    (at_places(places=[]), r"ask.population.places: expected 1 to .* received none"),
    (
        {"ask": {"population": {"kind": "line", "start": [0, 0], "stop": [1, 0], "count": 10**9}}},
        r"ask.population.count: .* at most 31416, received 1000000000",
    ),
    (at_places(spacing=1), r"ask.population.spacing is a key of the population 'grid'. Known keys"),
    ({"finger": {"mechanics": "solid"}}, r"mechanics: unknown key in \[finger\]; .* ask.mechanics"),
    (press(speed=0), r"motion.speed: .*above 0, received 0"),
    (press(depth=-1), r"motion.depth: .*above 0, received -1"),
    (press(depth="deep"), r"motion.depth: .*received 'deep'"),
    (press(depth=float("nan")), r"motion.depth: .*received nan"),
    (press(depth=True), r"motion.depth: .*received True"),
    (press(depth=5), r"motion.depth: expected less than 5 mm, the tissue under the pad"),
    (
        {"motion": {"kind": "sampled", "file": 3}},
        r"motion.file: expected the name of a CSV, LVM, MAT, HDF5 or WAV file",
    ),
    (
        {"motion": {"kind": "sampled", "file": "no.csv"}},
        r"motion.file: 'no.csv': expected a file of a record, such as CSV, received .* not exist",
    ),
    ({"ask": {"force": "yes"}}, r"ask.force: expected true or false, received 'yes'"),
    (
        {"ask": {"spikes": "SAI"}},
        r"""ask.spikes: expected a list out of SAI, SAII.*; write \["SAI"\]""",
    ),
    ({"ask": {"spikes": ["SA1"]}}, r"ask.spikes\[0\]: .*Did you mean 'SAI'\?"),
    ({"ask": {"spikes": ["SAI", "SAI"]}}, r"ask.spikes: expected every name once"),
    ({"ask": {"rel_error": 0}}, r"ask.rel_error: .*above 0 and at most 1"),
    ({"ask": {"seconds": -1}}, r"ask.seconds: .*above 0"),
    ({"ask": {"depths": {"SA1": 1}}}, r"SA1: unknown key in \[ask.depths\]. Did you mean 'SAI'"),
    ({"ask": {"depths": {"SAI": 6}}}, r"ask.depths.SAI: .*below 5, received 6"),
    ({"ask": {"depths": 3}}, r"ask.depths: expected a table"),
    ({"ask": {"drives": {"SAI": "compress"}}}, r"ask.drives.SAI: .*Did you mean 'compressive'\?"),
    ({"ask": {"generator": "linea"}}, r"ask.generator: .*Did you mean 'linear'\?"),
    ({"name": " "}, r"name: expected a name for the scene"),
    ({"name": 3}, r"name: expected a name for the scene that can be printed, received 3"),
]


@pytest.mark.parametrize(("tables", "message"), BAD_TABLES, ids=[m for _, m in BAD_TABLES])
def test_each_unusable_value_gets_its_own_sentence(tables, message):
    with pytest.raises(InputError, match=message):
        scene_of(**tables)


@pytest.mark.parametrize("poisson", [0, 0.5])
def test_the_ends_of_the_range_of_poissons_ratio_are_allowed(poisson):
    assert scene_of(**skin(poisson=poisson)).finger.skin.poisson == poisson


def test_missing_tables_are_named_with_an_example():
    with refused("finger"):
        Scene.from_dict({"motion": {}})
    with refused("motion"):
        Scene.from_dict({"finger": {"subject": "a.h."}})


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty; expected a scene with at least the tables"),
        (b" \n\n", "empty; expected a scene"),
        (b"[finger]\nsubject == 3\n", r"not TOML: .*line 2"),
        (b"\xff\xfe\x00", "expected a TOML file .* no text"),
    ],
)
def test_files_that_are_no_scenes_are_refused(tmp_path, content, message):
    file = tmp_path / "scene.toml"
    file.write_bytes(content)
    with pytest.raises(InputError, match=message):
        Scene.from_toml(file)


def test_a_scene_from_an_editor_on_windows_is_read(tmp_path):
    text = builtin.text("flat-press")
    file = tmp_path / "scene.toml"
    file.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert Scene.from_toml(file) == builtin.load("flat-press")


def test_lists_that_a_shell_has_unquoted_are_lists():
    given = builtin.settings(["ask.spikes=[SAI, FAI]", "motion.kind=ramp", "indenter.at=[1, .5]"])
    assert given["ask.spikes"] == ["SAI", "FAI"]
    assert given["indenter.at"] == [1.0, 0.5]


def test_a_scene_that_is_nowhere_gets_the_nearest_name(tmp_path):
    with pytest.raises(InputError, match=r"no file of that name.*Did you mean 'flat-press'\?"):
        builtin.load("flat-pres")
    (tmp_path / "my scene.toml").touch()
    near = str(tmp_path / "my_scene.toml")
    with pytest.raises(InputError, match=r"no such file in .*Did you mean '.*my scene.toml'\?"):
        builtin.load(near)
    with refused("scene"):
        Scene.from_toml(tmp_path / "no.toml")
    with refused("scene"):
        Scene.from_toml(tmp_path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("motion.depth", "expected FIELD=VALUE"),
        ("=3", "expected FIELD=VALUE"),
        ("motion.depth=", "motion.depth: .*received ''"),
        ("motion.dept=3", r"dept: unknown key in \[motion\]. Did you mean 'depth'\?"),
        ("moton.depth=3", r"moton: unknown key. Did you mean 'motion'\?"),
        ("motion.depth.x=3", r"motion.depth.x: expected a table at motion.depth"),
        ("motion.depth=deep", r"motion.depth: .*received 'deep'"),
        ("motion.depth=nan", r"motion.depth: .*received nan"),
        ("motion.depth=1\nhold=2", r"motion.depth: .*received '1\\nhold=2'"),
    ],
)
def test_a_setting_that_cannot_be_used_is_refused(text, message):
    with pytest.raises(InputError, match=message):
        published.load("flat-press", builtin.settings([text]))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"finger": 3}, "finger: expected a Finger, received int"),
        ({"motion": Flat()}, "motion: expected a Motion, received Flat"),
        ({"motion": Sampled((0, 1), (0, 5))}, "motion.depth: expected less than 5 mm"),
    ],
)
def test_python_gets_the_same_checks(changes, message):
    with pytest.raises(InputError, match=message):
        Scene(**{"finger": FINGER, "motion": Ramp(60, 1)} | changes)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Tissue(30, 0.48, prony=3), "tissue.prony: expected a Prony, received 3"),
        (
            lambda: Finger(14, 10, surface=3, tissue="maeno1998"),
            "finger.surface: expected the path of a surface file, received 3",
        ),
        (lambda: builtin.given(3), "scene: expected a Scene, the name of a built-in one"),
    ],
)
def test_python_gets_a_sentence_for_what_no_file_can_say(build, message):
    with pytest.raises(InputError, match=message):
        build()


def test_the_path_of_a_surface_survives_toml(tmp_path):
    (tmp_path / "scan.stl").touch()
    finger = Finger(14, 10, surface=tmp_path / "scan.stl", tissue="maeno1998")
    assert finger.surface == str(tmp_path / "scan.stl")
    assert tomllib.loads(Scene(finger=finger, motion=Ramp(1, 1)).to_toml())["finger"]["surface"]


ODD_VALUES = [[], {}, "x", "", float("nan"), float("inf"), -1, 0, 10**20, True, [1], [[]], {"a": 1}]


@cache
def keys_of_scenes():
    """Return each key of each kind of part once, with a scene that has it."""
    found = {}
    for name in builtin.names():
        table = builtin.load(name).to_dict()
        for part, values in table.items():
            found.setdefault((part, ""), (name, part))
            for key in values if part != "name" else ():
                found.setdefault((f"{part}.{key}", values.get("kind")), (name, f"{part}.{key}"))
    layers = [f"finger.{layer}.{key}" for layer in ("skin", "prony") for key in ("modulus", "c")]
    others = [("flat-press", path) for path in (*layers, "ask.depths.SAI", "ask.drives.SAI")]
    return [*found.values(), *others]


@pytest.mark.parametrize("value", [*ODD_VALUES, date(2020, 1, 1)], ids=str)
def test_no_value_anywhere_gives_anything_but_a_scene_or_a_sentence(value):
    for name, path in keys_of_scenes():
        try:
            scene = builtin.load(name, {path: value})
        except InputError:
            continue
        assert Scene.from_toml(scene.to_toml()) == scene  # exact: TOML keeps every digit


def test_toml_written_out_has_every_value_in_plain_tables():
    table = tomllib.loads(published.load("flat-press").to_toml())
    assert table["finger"]["subject"] == "a.h."
    assert table["finger"]["prony"] == {"c": [0.29, 0.47, 0.13, 0.1], "v": [226.0, 8.6, 0.61]}
    assert table["motion"]["kind"] == "ramp-hold"


def test_spikes_of_more_than_an_hour_are_refused_before_anything_is_solved():
    parts = {
        "finger": Finger.subject("a.h.", tissue="maeno1998"),
        "motion": RampHold(speed=1, depth=0.5, hold=4000),
    }
    with refused("motion"):
        Scene(**parts, ask=Ask(spikes=("SAI",)))
    assert Scene(**parts).motion.duration > 4000


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("flat-press", {"motion.depth": 0.1}),
        ("flat-press", {"motion.kind": "ramp", "motion.speed": 1000.0}),
        ("press-to-1N", {"motion.force": 0.01, "motion.loading_rate": 10.0}),
        ("flat-press", {"finger.width": 20.0, "finger.thickness": 16.0}),
        ("flat-press", {"finger.prony.c": [0.4, 0.3, 0.3], "finger.prony.v": [1.0, 10.0]}),
        ("pin-hold", {"indenter.width": 0.5}),
    ],
)
def test_a_change_in_a_scene_is_that_change_in_its_file(name, changes):
    """What was filled in follows: the corner of a ramp, the rim of a pin, the lengths of a pad."""
    in_scene = builtin.given(builtin.load(name), changes)
    # exact: one way to a scene, from the same numbers
    assert in_scene == builtin.load(name, changes)


def test_a_number_of_ones_own_stays_when_another_changes():
    """A corner or pad radius that differs from the default is not filled in anew."""
    mine = builtin.load("flat-press", {"motion.corner": 0.002, "finger.pad_radius": 9.0})
    after = builtin.given(mine, {"motion.depth": 1.0, "finger.width": 20.0})
    assert (after.motion.corner, after.finger.pad_radius) == (0.002, 9.0)
