"""A plate that turns along a path: its distances, symmetry, contact, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

import fefinger as ff
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.travel import Heights, envelope
from fefinger.geometry.profiles import frame
from fefinger.mechanics import condensed, linear, pressed, solid
from fefinger.mechanics.situation import Situation
from fefinger.scene.indenter import direction
from fefinger.support.checks import InputError


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
ASK = ff.Ask(fields=False)
TIMES, DEPTH = (0.0, 0.1, 0.2), (0.0, 0.6, 0.6)
STILL = (0.0, 0.0, 0.0)


pytestmark = pytest.mark.usefixtures("operators")


def respond(motion, **plate):
    indenter = ff.Flat(30, **plate)
    return condensed.respond(ff.Scene(finger=FINGER, indenter=indenter, motion=motion, ask=ASK))


def rock(**turns):
    return ff.SampledPath(TIMES, STILL, STILL, DEPTH, **turns)


@pytest.mark.parametrize(("angle", "tilt"), [(34.0, 0.0), (30.0, 7.0), (26.0, -5.0)])
def test_distances_are_those_to_the_turned_plane_along_the_travel(angle, tilt):
    plate, shift = ff.Flat(30), np.array([0.7, -0.4])
    obstacle = Obstacle(direction(plate), np.array([0.1, 0.2, -0.3]))
    points = np.random.default_rng(2).uniform(-4, 4, (50, 3))
    motion = rock(angle=(30, angle, angle), tilt=(0, tilt, tilt))
    incline = motion.inclines(0.2, plate)
    pivot, normal = (
        obstacle.origin + shift @ frame(obstacle.axis)[:2],
        direction(ff.Flat(angle, tilt)),
    )
    exact = (points - pivot) @ normal / (normal @ obstacle.axis)
    assert Heights.over(obstacle, points).distance(shift, incline) == pytest.approx(exact)
    swept = envelope(obstacle, shift[None], incline[None])
    assert swept.gap(points)[0] == pytest.approx(exact, abs=0.05)  # places in hundredths of a mm


@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_a_plate_that_has_its_angle_all_the_time_does_not_turn(mu):
    turned = respond(rock(angle=(30, 30, 30), tilt=STILL), friction=mu)
    level = respond(rock(), friction=mu)
    assert turned.force == pytest.approx(level.force, rel=1e-9, abs=1e-12)
    assert turned.contact_area == pytest.approx(level.contact_area, rel=1e-9)
    assert np.abs(turned.lateral.force - level.lateral.force).max() < 1e-9
    assert any(each.startswith("Turning") for each in turned.notes)


def test_tilts_to_both_sides_are_mirror_images():
    one, other = (respond(rock(tilt=(0, side, side))) for side in (6.0, -6.0))
    assert one.force[-1] == pytest.approx(other.force[-1], rel=1e-6)
    assert one.centroid[-1] == pytest.approx(other.centroid[-1] * (1, -1), abs=1e-5)
    assert abs(one.centroid[-1, 1]) > 0.2


@pytest.mark.parametrize("angle", [25.0, 36.0])
def test_a_turned_plate_touches_where_a_plate_of_that_angle_does(angle):
    force = (0.0, 0.4, 0.4)
    motion = ff.SampledPath(TIMES, STILL, STILL, force=force, angle=(30, 30, angle))
    turned = respond(motion)
    straight = condensed.respond(
        ff.Scene(
            finger=FINGER,
            indenter=ff.Flat(angle),
            motion=ff.Sampled(TIMES, force=force),
            ask=ASK,
        )
    )
    start = turned.centroid[np.searchsorted(turned.time, 0.1), 0]
    moved = straight.centroid[-1, 0] - start
    assert abs(moved) > 0.3
    assert turned.centroid[-1, 0] - start == pytest.approx(moved, rel=0.25)
    assert turned.contact_area[-1] == pytest.approx(straight.contact_area[-1], rel=0.1)


def test_pressure_on_a_turned_plate_pulls_along_it():
    turned = respond(rock(angle=(30, 30, 35)))
    slope = rock(angle=(30, 30, 35)).inclines(0.2, ff.Flat(30))
    assert np.abs(slope) == pytest.approx([np.tan(np.radians(5)), 0.0])
    assert turned.lateral.force[-1] == pytest.approx(turned.force[-1] * slope, rel=1e-6)


def test_angles_are_read_from_a_file_after_the_other_columns(tmp_path: Path):
    file = tmp_path / "path.csv"
    file.write_text("time,x,y,depth,angle,tilt (degrees)\n0,0,0,0,30,0\n1,1,0,0.5,33,-2\n")
    read = ff.SampledPath.from_csv(file)
    assert (read.angle, read.tilt) == ((30.0, 33.0), (0.0, -2.0))
    assert read.turns_plate
    assert not read.mirrored
    scene = ff.Scene(finger=FINGER, indenter=ff.Flat(30), motion=read, ask=ASK)
    assert ff.Scene.from_toml(scene.to_toml()) == scene
    file.write_text("time,x,y,depth,tilt\n0,0,0,0,0\n1,1,0,0.5,4\n")
    assert ff.SampledPath.from_csv(file).angle is None
    file.write_text("time,x,y,depth,yaw\n0,0,0,0,4\n1,1,0,0.5,4\n")
    assert ff.SampledPath.from_csv(file).angle is None  # a column of another quantity


@pytest.mark.parametrize(
    ("turns", "message"),
    [
        ({"angle": (30, 31)}, "motion.angle: expected as many values as times, .*received 2"),
        ({"angle": (30, 70, 30)}, r"motion.angle\[1\]: .* at most 60"),
        ({"tilt": (0, float("nan"), 0)}, r"motion.tilt\[1\]: expected"),
    ],
)
def test_angles_that_are_none_of_a_plate_get_a_sentence(turns, message):
    with pytest.raises(InputError, match=message):
        rock(**turns)


@pytest.mark.parametrize(
    ("mechanics", "indenter", "turns", "reason"),
    [
        (linear, ff.Flat(30), {"angle": (30, 45, 30)}, "= 15 degrees > 10"),
        (condensed, ff.Flat(30), {"tilt": (0, 20, 0)}, "degrees > 10"),
        (condensed, ff.Dots(3), {"angle": (30, 32, 30)}, "a smooth plate alone turns"),
        (solid, ff.Flat(30), {"angle": (30, 32, 30)}, "its plate does not turn"),
        (pressed, ff.Flat(30), {"angle": (30, 32, 30)}, "its plate does not turn"),
    ],
)
def test_turns_beyond_what_a_mechanics_does_are_refused(mechanics, indenter, turns, reason):
    refusals = mechanics.refuse(Situation(FINGER, indenter, rock(**turns), ASK))
    (refusal,) = (each for each in refusals if each.field == "motion.angle")
    assert refusal.about == "ability"
    assert reason in refusal.reason
    small = mechanics.refuse(Situation(FINGER, ff.Flat(30), rock(), ASK))
    assert not [each for each in small if each.about == "ability"]
