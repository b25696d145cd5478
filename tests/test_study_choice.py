"""All scenes of a study are answered by one mechanics on one mesh, unless it is asked otherwise."""

import fefinger as ff
from fefinger import plan
from fefinger.records import Plan, Refusal, Rung, Settings
from fefinger.studies import choice
from fefinger.studies.tasks import Asked


LEAN = {"ask.spikes": [], "ask.strain": False, "ask.pressure": False}
ANGLES = {"indenter.angle": (15, 30, 45)}


def tasks(over, mechanics=None, **changes):
    asked = Asked("flat-press", over, LEAN | changes, mechanics, ())
    return asked.tasks()[0]


def planned(monkeypatch, takes, refusing=()):
    """Let scenes take the (mechanics, mesh) of their angle; `refusing` names refuse 45 degrees."""

    def choose(scene, mechanics=None):
        angle = scene.indenter.angle
        name, mesh = takes[angle] if mechanics is None else (mechanics, takes[angle][1])
        refused = angle == 45 and mechanics in refusing
        reasons = (Refusal(name, "accuracy", "far"),) if refused else ()
        rung = Rung(name, 1.0, 0.1, "a report")
        return Plan(name, (rung,), "", reasons, Settings(mesh, None, 2, ("force",), ()))

    monkeypatch.setattr(choice, "choose", choose)


def test_scenes_that_take_the_same_are_left_as_they_are(monkeypatch):
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("linear", "coarse")))
    asked = tasks(ANGLES)
    assert choice.agreed(asked) == (asked, "")


def test_the_cheapest_that_refuses_none_answers_all_on_the_finest_mesh(monkeypatch):
    takes = {15: ("lumped", None), 30: ("linear", "coarse"), 45: ("linear", "standard")}
    planned(monkeypatch, takes)
    found, said = choice.agreed(tasks(ANGLES))
    assert {task["mechanics"] for task in found.values()} == {"linear"}
    assert {task["scene"]["finger"]["resolution"] for task in found.values()} == {"standard"}
    assert said.startswith("All scenes are answered by linear on the standard mesh; the cheapest ")
    assert "lumped, linear on the coarse mesh, linear on the standard mesh, scene by scene" in said


def test_one_that_refuses_a_scene_is_passed_over(monkeypatch):
    planned(monkeypatch, {15: ("hertz", None), 30: ("linear", "coarse"), 45: ("hertz", None)})
    assert {task["mechanics"] for task in choice.agreed(tasks(ANGLES))[0].values()} == {"linear"}
    takes = {15: ("hertz", None), 30: ("linear", "coarse"), 45: ("hertz", None)}
    planned(monkeypatch, takes, refusing=("linear",))
    assert {task["mechanics"] for task in choice.agreed(tasks(ANGLES))[0].values()} == {"solid"}
    planned(monkeypatch, takes, refusing=("linear", "solid"))
    asked = tasks(ANGLES)
    assert choice.agreed(asked) == (asked, "")


def test_a_study_of_forces_over_angles_is_of_one_mechanics_and_says_so():
    changes = LEAN | {"motion.depth": 0.3, "motion.hold": 0.0, "ask.rel_error": 0.9}
    changes |= {"ask.fields": False}
    each = {
        angle: plan.choose(ff.Scene.from_dict(task["scene"])).mechanics
        for angle, task in zip(
            (30, 45), tasks({"indenter.angle": (30, 45)}, **changes).values(), strict=True
        )
    }
    assert each[30] != each[45]
    found = ff.study("flat-press", {"indenter.angle": (30, 45)}, changes=changes)
    assert len({row["mechanics"] for row in found.rows}) == 1
    assert found.about["chosen"].startswith(f"All scenes are answered by {each[45]}")
    apart = ff.study("flat-press", {"indenter.angle": (30, 45)}, changes=changes, mechanics="each")
    assert {row["mechanics"] for row in apart.rows} == set(each.values())
