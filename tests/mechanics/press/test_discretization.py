"""A plate along the finger: it is continued behind its cut, and what goes beyond is told."""

import pytest

import fefinger as ff
from fefinger.mechanics import linear, solid
from fefinger.mechanics.linear import FAR
from fefinger.mechanics.press.mesh_limits import CLOSE, NEAR, gap, needs_continuation
from fefinger.mechanics.situation import Situation
from fefinger.mesh.extend import NOTE
from fefinger.pipeline import run


def finger(subject: str) -> ff.Finger:
    return ff.Finger.subject(subject, resolution="coarse", tissue="maeno1998")


def pressed(subject: str, depth: float, angle: float = 0.0) -> ff.Scene:
    ask = ff.Ask(pressure=False, strain=False, fields=False)
    motion = ff.Ramp(60.0, depth, corner=0.0)
    return ff.Scene(finger=finger(subject), indenter=ff.Flat(angle), motion=motion, ask=ask)


@pytest.mark.parametrize("subject", ["d.p.", "d.s.", "a.h.", "p.w."])
def test_no_finger_refuses_two_millimeters_at_any_angle(subject: str) -> None:
    for angle in (0, 5, 10, 15, 30, 60):
        case = Situation.of(pressed(subject, 2.0, angle))
        assert linear.beyond_cut("linear", case) == ()


@pytest.mark.parametrize("subject", ["p.w."])
def test_a_press_that_reached_the_cut_is_answered_on_the_continued_finger(subject: str) -> None:
    """2 mm, where the cut is 0.3 and 0.8 mm away from the plate."""
    scene = pressed(subject, 2.0)
    assert 2.0 > FAR * gap(scene.finger, ff.Flat(0.0))
    answer = run(scene, mechanics="linear")
    steeper = run(pressed(subject, 2.0, angle=7.0), mechanics="linear")
    assert 0.8 < answer.force[-1] / steeper.force[-1] < 1.2
    assert NOTE in answer.notes


def test_the_gap_at_the_continued_end_is_that_of_the_mesh() -> None:
    from fefinger.mesh.store import load_or_build

    mesh = load_or_build(finger("a.h."), half=True, with_continuation=True)
    low = mesh.points[mesh.facets["cut"].ravel(), 2].min()
    first = mesh.points[mesh.facets["pad"].ravel(), 2].min()
    assert low - first == pytest.approx(
        gap(finger("a.h."), ff.Flat(0.0), with_continuation=True), abs=0.03
    )


def test_the_finger_is_continued_only_where_the_plate_comes_close() -> None:
    near = gap(finger("a.h."), ff.Flat(0.0))
    for depth, expected in ((0.99 * CLOSE * near, False), (1.01 * CLOSE * near, True)):
        scene = pressed("a.h.", depth)
        assert needs_continuation(scene.finger, scene.indenter, scene.motion) is expected
    for other in (ff.Flat(30.0), ff.Sphere(5.0)):
        assert not needs_continuation(scene.finger, other, ff.Ramp(60.0, 3.0))
    assert needs_continuation(finger("d.p."), ff.Flat(0.0), ff.Ramp(loading_rate=1.0, force=2.0))


def test_where_the_plate_comes_close_the_continuation_changes_the_force_by_percents(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The vertices under the plate are the same: what changes is the tissue behind them."""
    scene = pressed("a.h.", 0.99 * CLOSE * gap(finger("a.h."), ff.Flat(0.0)))
    short = run(scene, mechanics="linear").force[-1]
    monkeypatch.setattr("fefinger.mechanics.press.problem.needs_continuation", lambda *_: True)
    long = run(scene, mechanics="linear").force[-1]
    assert 0.96 < long / short < 0.999


def test_beyond_the_continuation_the_press_is_refused() -> None:
    end = gap(finger("d.p."), ff.Flat(0.0), with_continuation=True)
    assert linear.beyond_cut("linear", Situation.of(pressed("d.p.", 0.99 * NEAR * end))) == ()
    (refusal,) = linear.beyond_cut("linear", Situation.of(pressed("d.p.", 1.05 * end)))
    assert refusal.about == "accuracy"
    assert "contact may reach the end" in refusal.reason
    deep = Situation.of(pressed("d.p.", 1.01 * FAR * end))
    (sure,) = linear.beyond_cut("solid", deep)
    assert sure.about == "ability"
    assert "contact reaches the end" in sure.reason
    assert sure in solid.refuse(deep)


def test_steeper_plates_and_other_objects_are_not_asked_about_it() -> None:
    deep = pressed("a.h.", 2.0, angle=30.0)
    assert linear.beyond_cut("linear", Situation.of(deep)) == ()
    ball = ff.Scene(finger=deep.finger, indenter=ff.Sphere(5.0), motion=deep.motion)
    assert linear.beyond_cut("linear", Situation.of(ball)) == ()
