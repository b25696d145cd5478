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
BOTH = linear, solid
SLIDE = ff.Slide(20, 0.1, distance=0.4, direction=180, passes=2, settle=0, approach=20)

pytestmark = pytest.mark.usefixtures("few_steps", "iterated_far")


def scene(depth: float = 0.1, mu: float = MU, distance: float | None = None) -> ff.Scene:
    """Return a plate that slides at 20 mm/s, pressed from the start: few steps are due."""
    far = depth if distance is None else distance
    path = ff.SampledPath((0.0, far / 20), (0.0, -far), (0.0, 0.0), depth=(depth, depth))
    return ff.Scene(finger=FINGER, indenter=ff.Flat(30, friction=mu), motion=path, ask=ASK)


@pytest.fixture(scope="module")
def slid(stride_far) -> Response:
    """Return the answer to a slide forth and back."""
    with pytest.MonkeyPatch.context() as patched:
        stride_far(patched)
        return solid.respond(replace(scene(), motion=SLIDE))


def test_it_tends_to_the_gross_slip_of_small_strain_in_first_order_of_the_depth():
    """By how much friction changes the force as well, which a wrong coupling would not give."""
    errors = []
    for depth in (0.04, 0.08):
        small, finite = (each.respond(scene(depth, 0.8, 2 * depth)) for each in BOTH)
        errors.append(finite.force[-1] / small.force[-1] - 1)
        since = [
            float(each.lateral.outcome.removeprefix("Gross slip: from ").split(" s")[0])
            for each in (small, finite)
        ]
        assert since[1] == pytest.approx(since[0], abs=0.25 * depth / 20)  # s, at 20 mm/s
    assert abs(errors[0]) < 0.01
    assert errors[1] / errors[0] == pytest.approx(2, rel=0.2)
    smooth = [each.respond(scene(depth, 0.0, 2 * depth)) for each in BOTH]
    changes = [a.force[-1] / b.force[-1] - 1 for a, b in zip((small, finite), smooth, strict=True)]
    assert abs(changes[0]) > 0.01
    assert changes[1] == pytest.approx(changes[0], rel=0.05)


def test_a_ball_that_slides_with_friction_tends_to_small_strain():
    """Its slopes are met at finite strain alone, and fall with the depth."""
    ball, errors = ff.Sphere(20, friction=MU, at=(0, 0)), []
    for depth in (0.6, 0.15):
        one = replace(scene(depth, distance=0.3), indenter=ball)
        small, finite = (each.respond(one) for each in BOTH)
        for name in ("force", "lateral.force"):
            a, b = (attrgetter(name)(response) for response in (small, finite))
            errors.append(np.abs(a[-1] - b[-1]).max() / np.abs(a[-1]).max())
    assert max(errors[2:]) < 0.06
    assert max(errors[2:]) < 0.7 * max(errors[:2])


def test_the_bone_bears_pressure_and_friction_and_their_moment():
    stages = Stages(None)
    press = Press.of(scene(0.1), finite_strain.FINITE_STRAIN, stages, mechanics="solid", notes=())
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


def test_half_a_finger_answers_as_the_whole_one_and_a_slide_that_does_not_end_stick_says_so(
    monkeypatch: pytest.MonkeyPatch,
):
    short = scene(distance=0.02)
    half = solid.respond(short)
    assert half.lateral.outcome.startswith("Partial slip: at least")
    assert 0 < half.lateral.stick_area[-1]
    monkeypatch.setattr(ff.Scene, "mirrored", False)
    whole = solid.respond(short)
    assert (half.numbers["half"], whole.numbers["half"]) == (1, 0)
    for name in ("force", "lateral.force", "lateral.work"):
        one, other = (attrgetter(name)(answer) for answer in (half, whole))
        assert other == pytest.approx(one, abs=1e-5 * np.abs(one).max())


def test_a_smooth_plate_that_slides_is_one_that_rests_and_a_rough_one_that_rests_sticks():
    still = ff.RampHold(20, 0.1, hold=0)
    rests, rough = (solid.respond(replace(scene(mu=mu), motion=still)) for mu in (0.0, MU))
    slides, vanishing = (solid.respond(scene(mu=mu)) for mu in (0.0, 1e-9))
    assert slides.force[-1] == pytest.approx(rests.force[-1], rel=1e-7)
    assert not slides.lateral.force.any()
    assert slides.lateral.shift[-1] == pytest.approx([-0.1, 0.0])
    assert vanishing.force == pytest.approx(slides.force, rel=1e-6, abs=1e-9)
    assert vanishing.pressure[-1] == pytest.approx(slides.pressure[-1], rel=1e-6, abs=1e-6)
    assert rough.force[-1] > 1.001 * rests.force[-1]
    assert rough.lateral.stick_area[-1] > 0
    assert rough.lateral.outcome.startswith(("Sticking", "Partial slip"))


def test_a_slide_to_the_side_pulls_to_the_side_and_leaves_no_trace_in_a_steady_state(
    slid: Response,
):
    """Friction has no memory of the path: a slide aside and back ends as one that goes straight."""
    turn = int(np.abs(slid.lateral.shift[:, 0]).argmax())
    path = ff.SampledPath((0.0, 0.05, 0.2), (0.0, 0.0, -0.8), (0.0, 0.3, 0.3), depth=(0.1,) * 3)
    bent = solid.respond(replace(scene(), motion=path))
    assert bent.numbers["half"] == 0
    aside = int(np.searchsorted(bent.time, 0.05))
    pulled = bent.lateral.force[aside]
    assert pulled[1] == pytest.approx(MU * bent.force[aside], rel=2e-3)
    assert abs(pulled[0]) < 0.1 * pulled[1]
    straight = slid.lateral.force[turn]
    assert bent.lateral.force[-1] == pytest.approx(straight, abs=0.02 * abs(straight[0]))


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


def test_a_path_of_any_shape_is_open_to_a_plate_without_friction():
    motion = ff.SampledPath((0.0, 1.0), (0.0, 1.0), (0.0, 1.0), (0.0, 0.3))
    finger = ff.Finger.subject("a.h.", resolution="coarse")  # whose table is shipped
    case = Situation(finger, ff.Flat(30), motion, ASK)
    assert not [each for each in solid.refuse(case) if each.about == "ability"]
    along = replace(motion, y=(0.0, 0.0))  # of half the finger
    answer = pressed.respond(ff.Scene(finger=finger, indenter=ff.Flat(30), motion=along, ask=ASK))
    assert answer.lateral.shift[-1] == pytest.approx([1.0, 0.0])


def test_friction_takes_more_time():
    slides = (replace(scene(mu=mu), motion=SLIDE) for mu in (0.0, 0.2, 0.8))
    costs = [solid.cost(Situation.of(each)) for each in slides]
    assert costs == sorted(costs)
    assert costs[0] < costs[1]
