"""The mechanics `layered`: its half-space limit, the finite elements, evidence and planning."""

from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.problems import published

import fefinger as ff
from fefinger import mechanics
from fefinger.mechanics import hertz, layered, linear
from fefinger.mechanics.situation import Situation
from fefinger.support.checks import BeyondError, InputError
from fefinger.theory.contact.contact_table import tabulate_to
from fefinger.theory.contact.indentation import paraboloid
from fefinger.theory.relaxation import hereditary_integral


FINGER = ff.Finger.subject("a.h.", tissue="maeno1998")
ASK = ff.Ask(fields=False)
STACK = layered.stack(FINGER)
BODY = tabulate_to(STACK, 14.0, depth=1.0)


def scene(**parts):
    given = {"finger": FINGER, "motion": ff.RampHold(20, 0.5, hold=1.0), "ask": ASK}
    return ff.Scene(**(given | parts))


def elastic(answer, depths):
    """Strain (n, 4, 3, 3) at the four central end organs of the elastic finger at the depths."""
    inward = -answer.sites.normals[0]
    values = BODY.strain(np.asarray(depths), np.zeros(4), answer.sites.depths)[..., None]
    axis = np.outer(inward, inward)
    across = values[:, 0, ..., None] * (np.eye(3) - axis)
    return across + values[:, 2, ..., None] * axis


@pytest.mark.parametrize("each", [hertz, layered])
@pytest.mark.parametrize("force", [3.0, 8.0, 60.0])
def test_a_force_through_the_tissue_is_refused_before_it_is_solved(each, force):
    press = ff.RampHold(loading_rate=50, force=force, hold=0.2)
    asked = scene(motion=press, ask=ff.Ask(fields=False, strain=False, pressure=False))
    unable = [found.field for found in each.refuse(Situation.of(asked)) if found.about == "ability"]
    if not unable:
        assert 0.5 < each.respond(asked).depth.max() < FINGER.pulp
        return
    with pytest.raises(BeyondError) as raised:
        each.respond(asked)
    assert unable == [raised.value.field] == ["motion.force"]


def test_a_contact_wider_than_the_pad_is_round_is_refused_before_it_is_solved():
    ball = scene(indenter=ff.Sphere(8.0), motion=ff.Ramp(60, 4.2))
    (found,) = layered.refuse(Situation.of(ball))
    assert (found.about, found.field) == ("ability", "motion.depth")
    with pytest.raises(BeyondError):
        layered.respond(ball)


@pytest.mark.parametrize("radius", [0.3, 5.0, 18.0])
def test_no_contact_is_as_wide_as_its_radius_at_depths_at_which_it_is_not_looked_for(radius):
    depth = layered.NARROW * radius
    assert tabulate_to(STACK, radius, depth=depth).contact_radius(depth) < radius


MOTIONS = [
    ff.RampHold(20, 0.5, hold=1.0),
    ff.Trapezoid(20, 0.5, hold=0.1),
    ff.RampSinusoid(20, 0.4, amplitude=0.3, frequency=8, cycles=3),
    ff.Trapezoid(loading_rate=2, force=0.3, hold=0.1),
]
EACH = pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.kind)


@EACH
def test_a_huge_finger_of_one_tissue_is_hertz(motion):
    """With thickness 1000 contact radii the force of the layer is within 1.1 chi = 2e-3."""
    one = ff.Tissue(34.0, 0.45)
    huge = ff.Finger(
        8e3,
        8e3,
        pad_radius=14.0,
        skin=ff.Tissue(34.0, 0.45, thickness=100.0),
        subcutaneous=one,
        prony=FINGER.prony,
    )
    mine, theirs = (kind.respond(scene(finger=huge, motion=motion)) for kind in (layered, hertz))
    for field in ("force", "contact_area", "strain"):
        got, want = getattr(mine, field), getattr(theirs, field)
        assert got == pytest.approx(want, abs=3e-3 * np.abs(want).max()), field
    if motion.control == "depth":
        assert mine.pressure[:, 0] == pytest.approx(
            theirs.pressure[:, 0], abs=5e-3 * theirs.pressure.max()
        )


def test_loading_is_the_integral_of_the_relaxation_over_contacts_solved_one_by_one():
    answer = layered.respond(scene())
    solved = [paraboloid(STACK, 14.0, contact_radius=a) for a in np.linspace(0.08, 3.2, 40)]
    depth = np.array([one.depth for one in solved])
    curve = np.interp(answer.depth, depth, [1e-3 * one.force for one in solved], left=0.0)
    want = hereditary_integral(FINGER.prony, answer.time, curve) / FINGER.prony.long_time
    # The chords of 40 contacts lie up to 4e-4 of the largest force above their curve.
    assert answer.force == pytest.approx(want, abs=1e-3 * want.max())
    area = np.interp(answer.depth, depth, [np.pi * one.contact_radius**2 for one in solved])
    late = answer.depth > 0.05
    assert answer.contact_area[late] == pytest.approx(area[late], rel=5e-3)


def test_a_light_touch_agrees_with_the_finite_elements_and_deep_ones_feel_the_flat_bone():
    """A finger is narrower than a flat stack: 6 % at 0.1 mm and 35 % at 0.5 mm (finding)."""
    coarse = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
    press = scene(finger=coarse, motion=ff.RampHold(20, 0.5, hold=0.05))
    mine, theirs = layered.respond(press), linear.respond(press)
    rising = slice(1, int(np.argmax(theirs.depth)) + 1)
    ratio = mine.force[rising] / np.maximum(theirs.force[rising], 1e-12)
    light, deep = (int(np.argmin(np.abs(mine.depth[rising] - depth))) for depth in (0.1, 0.5))
    assert 0.95 < ratio[light] < 1.12
    assert 1.2 < ratio[deep] < 1.5
    last = mine.strain[-1, :, 2, 2] / theirs.strain[-1, :, 2, 2]
    assert np.all(np.abs(last - 1) < 0.35)
    assert np.all(mine.strain[-1, :, 2, 2] < 0)


def test_a_bar_on_the_grid_agrees_with_the_finite_elements_as_far_as_its_stated_errors():
    """Of small strain both: the force is too large over flat bone, strain below is alike."""
    coarse = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
    bar = ff.Bar(3.0, corner=1.5)
    press = scene(finger=coarse, indenter=bar, motion=ff.Ramp(20, 0.6))
    mine, theirs = layered.respond(press), linear.respond(press)
    case = Situation.of(press)
    ratio = mine.force[-1] / theirs.force[-1]
    assert 1.1 < ratio < 1 + layered.error(case)[0]
    apart = np.linalg.norm(mine.strain[-1] - theirs.strain[-1])
    limit = layered.error(case, "strain")[0] * np.linalg.norm(theirs.strain[-1])
    assert 0.05 * limit < apart < 1.5 * limit  # the coarse mesh has an error of its own


def test_what_it_cannot_do_is_refused():
    light = {"motion": ff.RampHold(20, 0.2, hold=0.1)}
    asked = Situation.of(scene(ask=ff.Ask(), **light))
    assert {item.about for item in layered.refuse(asked)} == {"ability"}
    assert layered.refuse(Situation.of(scene())) == ()
    buried = layered.refuse(Situation.of(scene(ask=ff.Ask(fields=False, depths={"FAII": 4.8}))))
    assert "4.8 mm is not above the bone at 4.7 mm" in buried[0].reason
    for motion, received in (
        (
            ff.RampHold(20, 1.5, hold=0.1),
            r"motion\.depth: expected .* received 1\.5 mm; press less",
        ),
        (
            ff.RampHold(loading_rate=9, force=5.0, hold=0.1),
            r"motion\.force: expected .* received 5 N; press less",
        ),
    ):
        with pytest.raises(InputError, match=received) as refusal:
            layered.respond(scene(indenter=ff.Sphere(0.5), motion=motion))
        assert "tabulate" not in str(refusal.value)


def test_a_skin_that_leaves_nothing_above_the_bone_is_refused_with_both_thicknesses():
    for thick in (4.65, 4.8):
        full = replace(FINGER, skin=replace(FINGER.skin, thickness=thick))
        (refusal,) = layered.refuse(Situation.of(scene(finger=full)))
        assert refusal.about == "ability"
        assert "expected at most 4.606 mm" in refusal.reason
        assert f"received {thick} mm" in refusal.reason
        with pytest.raises(InputError, match=r"4\.7 mm above the bone"):
            layered.respond(scene(finger=full))
    nearly = replace(FINGER, skin=replace(FINGER.skin, thickness=4.6))
    assert np.isfinite(layered.respond(scene(finger=nearly)).force).all()


def test_the_contacts_of_a_stack_are_solved_once(monkeypatch):
    """A second answer on the same finger, at another speed and depth, solves nothing again."""
    layered.respond(scene())
    with monkeypatch.context() as patch:
        patch.setattr("fefinger.theory.contact.contact_table.subsurface_field", None)
        patch.setattr("fefinger.theory.contact.contact_table.ContactTable", None)
        again = layered.respond(scene(motion=ff.RampHold(40, 0.49, hold=0.5)))
    want = elastic(again, again.depth)
    assert again.strain == pytest.approx(want, abs=3e-4 * np.abs(want).max())


# Planning


def test_the_ladder_holds_it_between_the_half_space_and_the_finite_elements():
    names = mechanics.names()
    assert names.index("hertz") < names.index("layered") < names.index("linear")
    rungs = ff.explain(
        published.load("sphere-press", {"ask.fields": False, "ask.spikes": []})
    ).rungs
    seconds = {rung.mechanics: rung.seconds for rung in rungs if np.isfinite(rung.seconds)}
    assert seconds["hertz"] < seconds["layered"] < seconds["linear"]
    assert layered.coarser(scene()) is None


REFUSED = [
    ({"indenter": ff.Flat(tilt=40)}, "another tilt"),
    ({"indenter": ff.Flat(30), "motion": ff.Ramp(20, 2.5)}, "presses like it were measured to"),
    ({"indenter": ff.Sphere(0.3)}, "another larger curvature"),
    ({"finger": ff.Finger.subject("a.h.", nail="free")}, "the shape and bone of the subjects"),
    ({"finger": ff.Finger(8.0, 6.0, tissue="maeno1998")}, "another thickness of the finger"),
]


@pytest.mark.parametrize(("parts", "reason"), REFUSED)
def test_where_it_was_not_compared_its_error_is_not_known_and_the_reason_is_stated(parts, reason):
    error, source = layered.error(Situation.of(scene(**parts)))
    assert np.isnan(error)
    assert reason in source


def test_the_expected_time_grows_with_its_steps_and_end_organs():
    def seconds(**ask):
        return layered.cost(Situation.of(scene(ask=replace(ASK, **ask))))

    assert seconds(spikes=("FAII",)) > seconds(spikes=("SAI",)) > 0
    units = ff.Grid(spacing=1.0, radius=3.0)
    assert seconds(spikes=("SAI",), population=units) > seconds(spikes=("SAI",))


CHOSEN = [
    ("flat-press", {"ask.rel_error": 0.05}, "pressed"),
    ("flat-press", {"ask.rel_error": 0.01}, "solid"),
    ("flat-press", {}, "linear"),
    ("flat-press", {"ask.strain": False, "ask.pressure": False, "ask.spikes": []}, "lumped"),
    ("sphere-press", {"ask.rel_error": 0.2}, "linear"),
    ("sphere-press", {"ask.rel_error": 0.4}, "layered"),
    ("sphere-press", {"ask.rel_error": 0.25, "motion.depth": 0.5}, "layered"),
]


@pytest.mark.parametrize(("name", "changes", "chosen"), CHOSEN)
def test_the_planner_takes_it_where_its_error_is_good_enough(name, changes, chosen):
    fields = {} if name == "flat-press" and not changes else {"ask.fields": False}
    assert ff.explain(published.load(name, {**fields, **changes})).mechanics == chosen
