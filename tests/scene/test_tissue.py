"""The layers of a finger in a scene: what is given of them, and where the others are from."""

from dataclasses import replace

import pytest
import tomli_w
from fefinger.validation.problems import published

from fefinger.scene import builtin
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Tissue
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony


FINGER = Finger.subject("a.h.", tissue="maeno1998")


def scene_of(**finger):
    motion = {"kind": "ramp", "speed": 60, "depth": 1}
    return Scene.from_dict({"finger": {"subject": "a.h.", **finger}, "motion": motion})


def test_the_relaxation_of_a_layer_stays_with_it_as_in_python():
    prony, other = Prony((0.5, 0.5), (10,)), Prony((0.4, 0.6), (10,))
    table, another = {"c": [0.5, 0.5], "v": [10]}, {"c": [0.4, 0.6], "v": [10]}
    skin, pulp = FINGER.skin, FINGER.subcutaneous
    for given, parts in (
        ({"prony": table}, {"prony": prony}),
        ({"skin": {"prony": table}}, {"skin": replace(skin, prony=prony)}),
        ({"subcutaneous": {"prony": table}}, {"subcutaneous": replace(pulp, prony=prony)}),
        (
            {"prony": table, "skin": {"prony": another}},
            {"prony": prony, "skin": replace(skin, prony=other)},
        ),
        (
            {"prony": table, "skin": {"prony": table}},
            {"prony": prony, "skin": replace(skin, prony=prony)},
        ),
        (
            {"skin": {"prony": table}, "subcutaneous": {"prony": table}},
            {"skin": replace(skin, prony=prony), "subcutaneous": replace(pulp, prony=prony)},
        ),
    ):
        scene = scene_of(tissue=FINGER.tissue, **given)
        assert scene.finger == replace(FINGER, **parts)
        assert Scene.from_toml(scene.to_toml()) == scene


def test_single_values_of_a_layer_replace_those_of_the_named_set():
    finger = scene_of(tissue="dandekar2003", skin={"modulus": 90}).finger
    assert finger.skin == Tissue(90, 0.48, 1.0)
    assert finger.subcutaneous == Tissue(18, 0.48)


@pytest.mark.parametrize("layers", [("skin",), ("subcutaneous",), ("skin", "subcutaneous")])
def test_another_set_of_tissues_is_refused_where_layers_are_written_out(tmp_path, layers):
    file = tmp_path / "mine.toml"
    table = published.load("flat-press").to_dict()
    for layer in {"skin", "subcutaneous"} - set(layers):
        del table["finger"][layer]
    file.write_text(tomli_w.dumps(table))
    named = " and ".join(rf"\[finger.{layer}\]" for layer in layers)
    with pytest.raises(InputError, match=f"finger.tissue: expected .*received one with {named}, "):
        builtin.load(file, {"finger.tissue": "saal2017"})
    assert builtin.load(file, {"finger.tissue": "maeno1998"}) == builtin.load(file)
    other = published.load("flat-press", {"finger.tissue": "saal2017", "finger.skin.modulus": 90})
    assert (other.finger.tissue, other.finger.skin.modulus) == ("saal2017", 90)
