"""The receptive field of units: where an object makes them fire."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.__main__ import main
from fefinger.afferents import fire
from fefinger.scene import builtin
from fefinger.studies import receptive_field
from fefinger.studies.receptive_field import FILES, ReceptiveField, cheapest


SCENE = ff.Scene(
    finger=ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998"),
    indenter=ff.Pin(3.0),
    motion=ff.Trapezoid(speed=20, depth=0.5, hold=0.1, corner=0.01),
    ask=ff.Ask(rel_error=1.0),
)


@cache
def single():
    """Return the field of units with one end organ each."""
    options = {"reach": 2.0, "spacing": 2.0, "branched": False, "mechanics": "condensed"}
    return ff.receptive_field(SCENE, ("SAI", "FAI"), **options)


@pytest.fixture
def field(operators):
    """Return the field of units with one end organ each, from shared operators."""
    return single()


def test_a_unit_fires_most_under_the_object_and_less_beside_it(field):
    assert field.places.shape == (9, 2)
    assert field.impulses.shape == (9, 2)
    middle = np.flatnonzero((field.places == 0).all(axis=1))[0]
    for kind in field.kinds:
        fired = field.of(kind)
        assert fired[middle] == fired.max() > 0
        assert fired[middle] > 1.4 * np.median(fired)  # FAI: 4 spikes against 2
        assert field.organs[kind].shape == (1, 2)


def test_a_seed_moves_end_organs_and_changes_no_gain(monkeypatch):
    """The currents, which have no noise, of units with one end organ are those of every seed."""
    given = []

    def kept(ask, response, **options):
        trains = fire(ask, response, **options)
        given.append(trains.current)
        return trains

    monkeypatch.setattr(receptive_field, "fire", kept)
    ball = replace(SCENE, indenter=ff.Sphere(5))
    options = {"reach": 2.0, "spacing": 2.0, "branched": False, "mechanics": "hertz"}
    for seed in (0, 1):
        ff.receptive_field(ball, ("SAI", "FAI"), seed=seed, **options)
    half = len(given) // 2
    for one, other in zip(given[:half], given[half:], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)


def test_a_scene_that_names_its_mechanics_is_answered_by_it():
    ask = replace(SCENE.ask, mechanics="layered", fields=False)
    ball = replace(SCENE, indenter=ff.Sphere(5), ask=ask)
    field = ff.receptive_field(ball, ("SAI",), reach=2.0, spacing=2.0, branched=False)
    assert field.mechanics == "layered"


def test_the_field_is_that_of_the_scene_with_the_object_there(field):
    """Against a run of its own, with a population of that one unit."""
    place = (0.0, 2.0)
    units = ff.Places(places=((0.0, 0.0),), branched=False, spread=0.0)
    ask = replace(SCENE.ask, spikes=("SAI", "FAI"), population=units, fields=False)
    moved = replace(SCENE, indenter=replace(SCENE.indenter, at=place), ask=ask)
    counts = ff.run(moved, mechanics="condensed").spikes.count()
    index = np.flatnonzero((field.places == place).all(axis=1))[0]
    assert field.impulses[index].tolist() == counts.tolist()


@pytest.mark.usefixtures("operators")
def test_a_place_beside_the_pad_is_left_out_and_said():
    options = {"reach": 20.0, "spacing": 20.0, "branched": False, "mechanics": "condensed"}
    field = ff.receptive_field(SCENE, ("SAI",), **options)
    assert field.places.tolist() == [[0.0, 0.0]]
    assert len(field.left_out) == len(field.record()["left_out"]) == 8
    assert "indenter.at" in field.left_out[0][1]
    (axis,) = field.figure().axes[:1]
    assert axis.get_images()[0].get_array().tolist() == [field.of("SAI").tolist()]


def test_a_place_that_is_left_out_is_a_hole_in_the_picture():
    """Also one without which no place is in its column nor in its row."""
    places = 2.0 * np.array([[-1, 1], [1, 1], [1, -1]])
    field = ReceptiveField(
        ("SAI",), places, np.array([[3], [1], [2]]), 2.0, {"SAI": places}, "", ""
    )
    shown = field.figure().axes[0].get_images()[0]
    assert tuple(shown.get_extent()) == (-3.0, 3.0, -3.0, 3.0)
    holes = np.full((3, 3), np.nan)
    holes[[2, 2, 0], [0, 2, 2]] = 3, 1, 2
    np.testing.assert_array_equal(np.ma.filled(shown.get_array(), np.nan), holes)


def test_the_area_is_that_of_the_places_above_a_part_of_the_most():
    places = np.array([[0.0, 0.0], [0.0, 0.5], [0.5, 0.0], [0.5, 0.5]])
    impulses = np.array([[10, 0], [5, 0], [4, 0], [0, 0]])
    field = ReceptiveField(("SAI", "FAI"), places, impulses, 0.5, {}, "scene", "condensed")
    assert field.area("SAI") == pytest.approx(2 * 0.25)
    assert field.area("SAI", 0.3) == pytest.approx(3 * 0.25)
    more = replace(field, impulses=np.array([[10, 0], [5, 0], [1, 1], [0, 0]]))
    assert [more.area(kind, 0.0) for kind in more.kinds] == pytest.approx([3 * 0.25, 0.25])
    areas = more.record()["units"]["SAI"]
    assert areas["half_area_mm2"] == pytest.approx(0.5)
    assert areas["area_mm2"] == pytest.approx(0.75)
    assert field.area("FAI") == field.area("FAI", 0.0) == 0.0
    with refused("kind"):
        field.of("FAII")


def test_it_writes_a_table_and_a_picture(field, tmp_path, monkeypatch):
    assert [path.rpartition("/")[2] for path in field.save(tmp_path)] == list(FILES)
    lines = (tmp_path / "field.csv").read_text().splitlines()
    assert lines[0] == "x_mm,y_mm,SAI_impulses,FAI_impulses"
    assert len(lines) == 10
    assert (tmp_path / "field.svg").read_text().startswith("<svg")
    assert json.loads(json.dumps(field.record()))["mechanics"] == "condensed"
    monkeypatch.setattr("fefinger.view.figures.svg", lambda drawn: "<svg>")
    field.save(tmp_path)  # replaces its own
    assert (tmp_path / "field.svg").read_text() == "<svg>"


@pytest.mark.parametrize("name", FILES)
def test_files_of_another_origin_are_not_overwritten(name, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(receptive_field, "receptive_field", None)  # before it computes
    (tmp_path / name).write_text("x,y\n1,2\n")
    assert main(["field", "-o", str(tmp_path)]) == 2
    assert f"'{name}' in {str(tmp_path)!r} would be overwritten" in capsys.readouterr().err
    assert (tmp_path / name).read_text() == "x,y\n1,2\n"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["flat-press"], "indenter.kind: expected an object with a place"),
        (["pin-hold", "--spacing", "0.1"], "spacing: expected at most 1000 places"),
        (["pin-hold", "--reach", "0.5"], "reach"),
        (["pin-hold", "--type", "SA"], "SAI"),
    ],
)
def test_what_has_no_field_is_refused_in_a_sentence(options, message, capsys):
    assert main(["field", *options]) == 2
    assert message in capsys.readouterr().err


def test_many_places_share_what_a_mechanics_builds_once(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    changes = {"indenter.at": [0.5, 0.5], "finger.tissue": "maeno1998"}
    # Layers are cheaper, where more error is allowed.
    meshed = {"finger.resolution": "standard", "ask.rel_error": 0.2}
    scene = builtin.load("pin-hold", changes | meshed)
    assert cheapest(scene, 1) == "linear"
    assert cheapest(scene, 1000) == "condensed"
    refused = builtin.load("pin-hold", changes | {"ask.rel_error": 1e-6})
    assert cheapest(refused, 1) is None
