"""Studies: the grid, what is measured of each scene, resuming, failures, processes and cluster."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import process_calls
import pytest
from refusals import refused

import fefinger as ff
from fefinger.__main__ import main
from fefinger.commands import study as command
from fefinger.mechanics.hertz import tissue
from fefinger.neural.trains import Rerun
from fefinger.pipeline import run
from fefinger.scene.schema import column
from fefinger.studies import tasks
from fefinger.studies.grid import meaning, parse_at, parse_over, product
from fefinger.studies.measures import rows
from fefinger.studies.tables import StudyRows
from fefinger.support.checks import InputError
from fefinger.support.processes import cores
from fefinger.support.text import percent
from fefinger.theory.contact.elliptic import Elliptic
from fefinger.theory.relaxation import Prony


QUICK = {"ask.spikes": [], "motion.hold": 0.05, "motion.speed": 10}
LEAN = {"ask.spikes": [], "ask.pressure": False, "ask.strain": False}
ELASTIC = ff.Finger.subject(
    "a.h.", prony=Prony((1.0,), ()), resolution="coarse", tissue="maeno1998"
)
BARE = ff.Ask(strain=False, fields=False)


def settings(changes):
    """Return changes as words of a command."""
    return [w for name, value in changes.items() for w in ("--set", f"{name}={json.dumps(value)}")]


def same(first, second):
    """Return whether two lists of rows are the same but for the time they took."""
    return near([{**row, "seconds": 0} for row in first], [{**row, "seconds": 0} for row in second])


def near(value, other):
    """Compare nested values, numbers to a tolerance."""
    if isinstance(value, dict):
        return value.keys() == other.keys() and all(
            near(value[name], other[name]) for name in value
        )
    if isinstance(value, list | tuple):
        return len(value) == len(other) and all(map(near, value, other))
    return value == (pytest.approx(other, rel=1e-9) if isinstance(other, float) else other)


# The grid


def test_ranges_and_lists_make_a_grid_whose_last_field_changes_fastest():
    over = parse_over(["indenter.angle=0:0.3:4", "finger.subject=a.h., d.p.", "indenter.at=[0,1]"])
    assert over["indenter.angle"] == (0.0, 0.1, 0.2, 0.3)
    assert over["finger.subject"] == ("a.h.", "d.p.")
    assert over["indenter.at"] == ([0, 1],)
    assert parse_over(["motion.depth=.5,1."])["motion.depth"] == (0.5, 1.0)
    points = product({"a": (1, 2), "b": ("x", "y")})
    assert points == [{"a": a, "b": b} for a in (1, 2) for b in ("x", "y")]


@pytest.mark.parametrize(
    ("texts", "words"),
    [
        (["indenter.angle"], "expected FIELD=START:STOP:COUNT or FIELD=A,B,C"),
        (["=1,2"], "expected FIELD="),
        (["indenter.angle="], "expected FIELD="),
        (["indenter.angle=0:60"], "COUNT is a whole number from 2 to"),
        (["indenter.angle=0:60:1"], "COUNT is a whole number"),
        (["indenter.angle=0:60:2.5"], "COUNT is a whole number"),
        (["indenter.angle=0:x:3"], "COUNT is a whole number"),
        (["indenter.angle=0:inf:3"], "STOP: expected a finite number"),
        (["indenter.angle=1,,2"], "a value is missing"),
        (["indenter.angle=30,30.0"], "received 30.0 twice"),
        (["motion.depth=1,nan"], "expected a finite number, received nan"),
        (["motion.speed=1,2", "motion.speed=3,4"], "every field once, received motion.speed"),
    ],
)
def test_an_over_that_cannot_be_used_gets_a_sentence(texts, words):
    with pytest.raises(InputError) as error:
        parse_over(texts)
    assert words in str(error.value)


def test_values_on_further_lines_of_an_over_are_not_dropped():
    text = "0.3]\nx=[0.4"
    assert parse_over([f"motion.depth={text}"])["motion.depth"] == (text,)


def test_forces_and_depths_and_the_units_of_columns():
    assert parse_at(["1N", "0.5 mm", "2 N"]) == ((1.0, 2.0), (0.5,))
    for text in ("1", "N", "1 kPa", "-1N"):
        with pytest.raises(InputError, match="--at"):
            parse_at([text])
    assert column("indenter.angle") == "indenter.angle_deg"
    assert column("motion.speed") == "motion.speed_mm_per_s"
    assert column("motion.amplitude", "force-sinusoid") == "motion.amplitude_N"
    assert column("motion.amplitude", "sinusoid") == "motion.amplitude_mm"
    assert column("indenter.corner") == "indenter.corner_mm"
    assert column("motion.corner") == "motion.corner_s"
    assert column("finger.subject") == "finger.subject"


# What is measured


@pytest.fixture(scope="module")
def pressed():
    """Return a slow elastic ramp of a plate on the coarse finger."""
    scene = ff.Scene(finger=ELASTIC, motion=ff.Ramp(10, 1.2), ask=BARE)
    return run(scene, mechanics="linear")


def test_every_column_has_a_meaning_and_the_console_is_narrow(pressed):
    told = [{"indenter.angle_deg": 30.0, **row} for row in rows(pressed, depths=(1.0, 5.0))]
    for name in {name for row in told for name in row} - {"indenter.angle_deg"}:
        assert meaning(name)
    assert meaning("hertz_ellipticity").startswith("by elliptic Hertz contact on a half-space: 1 ")
    assert meaning("spikes_SAI").startswith("spikes of the units of SAI, at the end organs")
    study = StudyRows("press", ("indenter.angle_deg",), tuple(told), (), 1, 0, {"grid": {}})
    lines = command.study_summary(command.study_record(study, [])).splitlines()
    assert lines[0].split()[:4] == ["angle/deg", "at", "force/N", "error"]
    assert max(map(len, lines[:3])) <= 100
    stated = study.rows[0]["force_rel_error"]
    assert f" {percent(stated)} " in lines[1]


# Pressure over 1 mm² is summed on a pad: that of `hertz` is as large as its deepest contact.
@pytest.mark.parametrize(("mechanics", "tolerance"), [("hertz", 4e-3), ("linear", 1e-2)])
def test_a_force_on_the_way_is_what_a_run_under_force_control_gives(pressed, mechanics, tolerance):
    moved = run(pressed.scene, mechanics="hertz") if mechanics == "hertz" else pressed
    passed = rows(moved, forces=(0.2,))[2]
    scene = ff.Scene(finger=ELASTIC, motion=ff.Ramp(loading_rate=1.0, force=0.2), ask=BARE)
    held = rows(run(scene, mechanics=mechanics))[0]
    assert passed["force_N"] == pytest.approx(0.2)
    assert held["force_N"] == pytest.approx(0.2)
    assert passed["depth_mm"] == pytest.approx(held["depth_mm"], rel=1e-3)
    pressure = "highest_pressure_1mm2_kPa"
    assert passed[pressure] == pytest.approx(held[pressure], rel=tolerance)
    if mechanics == "hertz":
        assert passed["contact_area_mm2"] == pytest.approx(held["contact_area_mm2"], rel=1e-3)
    else:
        assert passed["asymmetry"] == pytest.approx(held["asymmetry"], abs=2e-3)
        assert passed["ellipticity"] == pytest.approx(held["ellipticity"], abs=5e-3)


def test_the_columns_of_a_press(pressed):
    peak, end, _, far = rows(pressed, depths=(1.0, 5.0))
    assert peak["at"] == "peak"
    assert end["time_s"] == pressed.time[-1]
    assert end["force_N"] == pressed.force[-1]  # exact: a row has the numbers of the result
    # exact: a row has the numbers of the result
    assert end["contact_area_mm2"] == pressed.contact_area[-1]
    assert far["status"] == "not reached: depth = 1.2 mm at most"
    assert "force_N" not in far
    assert end["shift_side_mm"] == pytest.approx(0, abs=1e-9)
    assert end["long_axis_deg"] == pytest.approx(0, abs=1e-6)
    step = np.diff(pressed.force)[-1] / np.diff(pressed.depth)[-1]
    assert end["stiffness_N_per_mm"] == pytest.approx(step, rel=0.03)
    load = pressed.pressure[-1] * pressed.pad.areas
    distal = pressed.pad.points @ [np.cos(np.radians(30)), 0, np.sin(np.radians(30))]
    assert end["shift_distal_mm"] == pytest.approx(load @ distal / load.sum(), abs=0.02)


def test_hertz_beside_it_is_that_of_the_radii_of_the_shape(pressed):
    row = rows(pressed, depths=(1.0,))[2]
    assert row["hertz_radius_distal_mm"] == pytest.approx(20.0, rel=0.01)
    assert row["hertz_radius_side_mm"] == pytest.approx(9.8, rel=0.01)
    want = Elliptic(20.0, 9.8, 1.0, *tissue(ELASTIC))
    assert row["hertz_force_N"] == pytest.approx(want.force * 1e-3, rel=0.01)
    assert row["hertz_contact_area_mm2"] == pytest.approx(want.area, rel=0.01)
    assert row["hertz_peak_pressure_kPa"] == pytest.approx(want.peak_pressure, rel=0.01)
    assert row["hertz_ellipticity"] == pytest.approx(1 - want.axis_ratio, abs=5e-3)


def test_a_relaxing_half_space_is_told_with_its_relaxed_modulus():
    scene = ff.Scene(
        finger=ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998"),
        motion=ff.RampHold(10, 0.5, hold=600),
        ask=BARE,
    )
    row = rows(run(scene, mechanics="linear"))[1]
    want = Elliptic(20.0, 9.8, 0.5, *tissue(scene.finger)).force * 1e-3
    assert row["hertz_force_N"] == pytest.approx(want, rel=0.015)
    assert np.isnan(row["stiffness_N_per_mm"])


def test_opposite_tilts_are_mirror_images():
    told = []
    for tilt in (10, -10):
        scene = ff.Scene(
            finger=ELASTIC, indenter=ff.Flat(30, tilt), motion=ff.Ramp(60, 0.6), ask=BARE
        )
        told.append(rows(run(scene, mechanics="linear"))[0])
    left, right = told
    assert abs(left["shift_side_mm"]) > 0.05
    for name in ("shift_side_mm", "long_axis_deg"):
        assert left[name] == pytest.approx(-right[name], abs=1e-3), name
    for name in ("asymmetry", "ellipticity", "shift_distal_mm", "reach_distal_mm"):
        assert left[name] == pytest.approx(right[name], abs=1e-4), name
    assert left["hertz_force_N"] == pytest.approx(right["hertz_force_N"], rel=1e-3)


def test_a_ball_of_hertz_has_a_round_contact_in_its_middle():
    scene = ff.Scene(
        finger=ELASTIC, indenter=ff.Flat(40), motion=ff.Ramp(60, 0.6), ask=ff.Ask(fields=False)
    )
    row = rows(run(scene, mechanics="hertz"))[0]
    assert row["asymmetry"] == pytest.approx(0, abs=0.01)
    assert row["shift_distal_mm"] == pytest.approx(0, abs=0.02)
    assert row["ellipticity"] == pytest.approx(0, abs=0.01)


def test_the_end_has_the_least_and_largest_counts_of_other_runs(synthetic):
    counts = synthetic.spikes.count()
    others = [Rerun("another trial", counts + 2), Rerun("another step", np.maximum(counts - 1, 0))]
    trains = synthetic.spikes.beside(*others)
    told = {row["at"]: row for row in rows(replace(synthetic, spikes=trains), depths=(1.0,))}
    for kind, count in zip(trains.types, counts.tolist(), strict=True):
        assert told["end"][f"least_spikes_{kind}"] == max(count - 1, 0)
        assert told["end"][f"largest_spikes_{kind}"] == count + 2
        assert f"least_spikes_{kind}" not in told["1 mm"]


def test_spikes_are_counted_up_to_the_time_of_the_row(synthetic):
    told = {row["at"]: row for row in rows(synthetic, depths=(1.0,))}
    counts = dict(zip(synthetic.spikes.types, synthetic.spikes.count().tolist(), strict=True))
    assert told["end"]["spikes"] == sum(counts.values())
    for kind, count in counts.items():
        assert told["end"][f"spikes_{kind}"] == count
    early = [times <= told["1 mm"]["time_s"] for times in synthetic.spikes.times]
    assert told["1 mm"]["spikes"] == sum(int(each.sum()) for each in early)
    nerve = replace(
        synthetic.spikes,
        times=tuple(times + 5.0 for times in synthetic.spikes.times),
        delays=np.full(len(synthetic.spikes), 5.0),
    )
    delayed = {row["at"]: row for row in rows(replace(synthetic, spikes=nerve), depths=(1.0,))}
    for when, row in told.items():
        assert delayed[when]["spikes"] == row["spikes"]


# Running


@pytest.mark.usefixtures("words_alone")
def test_rows_come_in_the_order_of_the_grid_with_units_and_files(tmp_path, capsys):
    command = ["study", "flat-press", "--over", "motion.depth=0.4,0.2", "--mechanics", "lumped"]
    command += ["--over", "indenter.angle=20:40:2", "--at", "0.1mm", "-o", str(tmp_path)]
    command += settings(LEAN | {"motion.speed": 10})
    assert main([*command, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["scenes"], record["reused"], record["failed"]) == (4, 0, [])
    assert record["over"] == ["motion.depth_mm", "indenter.angle_deg"]
    order = [(row["motion.depth_mm"], row["indenter.angle_deg"]) for row in record["rows"][::3]]
    assert order == [(0.4, 20), (0.4, 40), (0.2, 20), (0.2, 40)]
    assert [row["at"] for row in record["rows"][:3]] == ["peak", "end", "0.1 mm"]
    header = (tmp_path / "table.csv").read_text().splitlines()[0]
    assert header.startswith("motion.depth_mm,indenter.angle_deg,at,status,time_s,depth_mm,force_N")
    page = (tmp_path / "report.html").read_text()
    assert "4 of 4 scenes were answered" in page
    assert main(command) == 0
    assert "4 of 4 scenes by lumped, 4 of them reused" in capsys.readouterr().out


THICK_OR_DEEP = {"finger.thickness": (10, 20), "motion.depth": (0.3, 6)}
"""A grid of which one scene cannot be used, because it goes deeper than half the finger."""


def test_a_scene_that_fails_costs_itself_alone(capsys):
    command = ["study", "flat-press", "--mechanics", "lumped", "--json"]
    for field, values in THICK_OR_DEEP.items():
        command += ["--over", f"{field}={','.join(map(str, values))}"]
    assert main([*command, *settings(LEAN)]) == 1
    record = json.loads(capsys.readouterr().out)
    (failed,) = record["failed"]
    bad = {"finger.thickness": 10, "motion.depth": 6}
    assert failed["scene"] == bad
    assert "expected less than 5 mm" in failed["error"]
    peaks = [row for row in record["rows"] if row["at"] == "peak"]
    assert [row["motion.depth_mm"] for row in peaks] == [0.3, 0.3, 6]
    assert next(row for row in record["rows"] if not row["at"]) == {
        **{f"{field}_mm": value for field, value in bad.items()},
        "at": "",
        "status": f"failed: {failed['error']}",
    }


@pytest.mark.parametrize(
    ("field", "good", "bad", "sentence"),
    [
        ("motion.depth", 0.3, 9, "expected less than 5 mm"),
        ("finger.subject", "a.h.", "h.a.", "a.h."),
    ],
)
def test_a_value_that_no_scene_can_have_ends_a_study_before_it_runs(
    monkeypatch, field, good, bad, sentence
):
    monkeypatch.setattr(
        "fefinger.studies.study.local", lambda *inputs: pytest.fail("a scene was run")
    )
    over = {field: (good, bad), "indenter.angle": (20, 30)}
    with pytest.raises(InputError, match=f"{sentence}.*{field} = {bad}; none of the 4 scenes"):
        ff.study("flat-press", over, changes=QUICK, mechanics="hertz")


def test_levels_that_were_not_asked_for_have_rows_where_they_are_reached():
    options = {"changes": QUICK | LEAN, "mechanics": "lumped", "workers": 1}
    found = ff.study("flat-press", {"motion.depth": (0.2, 1.2)}, **options)
    assert [row["at"] for row in found.rows] == ["peak", "end", "peak", "end", "1 mm"]
    asked = ff.study("flat-press", {"motion.depth": (0.2, 1.2)}, at=("1mm",), **options)
    assert [row["at"] for row in asked.rows] == 2 * ["peak", "end", "1 mm"]


@pytest.mark.usefixtures("child_processes")
def test_one_that_no_mechanics_can_answer_fails_in_its_process_alone():
    found = ff.study(
        "sphere-press",
        {"indenter.kind": ("sphere", "cylinder")},
        changes={"ask.spikes": [], "motion.depth": 0.3},
        mechanics="hertz",
    )
    ((values, error),) = found.failures
    assert values == {"indenter.kind": "cylinder"}
    assert "hertz" in error
    assert found.rows[-1]["status"] == f"failed: {error}"


def test_what_cannot_be_used_at_all_is_refused_before_any_work(capsys):
    assert main(["study", "flat-press", "--over", "indenter.angel=0:60:3"]) == 2
    assert "Did you mean 'angle'?" in capsys.readouterr().err
    with refused("workers"):
        ff.study("flat-press", {"indenter.angle": (30,)}, workers=0)
    with refused("mechanics"):
        ff.study("flat-press", {"indenter.angle": (30,)}, mechanics="liner")
    scene = ff.Scene(finger=ELASTIC, motion=ff.Ramp(1, 1))
    with refused("finger.subject"):
        ff.study(scene, {"finger.subject": ("a.h.", "d.p.")})


def test_a_key_follows_everything_that_decides_the_answer(tmp_path, monkeypatch):
    def key(**changes):
        asked = tasks.StudyRequest("flat-press", {"indenter.angle": (30,)}, changes, None, ("1N",))
        return tasks.key(asked.tasks()[0][0])

    assert key() == key()
    assert key() != key(**{"finger.tissue": "saal2017"})
    before = key()
    monkeypatch.setattr(tasks, "VERSION", "0.0.0")
    assert key() != before


def test_it_goes_on_after_it_was_killed(tmp_path):
    over = {"indenter.angle": tuple(np.linspace(20, 40, 10).round(3))}
    listed = ",".join(map(str, over["indenter.angle"]))
    command = [sys.executable, "-m", "fefinger", "study", "flat-press", "--mechanics", "hertz"]
    command += ["--over", f"indenter.angle={listed}", "--workers", "1", "-o", str(tmp_path)]
    command += settings(QUICK)
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    until = time.monotonic() + 300  # for a machine with other work
    answered = "[!.]*.json"  # a file that is being written has a name with a dot before it
    while len(list((tmp_path / "scenes").glob(answered))) < 2 and time.monotonic() < until:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = len(list((tmp_path / "scenes").glob(answered)))
    assert 2 <= kept < 10
    options = {"changes": QUICK, "mechanics": "hertz"}
    resumed = ff.study("flat-press", over, folder=tmp_path, workers=2, **options)
    assert resumed.reused == kept
    assert same(resumed.rows, ff.study("flat-press", over, workers=1, **options).rows)


DAMAGES = {
    "cut": lambda text: text[:100],
    "empty": lambda _: "",
    "deep": lambda _: "[" * 100_000,
    "another type": lambda text: json.dumps({**json.loads(text), "rows": 5}),
    "another value": lambda text: re.sub(r'("force_N": \d\.\d*)\d', r"\g<1>0", text, count=1),
    "no number": lambda text: text.replace('"force_N": ', '"force_N": NaN, "x": ', 1),
    "many digits": lambda text: text.replace('"force_N": ', f'"force_N": {"1" * 5000}, "x": ', 1),
    "a list for a number": lambda text: text.replace('"mesh": ""', '"seed": [1]', 1),
    "no checksum": lambda text: json.dumps({"rows": json.loads(text)["rows"]}),
}


def test_a_damaged_file_is_answered_again(tmp_path):
    options = {"changes": QUICK, "mechanics": "hertz", "folder": tmp_path}
    first = ff.study("flat-press", {"indenter.angle": (30,)}, **options)
    (file,) = (tmp_path / "scenes").glob("*.json")
    text = file.read_text()
    assert ff.study("flat-press", {"indenter.angle": (30,)}, **options).reused == 1
    for name, damage in DAMAGES.items():
        file.write_text(damage(text))
        assert file.read_text() != text, name
        assert tasks.read_record(file) is None, name
    again = ff.study("flat-press", {"indenter.angle": (30,)}, **options)
    assert again.reused == 0
    assert same(first.rows, again.rows)
    file.unlink()
    os.mkfifo(file)  # which nothing writes to
    assert tasks.read_record(file) is None


def test_a_scene_on_which_its_process_dies_is_a_failure_with_advice(monkeypatch):
    """A task without a scene is answered by a sentence; one that ends the process costs itself."""
    monkeypatch.setattr(tasks, "answer", process_calls.end_for_odd)
    found = dict(tasks.local([0, 1, 2], 1))
    assert found[0] == found[2] == {"rows": []}
    assert "ended with status 3" in found[1]["error"]
    assert "use fewer --workers" in found[1]["error"]


def test_an_error_of_the_program_is_a_sentence_too():
    found = tasks.answer({"scene": {}, "mechanics": None, "forces": [], "depths": []})
    assert found["error"].startswith("finger: missing")
    assert tasks.answer({})["error"] == "unexpected KeyError: 'scene'"


@pytest.mark.filterwarnings("ignore")  # of the cluster's own libraries
def test_a_cluster_gives_the_same():
    distributed = pytest.importorskip("distributed", reason="needs the extra 'distributed'")
    over, options = THICK_OR_DEEP, {"changes": QUICK | LEAN, "mechanics": "lumped"}
    cluster = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    )
    with cluster:
        far = ff.study("flat-press", over, scheduler=cluster.scheduler_address, **options)
    near = ff.study("flat-press", over, workers=1, **options)
    assert same(far.rows, near.rows)
    assert far.failures == near.failures


@pytest.mark.parametrize("address", ["nowhere", "tls://127.0.0.1:1", "inproc://1/2/3"])
def test_an_address_of_no_scheduler_gets_a_sentence(address):
    pytest.importorskip("distributed", reason="needs the extra 'distributed'")
    import dask

    with pytest.raises(InputError, match=f"--scheduler: .*received '{address}'"):
        ff.study("flat-press", {"indenter.angle": (20,)}, scheduler=address)
    assert dask.config.get("scheduler", None) is None


def test_a_command_without_its_scheduler_ends_with_one_sentence():
    """A client that is not closed waits for 60 s when Python ends, and then says so."""
    pytest.importorskip("distributed", reason="needs the extra 'distributed'")
    command = [sys.executable, "-m", "fefinger", "study", "flat-press", "--over"]
    command += ["indenter.angle=20,21", "--scheduler", "nowhere"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=40, check=False)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1


def test_without_the_extra_the_cluster_is_refused(monkeypatch):
    monkeypatch.setitem(sys.modules, "dask.distributed", None)
    with refused("--scheduler"):
        ff.study("flat-press", {"indenter.angle": (20,)}, scheduler="tcp://127.0.0.1:1")


@pytest.mark.parametrize("values", [30, "a.h.", None])
def test_a_grid_takes_lists_of_values(values):
    with pytest.raises(InputError, match=f"expected a list of values, received {values!r}"):
        ff.study("flat-press", {"finger.subject": values})


def test_cores_are_those_this_process_may_use():
    assert 1 <= cores() <= (os.cpu_count() or 1)


def test_a_page_over_names_and_one_where_all_failed(tmp_path):
    options = {"changes": QUICK | LEAN, "mechanics": "lumped", "workers": 1}
    found = ff.study("flat-press", {"finger.subject": ("a.h.", "d.p.")}, **options)
    assert found.table()["finger.subject"].unique().tolist() == ["a.h.", "d.p."]
    found.save(tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "finger.subject a.h., d.p." in page
    assert 'src="data:image/svg+xml,' in page
    options |= {"mechanics": "hertz", "changes": options["changes"] | {"indenter.kind": "cylinder"}}
    none = ff.study("sphere-press", {"indenter.radius": (3, 4)}, **options)
    assert len(none.failures) == 2
    none.save(tmp_path)
    assert "0 of 2 scenes were answered" in (tmp_path / "report.html").read_text()
