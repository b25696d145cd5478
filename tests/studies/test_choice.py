"""All scenes of a study are answered by one mechanics on one mesh, unless it is asked otherwise."""

import pytest

import fefinger as ff
from fefinger import plan
from fefinger.results.records import Refusal, Rung
from fefinger.results.result_record import Plan, Settings
from fefinger.studies import study
from fefinger.studies.tasks import StudyRequest
from fefinger.support.checks import InputError


LEAN = {"ask.spikes": [], "ask.strain": False, "ask.pressure": False}
ANGLES = {"indenter.angle": (15, 30, 45)}


def tasks(over, mechanics=None, **changes):
    asked = StudyRequest("flat-press", over, LEAN | changes, mechanics, ())
    return asked.tasks()[0]


def mechanics_of(found):
    """Return the mechanics of all tasks."""
    return {task["mechanics"] for task in found.values()}


def meshes_of(found):
    """Return the meshes of the tasks, in their order."""
    return [task["scene"]["finger"]["resolution"] for task in found.values()]


def planned(monkeypatch, takes, refusing=()):
    """Let scenes take the (mechanics, mesh) of their angle; `refusing` names refuse 45 degrees."""

    def choose(scene, mechanics=None):
        angle = scene.indenter.angle
        name, mesh = takes[angle] if mechanics is None else (mechanics, takes[angle][1])
        stated = scene.finger.resolution
        mesh = mesh if stated == "auto" else stated
        refused = angle == 45 and mechanics in refusing
        reasons = (Refusal(name, "accuracy", "far"),) if refused else ()
        rung = Rung(name, 1.0, 0.1, "a report")
        return Plan(name, (rung,), "", reasons, Settings(mesh, None, 2, ("force",), ()))

    monkeypatch.setattr(study, "choose", choose)


def test_scenes_that_take_the_same_are_held_to_it_without_a_word(monkeypatch):
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("linear", "coarse")))
    found, said = study.agreed(tasks(ANGLES))
    assert mechanics_of(found) == {"linear"}
    assert set(meshes_of(found)) == {"coarse"}
    assert said == ""


def test_a_study_that_goes_on_keeps_its_choice_whatever_is_cheapest_by_then(monkeypatch, tmp_path):
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("linear", "standard")))
    first = study.agreed(tasks(ANGLES), ANGLES, tmp_path)
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("condensed", "standard")))
    assert study.agreed(tasks(ANGLES), ANGLES, tmp_path) == first
    other = {"indenter.angle": (15, 30)}
    assert study.agreed(tasks(other), other, tmp_path)[0][0]["mechanics"] == "condensed"
    for kept in tmp_path.iterdir():
        kept.write_text("{")
    again = study.agreed(tasks(ANGLES), ANGLES, tmp_path)[0]
    assert mechanics_of(again) == {"condensed"}


def test_a_folder_where_the_choice_is_stored_is_named(monkeypatch, tmp_path):
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("linear", "standard")))
    study.agreed(tasks(ANGLES), ANGLES, tmp_path)
    (stored,) = tmp_path.iterdir()
    stored.unlink()
    stored.mkdir()
    with pytest.raises(InputError, match=stored.name):
        study.agreed(tasks(ANGLES), ANGLES, tmp_path)


def test_a_scene_that_none_answers_is_not_said_to_be_answered(monkeypatch):
    planned(monkeypatch, {15: ("linear", "coarse"), 30: ("linear", "standard")})
    known = study.choose

    def choose(scene, mechanics=None):
        if scene.indenter.angle == 45:
            message = "none"
            raise InputError(message)
        return known(scene, mechanics)

    monkeypatch.setattr(study, "choose", choose)
    said = study.agreed(tasks(ANGLES))[1]
    assert said.startswith("The scenes that can be answered are answered by linear")


@pytest.mark.parametrize("name", ["hertz", "layered"])
def test_what_is_alike_at_all_angles_answers_no_study_of_them(monkeypatch, name):
    planned(monkeypatch, dict.fromkeys((15, 30, 45), (name, None)))
    found, said = study.agreed(tasks(ANGLES), ANGLES)
    assert mechanics_of(found) == {"condensed"}
    assert f"would be {name}, which does not depend on the place of contact" in said
    found, said = study.agreed(tasks(ANGLES), ["motion.depth"])
    assert mechanics_of(found) == {name}


def test_the_cheapest_that_refuses_none_answers_all_on_the_finest_mesh(monkeypatch):
    takes = {15: ("lumped", None), 30: ("linear", "coarse"), 45: ("linear", "standard")}
    planned(monkeypatch, takes)
    found, said = study.agreed(tasks(ANGLES))
    assert mechanics_of(found) == {"linear"}
    assert set(meshes_of(found)) == {"standard"}
    assert said.startswith("All scenes are answered by linear on the standard mesh; the cheapest ")
    assert "lumped, linear on the coarse mesh, linear on the standard mesh, scene by scene" in said


def test_one_that_refuses_a_scene_is_passed_over(monkeypatch):
    planned(monkeypatch, {15: ("hertz", None), 30: ("linear", "coarse"), 45: ("hertz", None)})
    assert mechanics_of(study.agreed(tasks(ANGLES))[0]) == {"linear"}
    takes = {15: ("hertz", None), 30: ("linear", "coarse"), 45: ("hertz", None)}
    planned(monkeypatch, takes, refusing=("linear",))
    assert mechanics_of(study.agreed(tasks(ANGLES))[0]) == {"solid"}
    planned(monkeypatch, takes, refusing=("linear", "solid"))
    asked = tasks(ANGLES)
    assert study.agreed(asked) == (asked, "")


def test_a_mechanics_that_the_scenes_name_answers_them(monkeypatch):
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("linear", "coarse")), refusing=("hertz",))
    named = tasks(ANGLES, **{"ask.mechanics": "hertz"})
    assert mechanics_of(study.agreed(named)[0]) == {"hertz"}
    compared = tasks({"ask.mechanics": ("hertz", "linear"), **ANGLES})
    assert study.agreed(compared) == (compared, "")


def test_a_mechanics_that_is_named_answers_all_on_the_finest_mesh_that_one_needs(monkeypatch):
    takes = {15: ("lumped", "coarse"), 30: ("lumped", "coarse"), 45: ("lumped", "standard")}
    planned(monkeypatch, takes, refusing=("linear",))
    found, said = study.agreed(tasks(ANGLES, "linear"))
    assert mechanics_of(found) == {"linear"}
    assert set(meshes_of(found)) == {"standard"}
    assert said.startswith("All scenes are answered by linear on the standard mesh, the finest ")
    assert "for others linear on the coarse mesh would suffice" in said
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("linear", "coarse")))
    assert study.agreed(tasks(ANGLES, "linear"))[1] == ""
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("hertz", None)))
    asked = tasks(ANGLES, "hertz")
    assert study.agreed(asked) == (asked, "")


def test_the_mesh_of_a_mechanics_that_is_named_is_kept_where_it_has_one(monkeypatch, tmp_path):
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("linear", "standard")))
    first = study.agreed(tasks(ANGLES, "linear"), ANGLES, tmp_path)
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("linear", "coarse")))
    assert study.agreed(tasks(ANGLES, "linear"), ANGLES, tmp_path) == first
    planned(monkeypatch, dict.fromkeys((15, 30, 45), ("hertz", None)))
    study.agreed(tasks(ANGLES, "hertz"), ANGLES, tmp_path)
    assert len(list(tmp_path.iterdir())) == 1


def test_meshes_that_scenes_state_stay(monkeypatch):
    planned(monkeypatch, {30: ("linear", "coarse")})
    over = {"finger.resolution": ("coarse", "standard")}
    for name in ("linear", None):
        found, said = study.agreed(tasks(over, name), over)
        assert (meshes_of(found), said) == (["coarse", "standard"], "")


def test_a_study_with_a_mechanics_that_is_named_is_on_one_mesh(monkeypatch):
    answered = {}

    def local(tasks, count):
        for i, task in enumerate(tasks):
            answered[i] = task
            yield i, {"error": "not answered"}

    monkeypatch.setattr("fefinger.studies.study.local", local)
    takes = {15: ("linear", "coarse"), 30: ("linear", "coarse"), 45: ("linear", "standard")}
    planned(monkeypatch, takes)
    found = ff.study("flat-press", ANGLES, changes=LEAN, mechanics="linear")
    assert meshes_of(answered) == ["standard"] * 3
    assert "linear on the standard mesh" in found.about["chosen"]
    ff.study("flat-press", ANGLES, changes=LEAN, mechanics="each")
    assert meshes_of(answered) == ["auto"] * 3


def test_forces_over_angles_that_plans_answer_apart_are_of_one_mechanics():
    changes = LEAN | {"motion.depth": 0.3, "motion.hold": 0.0, "ask.rel_error": 0.35}
    changes |= {"ask.fields": False}
    over = {"indenter.angle": (30, 45)}
    asked = tasks(over, **changes)
    each = {plan.choose(ff.Scene.from_dict(task["scene"])).mechanics for task in asked.values()}
    assert len(each) == 2
    found, said = study.agreed(asked, over)
    (chosen,) = mechanics_of(found)
    assert said.startswith(f"All scenes are answered by {chosen}")
