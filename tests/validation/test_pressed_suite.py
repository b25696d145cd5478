"""Suite `pressed`: its scenes are the same each time, and its report is about them."""

import pytest
from fefinger.validation.pressed import suite
from fefinger.validation.pressed.measure import errors
from fefinger.validation.pressed.scenes import COUNTS, STANDARD, drawn

import fefinger as ff
from fefinger.mechanics import pressed
from fefinger.mechanics.evidence.table import TABULATION, TABULATION_SETS, read
from fefinger.mechanics.evidence.tabulation_error import ABOUT, MARGIN, error
from fefinger.mechanics.situation import Situation
from fefinger.scene.ask import Ask


def test_all_sets_are_drawn_the_same_each_time_and_share_no_scene() -> None:
    sets = {name: drawn(name) for name in COUNTS}
    for name, scenes in sets.items():
        assert scenes == drawn(name)  # exact: one call, made twice
        assert len(scenes) == COUNTS[name]
        meshes = [scene.finger.resolution for scene in scenes]
        assert meshes.count("standard") == STANDARD[name]
    assert len(sets["held-out"]) >= 40
    motions = {scene.motion for scenes in sets.values() for scene in scenes}
    assert len(motions) == sum(COUNTS.values())


def test_the_report_is_of_these_scenes() -> None:
    for name, rows in ((name, read(TABULATION)[name]) for name in TABULATION_SETS):
        assert list(rows) == [scene.name for scene in drawn(name)]
        measured = [row for row in rows.values() if "refused" not in row]
        assert len(measured) >= 0.9 * len(rows)


def test_what_is_stated_is_the_largest_error_of_the_scenes_about_as_deep_with_the_margin() -> None:
    case = Situation.of(
        ff.Scene(finger=ff.Finger.subject("a.h."), motion=ff.Ramp(60, 1.0), ask=Ask(fields=False))
    )
    near = {
        key: row["peak"]["strain"]
        for key, row in suite.every().items()
        if 0.1 / ABOUT <= row["part"] <= 0.1 * ABOUT
    }
    worst = max(near, key=near.__getitem__)
    expected = pytest.approx(MARGIN * near[worst], rel=1e-12)
    assert error(case, "strain") == expected == suite.stated("peak", "strain", 0.1)
    second = max(value for scene, value in near.items() if scene != worst)
    stated = suite.stated("peak", "strain", 0.1, worst)
    assert stated == pytest.approx(MARGIN * second, rel=1e-12)


def test_a_response_has_no_error_against_itself() -> None:
    finger = ff.Finger.subject("a.h.", resolution="coarse")
    motion = ff.Trapezoid(20, 0.8, hold=0.1)
    response = pressed.respond(ff.Scene(finger=finger, motion=motion, ask=Ask(fields=False)))
    found = errors(response, response, by_force=False)
    assert {error for phase in found.values() for error in phase.values()} == {0.0}
    assert set(found["retreat"]) == {"force", "area", "strain", "pressure", "pressure in L2"}
