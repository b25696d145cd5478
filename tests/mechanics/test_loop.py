"""Fingers in real time: text, families of units, refused steps, and the warning of soft tissue."""

import copy
import dataclasses
import pickle
from collections.abc import Callable
from dataclasses import fields
from functools import cache

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.mechanics import condensed, get
from fefinger.mechanics.situation import Situation
from fefinger.neural.streaming import Afferents, RecordedAfferents
from fefinger.results.records import Sites
from fefinger.scene.indenter import direction
from fefinger.support.text import percent


SOFT = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
STIFFENING = ff.Finger.subject("a.h.", resolution="coarse")
RIM = "contact at their rim"
SITES = Sites(np.array([[0, 0, 0.9]]), -np.eye(3)[2:], np.array([0.8]), ("SAI",))


pytestmark = pytest.mark.usefixtures("operators")


SMALL = {"mechanics": "condensed"}
KINDS = {
    "condensed": SMALL,
    "pressed": {},
    "sliding": SMALL | {"reach": 0.0},
    "modal": {"mechanics": "modal"},
    "rolling": SMALL | {"angles": (15, 35)},
}
"""Options of every kind of loop."""


def finger_of(kind: str) -> ff.Finger:
    """Return a finger whose operators are small, or one whose press is shipped."""
    return STIFFENING if kind == "pressed" else SOFT


@cache
def made(kind: str) -> ff.Loop:
    return ff.Loop(finger_of(kind), ff.Flat(30), deepest=0.8, **KINDS[kind])


def loop(kind: str) -> ff.Loop:
    """Return the loop of a kind, at rest."""
    finger = made(kind)
    finger.reset()
    return finger


def stops_at_a_warning(words: str) -> pytest.RaisesExc[UserWarning]:
    """Expect a warning, which is an error here: before anything is built."""
    return pytest.raises(UserWarning, match=words)


@pytest.mark.parametrize("indenter", [ff.Flat(30), ff.Sphere(5)])
def test_tissue_that_stiffens_is_warned_of_with_the_error_of_the_scene(indenter) -> None:
    scene = ff.Scene(finger=STIFFENING, indenter=indenter, motion=ff.Ramp(10, 0.8))
    error, _ = condensed.error(Situation.of(scene))
    said = "" if np.isnan(error) else f"at 0.8 mm is wrong by some {percent(error)} "
    with stops_at_a_warning(f"stiffens.*{said}.*mechanics='pressed'"):
        ff.Loop(STIFFENING, indenter, mechanics="condensed", deepest=0.8)


@pytest.mark.parametrize("kind", ["sliding", "rolling", "modal"])
def test_the_other_fingers_at_small_strain_warn_too(kind: str) -> None:
    with stops_at_a_warning("calibrated_ah stiffens"):
        ff.Loop(STIFFENING, deepest=0.5, **KINDS[kind])


def test_a_finger_that_stiffens_by_the_law_of_the_thesis_is_not_warned_of() -> None:
    ff.Loop(STIFFENING, mechanics="condensed", deepest=0.5, stiffening=np.expm1)


@pytest.mark.parametrize("kind", ["condensed", "pressed", "modal"])
def test_the_fields_of_a_loop_are_those_of_a_run(kind: str) -> None:
    finger, motion = loop(kind), ff.RampHold(10, 0.6, hold=0.1)
    scene = ff.Scene(finger=finger_of(kind), indenter=ff.Flat(30), motion=motion)
    expected = get(kind).respond(scene)
    time, frame = expected.time, expected.fields
    assert frame is not None
    values = zip(motion.value(time).tolist(), np.diff(time, prepend=0.0).tolist(), strict=True)
    for depth, dt in values:
        finger.step(dt, depth=depth)
    unit, elastic = finger.prepared.fields(), finger.prepared.contact.elastic
    assert unit.mesh.points == pytest.approx(frame.points, abs=0)
    found = np.zeros(len(frame.points))
    found[unit.pad] = finger.now.pressure
    # Single precision; of a table the logarithmic strain is interpolated, not the gradient; and
    # a loop has fewer modes than a run.
    close = 1e-5 if kind == "condensed" else 2e-3
    for own, stored in (
        (np.tensordot(elastic, unit.displacement, 1), frame.displacement[-1]),
        (np.tensordot(elastic, unit.strain, 1), frame.strain[-1]),
        (found, frame.pressure[-1]),
    ):
        assert own == pytest.approx(stored, abs=close * np.abs(stored).max())


@pytest.mark.parametrize("kind", ["sliding", "rolling"])
def test_skin_under_a_plate_lies_on_it(kind: str) -> None:
    finger = loop(kind)
    finger.step(1.0, depth=0.6)
    unit, axis = finger.prepared.fields(), direction(ff.Flat(30 if kind == "sliding" else 25))
    moved = np.tensordot(finger.prepared.contact.elastic, unit.displacement, 1)
    touches = unit.pad[: len(finger.now.pressure)][finger.now.pressure > 0]
    first = (unit.mesh.points @ axis).min()
    ahead = (unit.mesh.points + moved)[touches] @ axis - first
    assert ahead == pytest.approx(0.6, abs=0.06)  # gaps are closed as means over facets


@pytest.mark.parametrize("kind", ["condensed", "pressed", "sliding"])
def test_units_are_of_either_family(kind: str) -> None:
    finger = loop(kind)
    recorded = finger.afferents()
    assert isinstance(recorded, RecordedAfferents)
    assert repr(recorded) == "<Afferents (recorded) of SAI, SAII, FAI, FAII>"
    thesis = finger.afferents(family="thesis")
    assert isinstance(thesis, Afferents)
    assert repr(thesis) == "<Afferents (thesis) of SAI, SAII, FAI, FAII>"
    with refused("family"):
        finger.afferents(family="theses")


def test_the_name_of_a_subject_is_no_finger() -> None:
    with pytest.raises(ff.InputError, match=r"expected a Finger, as ff.Finger.subject.*'a.h.'"):
        ff.Loop("a.h.")  # type: ignore[arg-type]  # of the wrong type on purpose


def sinking(kind: str) -> Callable[[ff.Loop, float], object]:
    """Return how a kind of loop goes to a depth."""
    turned = {"rolling": lambda depth: {"angle": 20 + 10 * depth}}
    slides = {"shift": lambda depth: {"shift": (0.2 * depth, 0.1)}}
    how = (turned | slides).get("shift" if kind.startswith("sliding") else kind, lambda depth: {})
    dt = 1e-4 if kind == "modal" else 5e-3
    return lambda finger, depth: finger.step(dt, depth=depth, **how(depth))


@pytest.mark.parametrize(
    ("kind", "options", "refused"),
    [
        (
            "condensed",
            {},
            [
                (lambda f: f.step(5e-3, depth=3.0), RIM),
                (lambda f: f.step(5e-3, depth=3.0, strain=False), RIM),
                (lambda f: f.step(5e-3, force=50.0), RIM),
                (lambda f: f.step(5e-3, depth=0.5, shift=(0.1, 0.0)), "shift: expected none"),
                (lambda f: f.step(5e-3, depth=0.5, angle=20.0), "angle: expected none"),
            ],
        ),
        (
            "pressed",
            {},
            [
                (lambda f: f.step(5e-3, depth=3.0), "at most the `deepest` = 0.8 mm"),
                (lambda f: f.step(5e-3, force=50.0), "received 50 N; give a larger `deepest`"),
            ],
        ),
        ("modal", {}, [(lambda f: f.step(1e-4, depth=3.0), RIM)]),
        (
            "rolling",
            {},
            [
                (lambda f: f.step(5e-3, depth=3.0, angle=33.0), RIM),
                (lambda f: f.step(5e-3, depth=0.5, tilt=3.0), "tilt: expected none"),
            ],
        ),
        *(
            (
                "sliding",
                {"indenter": ff.Dots(2.5, friction=mu)},
                [
                    (lambda f: f.step(1e-3, depth=2.5, shift=(3.0, 1.0)), "candidates"),
                    (lambda f: f.step(1e-3, depth=0.5, shift=(0.0, np.nan)), "shift: expected two"),
                ],
            )
            for mu in (0.0, 0.3)
        ),
    ],
    ids=["condensed", "pressed", "modal", "rolling", "sliding", "sliding with friction"],
)
def test_a_refused_step_leaves_the_finger_as_it_was(
    kind: str, options: dict, refused: list[tuple[Callable, str]]
) -> None:
    finger, take = (
        ff.Loop(SOFT, deepest=0.8, **KINDS[kind] | options) if options else loop(kind),
        sinking(kind),
    )
    for depth in (0.3, 0.6):
        before = copy.deepcopy(take(finger, depth))
    for step, words in refused:
        with pytest.raises(ff.InputError, match=words):
            step(finger)
    for field in fields(before):
        # exact: nothing was changed
        np.testing.assert_array_equal(getattr(finger.now, field.name), getattr(before, field.name))
    found = copy.deepcopy(take(finger, 0.5))
    finger.reset()
    for depth in (0.3, 0.6, 0.5):
        expected = take(finger, depth)
    for field in fields(expected):
        wanted = getattr(expected, field.name)
        close = {"rtol": 1e-9, "atol": 1e-9 * np.abs(wanted).max()}
        np.testing.assert_allclose(getattr(found, field.name), wanted, **close)


@pytest.mark.parametrize("kind", KINDS)
def test_a_copy_and_a_pickle_are_a_recipe_and_go_on_from_the_state(kind: str) -> None:
    finger, take = loop(kind), sinking(kind)
    for depth in (0.2, 0.5, 0.4):
        take(finger, depth)
    state, stored = finger.state(), pickle.dumps(finger)
    assert len(stored) < 200_000
    expected = copy.deepcopy(take(finger, 0.6))
    copied = copy.deepcopy(finger)
    assert copied.now.force == pytest.approx(expected.force, rel=1e-9)
    finger.restore(state)
    for other in (finger, pickle.loads(stored)):
        found = take(other, 0.6)
        assert found.force == pytest.approx(expected.force, rel=1e-9)
        assert found.strain == pytest.approx(expected.strain, rel=1e-8, abs=1e-10)
    with refused("state"):
        finger.restore(dataclasses.replace(state, contact=state.contact[:-1]))


def test_a_state_holds_the_angle_and_the_center() -> None:
    finger = loop("rolling")
    first = copy.deepcopy(finger.step(5e-3, depth=0.4))
    finger.step(5e-3, depth=0.4, angle=30.0)
    finger.reset()
    assert finger.step(5e-3, depth=0.4).x == pytest.approx(first.x, rel=1e-6)
    turned = copy.deepcopy(finger.step(5e-3, depth=0.4, angle=32.0))
    state = finger.state()
    finger.step(5e-3, depth=0.5, angle=18.0)
    finger.step(5e-3, depth=-0.5)
    finger.restore(state)
    again = finger.step(0.0, depth=0.4)
    assert again.force == pytest.approx(turned.force, rel=1e-6)
    assert (again.x, again.y) == pytest.approx((turned.x, turned.y), rel=1e-6, abs=1e-9)
    away = finger.step(5e-3, depth=-0.5)
    assert not away.touching
    state, left = finger.state(), (away.x, away.y)
    finger.step(5e-3, depth=0.4, angle=18.0)
    back = finger.restore(state)
    assert (back.x, back.y) == left  # exact: it is kept


def test_with_inertia_a_long_step_goes_straight_to_its_force() -> None:
    """As short steps with the force in between do; refused on the way, it changes nothing."""
    finger = loop("modal")
    finger.step(1e-3, force=0.05)
    start = finger.state()
    whole = finger.step(1e-3, force=0.2).depth
    finger.restore(start)
    for part in range(1, 11):
        short = finger.step(1e-4, force=0.05 + 0.015 * part).depth
    assert whole == pytest.approx(short, rel=1e-6)
    before = copy.deepcopy(finger.now)
    with pytest.raises(ff.InputError, match=RIM):
        finger.step(1e-3, depth=3.0)
    after = finger.step(1e-9, depth=before.depth)
    assert after.pressure == pytest.approx(before.pressure, rel=1e-3, abs=1e-3)


def test_a_finger_and_a_step_are_a_line_with_units() -> None:
    finger = loop("condensed")
    about = "finger a.h., maeno1998 tissue, coarse mesh, under Flat(angle=30.0, tilt=0.0)"
    assert repr(finger).startswith(f"<Loop, condensed: {about}; to 0.8 mm; ")
    assert repr(finger).endswith("vertices may touch; strain at SAI, SAII, FAI, FAII>")
    step = finger.step(1e-3, depth=0.3)
    assert repr(step).startswith(f"<Step: {step.force:.4g} N at 0.3 mm, ")
    assert repr(finger.step(1e6, depth=0.0)) == "<Step: 0 N at 0 mm, 0 mm², no contact>"


@pytest.mark.parametrize("kind", KINDS)
def test_out_of_contact_the_center_is_the_last_one_and_never_nan(kind: str) -> None:
    finger, take = loop(kind), sinking(kind)
    start = finger.now.x, finger.now.y
    assert start == pytest.approx(finger.prepared.touch[:2])
    pressed = take(finger, 0.4)
    center = pressed.x, pressed.y
    assert pressed.touching
    assert center != start
    away = take(finger, -0.5)
    assert not away.touching
    assert (away.x, away.y) == center  # exact: it is the last one, kept


def test_a_ball_is_moved_anywhere_within_its_reach_and_no_farther() -> None:
    """Skin under its rim alone would leave gaps: no force, or a refusal, in between."""
    finger = ff.Loop(SOFT, ff.Sphere(1), mechanics="condensed", deepest=0.3, reach=3.5)
    for place in ((1.2, 0.9), (-1.75, 0.0)):
        finger.reset()
        assert finger.step(0.05, depth=0.3, shift=place).force > 0.015
    with pytest.raises(ff.InputError, match=r"at most `reach` = 3\.5 mm from the first"):
        finger.step(0.05, depth=0.3, shift=(3.5, 0.1))


@pytest.mark.parametrize("kind", ["pressed", "modal"])
def test_a_finger_that_is_only_pressed_refuses_friction(kind: str) -> None:
    with pytest.raises(ff.InputError, match=r"indenter.friction = 0.5 > 0.*'condensed'"):
        ff.Loop(SOFT, ff.Flat(30, friction=0.5), **KINDS[kind])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"mechanics": "hertz"}, "mechanics: expected"),
        ({"reach": 1.0}, "reach: expected none with mechanics='pressed'"),
        ({"mechanics": "modal", "angles": (10, 20)}, "angles: expected none"),
        ({"mechanics": "modal", "substep": 0.0}, "substep: expected"),
        ({"stiffening": lambda depth: depth}, "stiffening: expected none"),
        (SMALL | {"angles": (10, 20), "reach": 1.0}, "angles: expected a plate that rolls"),
        (SMALL | {"reach": -1.0}, "reach: expected"),
        (SMALL | {"indenter": ff.Sphere(5, at=(12, 0))}, "indenter.at: expected a place"),
    ],
)
def test_what_a_mechanics_cannot_do_in_a_loop_gets_a_sentence(options: dict, words: str) -> None:
    with pytest.raises(ff.InputError, match=words):
        ff.Loop(SOFT, **options)


def test_a_step_is_to_a_depth_or_to_a_force() -> None:
    finger = loop("pressed")
    for given in ({}, {"depth": 0.1, "force": 0.1}):
        with pytest.raises(ff.InputError, match="step: expected a depth in mm or a force in N"):
            finger.step(1e-3, **given)


@pytest.mark.parametrize("kind", ["pressed", "condensed", "modal", "sliding"])
def test_a_depth_or_a_step_that_is_no_number_is_refused(kind: str) -> None:
    finger = loop(kind)
    for wrong in ("0.3", 1j, True, np.array([0.1, 0.2]), np.nan, np.inf):
        for strain in (True, False):
            with refused("depth"):
                finger.step(1e-3, depth=wrong, strain=strain)
        with refused("dt"):
            finger.step(wrong, depth=0.1)
    with refused("dt"):
        finger.step(-1e-3, depth=0.1)
    for wrong in (-0.1, np.nan):
        with refused("force"):
            finger.step(1e-3, force=wrong)
    with refused("strain"):
        finger.step(1e-3, depth=0.1, strain=np.array([True, False]))
    assert finger.step(1e-3, depth=np.array(0), strain=np.True_).depth == 0.0


def test_a_place_that_is_not_two_numbers_is_refused() -> None:
    finger = ff.Loop(SOFT, ff.Dots(2.5), **SMALL, deepest=0.5, reach=0.0)
    for wrong in ("a", "12", 1.0, (0.0,), (0.0, "1"), (0.0, True), (1j, 0.0), ([0.1], 0.0)):
        with refused("shift"):
            finger.step(1e-3, depth=0.1, shift=wrong)  # type: ignore[arg-type]  # on purpose
    assert finger.step(1e-3, depth=0.1, shift=np.array([0.5, 0])).shift.tolist() == [0.5, 0.0]


def test_a_plate_that_tilts_in_a_loop_is_the_rocking_plate_of_a_scene() -> None:
    times, level = (0.0, 0.05, 0.2, 0.3), (0.0, 0.0, 0.0, 0.0)
    tilts = (0.0, 0.0, 4.0, 4.0)
    motion = ff.SampledPath(times, level, level, (0.0, 0.5, 0.5, 0.4), tilt=tilts)
    scene = ff.Scene(finger=SOFT, indenter=ff.Flat(30), motion=motion, ask=ff.Ask(fields=False))
    expected = condensed.respond(scene)
    finger = loop("sliding")
    for k, time in enumerate(expected.time.tolist()):
        dt = time - expected.time[k - 1] if k else 0.0
        depth, turned = float(motion.value(time)), float(np.interp(time, times, tilts))
        force = finger.step(float(dt), depth=depth, tilt=turned).force
    assert force == pytest.approx(expected.force[-1], rel=1e-9)


def test_a_plate_along_the_finger_is_answered_to_the_depth_that_was_said() -> None:
    """Contact spreads to the proximal cut, behind which the finger is continued."""
    finger = ff.Loop(SOFT, ff.Flat(0), mechanics="condensed", deepest=1.5)
    assert finger.step(0.1, depth=1.5).force > finger.step(0.1, depth=1.4).force
    motion = ff.Ramp(15.0, 1.5, corner=0.0)
    scene = ff.Scene(finger=SOFT, indenter=ff.Flat(0), motion=motion, ask=ff.Ask(fields=False))
    expected = condensed.respond(scene)
    finger.reset()
    for depth, dt in zip(expected.depth, np.diff(expected.time, prepend=0.0), strict=True):
        force = finger.step(float(dt), depth=float(depth)).force
    assert force == pytest.approx(expected.force[-1], rel=1e-9)


def test_former_classes_say_what_they_are_now_and_step_as_before() -> None:
    made = {
        "condensed": lambda: ff.Condensed(SOFT, ff.Flat(30), deepest=0.8),
        "pressed": lambda: ff.Pressed(finger_of("pressed"), ff.Flat(30), deepest=0.8),
        "modal": lambda: ff.Modal(SOFT, ff.Flat(30), deepest=0.8),
    }
    for kind, make in made.items():
        with pytest.warns(DeprecationWarning, match="is ff.Loop now"):
            former = make()
        expected = loop(kind).step(1e-4, depth=0.3).force
        assert former.step(0.3, 1e-4).force == pytest.approx(expected, rel=1e-9)
    with pytest.warns(DeprecationWarning, match="ff.Sliding"):
        sliding = ff.Sliding(SOFT, ff.Flat(30), deepest=0.8)
    assert sliding.step(0.3, (0.1, 0.0), 1e-3).shift.tolist() == [0.1, 0.0]
    with pytest.warns(DeprecationWarning, match="ff.Rolling"):
        rolling = ff.Rolling(SOFT, angles=(15, 35), deepest=0.8, sites=SITES)
    assert rolling.step(0.3, 20.0, 1e-3).touching
