"""Soft objects under a tactile finger: as of the loop, their tangent, what is refused."""

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.mechanics.press.tactile_parts import under
from fefinger.results.touch import Touch
from fefinger.support.checks import InputError


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
PLATE = under(30.0)
NORMAL = PLATE[:, 2]
SOFT = ff.shapes.Soft(ff.shapes.Plane(), modulus=40, poisson=0.4, thickness=5)

pytestmark = pytest.mark.usefixtures("module_operators")


@pytest.fixture(scope="module")
def tip() -> ff.TactileFinger:
    return ff.TactileFinger(FINGER, finite_strain=False)


def press(tip: ff.TactileFinger, shape: ff.shapes.Shape, depth: float, dt: float = 5e-3) -> Touch:
    return tip.step([(shape, PLATE, depth * NORMAL)], dt)


def test_a_soft_plate_and_ball_are_those_of_the_loop(tip: ff.TactileFinger) -> None:
    for indenter, shape, behind, within in (
        (ff.Flat(30, modulus=40, poisson=0.4, thickness=5), SOFT, 0.0, 1e-3),
        (ff.Sphere(6, modulus=40), ff.shapes.Soft(ff.shapes.Sphere(6), 40), 6.0, 0.02),
    ):
        loop = ff.Loop(FINGER, indenter, mechanics="condensed", deepest=1.2)
        tip.reset()
        for depth in (0.2, 0.6, 1.0, 0.7):
            wanted = loop.step(0.02, depth=depth)
            place = loop.prepared.touch + (depth - behind) * NORMAL
            touch = tip.step([(shape, PLATE, place)], 0.02)
            assert touch.wrench[0, :3] @ NORMAL == pytest.approx(wanted.force, rel=within)
            assert touch.valid
            assert 0 < touch.depth[0] < 0.8 * depth  # of the skin alone
        assert np.isnan(touch.error).all()


def test_a_hard_one_is_rigid_and_a_rigid_step_after_a_soft_one_too(tip: ff.TactileFinger) -> None:
    hard = ff.shapes.Soft(ff.shapes.Plane(), 1e15)
    for shape, depth in ((hard, 0.3), (hard, 0.7)):
        tip.reset()
        found = press(tip, shape, depth)
        tip.reset()
        wanted = press(tip, ff.shapes.Plane(), depth)
        assert found.wrench == pytest.approx(wanted.wrench, rel=1e-9)
        assert found.depth == pytest.approx(wanted.depth, rel=1e-9)
        assert found.tangent == pytest.approx(wanted.tangent, rel=1e-7, abs=1e-9)
    tip.reset()
    press(tip, SOFT, 0.5)
    state = tip.state()
    after = press(tip, ff.shapes.Plane(), 0.7)
    tip.restore(state)
    assert press(tip, ff.shapes.Plane(), 0.7).wrench == pytest.approx(after.wrench, rel=1e-9)


def test_the_tangent_is_that_of_both_bodies(tip: ff.TactileFinger) -> None:
    """Taylor test: by differences of the travel of the soft one of two plates."""
    ball = ff.shapes.Sphere(5.0), np.eye(3), [-8.0, 0.0, -6.6]

    def step(moved: float) -> Touch:
        tip.reset()
        return tip.step([(SOFT, PLATE, (0.8 + moved) * NORMAL), ball], 1e-3)

    touch = step(0.0)
    assert (np.linalg.norm(touch.wrench[:, :3], axis=1) > 0.005).all()
    h = 1e-5
    slope = (step(h).wrench[0] - step(-h).wrench[0])[:3] / (2 * h)
    assert touch.tangent[0, :3, :3] @ NORMAL == pytest.approx(slope, rel=1e-5, abs=1e-8)
    tip.reset()
    rigid = tip.step([(ff.shapes.Plane(), PLATE, 0.8 * NORMAL), ball], 1e-3).tangent[0]
    assert touch.tangent[0, 2, 2] < 0.7 * rigid[2, 2]


def test_worlds_step_as_single_fingers_do(tip: ff.TactileFinger) -> None:
    many = ff.TactileFinger(FINGER, finite_strain=False, worlds=3)
    depths = np.array([0.2, 0.5, 0.8])
    for scale in (0.5, 1.0):
        touch = many.step([(SOFT, PLATE, scale * depths[:, None] * NORMAL)], 2e-3)
    for w, depth in enumerate(depths.tolist()):
        tip.reset()
        for scale in (0.5, 1.0):
            alone = press(tip, SOFT, scale * depth, 2e-3)
        assert touch.wrench[w] == pytest.approx(alone.wrench, rel=1e-8, abs=1e-10)


@pytest.mark.parametrize(
    "given",
    [
        {"modulus": 0.0},
        {"modulus": -1.0},
        {"modulus": np.nan},
        {"modulus": 5.0, "poisson": 0.0},
        {"modulus": 5.0, "poisson": 0.51},
        {"modulus": 5.0, "thickness": 0.0},
    ],
)
def test_bad_numbers_are_refused(given: dict[str, float]) -> None:
    with pytest.raises(InputError, match=": expected"):
        ff.shapes.Soft(ff.shapes.Sphere(5), **given)


def test_samples_and_friction_are_refused_and_change_nothing() -> None:
    samples = ff.shapes.function(
        lambda p: np.linalg.norm(p, axis=1) - 2, [-3] * 3, [3] * 3, pitch=0.5
    )
    for shape in (samples, SOFT, "ball"):
        with refused("shape"):
            ff.shapes.Soft(shape, 50)
    rough = ff.TactileFinger(FINGER, friction=0.5, finite_strain=False)
    before = press(rough, ff.shapes.Plane(), 0.5).wrench
    with refused("objects"):
        press(rough, SOFT, 0.7)
    assert press(rough, ff.shapes.Plane(), 0.5, 1e-9).wrench == pytest.approx(before, rel=1e-6)
