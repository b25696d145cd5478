"""Motions with a path: where the object is, when it moves, and what is refused."""

import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.mechanics import hertz, lumped
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.mechanics.situation import Situation
from fefinger.scene import builtin
from fefinger.support.checks import InputError


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
SLIDES = [
    ff.Slide(60, distance=10, direction=30, passes=3, settle=0.2, corner=corner, **{control: 1.2})
    for control in ("depth", "force")
    for corner in (0.0, 0.01)
]
PATHS = [
    ff.SampledPath((0, 0.1, 0.5), (0, 1, 0), (0, 0, 3), (0, 1, 1), corner=0.02),
    ff.SampledPath((0, 0.1, 0.5), (0, 1, 0), (0, 0, 3), force=(0, 1, 1)),
]


KINDS = {type(motion).__name__: type(motion) for motion in (*SLIDES, *PATHS)}


@pytest.mark.parametrize("motion", [*SLIDES, *PATHS], ids=str)
def test_a_path_is_the_integral_of_its_velocity_and_continuous(motion):
    assert eval(repr(motion), KINDS) == pickle.loads(pickle.dumps(motion)) == motion
    for start, stop in zip(motion.breakpoints[:-1], motion.breakpoints[1:], strict=True):
        inside = np.linspace(start, stop, 2001)
        middle = (inside[1:] + inside[:-1]) / 2
        way = motion.velocity(middle).sum(axis=0) * (stop - start) / 2000
        assert motion.shift(stop) - motion.shift(start) == pytest.approx(way, abs=1e-9)


@pytest.mark.parametrize("motion", [*SLIDES, *PATHS], ids=str)
def test_it_moves_in_the_intervals_called_moving_and_nowhere_else(motion):
    time = np.linspace(0, motion.duration, 4001)[1:-1]
    within = np.zeros(len(time), bool)
    for start, stop in motion.moving:
        within |= (time >= start) & (time <= stop)
    moves = (motion.rate(time) != 0) | (motion.velocity(time) != 0).any(axis=1)
    assert (moves & ~within).sum() == 0
    assert (within & ~moves).sum() <= 2 * len(motion.moving)
    steps = time_grid(motion, fast=False)
    assert np.abs(np.array(motion.breakpoints)[:, None] - steps).min(axis=1).max() < 1e-12


@pytest.mark.parametrize("motion", SLIDES, ids=str)
def test_passes_go_forth_and_back_along_the_direction_after_the_rest(motion):
    assert not motion.shift(np.linspace(0, motion.recorded_from, 50)).any()
    heading = np.array([np.cos(np.radians(30)), np.sin(np.radians(30))])
    assert motion.shift(motion.duration) == pytest.approx(10 * heading)
    time = np.linspace(0, motion.duration, 10001)
    along = motion.shift(time) @ heading
    assert along.max() == pytest.approx(10)
    turns = np.diff(np.sign(motion.velocity(time) @ heading))
    assert (np.abs(turns) > 0).sum() >= 3
    assert np.abs(motion.shift(time) @ [-heading[1], heading[0]]).max() < 1e-12
    assert motion.value(motion.recorded_from) == pytest.approx(1.2)
    assert motion.value(motion.duration) == pytest.approx(1.2)


@pytest.mark.parametrize(
    ("direction", "expected"), [(0, (1, 0)), (90, (0, 1)), (180, (-1, 0)), (-90, (0, -1))]
)
def test_right_angles_are_exact_and_tell_whether_the_scene_is_symmetric(direction, expected):
    motion = ff.Slide(10, 1, distance=2, direction=direction)
    assert (motion.shift(motion.duration) == 2 * np.array(expected)).all()
    assert motion.mirrored == (expected[1] == 0)
    scene = ff.Scene(finger=FINGER, motion=motion)
    assert Situation.of(scene).half == scene.mirrored == motion.mirrored


@pytest.mark.parametrize("control", ["depth", "force"])
def test_a_path_is_read_beside_the_scene_file(tmp_path: Path, control: str):
    prefix = "force-" if control == "force" else ""
    (tmp_path / "path.csv").write_text(f"time,x,y,{control}\n0,0,0,0\n1,2,0,0.5\n2,2,3,0.5\n")
    (tmp_path / "scene.toml").write_text(
        f'[finger]\nsubject = "a.h."\n[motion]\nkind = "{prefix}sampled-path"\nfile = "path.csv"\n'
    )
    motion = builtin.load(tmp_path / "scene.toml").motion
    assert motion.control == control
    assert motion.shift([0.5, 1.5]) == pytest.approx(np.array([[1, 0], [2, 1.5]]))
    assert motion.value(1.5) == 0.5
    assert not motion.mirrored


@pytest.mark.parametrize("name", ["yaw", "Roll (deg)"])
def test_a_turn_that_is_not_modeled_is_refused_unless_it_is_none(tmp_path: Path, name: str):
    file = tmp_path / "path.csv"
    file.write_text(f"time,x,y,depth,{name}\n0,0,0,0,3\n1,2,0,0.5,3\n")
    assert ff.SampledPath.from_csv(file).shift(1.0) == pytest.approx([2, 0])
    file.write_text(f"time,x,y,depth,{name}\n0,0,0,0,3\n1,2,0,0.5,4\n")
    with pytest.raises(
        InputError, match=re.escape(f"column {name!r}: expected no turn of a plate but angle")
    ):
        ff.SampledPath.from_csv(file)


BAD = [
    (lambda: ff.Slide(60, 1, distance=0), "motion.distance: .* above 0"),
    (lambda: ff.Slide(60, 1, distance=5, passes=0), "motion.passes: .* at least 1"),
    (lambda: ff.Slide(60, 1, distance=5, passes=1.5), "motion.passes: expected a whole number"),
    (lambda: ff.Slide(60, 1, distance=5, direction=400), "motion.direction: .* at most 360"),
    (lambda: ff.Slide(60, 1, distance=5, corner=3), "motion.corner: expected at most"),
    (lambda: ff.SampledPath((0, 1), (0,), (0, 1), (0, 1)), "motion.x: .* received 1 values and 2"),
    (lambda: ff.Flat(30, friction=-0.1), "indenter.friction: .* at least 0, received -0.1"),
    (lambda: ff.Sphere(3, friction=float("nan")), "indenter.friction: expected a finite number"),
]


@pytest.mark.parametrize(("make", "message"), BAD)
def test_what_is_no_path_and_no_friction_gets_a_sentence(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_path_that_leaves_the_object_is_refused_before_any_work():
    with pytest.raises(InputError, match="along its x, received one from 0 to 90 mm; take a shor"):
        ff.Scene(
            finger=FINGER,
            indenter=ff.Letters("ab"),
            motion=ff.Slide(60, 1, distance=90, direction=180),
        )
    aside = ff.Slide(60, 1, distance=60, direction=90)
    with refused("motion"):
        ff.Scene(finger=FINGER, indenter=ff.Braille("ab"), motion=aside)
    ff.Scene(finger=FINGER, indenter=ff.Dots(3), motion=aside)


@pytest.mark.parametrize(
    ("roll", "direction"), [(0, 180), (0, 90), (0, 200), (30, 150), (30, 0), (180, 0)]
)
def test_the_distance_that_a_refused_path_names_is_the_longest_accepted(roll, direction):
    def scene(distance: float) -> ff.Scene:
        motion = ff.Slide(60, 1, distance=distance, direction=direction)
        return ff.Scene(finger=FINGER, indenter=ff.Braille("ab", roll=roll), motion=motion)

    with refused("motion") as caught:
        scene(90.0)
    longest = float(re.search(r"\(motion.distance at most ([\d.]+)\)", str(caught.value))[1])
    scene(longest)
    with refused("motion"):
        scene(longest + 0.02)


def test_a_path_from_beside_the_object_has_no_shorter_one():
    with refused("motion"):
        ff.Scene(
            finger=FINGER,
            indenter=ff.Braille("ab", start=40.0),
            motion=ff.Slide(60, 1, distance=9, direction=180),
        )


@pytest.mark.parametrize(
    ("mechanics", "lacking"),
    [
        (lumped, {"motion.kind", "indenter.friction"}),
        (hertz, {"motion.kind", "indenter.friction"}),
    ],
)
def test_the_other_mechanics_name_the_field_that_they_have_no_answer_for(mechanics, lacking):
    motion = ff.Slide(60, 1, distance=5)
    scene = ff.Scene(finger=FINGER, indenter=ff.Flat(30, friction=0.4), motion=motion)
    refusals = mechanics.refuse(Situation.of(scene))
    assert lacking <= {each.field for each in refusals}
    assert any(
        "indenter.friction = 0.4 > 0: this mechanics has" in each.reason for each in refusals
    )
    lateral = [each for each in refusals if each.field in {"motion.kind", "indenter.friction"}]
    assert all(each.about == "ability" for each in lateral)


def test_each_pass_is_a_span_between_its_corners():
    there_and_back = ff.Slide(20, 0.5, distance=10, settle=0.1, corner=0.02, passes=2)
    spans = there_and_back.even_spans
    start = there_and_back.recorded_from
    lengths = [(start + 0.02, start + 0.5), (start + 0.52, start + 1.0)]
    np.testing.assert_allclose(spans, lengths, atol=1e-9)


def test_a_path_has_a_span_for_each_velocity_and_none_at_rest():
    time = (0.0, 0.1, 0.2, 0.4, 0.5, 0.6)
    path = ff.SampledPath(time, (0, 0, 2, 6, 6, 5), (0.0,) * 6, depth=(0, 0.5, 0.5, 0.5, 0.5, 0.5))
    spans = path.even_spans
    np.testing.assert_allclose(spans, [(0.1, 0.4), (0.5, 0.6)], atol=1e-9)
