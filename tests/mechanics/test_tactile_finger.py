"""A finger for simulators: objects at any pose, many worlds."""

import copy
import pickle
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from fefinger.validation.evidence import tactile
from numpy.typing import ArrayLike
from refusals import refused

import fefinger as ff
from fefinger.geometry.profiles import frame
from fefinger.mechanics import tactile_finger
from fefinger.mechanics.evidence.presses import read
from fefinger.mechanics.evidence.tactile_errors import REPORT, measured_errors
from fefinger.mechanics.press import elastic_press
from fefinger.mechanics.press.tactile_parts import under
from fefinger.results.touch import Touch
from fefinger.scene.indenter import direction
from fefinger.support.checks import InputError


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
ELASTIC = ff.Finger.subject(
    "a.h.", resolution="coarse", tissue="maeno1998", prony=ff.Prony((1.0,), ())
)
STIFFENING = ff.Finger.subject("a.h.", resolution="coarse")
PLATE = under(30.0)
NORMAL = PLATE[:, 2]
BALL = ff.shapes.Sphere(6.0)
TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])

pytestmark = pytest.mark.usefixtures("module_operators")


@pytest.fixture(scope="module", params=[0.0, 0.6], ids=["frictionless", "friction"])
def tip(request: pytest.FixtureRequest) -> ff.TactileFinger:
    return ff.TactileFinger(FINGER, friction=request.param, finite_strain=False)


def plate(
    tip: ff.TactileFinger,
    depth: float,
    dt: float = 5e-3,
    shift: Sequence[float] = (0, 0),
    touch: ArrayLike = (0, 0, 0),
) -> Touch:
    across = frame(direction(ff.Flat(30.0)))[:2].T @ np.asarray(shift, float)
    return tip.step([(ff.shapes.Plane(), PLATE, np.asarray(touch) + depth * NORMAL + across)], dt)


def ball(
    tip: ff.TactileFinger, depth: float, dt: float = 5e-3, shift: ArrayLike = (0, 0, 0)
) -> Touch:
    return tip.step([(BALL, np.eye(3), (depth - 6.0) * NORMAL + np.asarray(shift, float))], dt)


def about_z(degrees: float) -> np.ndarray:
    turn = np.radians(degrees)
    return np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])


def test_a_plate_is_that_of_the_loop_with_its_relaxation_and_friction(
    tip: ff.TactileFinger,
) -> None:
    tip.reset()
    loop = ff.Loop(
        FINGER, ff.Flat(30, friction=tip.friction), mechanics="condensed", deepest=1.2, reach=2.0
    )
    for k in range(40):
        depth, shift = (
            min(0.05 * k, 0.9),
            (0.03 * max(0, k - 20), 0.1 * np.sin(0.3 * max(0, k - 20))),
        )
        step = loop.step(5e-3, depth=depth, shift=shift)
        touch = plate(tip, depth, shift=shift, touch=loop.prepared.touch)
        force = touch.wrench[0, :3]
        assert force @ NORMAL == pytest.approx(step.force, rel=1e-9, abs=1e-10)
        across = frame(direction(ff.Flat(30.0)))[:2] @ force
        assert np.allclose(across, step.lateral_force, atol=1e-9)
        assert touch.stick_area[0] == pytest.approx(step.stick_area, rel=1e-9)


@pytest.mark.parametrize("radius", [3.0, 8.0])
def test_a_ball_is_that_of_the_loop_within_two_percent(radius: float) -> None:
    tip = ff.TactileFinger(FINGER, finite_strain=False)
    loop = ff.Loop(FINGER, ff.Sphere(radius), mechanics="condensed", deepest=1.2)
    for depth in (0.3, 0.6, 0.9, 1.2):
        wanted = loop.step(0.05, depth=depth).force
        shape = ff.shapes.Sphere(radius)
        place = loop.prepared.touch + (depth - radius) * NORMAL
        touch = tip.step([(shape, TURN, place)], 0.05)
        assert touch.wrench[0, :3] @ NORMAL == pytest.approx(wanted, rel=0.02)


def test_the_same_ball_by_samples_and_as_an_ellipsoid(tip: ff.TactileFinger) -> None:
    same = (
        (ff.shapes.Ellipsoid(6, 6, 6), 1e-6),
        (
            ff.shapes.function(
                lambda p: np.linalg.norm(p, axis=1) - 6, [-7] * 3, [7] * 3, pitch=0.25
            ),
            0.02,
        ),
    )
    tip.reset()
    wanted = ball(tip, 0.8).wrench[0]
    for shape, within in same:
        tip.reset()
        touch = tip.step([(shape, TURN, (0.8 - 6.0) * NORMAL)], 5e-3)
        assert np.abs(touch.wrench[0] - wanted).max() < within * np.abs(wanted).max()


def test_a_mirrored_scene_has_a_mirrored_answer(tip: ff.TactileFinger) -> None:
    mirror, wrenches = np.diag([1.0, -1.0, 1.0]), []
    for side in (1.0, -1.0):
        tip.reset()
        for k in range(12):
            spin = about_z(2.0 * k * side)
            place = np.array([-4.0 + 0.1 * k, side * (0.5 + 0.05 * k), -2.0 - 6.0 + 0.09 * k])
            touch = tip.step([(ff.shapes.Box(8, 8, 12, edge=0.8), spin, place)], 2e-3)
        wrenches.append(touch.wrench[0])
    force, moment = wrenches[0][:3], wrenches[0][3:]
    assert np.linalg.norm(force) > 0.05
    assert np.allclose(wrenches[1][:3], mirror @ force, atol=1e-7)
    assert np.allclose(wrenches[1][3:], -mirror @ moment, atol=1e-6)


def test_taxels_bear_the_force_to_rounding(tip: ff.TactileFinger) -> None:
    tip.reset()
    touch = plate(tip, 0.9)
    assert touch.taxels.shape == (70, 3)
    assert np.allclose(touch.taxels.sum(axis=0), touch.wrench[0, :3], atol=1e-13)
    assert (np.linalg.norm(touch.taxels, axis=1) > 1e-3).sum() > 10


def test_a_plate_that_spins_twists_the_finger_within_the_bound_of_friction() -> None:
    tip = ff.TactileFinger(FINGER, friction=0.6, finite_strain=False)
    torque = []
    for k in range(30):
        spin = about_z(1.5 * max(0, k - 10))
        touch = tip.step([(ff.shapes.Plane(), PLATE @ spin, min(0.08 * k, 0.8) * NORMAL)], 2e-3)
        torque.append(float(touch.wrench[0, 3:] @ NORMAL))
    force, reach = touch.wrench[0, :3] @ NORMAL, np.sqrt(touch.contact_area[0] / np.pi)
    assert torque[10] == pytest.approx(0.0, abs=0.01)
    assert 0.2 * 0.6 * force * reach < torque[-1] < 0.6 * force * 1.6 * reach
    assert torque[18] > torque[14] > torque[11] > 0.0  # it relaxes afterwards


def path(count: int = 80) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Give rotations and places of a ball that goes round in contact and returns."""
    for k in range(count + 1):
        a = 2 * np.pi * k / count
        yield np.eye(3), -5.2 * NORMAL + [0.8 * (1 - np.cos(a)), np.sin(a), 0.3 * np.sin(a)]


@pytest.mark.parametrize("friction", [0.0, 0.6])
def test_a_closed_path_on_an_elastic_pad_gains_no_energy(friction: float) -> None:
    tip = ff.TactileFinger(ELASTIC, friction=friction, finite_strain=False)
    work, scale, last = 0.0, 0.0, None
    for turn, place in (*path(), *path()):
        force = tip.step([(BALL, turn, place)], 1e-3).wrench[0, :3]
        if last is not None:
            done = 0.5 * (force + last[0]) @ (place - last[1])
            work, scale = work + done, scale + abs(done)
        last = force, place
    assert scale > 0.1
    assert work > (0.1 * scale if friction else -0.01 * scale)
    if not friction:
        assert abs(work) < 0.01 * scale


@pytest.mark.parametrize("friction", [0.0, 5.0])
def test_the_tangent_is_the_derivative_of_the_wrench(friction: float) -> None:
    """Of a plate: without friction, or with so much of it that all vertices stick."""
    tip = ff.TactileFinger(ELASTIC, friction=friction, finite_strain=False)
    touch = plate(tip, 0.7)
    before, tangent, h = tip.state(), touch.tangent[0], 1e-5
    pivot = 0.7 * NORMAL
    for k in range(6):
        motion = np.eye(6)[k]

        def moved(size: float, motion: np.ndarray = motion) -> np.ndarray:
            tip.restore(before)
            w = size * motion[3:]
            skew = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
            turn, _ = np.linalg.qr(np.eye(3) + skew)
            turn *= np.sign(np.diag(turn))
            pose = turn @ PLATE, turn @ pivot + size * motion[:3]
            return tip.step([(ff.shapes.Plane(), *pose)], 1e-3).wrench[0]

        slope = (moved(h) - moved(-h)) / (2 * h)
        off, scale = np.abs(slope - tangent[:, k]), np.abs(tangent[:, k]).max()
        force, moment = np.linalg.norm(touch.wrench[0, :3]), np.linalg.norm(touch.wrench[0, 3:])
        if k < 3:  # the places of contact move by as much, which moments feel
            assert off[:3].max() < 1e-5 * scale + 1e-9
            assert off[3:].max() < force + 1e-5 * scale
        else:  # and directions turn
            assert off[:3].max() < force + 0.1 * scale
            assert off[3:].max() < moment + 3.0 * force + 0.1 * scale  # contact is 3 mm away
    assert np.allclose(tangent, tangent.T, atol=1e-9 * np.abs(tangent).max())
    assert np.linalg.eigvalsh(tangent).min() > -1e-9 * np.abs(tangent).max()


def test_an_object_twice_and_one_out_of_reach_change_nothing(tip: ff.TactileFinger) -> None:
    tip.reset()
    alone = plate(tip, 0.8)
    near = ff.shapes.Plane(), PLATE, 0.8 * NORMAL
    behind = ff.shapes.Plane(), PLATE, 0.3 * NORMAL
    away = BALL, np.eye(3), [0, 0, -30.0]
    for pair in ([near, near], [near, behind], [behind, near], [near, away]):
        tip.reset()
        both = tip.step(pair, 5e-3)
        assert np.allclose(both.wrench.sum(axis=0), alone.wrench[0], atol=1e-9)
        assert np.allclose(both.pressure, alone.pressure, atol=1e-7)


def test_two_objects_share_one_pad(tip: ff.TactileFinger) -> None:
    tip.reset()
    lowest = [tip.pad.points[np.abs(tip.pad.points[:, 0] - x) < 1, 2].min() for x in (-7.0, 0.0)]
    poses = [
        (BALL, np.eye(3), [x, 0.0, z - 6.0 + 0.7]) for x, z in zip((-7.0, 0.0), lowest, strict=True)
    ]
    apart = []
    for pose in poses:
        tip.reset()
        apart.append(tip.step([pose], 5e-3).wrench[0])
    tip.reset()
    both = tip.step(poses, 5e-3)
    assert (np.linalg.norm(both.wrench[:, :3], axis=1) > 0.02).all()
    softer = np.linalg.norm(both.wrench[:, :3], axis=1) / np.linalg.norm(
        np.array(apart)[:, :3], axis=1
    )
    assert (softer < 1.0).all()
    assert (softer > 0.6).all()
    assert both.wrench[:, 2].sum() == pytest.approx(both.taxels[:, 2].sum(), abs=1e-12)


def test_the_tangent_of_an_object_holds_the_other_one() -> None:
    """Of two plates, as of two fingers of a gripper: by differences of its own motion alone."""
    tip = ff.TactileFinger(ELASTIC, finite_strain=False)

    def step(moved: float) -> Touch:
        tip.reset()
        one = (ff.shapes.Plane(), PLATE, (0.8 + moved) * NORMAL)
        return tip.step([one, (ff.shapes.Plane(), under(10.0), 0.9 * under(10.0)[:, 2])], 1e-3)

    touch, h = step(0.0), 1e-5
    assert (np.linalg.norm(touch.wrench[:, :3], axis=1) > 0.05).all()
    slope = (step(h).wrench[0] - step(-h).wrench[0])[:3] / (2 * h)
    assert touch.tangent[0, :3, :3] @ NORMAL == pytest.approx(slope, rel=1e-5, abs=1e-8)


def test_the_moment_is_about_the_places_of_contact_on_the_object() -> None:
    """Of a plate it is that of the forces where the skin meets it, on the plane of the plate."""
    tip = ff.TactileFinger(FINGER, finite_strain=False)
    touch = plate(tip, 0.8)
    force, moment = touch.wrench[0, :3], touch.wrench[0, 3:]
    center = np.cross(NORMAL, moment) / (force @ NORMAL)  # of pressure, across the normal
    lifted = center + 0.8 * NORMAL
    assert np.allclose(np.cross(lifted, force), moment, atol=1e-9)
    areas, hit = tip.pad.areas, touch.hit
    pressed = touch.pressure > 0
    heights = hit[pressed] @ NORMAL / areas[pressed]
    assert np.allclose(heights, 0.8, atol=1e-9)


def test_an_object_that_leaves_lets_go_of_the_skin(tip: ff.TactileFinger) -> None:
    tip.reset()
    ball(tip, 1.0)
    for k in range(1, 8):  # it moves on faster than the skin comes back
        touch = ball(tip, 1.0, 1e-3, shift=(-0.9 * k, 0.0, -0.25 * k))
        near = touch.touched >= 0
        assert (touch.pressure[~near] == 0.0).all()  # exact: no pressure is set there
        assert np.linalg.norm(touch.traction[~near]) == 0.0  # exact: as above
    assert ball(tip, 1.0, shift=(20.0, 0.0, -10.0)).wrench[0] == pytest.approx([0.0] * 6, abs=1e-12)
    ball(tip, -3.0, 1e4)  # it comes back along the normal, as the finger without a past is met
    again = ball(tip, 0.6, 1e4)
    tip.reset()
    ball(tip, -3.0, 1e4)
    fresh = ball(tip, 0.6, 1e4)
    assert again.wrench[0] == pytest.approx(fresh.wrench[0], rel=1e-3, abs=1e-5)


def test_a_state_can_be_branched_and_worlds_be_reset(tip: ff.TactileFinger) -> None:
    tip.reset()
    for k in range(10):
        ball(tip, 0.1 * k, shift=(0.02 * k, 0, 0))
    state = tip.state()
    first = [ball(tip, 0.9 - 0.05 * k, shift=(0.2, 0.03 * k, 0)).wrench for k in range(8)]
    tip.restore(state)
    again = [ball(tip, 0.9 - 0.05 * k, shift=(0.2, 0.03 * k, 0)).wrench for k in range(8)]
    assert np.allclose(first, again, atol=1e-9)
    tip.reset()
    fresh = ff.TactileFinger(FINGER, friction=tip.friction, finite_strain=False)
    assert np.allclose(ball(tip, 0.5).wrench, ball(fresh, 0.5).wrench, atol=1e-12)


@pytest.mark.parametrize("friction", [0.0, 0.6])
@pytest.mark.parametrize("precision", ["double", "single"])
def test_worlds_step_as_single_fingers_do(friction: float, precision: str) -> None:
    worlds = 5
    many = ff.TactileFinger(
        FINGER, friction=friction, finite_strain=False, worlds=worlds, precision=precision
    )
    single = ff.TactileFinger(FINGER, friction=friction, finite_strain=False)
    depths = np.linspace(0.2, 1.0, worlds)
    places = [(depths - 6.0)[:, None] * NORMAL + [0.05 * k, 0.02 * k, 0.0] for k in range(6)]
    stacked = [many.step([(BALL, np.eye(3), place)], 2e-3) for place in places]
    assert stacked[-1].wrench.shape == (worlds, 1, 6)
    assert stacked[-1].taxels.shape == (worlds, 70, 3)
    assert stacked[-1].strain.shape == (worlds, len(many.sites.types), 6)
    assert stacked[-1].tangent.shape == (worlds, 1, 6, 6)
    for w in range(worlds):
        single.reset()
        for k, place in enumerate(places):
            touch = single.step([(BALL, np.eye(3), place[w])], 2e-3)
            close = 1e-8 if precision == "double" else 1e-4
            assert np.allclose(stacked[k].wrench[w], touch.wrench, atol=close)
    for flags in (np.array([2]), np.ones(worlds - 1, bool)):
        with pytest.raises(InputError, match="worlds"):
            many.reset(flags)
    assert stacked[0].valid.shape == stacked[0].error.force.shape == (worlds,)
    assert len(stacked[0].reason) == worlds
    many.reset(np.arange(worlds) == 2)
    after = many.step([(BALL, np.eye(3), places[0])], 2e-3)
    for w, before in ((2, []), (4, places)):  # it starts anew, and the others go on
        single.reset()
        for place in (*before, places[0]):
            touch = single.step([(BALL, np.eye(3), place[w])], 2e-3)
        assert np.allclose(after.wrench[w], touch.wrench, atol=close)
        assert np.allclose(after.strain[w], touch.strain, atol=close)


@pytest.fixture(scope="module")
def stiffening(kept: Path) -> Iterator[ff.TactileFinger]:
    """Return a finger that stiffens, by tables of five depths, one on a mesh of its own."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(elastic_press, "PART", 0.6 / STIFFENING.thickness)
        patched.setattr(elastic_press, "STEPS", 6)
        patched.setattr(tactile_finger, "ANGLES", (0.0, 27.0, 30.0))
        yield ff.TactileFinger(STIFFENING, deepest=0.6)
    shutil.rmtree(kept / "fefinger" / "elastic")


def test_finite_strain_stiffens_the_plate_of_its_table_and_states_an_error(
    stiffening: ff.TactileFinger,
) -> None:
    linear = ff.TactileFinger(STIFFENING, deepest=0.6, finite_strain=False)
    loop = ff.Loop(STIFFENING, ff.Flat(30.0), deepest=0.6)
    for depth in (0.3, 0.6):
        stiffening.reset()
        force = loop.rest(1e4, depth=depth).force
        touch = plate(stiffening, depth, 1e4)
        assert touch.wrench[0, :3] @ NORMAL == pytest.approx(force, rel=0.01)
        assert 0.02 < touch.error.force < 0.3
    soft = plate(linear, 0.6, 1e4)
    assert soft.wrench[0, :3] @ NORMAL < 0.96 * force
    assert np.isnan(soft.error).all()


def test_under_a_soft_plate_the_factor_of_finite_strain_is_that_of_the_depth_of_the_skin(
    stiffening: ff.TactileFinger,
) -> None:
    stiffening.reset()
    rigid = plate(stiffening, 0.5, 1e4)
    stiffening.reset()
    soft = stiffening.step([(ff.shapes.Soft(ff.shapes.Plane(), 15), PLATE, 0.8 * NORMAL)], 1e4)
    assert soft.valid  # its own depth is below `deepest`
    assert soft.depth[0] < rigid.depth[0]
    assert soft.stiffness < 0.99 * rigid.stiffness
    stiffening.reset()
    same = plate(stiffening, float(soft.depth[0]), 1e4)
    assert soft.stiffness == pytest.approx(same.stiffness, rel=0.01)


def test_friction_worlds_and_strictness_change_no_factor_of_finite_strain(
    stiffening: ff.TactileFinger,
) -> None:
    other = ff.TactileFinger(STIFFENING, deepest=0.6, friction=0.6, worlds=2, strict=True)
    places = 0.5 * NORMAL * np.ones((2, 1))
    touch = other.step([(ff.shapes.Plane(), PLATE, places)], 1e-3)
    assert touch.wrench.shape == (2, 1, 6)
    stiffening.reset()
    still = plate(stiffening, 0.5, 1e-3)
    assert np.allclose(touch.stiffness, still.stiffness, rtol=1e-9)
    assert still.stiffness > 1.0


def test_stated_errors_are_of_presses_that_the_factor_was_not_fitted_to() -> None:
    ends, errors = measured_errors()
    rows = [row for row in read(REPORT)["rows"] if not row["fitted"]]
    assert len(rows) >= 28
    for what, stated in zip(errors._fields, errors, strict=True):
        assert stated.shape == ends.shape == (6,)
        for k, most in enumerate(stated):
            worst = [
                max(band for band in (row[what]["loading"][k], row[what]["later"][k], 0.0) if band)
                for row in rows
                if row[what]["loading"][k] or row[what]["later"][k]
            ]
            assert 0.9 <= np.mean(np.array(worst) <= most) < 1.0
    assert errors.force[2:].max() < 0.12  # aimed at: .1; lighter ones hang on first touch


def test_each_range_of_depth_has_the_error_of_the_press_there() -> None:
    depth = np.array([0.1, 0.4, 0.7, 1.0, 0.5])
    reference = np.array([1.0, 2.0, 3.0, 4.0, 2.0])
    found = reference + np.array([0.1, -0.2, 0.9, 0.0, 1.0])
    judged = np.array([True, True, False, True, True])
    errors = tactile.errors(depth, found, reference, judged)
    assert errors["loading"] == [0.1, 0.1, None, 0.0, None, None]
    assert errors["later"] == [None, 0.25, None, 0.0, None, None]


def test_what_it_cannot_answer_is_flagged_or_refused(tip: ff.TactileFinger) -> None:
    tip.reset()
    touch = ball(tip, 1.9)
    assert not touch.valid
    assert "deepest" in str(touch.reason)
    tip.reset()
    level = tip.pad.points[:, 2].min() + 1.45
    border = tip.step([(ff.shapes.Plane(), np.eye(3), [0.0, 0.0, level])], 1e-3)
    assert "border" in str(border.reason)
    tip.reset()
    assert ball(tip, -3.0).valid
    through = tip.step([(BALL, np.eye(3), 25.0 * NORMAL)], 1e-3)
    assert not through.valid
    assert "moved" in str(through.reason)
    strict = ff.TactileFinger(FINGER, friction=tip.friction, finite_strain=False, strict=True)
    good = ball(strict, 0.5).wrench
    with pytest.raises(InputError, match="deepest"):
        ball(strict, 2.5)
    assert np.allclose(ball(strict, 0.5, 1e-9).wrench, good, rtol=1e-6)


def lever(tip: ff.TactileFinger, degrees: float) -> Touch:
    """Give a bar of 60 mm that turns about its middle, beyond the tip."""
    turn = np.radians(degrees)
    about = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
    return tip.step([(ff.shapes.Box(60, 8, 8), about, [28.0, 0.0, 0.0])], 1e-3)


def test_a_turn_through_the_skin_is_flagged_and_one_beside_it_is_not(
    tip: ff.TactileFinger,
) -> None:
    for first, last, valid in (
        (-45.0, 45.0, False),
        (-90.0, -45.0, True),
        (45.0, 180.0 - 45.0, True),
    ):
        tip.reset()
        assert lever(tip, first).valid
        after = lever(tip, last)
        assert not after.wrench.any()
        assert after.valid == valid
        assert ("moved" in str(after.reason)) != valid
    tip.reset()
    ball(tip, 0.5)
    upside_down = np.diag([-1.0, 1.0, -1.0])  # half a turn of a ball moves no surface
    assert tip.step([(BALL, upside_down, -5.5 * NORMAL)], 1e-3).valid


POSE = BALL, np.eye(3), [0.0, 0.0, -8.0]


@pytest.mark.parametrize(
    "objects",
    [
        [(BALL, np.eye(3))],
        [("ball", np.eye(3), [0, 0, 0])],
        [(BALL, np.eye(2), [0, 0, 0])],
        [(BALL, np.eye(3), [0, np.nan, 0])],
        [(BALL, 2 * np.eye(3), [0, 0, 0])],
        [(BALL, -np.eye(3), [0, 0, 0])],
        [(BALL, np.full((3, 3), np.nan), [0, 0, 0])],
        [(BALL, np.stack([np.eye(3)] * 2), [0, 0, 0])],
        [(BALL, 1e300 * np.eye(3), [0, 0, 0])],
        [(BALL, None, [0, 0, 0])],
        [(BALL, np.eye(3), "abc")],
        [(BALL, np.eye(3), [0, 0, 1e300])],
        5,
    ],
)
def test_what_is_no_pose_is_refused_and_changes_nothing(
    tip: ff.TactileFinger, objects: list[tuple[object, ...]]
) -> None:
    tip.reset()
    before = ball(tip, 0.5).wrench
    with refused("objects"):
        tip.step(objects, 1e-3)  # type: ignore[arg-type]  # what the types forbid is refused too
    with refused("dt"):
        tip.step([POSE], -1.0)
    assert np.allclose(ball(tip, 0.5, 1e-9).wrench, before, rtol=1e-6)


def test_no_object_and_another_number_of_them(tip: ff.TactileFinger) -> None:
    tip.reset()
    assert tip.step([], 1e-3).wrench.shape == (0, 6)
    assert ball(tip, 0.5).wrench.shape == (1, 6)
    assert tip.step([POSE, POSE], 1e-3).wrench.shape == (2, 6)


def test_units_fire_where_a_ball_presses(tip: ff.TactileFinger) -> None:
    tip.reset()
    tip.units.reset()
    fired = sum(tip.units.step(ball(tip, 0.01 * k, 1e-3).strain, 1e-3) for k in range(100))
    assert fired > 5


def test_a_population_has_its_end_organs() -> None:
    layout = ff.Grid(spacing=2.0, radius=3.0, branched=False)
    tip = ff.TactileFinger(FINGER, finite_strain=False, population=layout)
    assert len(tip.sites.types) > 20
    assert ball(tip, 0.6).strain.shape == (len(tip.sites.types), 6)


def test_it_copies_and_pickles_by_recipe(tip: ff.TactileFinger) -> None:
    tip.reset()
    ball(tip, 0.6)
    saved = pickle.dumps(tip)
    assert len(saved) < 400_000
    wanted = ball(tip, 0.8).wrench
    for again in (pickle.loads(saved), copy.deepcopy(pickle.loads(saved))):
        assert np.allclose(ball(again, 0.8).wrench, wanted, atol=1e-9)
