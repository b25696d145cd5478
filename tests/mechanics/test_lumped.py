"""The lumped finger as an answer to a scene: force and depth, quickly, and what it refuses."""

import subprocess
import sys
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.calibration import subjects
from fefinger.validation.evidence import lumped as evidence_lumped

import fefinger as ff
from fefinger import mechanics
from fefinger.commands.run import run_record, run_summary
from fefinger.mechanics import lumped
from fefinger.mechanics.evidence.presses import read
from fefinger.mechanics.situation import Situation
from fefinger.pages import report
from fefinger.result import load
from fefinger.scene import builtin, library
from fefinger.theory.lumped import spring as law


FORCE_ONLY = ff.Ask(pressure=False, strain=False, fields=False)
PROTOCOLS = tuple(name for name in builtin.names() if name[:3] in ("p1-", "p2-", "p3-", "p4-"))
ROW = library.lumped()["a.h."]
AH = (law.Spring(ROW.b, ROW.m), ROW.prony)


def calibrated(subject="a.h.", **changes):
    return ff.Finger.subject(subject, tissue=library.calibrated_name(subject), **changes)


def scene(**parts):
    whole = {
        "finger": calibrated(),
        "indenter": ff.Flat(angle=30),
        "motion": ff.RampHold(speed=60, depth=1.5, hold=5),
        "ask": FORCE_ONLY,
    }
    return ff.Scene(**(whole | parts))


MOTIONS = [
    ff.RampHold(speed=60, depth=1.5, hold=5),
    ff.Ramp(speed=0.2, depth=1.5),
    ff.RampSinusoid(20, 1.5, amplitude=0.4, frequency=4, cycles=5),
    ff.Trapezoid(speed=20, depth=1.5, hold=1),
    ff.Sampled(time=(0.0, 0.1, 0.2, 1.0), depth=(-0.5, 1.0, -0.2, 1.2)),
]


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.kind)
def test_the_force_is_that_of_much_finer_times(motion):
    answer = lumped.respond(scene(motion=motion))
    fine = np.unique(np.append(np.linspace(0, motion.duration, 50_001), answer.time))
    exact = law.contact_force(*AH, fine, motion.value(fine))
    off = np.abs(answer.force - np.interp(answer.time, fine, exact)).max()
    assert off < lumped.NUMERICAL * exact.max()
    assert answer.force.min() >= 0
    np.testing.assert_allclose(answer.depth, motion.value(answer.time), rtol=1e-12)


def test_under_force_control_the_depth_gives_the_force_back():
    motion = ff.RampHold(loading_rate=20, force=1, hold=3)
    answer = lumped.respond(scene(motion=motion))
    np.testing.assert_allclose(answer.force, motion.value(answer.time), rtol=1e-12)
    back = law.force(*AH, answer.time, answer.depth)
    assert np.abs(back - answer.force).max() < 5e-3
    assert answer.depth[-1] > 1.15 * answer.depth[answer.time <= 0.06][-1]


@pytest.mark.parametrize(
    ("finger", "whose"),
    [
        (calibrated(), "Table 2.1, a.h."),
        (ff.Finger.subject("a.h.", tissue="maeno1998"), "lumped-force.json"),
    ],
)
def test_it_gives_force_and_depth_and_says_whose(finger, whose):
    answer = lumped.respond(scene(finger=finger))
    for absent in ("contact_area", "centroid", "pad", "pressure", "sites", "strain", "fields"):
        assert getattr(answer, absent) is None
    assert whose in answer.sources["lumped"]
    assert any(whose in note for note in answer.notes)
    printed = "Table 2.1" in whose
    assert any("tissue and G of the scene are not used" in note for note in answer.notes) == printed
    assert list(answer.seconds) == ["lumped"]


@pytest.mark.parametrize("what", ["pressure", "strain", "fields"])
def test_anything_beyond_force_is_beyond_it(what):
    asked = scene(ask=replace(FORCE_ONLY, **{what: True}))
    (refusal,) = lumped.refuse(Situation.of(asked))
    assert refusal.about == "ability"
    assert refusal.reason == f"ask.{what}: requested, but this mechanics gives only force and depth"
    assert ff.explain(asked).mechanics == "pressed"


def test_spikes_are_beyond_it():
    asked = scene(ask=replace(FORCE_ONLY, spikes=("SAI",)))
    assert [refusal.about for refusal in lumped.refuse(Situation.of(asked))] == ["ability"]


OTHER = "finger: of other size or tissue than those whose law was identified; that of Table 2.1, "

REASONS = [
    ({"indenter": ff.Sphere(radius=0.3)}, "indenter = sphere: it was measured with a flat plate"),
    ({"indenter": ff.Flat(angle=30, tilt=40)}, "indenter.angle, tilt = 30, 40 degrees: it was"),
    ({"finger": ff.Finger(14, 10, pad_radius=13, tissue="maeno1998")}, f"{OTHER}means, is taken"),
    (
        {"finger": ff.Finger.subject("f.c.", width=14, thickness=10, tissue="maeno1998")},
        f"{OTHER}means, is taken",
    ),
    ({"finger": calibrated(width=15)}, f"{OTHER}a.h., is taken"),
    ({"finger": calibrated(prony=ff.Prony((0.4, 0.6), (10.0,)))}, f"{OTHER}a.h."),
    (
        {"finger": ff.Finger.subject("a.h.", surface=__file__, tissue="maeno1998")},
        "finger: from a surface",
    ),
    (
        {"finger": ff.Finger.subject("d.s.", tissue="maeno1998"), "indenter": ff.Flat(20)},
        "its law is known under plates at 30 degrees; that of Table 2.1, d.s., is taken",
    ),
    ({"motion": ff.Ramp(60, 2.4)}, "relaxed force at 2.4 mm = 3.3 > 3 N"),
    ({"motion": ff.RampHold(loading_rate=5, force=4, hold=1)}, "force = 4 > 3 N, the largest"),
]


@pytest.mark.parametrize(("parts", "reason"), REASONS)
def test_what_was_not_measured_is_refused_for_accuracy_but_answered_when_named(parts, reason):
    asked = scene(**parts)
    (refusal,) = lumped.refuse(Situation.of(asked))
    assert refusal.about == "accuracy"
    assert refusal.reason.startswith(reason)
    with suppress(ff.InputError):  # so deep that no press was like it
        assert ff.explain(asked).mechanics in ("pressed", "solid")
    named = ff.run(asked, mechanics="lumped")
    assert named.plan.overridden[0] == refusal
    assert named.force.max() > 0


@pytest.mark.parametrize(
    ("name", "indenter"),
    [("flat-45", ff.Flat(45)), ("flat-15", ff.Flat(15)), ("sphere-5", ff.Sphere(5))],
)
def test_under_another_object_the_law_of_a_finger_errs_as_in_a_press_of_it(name, indenter):
    """The force of a plate changes with its angle, which the law does not see."""
    row = read("press-mesh.json")["rows"][f"a.h./{name}"]
    depth, true = row["depth_mm"][5], row["force_N"][5]
    asked = scene(indenter=indenter, motion=ff.Ramp(0.001, depth, corner=0))  # relaxed
    printed = library.lumped()["a.h."]
    known = abs(printed.prony.long_time * law.Spring(printed.b, printed.m).force(depth) / true - 1)
    error, evidence = lumped.error(Situation.of(asked))
    factor = read("evidence.json")["factors"]["lumped"]["force"]  # what was found, times a margin
    assert known < error < 1.1 * factor * known + 0.05
    assert f"evidence.json, a.h./{name} and 4 more" in evidence
    assert ff.explain(asked).mechanics != "lumped"
    assert ff.run(asked, mechanics="lumped").force.max() > 0


@pytest.mark.parametrize("object_", ["flat-45", "sphere-5"])
def test_the_error_of_the_law_in_a_press_is_that_of_its_relaxed_force(object_):
    row = read("press-mesh.json")["rows"][f"a.h./{object_}"]
    printed = library.lumped()["a.h."]
    depth, true = np.array(row["depth_mm"]), np.array(row["force_N"])
    relaxed = printed.prony.long_time * printed.b / printed.m * np.expm1(printed.m * depth)
    mesh = np.array(row["errors"]["solid standard"]["force"])
    least = np.abs(relaxed - true) / true
    assert (np.array(row["errors"]["lumped"]["force"]) - mesh >= least * (1 - 4e-3)).all()


SUBJECTS = [name for name in library.lumped() if name != "means"]


@pytest.mark.parametrize("subject", SUBJECTS)
def test_a_calibrated_finger_has_the_law_of_its_subject_and_the_error_of_its_calibration(subject):
    asked = scene(
        finger=calibrated(subject),
        motion=ff.RampHold(60, 1.0, hold=5, corner=0),
        ask=replace(FORCE_ONLY, rel_error=0.9),
    )
    assert lumped.refuse(Situation.of(asked)) == ()
    plan = ff.choose(asked, "lumped")  # not the cheapest for p.w., whose law is 41 % off
    assert "18 % at the peaks of sinusoids against the measured" in plan.chosen.evidence
    row = library.lumped()[subject]
    peak = law.constant_velocity(law.Spring(row.b, row.m), row.prony, 1.0, 60.0)
    assert lumped.respond(asked).force.max() == pytest.approx(float(peak), rel=1e-9)
    found = subjects.calibrated(subject)
    apart = row.prony.long_time * law.Spring(row.b, row.m).force(1.0) / found.curve.force(1.0) - 1
    assert plan.chosen.error > 0.97 * abs(apart)


@pytest.mark.parametrize("subject", SUBJECTS)
def test_a_finger_of_published_tissue_has_the_law_of_its_own_press(subject):
    """Its relaxed force equals `solid`, within twice what the spring of Eq. 2.1 leaves."""
    finger = ff.Finger.subject(subject, tissue="maeno1998")
    row = read("solid-force.json")["rows"][f"{subject}/flat-30"]
    depth, force = (np.array(x) for x in (row["depth_mm"], row["force_N"]["solid"]))
    deepest = depth <= 0.18 * finger.thickness
    for x, known in zip(depth[deepest], force[deepest], strict=True):
        asked = scene(finger=finger, motion=ff.RampHold(60, float(x), hold=1e4))
        found = lumped.respond(asked).force[-1]
        assert found == pytest.approx(known, abs=0.05 * force[deepest][-1])
        assert lumped.error(Situation.of(asked))[0] > abs(found / known - 1)


def test_the_laws_are_those_of_the_presses_that_the_reports_hold():
    kept = read("lumped-force.json")
    for row, fresh in zip(kept["rows"], evidence_lumped.rows(), strict=True):
        for key, value in fresh.items():
            close = value if isinstance(value, str) else pytest.approx(value, rel=1e-3)
            assert row[key] == close, key


def test_the_law_of_a_finger_goes_with_its_moduli_and_its_relaxation():
    soft, G = ff.Finger.subject("a.h.", tissue="maeno1998"), ff.Prony((0.4, 0.6), (10.0,))
    double = {
        name: replace(getattr(soft, name), modulus=2 * getattr(soft, name).modulus)
        for name in ("skin", "subcutaneous")
    }
    motion = ff.RampHold(60, 1.0, hold=1e3)
    one, two, three = (
        lumped.respond(scene(finger=finger, motion=motion)).force
        for finger in (soft, replace(soft, **double), replace(soft, prony=G))
    )
    np.testing.assert_allclose(two, 2 * one, rtol=1e-12)
    assert three[-1] == pytest.approx(one[-1], rel=1e-6)
    assert three.max() / three[-1] < 1 / 0.4


@pytest.mark.parametrize(("angle", "neighbors"), [(20, (15, 30)), (4, (0, 15))])
def test_the_law_between_two_plates_lies_between_theirs(angle, neighbors):
    finger = ff.Finger.subject("a.h.", tissue="maeno1998")
    below, own, above = (
        lumped.respond(scene(finger=finger, indenter=ff.Flat(each), motion=ff.Ramp(60, 0.9)))
        for each in (neighbors[0], angle, neighbors[1])
    )
    assert below.force.max() < own.force.max() < above.force.max()
    assert "flat-0" in own.sources["lumped"]


def test_the_planner_asks_it_first():
    assert mechanics.names()[0] == "lumped"
    assert mechanics.get("lumped") is lumped


@pytest.mark.parametrize("name", mechanics.names())
def test_every_mechanics_offers_what_the_protocol_names(name):
    wanted = {
        member: given
        for member, given in vars(mechanics.Mechanics).items()
        if not member.startswith("_")
    }
    assert {"refuse", "cost", "error", "coarser", "respond"} <= set(wanted)
    for member, given in wanted.items():
        assert callable(getattr(mechanics.get(name), member)) == callable(given), member


@pytest.mark.parametrize("name", PROTOCOLS)
def test_the_protocols_of_the_thesis_are_answered_without_a_mesh(name):
    result = ff.run(name)
    assert result.plan.mechanics == "lumped"
    assert 0.5 < result.force.max() < 3.0


def test_the_repetitive_task_has_the_forces_of_the_recomputed_thesis():
    result = ff.run("p4-repetitive-task")
    cycle = result.time[-1] - np.linspace(0, 1, 1001)[:-1] / 16
    force = np.interp(cycle, result.time, result.force)
    assert np.ptp(force) == pytest.approx(0.820, rel=5e-3)
    assert force.mean() == pytest.approx(0.492, rel=5e-3)


def test_a_result_of_force_alone_can_be_saved_reported_and_loaded(tmp_path):
    result = ff.run(scene(ask=replace(FORCE_ONLY, rel_error=0.4)))
    written = result.save(str(tmp_path))
    assert [file.rsplit("/", 1)[1] for file in written] == ["result.nc", "report.html"]
    again = ff.load(str(tmp_path))
    np.testing.assert_array_equal(again.force, result.force)  # exact: a file keeps every bit
    assert again.plan == result.plan  # exact: a file keeps every bit
    assert load(tmp_path).contact_area is None
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "18 % at the peaks of sinusoids against the measured" in html
    assert "None" not in html
    assert "force peaks at 1.25 N" in report.answer(result)
    record = run_record(result, {}, [])
    assert (record["contact_area_mm2"], record["centroid_mm"]) == (None, None)
    assert "contact area" not in run_summary(result, {}, [])


def test_a_run_of_force_alone_loads_no_mesh_no_elements_and_no_membranes():
    """What `ask` may hold is checked against the names in neural; its simulation is not loaded."""
    code = (
        "import sys, fefinger as ff\n"
        "assert ff.run('p2-ramp-and-hold').plan.mechanics == 'lumped'\n"
        "print(*(name for name in sys.modules))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    heavy = ("scipy", "skfem", "numba", "trimesh", "pytetwild", "meshio", "matplotlib", "xarray")
    parts = ("afferents", "membranes", "_hodgkin_huxley", "gains")
    ours = [f"fefinger.neural.{part}" for part in parts]
    assert "fefinger.mechanics.lumped" in loaded
    assert not loaded & {*heavy, *ours, "fefinger.mechanics.press.small_strain"}
    assert not [name for name in loaded if name.startswith(("fefinger.mesh", "fefinger.fem"))]
