"""A plate that slides at finite strain: small strain, balances, symmetry, onset, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.problems import published

import fefinger as ff
from fefinger.fem.hyperelastic.continuum import continuum
from fefinger.mechanics import linear, pressed, solid
from fefinger.mechanics.press import finite_strain
from fefinger.mechanics.press.problem import Press, materials
from fefinger.mechanics.situation import Situation
from fefinger.results.records import Response
from fefinger.support.checks import InputError
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
    drag = MU * np.array([-np.cos(np.radians(30)), 0.0, -0.5])  # proximal, in the plane
    along = (press.obstacle.axis + drag)[[0, 2]]
    total = reaction.reshape(-1, 3).sum(axis=0)[[0, 2]]
    assert total == pytest.approx(-borne * along, abs=EQUILIBRIUM * borne)


def test_friction_is_mu_times_the_force_at_all_times_at_speed(slid: Response):
    lateral, motion = slid.lateral, scene(passes=2, distance=0.6).motion
    speed = motion.heading(slid.time)[:, 0]
    assert lateral.force[:, 0] == pytest.approx(MU * speed * slid.force, abs=1e-15)
    pulled = np.einsum("tpk,p->tk", lateral.traction, slid.pad.areas) * 1e-3
    assert pulled == pytest.approx(lateral.force, abs=1e-9)
    assert np.abs(speed).max() == pytest.approx(1)
    assert speed[-1] == pytest.approx(1)  # back, and it stays


def test_friction_loses_work_and_no_more_than_the_plate_does(slid: Response):
    work = slid.lateral.work
    path = np.abs(np.diff(slid.lateral.shift[:, 0], prepend=0.0))
    done = float(np.abs(slid.lateral.force[:, 0]) @ path)
    assert np.diff(work).min() > -1e-9 * work[-1]
    assert 0.5 * done < work[-1] < done  # the rest is stored, or lost while stick ends


def test_a_slide_to_the_other_side_is_the_mirror_image():
    one, other = (solid.respond(scene(direction=side)) for side in (90, 270))
    assert other.force == pytest.approx(one.force, rel=1e-6, abs=1e-9)
    assert other.lateral.force[-1] == pytest.approx(-one.lateral.force[-1], rel=1e-6, abs=1e-9)
    assert one.lateral.force[-1, 1] == pytest.approx(MU * one.force[-1])


def test_a_smooth_plate_that_slides_is_one_that_rests():
    still = replace(scene(mu=0.0), motion=ff.RampHold(20, 0.2, hold=0.1))
    slides, rests = solid.respond(scene(mu=0.0)), solid.respond(still)
    assert slides.force[-1] == pytest.approx(rests.force[-1], rel=1e-7)
    assert not slides.lateral.force.any()
    assert slides.lateral.shift[-1] == pytest.approx([-0.2, 0.0])
    vanishing = solid.respond(scene(mu=1e-9))
    assert vanishing.force == pytest.approx(slides.force, rel=1e-6, abs=1e-9)
    assert vanishing.pressure[-1] == pytest.approx(slides.pressure[-1], rel=1e-6, abs=1e-6)


def test_a_slide_that_does_not_end_stick_is_refused_with_the_distance_it_takes():
    with pytest.raises(InputError, match=r"slide over more than 0\.\d+ mm.* received 0\.02 mm"):
        solid.respond(scene(distance=0.02, corner=0.0005))


@pytest.mark.parametrize("mechanics", [solid, pressed], ids=["solid", "pressed"])
@pytest.mark.parametrize(
    ("indenter", "motion", "field"),
    [
        (ff.Dots(3), ff.Slide(20, 0.3, distance=1), "motion.kind"),
        (ff.Flat(30, friction=MU), ff.RampHold(20, 0.3, hold=0), "indenter.friction"),
        (
            ff.Flat(30, friction=MU),
            ff.SampledPath((0.0, 1.0), (0.0, 1.0), (0.0, 0.0), (0.0, 0.3)),
            "indenter.friction",
        ),
    ],
)
def test_what_it_does_not_slide_is_refused(mechanics, indenter, motion, field):
    case = Situation(FINGER, indenter, motion, ASK)
    refusals = mechanics.refuse(case)
    assert {each.about for each in refusals} == {"ability"}
    assert field in {each.field for each in refusals}


@pytest.mark.usefixtures("few_depths")
def test_a_path_of_any_shape_is_open_to_a_plate_without_friction():
    motion = ff.SampledPath((0.0, 1.0), (0.0, 1.0), (0.0, 1.0), (0.0, 0.3))
    case = Situation(FINGER, ff.Flat(30), motion, ASK)
    assert not [each for each in solid.refuse(case) if each.about == "ability"]
    answer = pressed.respond(ff.Scene(finger=FINGER, indenter=ff.Flat(30), motion=motion, ask=ASK))
    assert answer.lateral.shift[-1] == pytest.approx([1.0, 1.0])


def test_friction_that_sets_in_takes_more_steps_and_more_time():
    costs = [solid.cost(Situation.of(scene(mu=mu))) for mu in (0.0, 0.2, 0.8)]
    assert costs == sorted(costs)
    assert costs[0] < costs[2]
