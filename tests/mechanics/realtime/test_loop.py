"""Fingers in real time: text, families of units, refused steps, and the warning of soft tissue."""

import copy
from collections.abc import Callable
from dataclasses import fields
from functools import partial

import numpy as np
import pytest

import fefinger as ff
from fefinger.mechanics import condensed
from fefinger.mechanics.situation import Situation
from fefinger.neural.streaming import Afferents, RecordedAfferents
from fefinger.results.records import Sites
from fefinger.support.text import percent


SOFT = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")
STIFFENING = ff.Finger.subject("a.h.", resolution="coarse")
RIM = "contact at their rim"
SITES = Sites(np.array([[0, 0, 0.9]]), -np.eye(3)[2:], np.array([0.8]), ("SAI",))


pytestmark = pytest.mark.usefixtures("operators")


@pytest.mark.parametrize("indenter", [ff.Flat(30), ff.Sphere(5)])
def test_tissue_that_stiffens_is_warned_of_with_the_error_of_the_scene(indenter) -> None:
    scene = ff.Scene(finger=STIFFENING, indenter=indenter, motion=ff.Ramp(10, 0.8))
    error, _ = condensed.error(Situation.of(scene))
    said = "" if np.isnan(error) else f"at 0.8 mm is wrong by some {percent(error)} "
    with pytest.warns(UserWarning, match=f"stiffens.*{said}.*ff.Pressed"):
        ff.Condensed(STIFFENING, indenter, deepest=0.8)


def test_the_other_fingers_at_small_strain_warn_too() -> None:
    with pytest.warns(UserWarning, match="calibrated_ah stiffens"):
        ff.Sliding(STIFFENING, ff.Flat(30), deepest=0.5)
    with pytest.warns(UserWarning, match="calibrated_ah stiffens"):
        ff.Rolling(STIFFENING, angles=(28, 32), deepest=0.5, sites=SITES)
    with pytest.warns(UserWarning, match="calibrated_ah stiffens"):
        ff.Modal(STIFFENING, ff.Flat(30), deepest=0.5)
    law = ff.Stiffening(1.0, 1.0)  # stiffens by t(u): nothing to warn of
    ff.Condensed(STIFFENING, ff.Flat(30), deepest=0.5, stiffening=law)


@pytest.mark.parametrize("kind", [ff.Condensed, ff.Pressed, ff.Sliding])
def test_units_are_of_either_family(kind: type) -> None:
    finger = kind(SOFT, ff.Flat(30), deepest=0.8)
    recorded = finger.afferents()
    assert isinstance(recorded, RecordedAfferents)
    assert repr(recorded) == "<Afferents (recorded) of SAI, SAII, FAI, FAII>"
    thesis = finger.afferents(family="thesis")
    assert isinstance(thesis, Afferents)
    assert repr(thesis) == "<Afferents (thesis) of SAI, SAII, FAI, FAII>"
    with pytest.raises(ff.InputError, match="family"):
        finger.afferents(family="theses")


@pytest.mark.parametrize("kind", [ff.Condensed, ff.Pressed, ff.Sliding, ff.Modal])
def test_the_name_of_a_subject_is_no_finger(kind: type) -> None:
    with pytest.raises(ff.InputError, match=r"expected a Finger, as ff.Finger.subject.*'a.h.'"):
        kind("a.h.", ff.Flat(30))


def test_a_force_beyond_the_press_is_refused_with_the_largest_one() -> None:
    finger = ff.Pressed(SOFT, ff.Flat(30), deepest=0.8)
    with pytest.raises(ff.InputError, match="expected at most") as caught:
        finger.step_force(50.0, 1e-3)
    most = float(str(caught.value).split()[4].rstrip(","))
    assert finger.step_force(0.99 * most, 1e-3).force == pytest.approx(0.99 * most)


def slide(finger: ff.Sliding, depth: float) -> object:
    return finger.step(depth, (0.2 * depth, 0.1), 1e-3)


@pytest.mark.parametrize(
    ("make", "take", "refused"),
    [
        (
            lambda: ff.Condensed(SOFT, ff.Flat(30), deepest=0.8),
            lambda f, depth: f.step(depth, 5e-3),
            [
                (lambda f: f.step(3.0, 5e-3), RIM),
                (lambda f: f.step_contact(3.0, 5e-3), RIM),
                (lambda f: f.step_force(50.0, 5e-3), RIM),
            ],
        ),
        (
            lambda: ff.Pressed(SOFT, ff.Flat(30), deepest=0.8),
            lambda f, depth: f.step(depth, 5e-3),
            [
                (lambda f: f.step(3.0, 5e-3), "depth: expected .* at most 0.8"),
                (lambda f: f.step_force(50.0, 5e-3), "give a larger `deepest`"),
            ],
        ),
        (
            lambda: ff.Modal(SOFT, ff.Flat(30), deepest=0.8),
            lambda f, depth: f.step(depth, 1e-4),
            [
                (lambda f: f.step(3.0, 1e-4), RIM),
                (lambda f: f.step(0.5, 1e-3), r"of at most 0\.0001 s"),
            ],
        ),
        (
            lambda: ff.Rolling(SOFT, angles=(15, 35), deepest=0.8, sites=SITES),
            lambda f, depth: f.step(depth, 20 + 10 * depth, 5e-3),
            [(lambda f: f.step(3.0, 33.0, 5e-3), RIM)],
        ),
        *(
            (
                lambda mu=mu: ff.Sliding(SOFT, ff.Dots(2.5, friction=mu), deepest=0.8),
                slide,
                [
                    (lambda f: f.step(2.5, (3.0, 1.0), 1e-3), "candidates"),
                    (lambda f: f.step(0.5, (0.0, np.nan), 1e-3), "shift: expected two finite"),
                ],
            )
            for mu in (0.0, 0.3)
        ),
    ],
    ids=["condensed", "pressed", "modal", "rolling", "sliding", "sliding with friction"],
)
def test_a_refused_step_leaves_the_finger_as_it_was(
    make: Callable, take: Callable, refused: list[tuple[Callable, str]]
) -> None:
    finger = make()
    for depth in (0.3, 0.6):
        before = copy.deepcopy(take(finger, depth))
    for step, words in refused:
        with pytest.raises(ff.InputError, match=words):
            step(finger)
    for field in fields(before):
        np.testing.assert_array_equal(getattr(finger.now, field.name), getattr(before, field.name))
    found = copy.deepcopy(take(finger, 0.5))
    finger.reset()
    for depth in (0.3, 0.6, 0.5):
        expected = take(finger, depth)
    for field in fields(expected):
        wanted = getattr(expected, field.name)
        close = {"rtol": 1e-9, "atol": 1e-9 * np.abs(wanted).max()}
        np.testing.assert_allclose(getattr(found, field.name), wanted, **close)


def test_a_finger_and_a_step_are_a_line_with_units() -> None:
    finger = ff.Condensed(SOFT, ff.Flat(30), deepest=0.8)
    about = "finger a.h., maeno1998 tissue, coarse mesh, under Flat(angle=30.0, tilt=0.0)"
    assert repr(finger).startswith(f"<Condensed: {about}; to 0.8 mm; ")
    assert repr(finger).endswith("vertices may touch; strain at SAI, SAII, FAI, FAII>")
    step = finger.step(0.3, 1e-3)
    assert repr(step).startswith(f"<Step: {step.force:.4g} N at 0.3 mm, ")
    assert "Step: 0 N at 0 mm, 0 mm² about x nan" in repr(finger.step(0.0, 1e6))


def test_a_ball_is_moved_anywhere_within_its_reach_and_no_farther() -> None:
    """Skin under its rim alone would leave gaps: no force, or a refusal, in between."""
    finger = ff.Sliding(SOFT, ff.Sphere(1), deepest=0.3, reach=3.5)
    for place in ((1.2, 0.9), (-1.75, 0.0)):
        finger.reset()
        assert finger.step(0.3, place, 0.05).force > 0.015
    with pytest.raises(ff.InputError, match=r"at most `reach` = 3\.5 mm from the first"):
        finger.step(0.3, (3.5, 0.1), 0.05)


@pytest.mark.parametrize("kind", [ff.Condensed, ff.Pressed, ff.Modal])
def test_a_finger_that_is_only_pressed_refuses_friction(kind: type) -> None:
    with pytest.raises(ff.InputError, match=r"indenter.friction = 0.5 > 0.*use ff.Sliding"):
        kind(SOFT, ff.Flat(30, friction=0.5), deepest=0.5)


@pytest.mark.parametrize("make", [
    lambda: ff.Pressed(SOFT, ff.Flat(30), deepest=0.5).step,
    lambda: ff.Condensed(SOFT, ff.Flat(30), deepest=0.5).step,
    lambda: ff.Modal(SOFT, ff.Flat(30), deepest=0.5, dt=1.0).step,
    lambda: partial(ff.Sliding(SOFT, ff.Dots(2.5), deepest=0.5).step, shift=(0.0, 0.0)),
], ids=["pressed", "condensed", "modal", "sliding"])  # fmt: skip
def test_a_depth_or_a_step_that_is_no_number_is_refused(make: Callable) -> None:
    step = make()
    for wrong in ("0.3", None, 1j, True, np.array([0.1, 0.2])):
        with pytest.raises(ff.InputError, match="depth: expected"):
            step(depth=wrong, dt=1e-3)
        with pytest.raises(ff.InputError, match="dt: expected"):
            step(depth=0.1, dt=wrong)
    assert step(depth=np.array(0), dt=1).depth == 0.0


def test_a_place_that_is_not_two_numbers_is_refused() -> None:
    finger = ff.Sliding(SOFT, ff.Dots(2.5), deepest=0.5)
    for wrong in ("a", "12", None, 1.0, (0.0,), (0.0, "1"), (0.0, True), (1j, 0.0), ([0.1], 0.0)):
        with pytest.raises(ff.InputError, match="shift: expected two finite numbers in mm"):
            finger.step(0.1, wrong, 1e-3)  # type: ignore[arg-type]  # of the wrong type on purpose
    assert finger.step(0.1, np.array([0.5, 0]), 1e-3).shift.tolist() == [0.5, 0.0]
