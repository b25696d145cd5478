"""Sliding and friction at finite strain: small strain, balances, symmetry, onset, refusals."""

from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest
from fefinger.validation.problems import published

import fefinger as ff
from fefinger.fem.hyperelastic.continuum import continuum
from fefinger.geometry.profiles import frame
from fefinger.mechanics import linear, pressed, solid
from fefinger.mechanics.press import finite_strain
from fefinger.mechanics.press.problem import Press, materials
from fefinger.mechanics.situation import Situation
from fefinger.results.records import Response
from fefinger.support.progress import Stages
from fefinger.support.tolerances import EQUILIBRIUM


ELASTIC = ff.Prony((1.0,), ())
FINGER = replace(published.load("flat-press").finger, resolution="coarse", prony=ELASTIC)
ASK = ff.Ask(strain=False, fields=False)
MU = 0.4

pytestmark = pytest.mark.usefixtures("few_steps", "iterated_far")


def scene(depth: float = 0.2, mu: float = MU, **motion: float) -> ff.Scene:
    """Return a plate that is pressed and slides by half its depth, without a rest."""
    given = {"distance": depth, "direction": 180, "settle": 0, "approach": 20} | motion
    slide = ff.Slide(20, depth, **given)
    return ff.Scene(finger=FINGER, indenter=ff.Flat(30, friction=mu), motion=slide, ask=ASK)


@pytest.fixture(scope="module")
def slid(stride_far) -> Response:
    """Return the answer to a slide forth and back."""
    with pytest.MonkeyPatch.context() as patched:
        stride_far(patched)
        return solid.respond(scene(passes=2, distance=0.6))


def test_it_tends_to_the_gross_slip_of_small_strain_in_first_order_of_the_depth():
    """By how much friction changes the force as well, which a wrong coupling would not give."""
    errors, changes = [], []
    for depth in (0.04, 0.08):
        forces = {
            (mechanics.name, mu): mechanics.respond(scene(depth, mu, distance=2 * depth)).force[-1]
            for mechanics in (linear, solid)
            for mu in (0.0, 0.8)
        }
        errors.append(forces["solid", 0.8] / forces["linear", 0.8] - 1)
        changes.append([forces[name, 0.8] / forces[name, 0.0] - 1 for name in ("linear", "solid")])
    assert abs(errors[0]) < 0.01
    assert errors[1] / errors[0] == pytest.approx(2, rel=0.2)
    for small, finite in changes:
        assert abs(small) > 0.01
        assert finite == pytest.approx(small, rel=0.05)


def test_the_whole_contact_slips_from_when_no_vertex_sticks_at_small_strain():
    small, finite = (each.respond(scene(0.04)) for each in (linear, solid))
    since = [
        float(response.lateral.outcome.removeprefix("Gross slip: from ").split(" s")[0])
        for response in (small, finite)
    ]
    assert since[1] == pytest.approx(since[0], abs=3 * np.diff(small.time).max())
    pull = [response.lateral.force[:, 0] for response in (small, finite)]
    assert pull[1] == pytest.approx(pull[0], abs=0.05 * np.abs(pull[0]).max())


def test_a_ball_that_slides_with_friction_tends_to_small_strain():
    """Its slopes are met at finite strain alone, and fall with the depth."""
    ball, errors = ff.Sphere(20, friction=MU, at=(0, 0)), []
    for depth in (0.6, 0.15):
        one = replace(scene(depth, distance=0.3), indenter=ball)
        small, finite = (each.respond(one) for each in (linear, solid))
        for name in ("force", "lateral.force"):
            a, b = (attrgetter(name)(response) for response in (small, finite))
            errors.append(np.abs(a[-1] - b[-1]).max() / np.abs(a[-1]).max())
    assert max(errors[2:]) < 0.06
    assert max(errors[2:]) < 0.7 * max(errors[:2])


def test_a_press_with_friction_and_without_a_path_sticks():
    press = replace(scene(), motion=ff.RampHold(20, 0.2, hold=0.02))
    rough = solid.respond(press)
    free = solid.respond(replace(press, indenter=ff.Flat(30)))
    assert rough.force[-1] > 1.001 * free.force[-1]
    assert rough.lateral.stick_area[-1] > 0
    assert rough.lateral.outcome.startswith(("Sticking", "Partial slip"))


def test_the_bone_bears_pressure_and_friction_and_their_moment():
    stages = Stages(None)
    press = Press.of(scene(), finite_strain.FINITE_STRAIN, stages, mechanics="solid", notes=())
    history = finite_strain.solve(press, stages)
    elements = continuum(press.body.space, materials(FINGER), soft=(1, 2))
    values = history.frames[max(history.frames)]
    assert max(history.frames) == len(history.depth) - 1
    inner, _ = elements.residual(values, elements.at_rest)
    count = press.body.space.n_displacements
    reaction = inner[:count].copy()
    reaction[press.system.free[press.system.free < count]] = 0.0
    borne = float(history.contact.projected @ history.pressure[-1])
    pulled = history.sideways.force[-1] @ frame(press.obstacle.axis)[:2]
    assert np.linalg.norm(pulled) == pytest.approx(MU * borne, rel=1e-3)
    loads = (borne * press.obstacle.axis + pulled)[[0, 2]]
    total = reaction.reshape(-1, 3).sum(axis=0)[[0, 2]]
    assert total == pytest.approx(-loads, abs=EQUILIBRIUM * borne)


def test_friction_is_mu_times_the_force_once_the_whole_contact_slips(slid: Response):
    lateral = slid.lateral
    pulled = np.einsum("tpk,p->tk", lateral.traction, slid.pad.areas) * 1e-3
    assert pulled == pytest.approx(lateral.force, abs=1e-9)
    assert (np.abs(lateral.force[:, 0]) <= MU * slid.force * (1 + 1e-6) + 1e-12).all()
    far = np.abs(lateral.shift[:, 0])
    turn = int(far.argmax())
    assert lateral.force[turn, 0] == pytest.approx(-MU * slid.force[turn], rel=1e-3)
    assert lateral.force[-1, 0] == pytest.approx(MU * slid.force[-1], rel=1e-3)
    assert lateral.stick_area[[turn - 2, -2]] == pytest.approx([0, 0], abs=1e-9)
    assert lateral.stick_area.max() > 0.5 * slid.contact_area.max()


def test_friction_loses_work_and_no_more_than_the_plate_does(slid: Response):
    work = slid.lateral.work
    path = np.abs(np.diff(slid.lateral.shift[:, 0], prepend=0.0))
    done = float(np.abs(slid.lateral.force[:, 0]) @ path)
    assert np.diff(work).min() > -1e-9 * work[-1]
    assert 0.5 * done < work[-1] < done  # the rest is stored


def test_a_slide_to_the_other_side_is_the_mirror_image():
    one, other = (solid.respond(scene(direction=side)) for side in (90, 270))
    assert other.force == pytest.approx(one.force, rel=1e-6, abs=1e-9)
    mirrored = one.lateral.force[-1] * [1, -1]
    assert other.lateral.force[-1] == pytest.approx(mirrored, rel=1e-6, abs=1e-9)
    assert one.lateral.force[-1, 1] == pytest.approx(MU * one.force[-1], rel=2e-3)


def test_half_a_finger_answers_as_the_whole_one(monkeypatch: pytest.MonkeyPatch):
    half = solid.respond(scene(distance=0.1))
    monkeypatch.setattr(ff.Scene, "mirrored", False)
    whole = solid.respond(scene(distance=0.1))
    assert (half.numbers["half"], whole.numbers["half"]) == (1, 0)
    for name in ("force", "lateral.force", "lateral.work"):
        one, other = (attrgetter(name)(answer) for answer in (half, whole))
        assert other == pytest.approx(one, abs=1e-5 * np.abs(one).max())


def test_a_smooth_plate_that_slides_is_one_that_rests():
    still = replace(scene(mu=0.0), motion=ff.RampHold(20, 0.2, hold=0.1))
    slides, rests = solid.respond(scene(mu=0.0)), solid.respond(still)
    assert slides.force[-1] == pytest.approx(rests.force[-1], rel=1e-7)
    assert not slides.lateral.force.any()
    assert slides.lateral.shift[-1] == pytest.approx([-0.2, 0.0])
    vanishing = solid.respond(scene(mu=1e-9))
    assert vanishing.force == pytest.approx(slides.force, rel=1e-6, abs=1e-9)
    assert vanishing.pressure[-1] == pytest.approx(slides.pressure[-1], rel=1e-6, abs=1e-6)


def test_a_slide_that_does_not_end_stick_says_so():
    answer = solid.respond(scene(distance=0.02, corner=0.0005))
    assert answer.lateral.outcome.startswith("Partial slip: at least")
    assert 0 < answer.lateral.stick_area[-1]


def test_a_steady_state_does_not_hang_on_the_place_of_a_plate():
    """Friction has no memory of the path: a slide aside and back ends as one that goes straight."""
    straight = solid.respond(scene(distance=0.6)).lateral
    x, y = (0.0, 0.0, -1.2), (0.0, 0.4, 0.4)
    path = ff.SampledPath((0.0, 0.05, 0.2), x, y, depth=(0.2, 0.2, 0.2))
    bent = solid.respond(replace(scene(), motion=path)).lateral
    assert bent.force[-1] == pytest.approx(
        straight.force[-1], abs=0.02 * abs(straight.force[-1, 0])
    )


@pytest.mark.parametrize(
    ("mechanics", "indenter", "motion", "field"),
    [
        (pressed, ff.Dots(3), ff.Slide(20, 0.3, distance=1), "motion.kind"),
        (pressed, ff.Flat(30, friction=MU), ff.RampHold(20, 0.3, hold=0), "indenter.friction"),
        (solid, ff.Flat(30, modulus=50), ff.Slide(20, 0.3, distance=1), "indenter.modulus"),
        (
            solid,
            ff.Flat(30),
            ff.SampledPath((0.0, 1.0), (0, 0), (0, 0), depth=(0.0, 0.3), angle=(30.0, 35.0)),
            "motion.angle",
        ),
    ],
)
def test_what_it_does_not_slide_is_refused(mechanics, indenter, motion, field):
    refusals = mechanics.refuse(Situation(FINGER, indenter, motion, ASK))
    assert {each.about for each in refusals} == {"ability"}
    assert field in {each.field for each in refusals}


@pytest.mark.usefixtures("few_depths")
def test_a_path_of_any_shape_is_open_to_a_plate_without_friction():
    motion = ff.SampledPath((0.0, 1.0), (0.0, 1.0), (0.0, 1.0), (0.0, 0.3))
    case = Situation(FINGER, ff.Flat(30), motion, ASK)
    assert not [each for each in solid.refuse(case) if each.about == "ability"]
    along = replace(motion, y=(0.0, 0.0))  # of half the finger
    answer = pressed.respond(ff.Scene(finger=FINGER, indenter=ff.Flat(30), motion=along, ask=ASK))
    assert answer.lateral.shift[-1] == pytest.approx([1.0, 0.0])


def test_friction_takes_more_time():
    costs = [solid.cost(Situation.of(scene(mu=mu))) for mu in (0.0, 0.2, 0.8)]
    assert costs == sorted(costs)
    assert costs[0] < costs[1]
