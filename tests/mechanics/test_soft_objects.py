"""Soft objects under a whole finger: `condensed`, `linear` and `modal`, and who refuses them."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.mechanics import condensed, get, layered, linear, modal, solid
from fefinger.mechanics.press.notes import RIGID_OBJECT
from fefinger.mechanics.situation import Situation
from fefinger.results.records import Response
from fefinger.scene.motion import Motion
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
HOLD = ff.RampHold(20, 0.8, hold=0.2)

pytestmark = pytest.mark.usefixtures("operators")


def scene(indenter: ff.Indenter, motion: Motion = HOLD, **ask: object) -> ff.Scene:
    return ff.Scene(
        finger=FINGER, indenter=indenter, motion=motion, ask=ff.Ask(fields=False, **ask)
    )


def same(found: Response, expected: Response, rel: float) -> None:
    for name in ("depth", "force", "contact_area", "pressure", "gap"):
        a, b = (np.nan_to_num(getattr(each, name)) for each in (found, expected))
        assert np.abs(a - b).max() <= rel * np.abs(b).max()


def test_the_response_has_both_bodies_in_its_gap_and_says_so() -> None:
    rigid, soft = (condensed.respond(scene(ff.Flat(30, modulus=E))) for E in (None, 50.0))
    assert RIGID_OBJECT in rigid.notes
    (note,) = (each for each in soft.notes if each.startswith("The object is soft"))
    assert "50 kPa" in note
    assert soft.force.max() < 0.5 * rigid.force.max()
    # In contact the pointwise gap is that of a rigid object: some um, not the .4 mm of its surface.
    inside = [np.abs(each.gap[-1][each.pressure[-1] > 0]).max() for each in (rigid, soft)]
    assert inside[1] < 2 * inside[0]
    assert soft.numbers["penetration_mm"] < 2 * rigid.numbers["penetration_mm"]


def test_an_object_relaxes_beside_the_finger_in_steps_of_any_length() -> None:
    """In its gap, in a loop that halves the steps of the march, and more than an elastic one."""
    ball = ff.Sphere(6, modulus=30, prony=Prony((0.3, 0.5, 0.2), (8.0, 120.0)))
    answer = condensed.respond(scene(ball))
    elastic = condensed.respond(scene(ff.Sphere(6, modulus=100)))
    assert answer.force[-1] / answer.force.max() < 0.8 * elastic.force[-1] / elastic.force.max()
    inside = np.abs(answer.gap[-1][answer.pressure[-1] > 0]).max()
    assert inside < 2 * np.abs(elastic.gap[-1][elastic.pressure[-1] > 0]).max()
    (note,) = (each for each in answer.notes if each.startswith("The object is soft"))
    assert "it gives way more as it relaxes, to 30 % of its stress at once" in note
    loop, last = ff.Loop(FINGER, ball, mechanics="condensed", deepest=0.8), 0.0
    for time, depth in zip(np.diff(answer.time), answer.depth[1:], strict=True):
        loop.step(float(time) / 2, depth=(last + float(depth)) / 2)
        force = loop.step(float(time) / 2, depth=float(depth)).force
        last = float(depth)
    assert force == pytest.approx(answer.force[-1], rel=1e-3)


@pytest.mark.parametrize("name", ["solid", "modal"])
def test_a_mechanics_of_elastic_objects_refuses_one_that_relaxes(name: str) -> None:
    plate = ff.Flat(30, modulus=50, prony=FINGER.prony)
    (refusal,) = get(name).refuse(Situation.of(scene(plate)))
    assert (refusal.about, refusal.field) == ("ability", "indenter.prony")
    if name == "modal":
        with refused("indenter.prony"):
            ff.Loop(FINGER, plate, mechanics=name)
    error, source = condensed.error(Situation.of(scene(plate)))
    assert np.isnan(error)
    assert "do not relax" in source


def test_linear_and_condensed_agree_and_half_a_finger_is_the_whole() -> None:
    ball = ff.Sphere(6, modulus=30, thickness=4)
    half = condensed.respond(scene(ball))
    whole = condensed.respond(scene(replace(ball, at=(0.0, 1e-9))))
    assert half.numbers["half"] == 1
    assert whole.numbers["half"] == 0
    assert half.force == pytest.approx(whole.force, rel=1e-5)
    body = ff.Flat(30, modulus=30, prony=FINGER.prony)
    plate = scene(body, ff.Ramp(20, 0.6))  # on the mesh of `linear` too
    same(condensed.respond(plate), linear.respond(plate), 1e-9)


def test_a_hard_object_is_the_rigid_one() -> None:
    for motion in (HOLD, ff.Trapezoid(loading_rate=2, force=0.2, hold=0.1)):
        hard = condensed.respond(scene(ff.Flat(30, modulus=1e15), motion))
        same(hard, condensed.respond(scene(ff.Flat(30), motion)), 1e-9)


def test_the_limit_of_depth_under_a_force_is_that_of_the_skin() -> None:
    """A very soft ball gives way by more than the tissue is thick."""
    ball = ff.Sphere(4, modulus=8)
    answer = condensed.respond(scene(ball, ff.RampHold(loading_rate=5, force=0.25, hold=0.0)))
    assert answer.depth.max() > FINGER.pulp
    assert answer.force[-1] == pytest.approx(0.25, rel=1e-6)
    with refused("motion.force"):
        condensed.respond(scene(ball, ff.RampHold(loading_rate=50, force=9.0, hold=0.0)))


def test_a_loop_is_the_march_and_slides_without_friction() -> None:
    ball = ff.Sphere(6, modulus=30)
    answer = condensed.respond(scene(ball, ff.Ramp(20, 0.6)))
    loop = ff.Loop(FINGER, ball, mechanics="condensed", deepest=0.8)
    for before, time, depth in zip(
        answer.time[:-1], answer.time[1:], answer.depth[1:], strict=True
    ):
        force = loop.step(float(time - before), depth=float(depth)).force
    assert force == pytest.approx(answer.force[-1], rel=1e-6)
    plate = ff.Loop(FINGER, ff.Flat(30, modulus=30), mechanics="condensed", reach=1.0, deepest=0.8)
    still = plate.step(0.01, depth=0.6).force
    plate.reset()
    moved = plate.step(0.01, depth=0.6, shift=(0.5, 0.0))
    assert moved.force == pytest.approx(still, rel=1e-9)  # a plate looks the same everywhere


def test_modes_at_rest_are_statics_and_a_hard_object_is_rigid_to_them() -> None:
    made = {
        (name, modulus): ff.Loop(FINGER, ff.Flat(30, modulus=modulus), mechanics=name, deepest=0.8)
        for name, modulus in (
            ("modal", 40.0),
            ("condensed", 40.0),
            ("modal", 1e15),
            ("modal", None),
        )
    }
    forces = [made[name, 40.0].rest(50.0, depth=0.6).force for name in ("modal", "condensed")]
    assert forces[0] == pytest.approx(forces[1], rel=1e-6)
    hard, rigid = (
        [made["modal", each].step(2e-4, depth=0.02 * k).force for k in range(1, 8)]
        for each in (1e15, None)
    )
    assert hard == pytest.approx(rigid, rel=1e-9)


@pytest.mark.usefixtures("few_steps")
def test_solid_tends_to_small_strain_and_to_the_rigid_object() -> None:
    """Where it presses little, also with the other law of relaxation and contact on deformed skin.

    The 1 % is finite strain: it falls with the depth, as of a rigid object.
    """
    press = ff.Ramp(20, 0.1)
    soft = scene(ff.Flat(30, modulus=60), press)
    found, small = solid.respond(soft), condensed.respond(soft)
    assert found.force[-1] == pytest.approx(small.force[-1], rel=0.01)
    assert found.contact_area[-1] == pytest.approx(small.contact_area[-1], rel=0.02)
    assert found.numbers["penetration_mm"] < 0.15 * 0.1  # in the deformed object
    at_once = ff.Sampled((0.0, 0.001), (0.1, 0.1))
    hard, rigid = (solid.respond(scene(ff.Flat(30, modulus=E), at_once)) for E in (1e14, None))
    assert hard.force == pytest.approx(rigid.force, rel=1e-9, abs=1e-12)
    assert found.force[-1] < 0.5 * rigid.force[-1]


@pytest.mark.usefixtures("few_steps")
def test_solid_holds_a_force_on_a_soft_ball() -> None:
    motion = ff.RampHold(loading_rate=2, force=0.03, hold=0.05)
    found, small = (
        each.respond(scene(ff.Sphere(8, modulus=40, thickness=3), motion))
        for each in (solid, condensed)
    )
    assert found.force[-1] == pytest.approx(0.03, rel=1e-6)
    assert found.depth[-1] == pytest.approx(small.depth[-1], rel=0.02)


def test_on_layers_a_soft_ball_is_as_much_softer_than_a_hard_one_as_on_the_mesh() -> None:
    balls = ff.Sphere(6, modulus=30), ff.Sphere(6, modulus=30, thickness=4), ff.Sphere(6)
    motion, ask = ff.RampHold(20, 0.5, hold=0.1), {"strain": False}
    answers = [
        [each.respond(scene(ball, motion, **ask)) for ball in balls]
        for each in (layered, condensed)
    ]
    forces = ([answer.force.max() for answer in each] for each in answers)
    on_layers, on_mesh = (np.array(each[:2]) / each[2] for each in forces)
    assert on_layers == pytest.approx(on_mesh, rel=0.1)  # the pad itself is 13 % stiffer there
    notes = answers[0][0].notes
    assert sum("30 kPa" in each for each in notes) == 1
    assert RIGID_OBJECT not in notes


@pytest.mark.parametrize("name", ["lumped", "pressed"])
def test_a_mechanics_of_rigid_objects_refuses(name: str) -> None:
    refusals = get(name).refuse(Situation.of(scene(ff.Flat(30, modulus=50))))
    (refusal,) = (each for each in refusals if each.field == "indenter.modulus")
    assert refusal.about == "ability"
    assert "50 kPa" in refusal.reason


def test_soft_plates_do_not_turn_nor_sweep() -> None:
    plate = ff.Flat(30, modulus=50)
    slide = ff.Slide(10, depth=0.5, distance=2)
    refusals = [each.refuse(Situation.of(scene(plate, slide))) for each in (linear, modal)]
    assert [each.field for each in refusals[1]] == ["motion.kind"]
    assert not refusals[0]
    with refused("indenter.modulus"):
        ff.Vibrations(FINGER, plate, deepest=0.8)
    for options in ({"mechanics": "pressed"}, {"mechanics": "condensed", "angles": (20, 40)}):
        with pytest.raises(InputError, match=r"indenter\.modulus = 50 kPa"):
            ff.Loop(FINGER, plate, **options)


def test_the_stated_error_has_a_part_of_the_soft_object_where_that_was_measured() -> None:
    plate, rigid = (Situation.of(scene(ff.Flat(30, modulus=E))) for E in (50.0, None))
    (error, source), (alone, _) = (condensed.error(each) for each in (plate, rigid))
    assert error == pytest.approx(np.hypot(alone, 0.03))
    assert "soft.json" in source
    plan = ff.explain(scene(ff.Flat(30, modulus=50.0), rel_error=1.1 * error))
    assert plan.mechanics in {"condensed", "linear", "solid"}
    force = ff.RampHold(loading_rate=1, force=0.1, hold=0.1)
    for unknown in (
        scene(ff.Flat(30, modulus=50.0, thickness=2)),
        scene(ff.Sphere(3, modulus=50.0)),
        scene(ff.Flat(30, modulus=50.0), force),
    ):
        error, source = condensed.error(Situation.of(unknown))
        assert np.isnan(error)
        assert source.startswith("not known")
    assert np.isnan(condensed.error(plate, "area")[0])
    with pytest.raises(InputError, match="depth / relative radius"):
        ff.explain(scene(ff.Sphere(3, modulus=50.0)))
