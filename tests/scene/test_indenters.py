"""Cylinders, bars, gratings and reliefs: from TOML and files, who answers them, how they look."""

import ast
import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.geometry.height_map import MOST
from fefinger.mechanics import hertz, layered, linear, lumped
from fefinger.mechanics.situation import Situation
from fefinger.pages.report import _touch
from fefinger.result import Result
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import INDENTERS
from fefinger.scene.toml import MOTIONS
from fefinger.support.checks import InputError
from fefinger.view import frames


LINE = tuple(np.linspace(-6, 6, 25).tolist())
FINE = np.linspace(-3, 3, 61)


def dots(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 0.2 * np.cos(2 * np.pi * x / 3) * np.cos(2 * np.pi * y / 3)


RELIEF = ff.Relief.of(dots, LINE, LINE)
CHECKS = {"isinstance", "issubclass"}
OBJECTS = [
    ff.Cylinder(4.0),
    ff.Cylinder(1 / 3, roll=90, at=(-1.0, 0.5)),
    ff.Bar(3.0, 0.7, roll=-20),
    ff.Pin(1.0, at=(0.2, 0.1)),
    ff.Grating(3.0, 1.0, 0.5, shift=0.1 + 0.2, angle=20, tilt=5, roll=45),
    RELIEF,
    ff.Dots(2.5, diameter=0.8, arrangement="random", seed=3, roll=20),
    ff.Braille("ab", start=-1 / 3),
    ff.Letters("O", size=5, angle=20),
    ff.Fabric(1.5, height=0.2, fiber=0.3, seed=4, roll=15),
]
EXTENT = {"pressure": False, "strain": False, "fields": False}


def scene(indenter: Indenter, **requested: object) -> ff.Scene:
    return ff.Scene(
        finger=ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998"),
        indenter=indenter,
        motion=ff.Ramp(60, 0.6),
        ask=ff.Ask(**({"fields": False} | requested)),
    )


@pytest.mark.parametrize("indenter", OBJECTS, ids=lambda one: one.kind)
def test_a_scene_survives_toml_exactly(indenter: Indenter) -> None:
    there = scene(indenter)
    again = ff.Scene.from_toml(there.to_toml())
    assert again == there  # exact: TOML keeps every digit
    assert hash(again) == hash(there)


def written(path: Path) -> Path:
    if path.suffix == ".npz":
        np.savez(path, x=LINE, y=LINE, height=RELIEF.heights)
        return path
    rows = [
        f"{x},{y},{RELIEF.heights[i][j]!r}" for i, x in enumerate(LINE) for j, y in enumerate(LINE)
    ]
    path.write_text("x,y,height\n" + "\n".join(reversed(rows)) + "\n")
    return path


@pytest.mark.parametrize("name", ["dots.csv", "dots.npz"])
def test_a_relief_is_read_from_a_file_beside_its_scene(tmp_path: Path, name: str) -> None:
    written(tmp_path / name)
    text = scene(ff.Flat()).to_toml()
    text = text.replace('kind = "flat"', f'kind = "relief"\nfile = "{name}"\nroll = 10.0')
    (tmp_path / "mine.toml").write_text(text)
    read = ff.Scene.from_toml(tmp_path / "mine.toml")
    assert read.indenter == dataclasses.replace(RELIEF, roll=10)  # exact: the file has every digit


def test_a_matrix_of_heights_lies_as_the_pixels_of_a_picture(tmp_path: Path) -> None:
    heights = np.arange(20.0).reshape(4, 5) / 100
    np.savetxt(tmp_path / "h.csv", heights, "%g", ",")
    read = ff.Relief.from_file(tmp_path / "h.csv", pitch=0.5)
    assert read.x == (-1, -0.5, 0, 0.5, 1)
    assert read.y == (-0.75, -0.25, 0.25, 0.75)
    np.testing.assert_array_equal(read.heights, heights[::-1].T)


MATRICES = [
    ("1,2,3,4\n1,2,3\n", 0.1, "line 2: expected 4 values, received 3"),
    ("x,y,height\n1,2,3\n", 0.1, "numbers alone, without a header, received the first line 'x,y"),
    (",".join("1" * 99) + "\n1\n", None, "^indenter.pitch: missing; .{,250}$"),
    ("1,2\n3,4\n", 0.1, "at least 4 by 4 heights in .* received 2 by 2"),
]


@pytest.mark.parametrize(("text", "pitch", "message"), MATRICES)
def test_a_matrix_that_cannot_be_used_gets_a_sentence(
    tmp_path: Path, text: str, pitch: float | None, message: str
) -> None:
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(InputError) as refused:
        ff.Relief.from_file(tmp_path / "bad.csv", pitch=pitch)
    assert re.search(message, str(refused.value).replace(str(tmp_path), ""))


def test_a_missing_file_is_named_before_its_options(tmp_path: Path) -> None:
    for place, reason in ((tmp_path / "none.csv", "does not exist"), (tmp_path, "is a folder")):
        with pytest.raises(InputError, match=f"indenter.file: .*{reason}"):
            ff.Relief.from_file(place, height=0.1)


def test_too_few_heights_are_told_as_such() -> None:
    with refused("indenter.heights"):
        ff.Relief.from_array(np.zeros((3, 3)), pitch=0.1)


BAD_FILES = [
    ("a,b,c\n1,2,3\n", "the first line to be 'x,y,height', .*received 'a,b,c'"),
    ("x,y,height\n", "received the header .x,y,height. alone"),
    ("x,y,height\n1,2,3\n1,3,oops\n", "line 3, column height: expected a finite number"),
    ("x,y,height\n1,2,3\n1,3,4\n2,2,5\n", "3 rows for 2 x 2 places"),
    ("x,y,height\n1,2,3\n1,2,3\n1,2,3\n", "3 rows for 1 x 1"),
]


@pytest.mark.parametrize(("text", "message"), BAD_FILES)
def test_a_file_that_is_no_grid_gets_a_sentence(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(InputError, match=message):
        ff.Relief.from_file(tmp_path / "bad.csv")


def test_an_archive_without_the_arrays_or_with_other_shapes_gets_a_sentence(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", x=LINE)
    with pytest.raises(InputError, match="expected arrays x, y and height"):
        ff.Relief.from_file(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", x=LINE, y=LINE, height=np.zeros((3, 25)))
    with pytest.raises(InputError, match=r"shape \(x, y\) = \(25, 25\)"):
        ff.Relief.from_file(tmp_path / "b.npz")
    with refused("indenter.file"):
        ff.Relief.from_file(tmp_path / "none.csv")


def test_heights_may_be_an_array() -> None:
    assert ff.Relief(LINE, LINE, np.array(RELIEF.heights)) == RELIEF  # exact: the same numbers
    # exact: the same numbers
    assert ff.Relief(LINE, LINE, list(np.array(RELIEF.heights))) == RELIEF


BAD = [
    (lambda: ff.Cylinder(0), "indenter.radius: .*above 0"),
    (lambda: ff.Cylinder(1, roll=200), "indenter.roll: .*at most 180"),
    (lambda: ff.Bar(1, 0.6), "indenter.corner: .*at most 0.5"),
    (lambda: ff.Grating(2, 2, 1), "indenter.ridge: .*below 2"),
    (lambda: ff.Grating(2, 1, 0), "indenter.depth: .*above 0"),
    (lambda: ff.Grating(2, 1, 1, shift=np.nan), "indenter.shift: expected a finite"),
    (lambda: ff.Grating(2, 1, 1, angle=70), "indenter.angle: .*at most 60"),
    (lambda: ff.Relief((0, 1, 1, 2), LINE, RELIEF.heights), "indenter.x: .*rising"),
    (lambda: ff.Relief((0, 1, 2), LINE, RELIEF.heights), "indenter.x: expected at least 4"),
    (lambda: ff.Relief(LINE, LINE, RELIEF.heights[:-1]), "one row for each of the 25 .* 24 rows"),
    (lambda: ff.Relief(LINE, LINE, np.zeros((24, 25))), "one row for each of the 25 .* 24 rows"),
    (
        lambda: ff.Relief(LINE, LINE, np.array(3.0)),
        "indenter.heights: expected a list of lists of numbers",
    ),
    (lambda: ff.Relief(LINE, LINE[:-1], RELIEF.heights), r"indenter.heights\[0\]: .*24 numbers"),
    (lambda: ff.Relief.of(lambda x, y: x / 0, LINE, LINE), r"heights\[0\]\[0\]: .*finite"),
    (lambda: ff.Relief.of(lambda x, y: 1.0, LINE, LINE), "one height for each of 25 x 25"),
]


@pytest.mark.parametrize(("make", "message"), BAD)
def test_what_cannot_be_an_object_gets_a_sentence(make: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("indenter", OBJECTS, ids=lambda one: one.kind)
def test_mechanics_without_such_an_object_say_so(indenter: Indenter) -> None:
    bare = scene(indenter, **EXTENT)
    for mechanics in (lumped, hertz):
        (refusal,) = mechanics.refuse(Situation.of(bare))
        assert refusal.about == "ability"
        assert f"indenter.kind = '{indenter.kind}'" in refusal.reason
    assert not layered.refuse(Situation.of(bare))


ANSWERS = {
    "flat": (ff.Flat(20, 5), (20, 5), (20, 5), None, 0, (np.inf, np.inf), None, np.inf),
    "sphere": (ff.Sphere(3, at=(1, 2)), None, None, (1, 2), 0, (3, 3), 3, 3),
    "ellipsoid": (ff.Ellipsoid((3, 2, 4)), None, None, None, 0, (9 / 4, 1), None, 1),
    "cylinder": (ff.Cylinder(4, roll=90), None, None, None, 90, None, None, 4),
    "bar": (ff.Bar(3, 0.7, at=(0, 1)), None, None, (0, 1), 0, None, None, 0.7),
    "pin": (ff.Pin(1, at=(0, 1)), None, None, (0, 1), 0, None, None, 0.2),
    "grating": (ff.Grating(3, 1, 0.5, roll=10), (30, 0), None, None, 10, None, None, 0.346),
    "dots": (ff.Dots(3, edge=0.2, roll=10), (30, 0), None, None, 10, None, None, 0.2),
    "braille": (ff.Braille("a", angle=20), (20, 0), None, None, 0, None, None, 0.25),
    "letters": (ff.Letters("I", edge=0.1), (30, 0), None, None, 0, None, None, 0.1),
    "fabric": (ff.Fabric(1.2, roughness=0), (30, 0), None, None, 0, None, None, 0.486),
    "relief": (ff.Relief.of(dots, FINE, FINE, angle=9), (9, 0), None, None, 0, None, None, 1.14),
}
"""Of every kind an object, with its plate, flat, place, turn, hertzian radii, ball and least
radius."""


@pytest.mark.parametrize("kind", INDENTERS)
def test_an_object_answers_for_itself(kind: str) -> None:
    one, plate, flat, place, turn, hertzian, ball, least = ANSWERS[kind]
    assert (one.kind, type(one)) == (kind, INDENTERS[kind])
    assert (one.plate, one.flat, one.place, one.turn) == (plate, flat, place, turn)
    assert (one.hertzian, one.ball_radius) == (hertzian, ball)
    assert one.least_radius == pytest.approx(least, rel=0.05)
    smooth = {"flat", "sphere", "ellipsoid", "cylinder"}
    assert one.sharp == (kind not in smooth)
    assert one.profile.plane == (kind == "flat")
    assert one.describe().startswith("a rigid ")


@pytest.mark.parametrize("kind", INDENTERS)
def test_the_radii_of_an_object_are_those_of_its_profile(kind: str) -> None:
    one = ANSWERS[kind][0]
    if one.hertzian is not None:
        curvature = one.profile.height(np.zeros(2))[2]
        assert np.diag(curvature) == pytest.approx(1 / np.array(one.hertzian))


@pytest.mark.parametrize("kind", INDENTERS)
def test_every_kind_is_a_final_class_with_one_line_of_bases(kind: str) -> None:
    made = INDENTERS[kind]
    assert made.__final__
    assert [len(each.__bases__) for each in made.__mro__[:-1]] == [1] * (len(made.__mro__) - 1)


def test_nothing_outside_its_file_looks_at_the_class_of_an_indenter_or_a_motion() -> None:
    expected = {cls.__name__ for cls in (*INDENTERS.values(), *MOTIONS.values())}
    expected |= {"Indenter", "Edged", "Raised", "Text"}
    expected |= {"Motion", "Ramped", "Vibrating", "SampledMotion"}
    seen = []
    for room in ("fefinger", "validation"):
        for file in (Path(__file__).parents[2] / room).rglob("*.py"):
            text = file.read_text(encoding="utf-8")
            if not any(name in text for name in expected):
                continue
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.Call) and getattr(node.func, "id", "") in CHECKS:
                    classes = {ast.unparse(part) for part in ast.walk(node.args[1])}
                    classes = {name.rpartition(".")[2] for name in classes}
                    seen += [f"{file.name}: {ast.unparse(node)}"] if classes & expected else []
    assert not seen


def test_the_smallest_radius_of_an_object_is_that_of_its_sharpest_crest() -> None:
    ridge = 10 / np.sqrt(3) * 0.5 / 1.0**2  # largest S'' = 10 / sqrt(3)
    assert ff.Grating(3, 1, 0.5).least_radius == pytest.approx(1 / ridge, rel=0.01)
    wave = 0.2 * (2 * np.pi / 3) ** 2
    assert ff.Relief.of(dots, FINE, FINE).least_radius == pytest.approx(1 / wave, rel=0.05)


def peak(indenter: Indenter, **requested: object) -> float:
    return float(linear.respond(scene(indenter, **(EXTENT | requested))).force[-1])


@pytest.fixture(scope="module")
def plate() -> float:
    return peak(ff.Flat())


def test_objects_without_relief_are_plates(plate: float) -> None:
    level = ff.Relief(LINE, LINE, tuple(tuple(0.0 for _ in LINE) for _ in LINE))
    for smooth in (ff.Grating(3, 1, 1e-9), level):
        assert peak(smooth) == pytest.approx(plate, rel=1e-5)


def test_ridges_take_less_force_and_touch_less(plate: float) -> None:
    assert 0.2 * plate < peak(ff.Grating(4, 2, 0.6)) < plate
    assert peak(ff.Cylinder(3.0, roll=90)) < plate


def test_a_half_finger_under_a_cylinder_is_half_of_the_whole() -> None:
    aside = peak(ff.Cylinder(4.0, roll=90.0, at=(-1.0, 1e-6)))
    assert peak(ff.Cylinder(4.0, roll=90.0, at=(-1.0, 0.0))) == pytest.approx(aside, rel=1e-4)


def test_which_objects_are_their_own_mirror_image() -> None:
    assert ff.Bar(3, 1, roll=90).mirrored
    assert ff.Grating(3, 1, 1, shift=0.2).mirrored
    assert not ff.Grating(3, 1, 1, shift=0.2, roll=90).mirrored
    assert not ff.Bar(3, 1, roll=30).mirrored
    assert not ff.Cylinder(3, at=(0, 1)).mirrored
    assert not RELIEF.mirrored


def test_a_grating_under_another_roll_is_a_relief_of_the_same_heights() -> None:
    grating = ff.Grating(4, 2, 0.3, roll=90)
    fine = np.linspace(-8, 8, 161)
    same = ff.Relief.of(
        lambda x, y: -grating.profile.height(np.stack([y, -x], axis=-1))[0], fine, fine
    )
    assert peak(same) == pytest.approx(peak(grating), rel=1e-3)


@pytest.mark.parametrize("indenter", OBJECTS, ids=lambda one: one.kind)
def test_an_object_reaches_its_depth_and_is_described(
    synthetic: Result, indenter: Indenter
) -> None:
    result = dataclasses.replace(
        synthetic, scene=dataclasses.replace(synthetic.scene, indenter=indenter)
    )
    pose = frames.pose(result, 1.5)
    outline = pose.outline(5.0)
    assert len(outline) > 100
    assert np.isfinite(outline).all()
    flat = np.insert(outline[:-2], 1, 0.0, axis=1) - pose.origin
    behind = pose.profile.height(flat @ pose.frame[:2].T)[0]
    if pose.roll or indenter.kind != "cylinder":
        assert flat @ pose.axis == pytest.approx(-behind, abs=1e-6)
    assert indenter.kind in _touch(result)


def test_an_object_with_a_place_moves_and_a_plate_does_not():
    pin = ff.Pin(1.0, at=(0.0, 1.0))
    assert pin.moved((2.0, -1.0)) == ff.Pin(1.0, at=(2.0, -1.0))
    with refused("indenter.kind"):
        ff.Flat(30).moved((0.0, 0.0))


def test_more_heights_than_a_finger_needs_are_refused_before_they_are_read(tmp_path: Path) -> None:
    """A small file holds many zeros; a grid of scattered places would have their square."""
    size = MOST // 1000 + 1
    np.savez_compressed(
        tmp_path / "many.npz", x=np.arange(size), y=np.arange(1000), height=np.zeros((size, 1000))
    )
    np.savez_compressed(tmp_path / "huge.npz", x=[0], y=[0], height=np.zeros(2 * MOST, complex))
    (tmp_path / "many.csv").write_text((",".join("0" * 1000) + "\n") * size)
    for name, pitch in (("many.npz", None), ("huge.npz", None), ("many.csv", 0.1)):
        with pytest.raises(InputError, match=r"(at most|more than) 1000+ ") as refusal:
            ff.Relief.from_file(tmp_path / name, pitch=pitch)
        assert refusal.value.field == "indenter.file"
    with refused("indenter.heights"):
        ff.Relief(range(size), range(1000), [])
    places = "".join(f"{k},{k},0\n" for k in range(100_000))
    (tmp_path / "scattered.csv").write_text(f"x,y,height\n{places}")
    with pytest.raises(InputError, match="100000 rows for 100000 x 100000 places"):
        ff.Relief.from_file(tmp_path / "scattered.csv")


def test_an_archive_holds_real_numbers(tmp_path: Path) -> None:
    lines, heights = np.arange(5), np.zeros((5, 5))
    file = tmp_path / "relief.npz"
    np.savez(file, x=lines, y=lines, height=heights)
    assert ff.Relief.from_file(file).heights[4] == (0.0,) * 5
    content = file.read_bytes()
    file.write_bytes(content[:100] + bytes(200) + content[300:])
    with pytest.raises(InputError, match="expected arrays x, y and height"):
        ff.Relief.from_file(file)
    for kind in (complex, str, bool):
        np.savez(file, x=lines, y=lines, height=heights.astype(kind))
        with pytest.raises(InputError, match="height has other values than real numbers"):
            ff.Relief.from_file(file)
