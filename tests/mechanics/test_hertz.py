"""The mechanics `hertz`: strain, force and pressure against closed forms, place, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.problems import published
from oracles.differences import gradient

import fefinger as ff
from fefinger.mechanics import hertz, linear
from fefinger.mechanics.press import axisymmetric
from fefinger.mechanics.press.axisymmetric import Touch, turned
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS
from fefinger.results.records import Sites
from fefinger.support.checks import InputError
from fefinger.theory.contact import ting
from fefinger.theory.contact.hertz import Hertz
from fefinger.theory.contact.ting import radius_nodes
from fefinger.theory.relaxation import (
    ELASTIC,
    Prony,
    creep_integral,
    hereditary_integral,
    in_series,
)


FINGER = ff.Finger.subject("a.h.", tissue="maeno1998")
ASK = ff.Ask(fields=False)
PRONY = FINGER.prony
BODY = hertz.HalfSpace(14.0, *hertz.tissue(FINGER))


def scene(**parts):
    given = {"finger": FINGER, "motion": ff.RampHold(20, 0.5, hold=1.0), "ask": ASK}
    return ff.Scene(**(given | parts))


# Strain


def test_touching_the_dent_again_is_weaker_than_touching_rested_skin():
    again = ff.Sampled([0, 0.1, 0.3, 0.4, 0.42, 0.5], depth=[0, 0.5, 0.5, 0, 0, 0.4])
    answer = hertz.respond(scene(motion=again))
    rested = hertz.respond(scene(motion=ff.Sampled([0, 0.08], depth=[0, 0.4])))
    assert 0 < answer.force[-1] < 0.9 * rested.force[-1]
    lower = answer.strain[-1, 0] - rested.strain[-1, 0]
    assert np.abs(lower).max() < 0.1 * np.abs(rested.strain[-1, 0]).max()


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.48, 0.5])
def test_strain_is_the_gradient_of_the_displacement(poisson):
    field = Hertz(12.0, 0.4, 50.0, poisson)
    r, z = np.array([0.7, 2.0, 3.1]), np.array([0.4, 1.2, 0.6])
    body = hertz.HalfSpace(12.0, 50.0, poisson)
    got = body.strain(np.array([0.4]), r, z)[0]
    assert got == pytest.approx(gradient(field.displacement, r, z), abs=1e-7)
    if poisson == 0.5:
        assert got[:3].sum(axis=0) == pytest.approx(0, abs=1e-14)


def test_components_turn_into_the_tensors_of_the_frame_of_the_finger():
    first = Touch(np.array([1.0, 2.0, 3.0]), np.array([-0.48, 0.6, 0.64]))
    rng = np.random.default_rng(5)
    depths = rng.uniform(0.5, 3, 6)
    across = np.cross(first.axis, rng.normal(size=(6, 3)))
    across[0] = 0
    points = first.origin + across + depths[:, None] * first.axis
    organs = Sites(points, np.tile(-first.axis, (6, 1)), depths, ("SAI",) * 6)
    r, _, frames = axisymmetric._cylinder(first, organs)
    assert r == pytest.approx(np.linalg.norm(across, axis=1))
    assert frames @ np.moveaxis(frames, 1, 2) == pytest.approx(np.tile(np.eye(3), (6, 1, 1)))
    components = rng.normal(size=(2, 4, 6))
    tensors = turned(components, frames)
    back = np.einsum("sai,tsij,sbj->tsab", frames, tensors, frames)
    want = np.zeros((2, 6, 3, 3))
    want[..., [0, 1, 2], [0, 1, 2]] = np.moveaxis(components[:, :3], 1, 2)
    want[..., 0, 2] = want[..., 2, 0] = components[:, 3]
    assert back == pytest.approx(want, abs=1e-12)


# Force, pressure, area


def test_ramp_and_hold_equal_the_integral_of_the_relaxation_over_the_force_of_hertz():
    answer = hertz.respond(scene())
    relaxed = [1e-3 * Hertz(14.0, d, BODY.modulus, BODY.poisson).force for d in answer.depth]
    want = hereditary_integral(PRONY, answer.time, relaxed) / PRONY.long_time
    assert answer.force == pytest.approx(want, abs=2e-5 * want.max())
    assert answer.contact_area == pytest.approx(np.pi * 14.0 * answer.depth, abs=1e-2)


@pytest.mark.parametrize("motion", [
    ff.RampHold(20, 0.2, hold=3.0),
    ff.RampHold(loading_rate=1.0, force=0.05, hold=3.0),
], ids=["depth", "force"])  # fmt: skip
def test_how_long_a_press_is_held_changes_nothing_of_its_start(motion):
    start = motion.duration - motion.hold
    after = start + np.array([0.001, 0.01, 0.1, 0.3, 1.0, 2.0])
    short, *longer = (
        hertz.respond(scene(motion=replace(motion, hold=hold))) for hold in (3.0, 1e2, 1e3, 1e6)
    )
    for quantity in ("force", "depth"):
        expected = np.interp(after, short.time, getattr(short, quantity))
        for each in longer:
            found = np.interp(after, each.time, getattr(each, quantity))
            assert found == pytest.approx(expected, rel=1e-3)


def test_a_slow_ramp_after_a_jump_relaxes_as_a_rest_does():
    jump = ((0.0, 1e-3, 1e3), (0.0, 0.2, 0.2 + 1e-6))
    rest, slow = (
        hertz.respond(scene(motion=each))
        for each in (ff.RampHold(200, 0.2, hold=1e3, corner=0.0), ff.Sampled(*jump))
    )
    after = np.array([0.01, 0.05, 0.2, 1.0, 10.0])
    expected = np.interp(after, rest.time, rest.force)
    assert np.interp(after, slow.time, slow.force) == pytest.approx(expected, rel=5e-3)


def test_the_pressure_in_the_middle_is_the_integral_of_that_of_hertz_over_its_cell():
    answer = hertz.respond(scene())
    radius = np.sqrt(answer.pad.areas[0] / np.pi)
    x, weight = np.polynomial.legendre.leggauss(60)
    r = radius * (x + 1) / 2
    mean = [
        weight @ (r * Hertz(14.0, d, BODY.modulus, BODY.poisson).pressure(r)) / radius if d else 0.0
        for d in answer.depth
    ]
    want = hereditary_integral(PRONY, answer.time, mean) / PRONY.long_time
    assert answer.pressure[:, 0] == pytest.approx(want, abs=1e-3 * want.max())


# Place and object


def test_the_object_touches_where_it_is_put_and_the_same_pad_answers():
    middle = hertz.respond(scene(indenter=ff.Sphere(5.0)))
    aside = hertz.respond(scene(indenter=ff.Sphere(5.0, at=(1.0, -1.5))))
    assert aside.force == pytest.approx(middle.force)
    assert aside.centroid[-1] == pytest.approx([1.0, -1.5])
    assert middle.centroid[-1] == pytest.approx([0.0, 0.0])
    plate = hertz.respond(scene(indenter=ff.Sphere(1e9)))
    assert plate.force == pytest.approx(hertz.respond(scene()).force)
    assert middle.force[-1] < 0.6 * plate.force[-1]


def test_a_plate_at_another_angle_touches_the_tip_side():
    answer = hertz.respond(scene(indenter=ff.Flat(angle=40)))
    assert answer.centroid[-1, 0] > 1
    assert answer.force == pytest.approx(hertz.respond(scene()).force)
    assert answer.sites.normals[0] == pytest.approx(
        [np.sin(np.radians(40)), 0, -np.cos(np.radians(40))]
    )


def test_the_reference_is_the_small_plate_on_the_same_finger():
    ask = ff.Ask(spikes=("SAI", "SAII", "FAI", "FAII"), fields=False)
    answer = hertz.respond(scene(indenter=ff.Sphere(5.0), ask=ask))
    plate = hertz.respond(scene(motion=ff.RampHold(20, 0.5, hold=0.1)))
    assert answer.reference.strain == pytest.approx(plate.strain[-1], abs=1e-12)
    assert answer.reference.types == plate.sites.types


# Refusals, error, planning


def test_the_tissue_that_stands_for_two_is_between_them_and_exact_for_one():
    modulus, poisson = hertz.tissue(FINGER)
    assert modulus == pytest.approx(1 / (0.2 / 102.4 + 0.8 / 34))
    assert poisson == pytest.approx(0.48)
    assert hertz.tissue(ff.Finger.subject("a.h.", tissue="saal2017")) == pytest.approx((50, 0.4))


def test_the_first_coefficient_of_the_layer_is_the_integral_of_its_kernel():
    """P / P_Hertz = 1 + 2/pi integral of (1 - L) chi, L the bonded incompressible layer."""
    x, weight = np.polynomial.legendre.leggauss(200)
    x, weight = 10 * (x + 1), 10 * weight
    kernel = (2 * np.sinh(2 * x) - 4 * x) / (2 * np.cosh(2 * x) + 4 * x**2 + 2)
    assert 2 / np.pi * weight @ (1 - kernel) == pytest.approx(hertz.STIFFENING, abs=5e-4)


TILTED = ff.Flat(tilt=5)
"""A plate that the trade-off has not measured."""

STRANGE = ff.Finger.subject("a.h.", tissue="saal2017")
REFUSED = [
    ({"ask": ff.Ask()}, "ability", "ask.fields: this mechanics has no mesh"),
    ({"indenter": TILTED}, "accuracy", "contact radius / tissue thickness = 0.53 > 0.1"),
    ({"indenter": TILTED}, "accuracy", "skin modulus / subcutaneous modulus = 3,"),
    ({"indenter": ff.Sphere(1.0)}, "accuracy", "contact radius / radius of the object = 0.68"),
    ({"indenter": ff.Flat(45), "finger": STRANGE}, "accuracy", "angle = 45 degrees"),
    ({"indenter": ff.Flat(tilt=5)}, "accuracy", "tilt = 5 > 0"),
    ({"indenter": ff.Sphere(5.0, at=(3.0, 0.0))}, "accuracy", "from the middle = 3 > 2 mm"),
]


@pytest.mark.parametrize(("parts", "about", "reason"), REFUSED)
def test_a_refusal_quotes_the_number_that_broke(parts, about, reason):
    refusals = hertz.refuse(Situation.of(scene(**parts)))
    assert any(refusal.about == about and reason in refusal.reason for refusal in refusals)


def test_a_scan_is_refused_because_one_radius_stands_for_it(tmp_path):
    file = tmp_path / "scan.stl"
    file.touch()
    refusals = hertz.refuse(Situation.of(scene(finger=replace(FINGER, surface=str(file)))))
    assert any("finger.surface" in refusal.reason for refusal in refusals)


def test_a_place_beyond_the_pad_is_beyond_its_ability():
    tiny = replace(FINGER, pad_radius=4.0)
    beyond = scene(finger=tiny, indenter=ff.Sphere(5.0, at=(6.0, 0.0)))
    unable = [
        refusal for refusal in hertz.refuse(Situation.of(beyond)) if refusal.about == "ability"
    ]
    assert "indenter.at" in unable[0].reason
    with pytest.raises(InputError, match="expected a place on the pad"):
        hertz.respond(beyond)


def test_reasons_of_a_measured_error_are_told_until_it_is_allowed():
    asked = {"ask.fields": False, "ask.spikes": []}
    case = Situation.of(published.load("flat-press", asked))
    error, _ = hertz.error(case)
    reasons = [refusal.reason for refusal in hertz.refuse(case)]
    assert any("contact radius / tissue thickness" in reason for reason in reasons)
    assert any("skin modulus / subcutaneous modulus" in reason for reason in reasons)
    assert {refusal.field for refusal in hertz.refuse(case)} == {"ask.rel_error"}
    allowed = published.load("flat-press", asked | {"ask.rel_error": min(1.01 * error, 1.0)})
    assert hertz.refuse(Situation.of(allowed)) == ()


def test_where_no_press_is_like_a_finger_its_error_is_that_of_the_bone_below():
    soft = ff.Finger.subject("a.h.", tissue="saal2017", nail="free")
    light = scene(finger=soft, indenter=ff.Sphere(1.0), motion=ff.Ramp(1, 0.05, corner=0))
    assert hertz.error(Situation.of(light))[0] == pytest.approx(
        1.127 * np.sqrt(0.05 * 14 / 15) / 5, rel=0.06
    )
    homogeneous = ff.Finger.subject("a.h.", tissue="saal2017")
    deeper = replace(
        light, finger=homogeneous, indenter=ff.Sphere(2.0), motion=ff.Ramp(1, 0.5, corner=0)
    )
    assert MECHANICS[ff.explain(deeper).mechanics].finite
    with pytest.raises(InputError, match="no mesh"):
        ff.run(replace(light, ask=ff.Ask(fields=True)), mechanics="hertz")


def test_named_it_runs_to_the_spikes_and_records_what_it_would_have_refused():
    asked = scene(motion=ff.RampHold(60, 1.5, hold=0.5), ask=replace(ASK, spikes=("SAI", "FAI")))
    result = ff.run(asked, mechanics="hertz")
    assert result.plan.overridden
    assert result.spikes.count().min() >= 1
    assert any("39.24 kPa" in note for note in result.notes)
    assert any("weights sum to 0.99" in note for note in result.notes)


def test_what_is_not_asked_is_none():
    bare = hertz.respond(scene(ask=ff.Ask(pressure=False, strain=False, fields=False)))
    for absent in ("pad", "pressure", "contact_area", "centroid", "sites", "strain", "fields"):
        assert getattr(bare, absent) is None


def test_without_relaxation_it_is_hertz_on_the_way_back_too():
    stiff = replace(FINGER, prony=Prony((1.0,), ()))
    answer = hertz.respond(scene(finger=stiff, motion=ff.Trapezoid(20, 0.5, hold=0.1)))
    want = 1e-3 * BODY.force(np.maximum(answer.depth, 0))
    assert answer.force == pytest.approx(want, abs=2e-5 * want.max())


def test_on_homogeneous_tissue_the_finite_elements_agree_within_the_stated_error():
    """A small ball, pressed and released: mesh, contact and time of `linear` share nothing."""
    soft = ff.Finger.subject("a.h.", tissue="saal2017", resolution="coarse")
    ball = scene(finger=soft, indenter=ff.Sphere(3.0), motion=ff.Trapezoid(20, 0.3, hold=0.1))
    mine, theirs = hertz.respond(ball), linear.respond(ball)
    stiffer = theirs.force.max() / mine.force.max() - 1
    assert 0 < stiffer < hertz.error(Situation.of(ball))[0]
    apart = np.abs(theirs.force - mine.force)
    assert apart.max() < hertz.error(Situation.of(ball))[0] * theirs.force.max()
    lost = [answer.time[answer.force > 0][-1] for answer in (mine, theirs)]
    assert lost[0] < mine.time[-1] - 1e-3  # before the ball is back
    assert lost[1] == pytest.approx(lost[0], abs=1e-3)


def test_spikes_do_not_depend_on_the_number_of_contact_radii(monkeypatch):
    asked = published.load("press-to-1N", {"ask.fields": False})
    counts = []
    for count in (64, 256):
        monkeypatch.setattr(ting, "radius_nodes", lambda deepest, n=count: radius_nodes(deepest, n))
        counts.append(ff.run(asked, mechanics="hertz").spikes.count().tolist())
    assert counts[0] == counts[1]


# Soft objects


def soft(modulus, **parts):
    ball = ff.Sphere(8, modulus=modulus, poisson=0.45) if modulus else ff.Sphere(8)
    return scene(indenter=ball, **parts)


@pytest.mark.parametrize("other", [ELASTIC, Prony((0.3, 0.5, 0.2), (0.4, 7.0))])
@pytest.mark.parametrize("share", [0.2, 0.9])
def test_in_series_the_compliances_add(share, other):
    """At every time: what both parts give way under the same force."""
    time = np.linspace(0, 3, 4001) ** 2
    force = hereditary_integral(in_series(PRONY, share, other), time, np.sin(time) + 1.5)
    both = share * creep_integral(other, time, force)
    both += (1 - share) * creep_integral(PRONY, time, force)
    assert both == pytest.approx(np.sin(time) + 1.5, rel=1e-4)
    assert in_series(PRONY, 0.0) is PRONY
    with pytest.raises(ValueError, match="in_series"):
        in_series(PRONY, 1.0)


def test_an_object_that_relaxes_as_the_skin_does_shares_its_strain_at_all_times():
    motion = ff.RampHold(20, 0.4, hold=0.3)
    ball = ff.Sphere(8, modulus=20, poisson=0.45, prony=FINGER.prony)
    both = hertz.respond(scene(indenter=ball, motion=motion))
    rigid, elastic = (hertz.respond(soft(modulus, motion=motion)) for modulus in (None, 20.0))
    part = both.force[-1] / rigid.force[-1]
    assert both.force == pytest.approx(part * rigid.force, rel=1e-9)
    assert np.abs(both.strain - part * rigid.strain).max() < 1e-3 * np.abs(both.strain).max()
    assert both.force[-1] / both.force.max() < 0.95 * elastic.force[-1] / elastic.force.max()
    (note,) = (each for each in both.notes if "The object is soft" in each)
    assert "gives way more as it relaxes" in note


def test_relaxed_bodies_add_up_in_force_and_share_the_strain():
    answer = hertz.respond(soft(20.0, motion=ff.RampHold(20, 0.4, hold=1e4)))
    rigid = hertz.respond(soft(None, motion=ff.RampHold(20, 0.4, hold=1e4)))
    modulus, poisson = hertz.tissue(FINGER)
    radius = hertz.half_space(FINGER, ff.Sphere(8)).relative_radius
    skin, own = (1 - poisson**2) / modulus, (1 - 0.45**2) / 20.0
    expected = 4 / 3 / (skin + own) * np.sqrt(radius) * 0.4**1.5 * 1e-3
    assert answer.force[-1] == pytest.approx(expected, rel=2e-4)
    part = skin / (skin + own)
    assert answer.strain[-1] == pytest.approx(part * rigid.strain[-1], rel=1e-3, abs=1e-7)
    assert answer.contact_area[-1] == pytest.approx(rigid.contact_area[-1], rel=1e-6)
    (note,) = (each for each in answer.notes if "soft" in each)
    assert "20 kPa" in note


def test_a_hard_object_is_the_rigid_one():
    hard, rigid = (hertz.respond(soft(modulus)) for modulus in (1e13, None))
    for name in ("force", "strain", "pressure"):
        exact = getattr(rigid, name)
        assert np.abs(getattr(hard, name) - exact).max() < 1e-9 * np.abs(exact).max()


def test_a_layer_is_refused():
    plate = ff.Flat(30, modulus=20, thickness=3)
    refusals = hertz.refuse(Situation.of(scene(indenter=plate)))
    assert "indenter.thickness" in [each.field for each in refusals]
