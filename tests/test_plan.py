"""The planner: the cheapest mechanics and mesh that is good enough, and what it says of the others.

And that nothing is built that the scene did not ask for.
"""

import json
import re
import subprocess
import sys
from dataclasses import astuple, replace
from types import SimpleNamespace

import pytest
from fefinger.validation.problems import published
from refusals import refused

import fefinger as ff
from fefinger import mechanics, plan
from fefinger.mechanics import get, layered
from fefinger.mechanics.evidence import costs
from fefinger.mechanics.situation import Situation
from fefinger.results import key_numbers, result_record
from fefinger.results.candidate import MECHANICS, meshed
from fefinger.results.records import Refusal, Rung
from fefinger.results.result_record import Settings
from fefinger.scene import builtin
from fefinger.support import machine, text
from fefinger.support.checks import BeyondError, InputError


def rung(name, *, seconds, error, refusals=()):
    """Return a mechanics that takes 1, 10 and 100 times `seconds` and errs 4, 1 and 0.5 times."""

    def measured(case):
        if any(refusal.about == "ability" for refusal in refusals):
            pytest.fail("the cost of what cannot be done was asked")
        return seconds * {"coarse": 0.1, "standard": 1.0, "fine": 10.0}[case.mesh]

    factors = {"coarse": 4.0, "standard": 1.0, "fine": 0.5}
    return SimpleNamespace(
        name=name,
        refuse=lambda case: refusals,
        cost=measured,
        once=lambda case: 0.0,
        coarser=lambda scene: None,
        error=lambda case, quantity="force": (error * factors[case.mesh], f"reports/{name}.json"),
    )


UNABLE = Refusal("lumped", "ability", "strain: requested, but it gives none")
THIN = Refusal("hertz", "accuracy", "contact radius / tissue thickness = 0.9 > 0.1")
LADDER = {
    "lumped": rung("lumped", seconds=1e-5, error=0.01, refusals=(UNABLE,)),
    "hertz": rung("hertz", seconds=1e-3, error=0.02, refusals=(THIN,)),
    "linear": rung("linear", seconds=30.0, error=0.03),
    "solid": rung("solid", seconds=600.0, error=0.001),
}


@pytest.fixture
def four(monkeypatch):
    monkeypatch.setattr(plan, "names", lambda: tuple(LADDER))
    monkeypatch.setattr(plan, "get", LADDER.__getitem__)
    monkeypatch.setattr(costs, "threads", lambda: 1)  # their seconds are wall time


@pytest.fixture
def _speed(monkeypatch):
    monkeypatch.setattr(machine, "kept", lambda: machine.REPORTED)


pytestmark = pytest.mark.usefixtures("_speed")


def scene(**changes):
    settings = {"ask.spikes": []} | {f"ask.{name}": value for name, value in changes.items()}
    return published.load("flat-press", {"ask.rel_error": 0.05} | settings)


def asked(**changes):
    """Return a press that asks for nothing but what is named."""
    alone = dict.fromkeys(("pressure", "strain", "fields"), False) | {"spikes": ()} | changes
    return ff.Scene(
        finger=ff.Finger.subject(
            "a.h.", resolution=alone.pop("resolution", "auto"), tissue="maeno1998"
        ),
        motion=ff.RampHold(60, alone.pop("depth", 0.8), hold=0.02, corner=0.0),
        ask=ff.Ask(rel_error=alone.pop("rel_error", 0.4), **alone),
    )


@pytest.mark.usefixtures("four")
def test_a_scene_may_be_named_as_for_a_run():
    named, given = "flat-press", builtin.load("flat-press")
    for planned in (ff.explain, ff.choose):
        # As texts: of a mechanics that is not able the seconds are NaN, which equals nothing.
        told = [repr(astuple(planned(scene))) for scene in (named, given)]
        assert told[0] == told[1]  # exact: one scene is planned twice, by its name and as loaded


@pytest.mark.usefixtures("four")
def test_the_cheapest_that_does_not_refuse_is_chosen_and_all_are_listed():
    found = plan.explain(scene())
    assert (found.mechanics, found.settings.resolution) == ("linear", "standard")
    assert found.chosen.evidence == "reports/linear.json"
    assert [(rung.mechanics, rung.resolution) for rung in found.rungs] == [
        ("lumped", None),
        ("hertz", None),
        *((name, mesh) for name in ("linear", "solid") for mesh in ("coarse", "standard", "fine")),
    ]
    assert [rung.refusals for rung in found.rungs[:2]] == [(UNABLE,), (THIN,)]
    assert "linear, the cheapest that does not refuse" in found.sentence
    assert "linear on the standard mesh: force within 3 %, solved in about 30 s." in repr(found)
    assert "on the standard mesh of half a finger" in found.sentence


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, "Expected within: force 4 %, contact area 30 %. Error not known: highest "
         "pressure over 1 mm², strain at the end organs."),
        ({"strain": False, "pressure": False}, "Expected within: force 4 %."),
        ({"force": False, "pressure": False}, "Error not known: strain at the end organs."),
        ({"errors": {"pressure": 0.88, "area": 1.2}, "strain": False}, "Expected within: force "
         "4 %, highest pressure over 1 mm² 88 % (true value 0.53 to 8.3 times the answer), "
         "contact area 120 % (true value at least 0.45 times the answer, upper limit not known)."),
    ],
)  # fmt: skip
def test_how_far_each_thing_that_is_asked_can_be_trusted_is_said(changes, said):
    errors = changes.pop("errors", {"area": 0.3})
    rung = Rung("linear", 1.0, 0.04, "reports/linear.json", errors=errors)
    assert result_record.trust(rung, scene(**changes).ask) == said


def test_where_the_force_is_prescribed_the_depth_has_an_error_and_the_force_that_there():
    found = plan.choose(published.load("press-to-1N", {"ask.rel_error": 0.9, "ask.fields": False}))
    told = re.sub(r" \(.*?\)", "", found.trust)
    depth, force = found.chosen.errors["depth"], found.chosen.error
    expected = f"largest depth {text.percent(depth)}, force at the depth {text.percent(force)}, "
    assert told.startswith(f"Expected within: {expected}")


def test_parts_finer_than_the_facets_are_refused_before_and_said_on_top_of_the_answer():
    fine = {"indenter.period": 0.5, "indenter.ridge": 0.25, "indenter.depth": 0.1}
    asked = builtin.load("grating-press", fine | {"ask.spikes": []})
    for rung in plan.rungs(asked):
        resolution = [each.field == "finger.resolution" for each in rung.refusals]
        assert any(resolution) is MECHANICS[rung.mechanics].meshed
    named = plan.choose(asked, "condensed")
    (reason,) = (each.reason for each in named.overridden if each.field == "finger.resolution")
    result = SimpleNamespace(plan=named)
    assert key_numbers._unresolved(result) == [reason]
    assert "0.25 / 0.42 mm" in reason


def test_a_texture_that_slides_is_felt_without_a_mesh_where_one_is_accurate_enough():
    smooth = {"finger.ridges": None, "ask.rel_error": 0.9}
    found = ff.explain("slide-dots", changes=smooth)
    willing = [each for each in found.rungs if not each.refusals]
    cheapest = min(willing, key=lambda each: each.seconds).mechanics
    assert MECHANICS[cheapest].meshed
    assert found.mechanics == "layered"
    assert "vertices" in found.sentence
    scene = builtin.load("slide-dots", smooth)
    unfelt = replace(scene.ask, spikes=(), strain=False, population=None)
    found = ff.explain(replace(scene, ask=unfelt))
    assert MECHANICS[found.mechanics].meshed
    assert "vertices" not in found.sentence


@pytest.mark.parametrize("name", [each for each in builtin.names() if each.startswith("slide-")])
def test_scenes_of_textures_are_answered_with_ridges(name):
    plan = ff.explain(name)
    assert plan.mechanics == "layered"
    assert builtin.load(name).finger.raised_ridges is not None


def test_ridges_of_no_height_are_a_smooth_pad_and_higher_ones_err_more():
    def error(height):
        scene = builtin.load("slide-dots", {"finger.ridges": {"height": height}})
        return layered.error(Situation.of(scene)).error

    smooth = builtin.load("slide-dots", {"finger.ridges": None})
    assert error(0.0) == pytest.approx(layered.error(Situation.of(smooth)).error)
    assert error(0.0) < error(0.05) < error(0.1)
    scene = builtin.load("slide-dots", {"finger.ridges.height": 0.0})
    linear = next(each for each in plan.rungs(scene) if each.mechanics == "linear")
    assert not linear.refusals


def test_a_mechanics_that_finds_a_scene_beyond_its_limits_is_followed_by_the_next(monkeypatch):
    alone = {"ask.strain": False, "ask.pressure": False, "ask.fields": False, "ask.spikes": []}
    asked = builtin.load("press-to-1N", alone | {"ask.rel_error": 1.0})
    first = plan.choose(asked).mechanics

    def beyond(scene, progress=None):
        raise BeyondError("motion.force: it presses 7.98 mm deep")

    monkeypatch.setattr(get(first), "respond", beyond)
    answer = ff.run(asked)
    assert answer.plan.mechanics != first
    assert [refusal.mechanics for refusal in answer.plan.tried] == [first]
    (note,) = (each for each in answer.notes if each.startswith(f"{first} was chosen first"))
    assert "7.98 mm" in note
    for named in ({"mechanics": first}, {"changes": {"ask.mechanics": first}}):
        with pytest.raises(BeyondError):
            ff.run(asked, **named)


@pytest.mark.parametrize("afferents", ["recorded", "thesis"])
def test_of_spikes_no_error_is_known_before_they_are_compared_on_a_coarser_mesh(afferents):
    asked = scene(spikes=["SAI"], afferents=afferents, rel_error=0.99)
    assert plan.choose(asked, "solid").trust.endswith("Error not known: spikes.")


@pytest.mark.usefixtures("four")
def test_a_coarser_mesh_is_taken_where_it_will_do_and_another_mechanics_where_it_is_cheaper():
    assert plan.explain(scene(rel_error=0.12)).settings.resolution == "coarse"
    fine = plan.explain(scene(rel_error=0.02))
    assert (fine.mechanics, fine.settings.resolution) == ("solid", "coarse")


@pytest.mark.usefixtures("four")
def test_a_mesh_that_the_scene_states_is_the_only_one():
    stated = published.load("flat-press", {"ask.spikes": [], "finger.resolution": "fine"})
    found = plan.explain(stated)
    assert {rung.resolution for rung in found.rungs[2:]} == {"fine"}
    assert plan.settled(stated, found).finger == stated.finger
    chosen = plan.settled(scene(rel_error=0.12), plan.explain(scene(rel_error=0.12)))
    assert chosen.finger.resolution == "coarse"


@pytest.mark.usefixtures("four")
def test_spike_counts_keep_a_coarser_mesh_to_be_checked_on():
    found = plan.explain(scene(rel_error=0.4, spikes=["SAI"]))
    assert found.settings.resolution == "standard"
    assert "coarse" not in {rung.resolution for rung in found.rungs}


@pytest.mark.usefixtures("four")
def test_a_smaller_error_costs_more():
    found = plan.explain(scene(rel_error=0.01))
    assert found.mechanics == "solid"
    standard = next(
        rung for rung in found.rungs if (rung.mechanics, rung.resolution) == ("linear", "standard")
    )
    assert standard.refusals[0].reason == "expected relative error = 0.03 > 0.01 (ask.rel_error)"


@pytest.mark.usefixtures("four")
def test_when_nobody_answers_the_ladder_is_shown_with_what_to_relax():
    with pytest.raises(InputError) as caught:
        plan.explain(scene(rel_error=0.01, seconds=50))
    message = str(caught.value)
    assert "ability: strain: requested, but it gives none" in message
    assert "accuracy: contact radius / tissue thickness = 0.9 > 0.1" in message
    assert "accuracy: expected relative error = 0.03 > 0.01 (ask.rel_error)" in message
    assert "time: expected time = 60 s > 50 s (ask.seconds)" in message
    assert "Relax ask.rel_error to 0.03 and linear on the standard mesh answers." in message
    assert "Relax ask.seconds to 60 and solid on the coarse mesh answers." in message
    relaxed = plan.explain(scene(rel_error=0.031, seconds=50))
    assert relaxed.mechanics == "linear"
    assert plan.explain(scene(rel_error=0.01, seconds=60.5)).mechanics == "solid"


@pytest.mark.usefixtures("four")
def test_the_most_exact_mechanics_is_the_one_to_name_where_error_and_time_speak_against_all():
    with pytest.raises(InputError, match=r"name solid \(--mechanics solid\)"):
        plan.explain(scene(rel_error=0.0005, seconds=50))


@pytest.mark.usefixtures("four")
def test_what_to_relax_is_read_from_the_field_of_a_refusal_and_not_from_its_sentence(monkeypatch):
    reason = "expected relative error = 0.03 > 0.01 (ask.rel_error)"
    other = Refusal("linear", "accuracy", reason, "indenter.radius")
    barred = rung("linear", seconds=30.0, error=0.0001, refusals=(other,))
    monkeypatch.setitem(LADDER, "linear", barred)
    with pytest.raises(InputError) as caught:
        plan.explain(scene(rel_error=0.01, seconds=5))
    assert "Relax ask.rel_error" not in str(caught.value)
    assert "Relax ask.seconds to 60 and solid on the coarse mesh answers." in str(caught.value)


def test_when_spike_counts_cost_too_much_the_mesh_that_they_are_not_checked_on_is_offered():
    with refused("ask") as caught:
        plan.explain(scene(rel_error=0.4, seconds=3, spikes=["SAI"]))
    assert "Or set finger.resolution to 'coarse' and linear answers in " in str(caught.value)
    own = {"finger.resolution": "coarse", "ask.rel_error": 0.4, "ask.seconds": 3}
    assert plan.explain(published.load("flat-press", own)).mechanics == "linear"


BALL = {"kind": "sphere", "radius": 1, "at": [11, 5]}
PUSH = {"kind": "force-ramp", "loading_rate": 20, "force": 8}
IMPOSSIBLE = [
    ({"indenter": BALL}, "ability: indenter.at: expected a place (x, y) mm on the pad"),
    ({"motion.depth": 4.9}, "it goes to 0.49 of the finger's thickness, and presses like it were"),
    (
        {"motion.depth": 2.3, "indenter.angle": 0},
        "it goes to 0.23 of the finger's thickness, and presses like it were measured to",
    ),
    ({"motion": PUSH}, "of the finger's thickness, and presses like it were measured to 0.2"),
    ({"finger.skin.modulus": 1e6}, "modulus / subcutaneous modulus = 2.94e+04, not within 30"),
    (
        {"finger.skin.law": "demiray", "finger.skin.exponent": 40},
        "exponent of skin = 40 > 32.7: errors are not measured there",
    ),
    (
        {"finger.subcutaneous.law": "demiray", "finger.subcutaneous.exponent": 20},
        "exponent of subcutaneous = 20 > 11.3: errors are not measured there",
    ),
]


@pytest.mark.parametrize(("changes", "reason"), IMPOSSIBLE)
def test_what_cannot_be_run_or_was_measured_nowhere_near_is_not_chosen(changes, reason):
    with refused("ask") as caught:
        plan.explain(published.load("flat-press", changes))
    said = [line for line in str(caught.value).splitlines() if reason in line]
    assert len(said) >= 3, caught.value


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"finger.thickness": 1e3}, r"^finger.thickness: expected a finite number in mm at"),
        ({"finger.pad_radius": 4}, r"^finger.pad_radius: expected at least 7.7 mm on a finger"),
    ],
)
def test_a_finger_that_no_mesh_can_be_made_of_is_refused_in_one_sentence(changes, reason):
    with pytest.raises(InputError, match=reason) as caught:
        plan.explain(published.load("flat-press", changes))
    assert "No mesh can be made of this finger, and no mechanics without" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_force_that_no_tissue_bears_is_refused_with_its_likely_unit():
    push = {"motion": {"kind": "force-ramp", "loading_rate": 100, "force": 600}}
    for take in (plan.explain, plan.choose):
        with pytest.raises(
            InputError, match="would press to some 26 of it, as if it were in"
        ) as caught:
            take(published.load("flat-press", push))
        assert "mN or grams of force; convert it, or press less" in str(caught.value)
        assert "--mechanics" not in str(caught.value)
    assert plan.choose(published.load("flat-press", push), "solid").mechanics == "solid"


@pytest.mark.usefixtures("four")
def test_a_named_mechanics_runs_in_spite_of_its_accuracy_which_is_recorded():
    found = plan.choose(scene(), "hertz")
    assert (found.mechanics, found.overridden) == ("hertz", (THIN,))
    assert "It would have refused: contact radius / tissue thickness" in found.sentence
    assert plan.choose(scene(), "solid").overridden == ()
    rough = plan.choose(scene(rel_error=0.001), "linear")
    assert rough.settings.resolution == "standard"
    assert "expected relative error = 0.03 > 0.001" in rough.overridden[0].reason


@pytest.mark.usefixtures("four")
def test_a_scene_may_name_its_mechanics_and_a_call_overrides_it():
    own = scene(mechanics="hertz")
    assert plan.choose(own) == plan.choose(scene(), "hertz")
    assert plan.choose(own, "solid").mechanics == "solid"
    with refused("ask.mechanics"):
        plan.choose(scene(mechanics="liner"))
    with refused("ask.mechanics"):
        scene(mechanics=1)


@pytest.mark.usefixtures("four")
def test_a_named_mechanics_does_not_run_beyond_its_ability():
    with pytest.raises(InputError, match="'lumped' cannot answer this scene\n  lumped: ability"):
        plan.choose(scene(), "lumped")


@pytest.mark.usefixtures("four")
def test_an_unknown_mechanics_gets_the_nearest_name():
    with refused("mechanics"):
        plan.choose(scene(), "liner")


@pytest.mark.usefixtures("four")
def test_the_ladder_is_a_table_with_errors_times_refusals_and_sources():
    text = repr(plan.explain(scene()))
    lines = [line.split() for line in text.splitlines()]
    assert ["*", "linear", "standard", "3", "%", "30", "s", "chosen"] in lines
    assert ["solid", "coarse", "0.4", "%", "60", "s", "good", "enough"] in lines
    assert "linear coarse, linear standard, linear fine  reports/linear.json" in text


def test_a_depth_in_meters_is_asked_about() -> None:
    with pytest.raises(InputError, match="lengths are in mm, not in m"):
        plan.explain("flat-press", changes={"motion.depth": 1.5e-3})


def test_a_plan_is_read_in_a_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(costs, "threads", lambda: 4)
    chosen = plan.explain("flat-press")
    first, sentence, trust, ladder, _ = repr(chosen).split("\n\n")
    assert first.startswith(f"{chosen.on}: force within ")
    assert (sentence, trust) == (chosen.sentence, chosen.trust)
    row = ladder.splitlines()[-1]  # `solid`, whose wall time on four cores is much less than CPU
    assert f" {text.duration(chosen.rungs[-1].wall)} " in row


def test_a_scene_that_all_refuse_names_first_what_runs_it_all_the_same():
    with pytest.raises(InputError) as refused:
        plan.choose(builtin.load("flat-press", {"indenter.tilt": 40.0}))
    first, _, table = str(refused.value).partition("\n\n")
    assert "name pressed (--mechanics pressed)" in first
    assert "no press like it was measured" in first
    assert table.splitlines()[0].endswith("verdict")


@pytest.mark.parametrize("mechanics", ["lumped", "hertz", "layered"])
def test_one_that_is_named_leaves_out_what_it_cannot_give_unless_it_is_asked_for(mechanics):
    scene = builtin.load("flat-press", {"ask.spikes": []})
    settled = plan.settled(scene, plan.choose(scene, mechanics))
    assert not settled.ask.fields
    assert settled.ask.pressure == settled.ask.strain == (mechanics != "lumped")
    assert "ask.fields" in result_record.left_out(scene.ask, mechanics)[0]
    assert not result_record.left_out(settled.ask, mechanics)
    with pytest.raises(InputError, match=r"ask\.fields"):
        plan.choose(replace(scene, ask=replace(scene.ask, fields=True)), mechanics)
    assert MECHANICS[plan.choose(scene).mechanics].meshed  # where none is named, all is asked for


def test_refusals_that_differ_in_the_field_or_the_mesh_alone_are_written_once():
    written = result_record.ladder(plan.explain(published.load("flat-press")).rungs)
    assert written.count("this mechanics gives only force and depth") == 1
    assert "ability: ask.pressure, ask.strain, ask.fields, ask.spikes: requested, but" in written
    changed = {"finger.tissue": "calibrated_ah", "finger.skin.thickness": 1.2}
    other = builtin.load("flat-press", changed)  # no error of small strain is known of it
    assert "as on the standard mesh" in result_record.ladder(plan.explain(other).rungs)


@pytest.mark.parametrize(
    ("value", "limit", "said"),
    [
        (0.5, 0.4, "0.5 s > 0.4 s"),
        (0.404, 0.4, "0.404 s > 0.4 s"),
        (0.40001, 0.4, "0.40001 s > 0.4 s"),
        (61.2, 50, "61 s > 50 s"),
        (1234, 1233, "1234 s > 1233 s"),
    ],
)
def test_what_is_above_a_limit_is_shown_above_it(value, limit, said):
    assert text.format_excess(value, limit, " s") == said


@pytest.mark.parametrize(
    ("error", "said"), [(1.24, "120 %"), (0.0124, "1.2 %"), (7.6e-6, "0.00076 %"), (11, "no limit")]
)
def test_an_error_is_written_in_percent(error, said):
    assert text.percent(error) == said


def test_the_settings_are_what_was_asked():
    found = plan.choose(scene(rel_error=0.4, spikes=["SAI", "FAI"], pressure=False))
    assert found.settings == Settings(
        resolution="standard",
        half=True,
        times=found.settings.times,
        computed=("force", "strain", "fields"),
        afferents=("SAI", "FAI"),
    )
    tilted = {"kind": "flat", "angle": 30, "tilt": 5}
    whole = published.load("flat-press", {"indenter": tilted, "ask.rel_error": 1.0})
    assert plan.choose(whole).settings.half is False
    slow, fast = (plan.choose(scene(rel_error=0.4, spikes=[kind])) for kind in ("SAI", "FAII"))
    assert fast.settings.times > slow.settings.times


def test_a_long_motion_that_the_mechanics_can_take_is_planned():
    motion = ff.Sinusoid(amplitude=0.3, frequency=200, cycles=10_000)
    ask = ff.Ask(pressure=False, strain=False, fields=False)
    asked = ff.Scene(finger=ff.Finger.subject("a.h.", tissue="maeno1998"), motion=motion, ask=ask)
    found = plan.choose(asked, "lumped")
    assert found.settings.times == 400_001


def test_no_mesh_is_asked_after_where_a_force_law_will_do():
    found = plan.choose(asked())
    assert found.mechanics == "lumped"
    assert [rung.mechanics for rung in found.rungs] == ["lumped", "hertz", "layered"]
    assert (
        "Not considered, because slower and not needed: condensed, pressed, modal, linear, solid."
        in found.sentence
    )
    shortest = asked(resolution="coarse")
    for name in meshed():
        assert get(name).cost(Situation.of(shortest)) > mechanics.QUICKEST


def loaded(code):
    """Return the modules of fefinger that are loaded after `code` in a new process."""
    told = f"{code}\nimport json, sys\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


RUN = """import fefinger as ff
scene = ff.Scene(
    finger=ff.Finger.subject("a.h."),
    motion=ff.RampHold(60, 1.5, hold=0.1),
    ask=ff.Ask(pressure=False, strain=False, fields=False, rel_error=0.4),
)
result = ff.run(scene)
"""


def test_a_scene_of_the_force_alone_loads_no_mesh_no_elements_and_no_nerve():
    modules = loaded(f"{RUN}assert result.plan.mechanics == 'lumped'")
    parts = tuple(f"fefinger.{part}" for part in ("mesh", "fem", "neural.", "view", "report"))
    ours = {name for name in modules if name.startswith(parts) and name != "fefinger.reports"}
    assert not ours
    strangers = {"scipy", "numba", "skfem", "trimesh", "pyvista", "meshio", "h5py", "matplotlib"}
    assert not strangers & modules


def test_a_scene_without_spikes_loads_no_membrane():
    asks = RUN.replace("strain=False", "strain=True")
    assert "strain=True" in asks
    modules = loaded(asks.replace("ff.run(scene)", "ff.run(scene, mechanics='hertz')"))
    assert "fefinger.theory.contact.ting" in modules
    assert not [name for name in modules if name.startswith("fefinger.neural.membranes")]


@pytest.mark.parametrize("name", ["hertz", "linear"])
def test_strain_is_computed_only_where_it_is_asked(name, monkeypatch):
    from fefinger.mechanics.press import axisymmetric, problem, reference

    def forbidden(*args, **kwargs):
        pytest.fail("sites were placed without being asked for")

    for module in (axisymmetric, problem):
        monkeypatch.setattr(module, "end_organ_sites", forbidden)
    monkeypatch.setattr(reference, "reference_press", forbidden)
    result = ff.run(asked(pressure=True, depth=0.2, resolution="coarse"), mechanics=name)
    assert result.pressure is not None
    assert (result.strain, result.sites, result.response.reference) == (None, None, None)
    assert (result.fields, result.spikes) == (None, None)
    assert result.plan.settings.computed == ("force", "pressure")


@pytest.mark.usefixtures("operators")
@pytest.mark.parametrize("name", ["hertz", "layered", "condensed", "linear"])
def test_the_press_that_scales_spikes_is_made_for_spikes_alone(name):
    scene = asked(strain=True, depth=0.2, resolution="coarse")
    fired = replace(scene, ask=replace(scene.ask, spikes=("SAI",)))
    assert get(name).respond(scene).reference is None
    assert get(name).respond(fired).reference is not None


def test_a_machine_that_is_slower_is_expected_to_take_longer(monkeypatch):
    ask = asked(resolution="coarse", pressure=True, strain=True)
    before = {name: get(name).cost(Situation.of(ask)) for name in mechanics.names()}
    monkeypatch.setattr(machine, "kept", lambda: 3 * machine.REPORTED)
    after = {name: get(name).cost(Situation.of(ask)) for name in mechanics.names()}
    assert after == pytest.approx({name: 3 * cost for name, cost in before.items()})
    assert "this machine, 0.33 times as fast as that of the reports" in machine.sentence()


def test_what_is_built_once_is_in_the_expected_time_and_said(monkeypatch):
    from fefinger.mesh import store

    scene = asked(rel_error=0.1, pressure=True, depth=1.5, resolution="coarse")
    kept = plan.choose(scene, "solid")
    assert "built once" not in kept.sentence
    monkeypatch.setattr(store, "available", lambda *a: False)
    made = plan.choose(scene, "solid")
    build = costs.seconds("mesh", "morph", "coarse")
    assert made.chosen.seconds - kept.chosen.seconds == pytest.approx(build)
    assert "What is built once and kept takes " in made.sentence


def test_under_a_steep_plate_condensed_is_expected_to_solve_the_whole_mesh():
    steep = asked(rel_error=0.4, pressure=True, resolution="coarse")
    steep = replace(steep, indenter=ff.Flat(60))
    assert get("condensed").cost(Situation.of(steep)) > get("linear").cost(Situation.of(steep))
