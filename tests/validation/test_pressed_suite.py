"""Suite `pressed`: its scenes are the same each time, and its report is about them."""

import numpy as np
from fefinger.validation.pressed import suite
from fefinger.validation.pressed.measure import (
    COUNTS,
    STANDARD,
    TABULATION,
    TABULATION_SETS,
    drawn,
    errors,
)

import fefinger as ff
from fefinger.mechanics import pressed
from fefinger.mechanics.evidence.presses import read
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


def test_what_is_stated_holds_in_95_of_100_scenes_that_it_is_stated_without() -> None:
    every = suite.every()
    held = [
        row["peak"]["strain"] <= suite.stated("peak", "strain", row["part"], key)
        for key, row in every.items()
    ]
    assert 0.93 <= np.mean(held) < 1.0
    shallow, deep = (suite.stated("peak", "strain", part) for part in (0.02, 0.2))
    assert 0 < shallow < deep < 0.05


def test_a_response_has_no_error_against_itself() -> None:
    finger = ff.Finger.subject("a.h.", resolution="coarse")
    motion = ff.Trapezoid(20, 0.8, hold=0.1)
    response = pressed.respond(ff.Scene(finger=finger, motion=motion, ask=Ask(fields=False)))
    found = errors(response, response, by_force=False)
    assert {error for phase in found.values() for error in phase.values()} == {0.0}
    assert set(found["retreat"]) == {"force", "area", "strain", "pressure", "pressure in L2"}
