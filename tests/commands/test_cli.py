"""The command line: what it prints and its exit statuses; what it refuses has its own file."""

import io
import json
import os
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fefinger.validation.problems import published

import fefinger as ff
from fefinger import mechanics
from fefinger.__main__ import main
from fefinger.commands import console
from fefinger.mechanics import linear
from fefinger.result import load
from fefinger.results.records import Lateral, Refusal
from fefinger.results.result_record import trust
from fefinger.scene import builtin
from fefinger.scene.ask import Ask
from fefinger.scene.finger import origin_notes
from fefinger.scene.scene import Scene
from fefinger.scene.schema import schema


QUICK = ("--set", "finger.resolution=coarse", "--set", "motion.hold=0.05")


def test_run_answers_a_changed_scene_and_prints_a_summary(capsys, answered):
    assert main(["run", "flat-press", "--set", "motion.depth=1", "--mechanics", "linear"]) == 0
    ((scene, options),) = answered
    assert scene == builtin.load("flat-press", {"motion.depth": 1})
    assert options == {"mechanics": "linear", "progress": None}
    out, err = capsys.readouterr()
    for words in ("synthetic", "peak force", "within 4 %", "contact area", "SAI-1", "its 3 notes"):
        assert words in out
    assert sum(not line.startswith("caution") for line in out.splitlines()) <= 10
    assert err == ""


def test_run_warns_of_what_speaks_against_the_mechanics_that_was_named(
    capsys, monkeypatch, synthetic
):
    against = Refusal("linear", "accuracy", "depth / thickness = 0.4 > 0.1")
    plan = replace(synthetic.plan, overridden=(against,))
    result = replace(synthetic, plan=plan)
    monkeypatch.setattr("fefinger.pipeline.run", lambda scene, **options: result)
    assert main(["run", "flat-press", "--mechanics", "linear"]) == 0
    assert "chosen by name despite: depth / thickness = 0.4 > 0.1" in capsys.readouterr().out


def test_run_prints_how_the_answer_was_reached_with_verbose(capsys, answered):
    assert main(["run", "flat-press", "-v"]) == 0
    out = capsys.readouterr().out
    for words in ("peak force", "status", "centroid", "trust", "seconds", "note", "No inertia"):
        assert words in out


@pytest.mark.usefixtures("plain_report")
def test_run_names_the_report_that_it_wrote(capsys, answered, tmp_path):
    assert main(["run", "flat-press", "-o", str(tmp_path / "out")]) == 0
    assert str(tmp_path / "out" / "report.html") in capsys.readouterr().out


@pytest.mark.usefixtures("plain_report")
def test_run_tells_that_it_replaced_a_result(capsys, answered, tmp_path):
    command = ["run", "flat-press", "-o", str(tmp_path)]
    assert main(command) == 0
    assert "replaced" not in capsys.readouterr().err
    assert main(command) == 0
    assert f"replaced an earlier result in {tmp_path}" in capsys.readouterr().err


def test_run_refuses_a_folder_with_files_of_others_before_it_computes(capsys, answered, tmp_path):
    (tmp_path / "spikes.csv").write_text("mine")
    assert main(["run", "flat-press", "-o", str(tmp_path)]) == 2
    assert "'spikes.csv'" in capsys.readouterr().err
    assert answered == []


def test_run_json_has_the_keys_of_the_contract_and_nothing_else(capsys, answered, synthetic):
    assert main(["run", "flat-press", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert list(record) == [
        *("status", "mechanics", "peak_force_N", "final_force_N", "contact_area_mm2"),
        *("centroid_mm", "afferents", "spikes", "spikes_within", "rates_Hz", "rates_within_Hz"),
        *("unmodeled", "seconds", "files"),
    ]
    assert record["peak_force_N"] == pytest.approx(synthetic.force.max())
    assert record["final_force_N"] == pytest.approx(synthetic.force[-1])
    area = synthetic.contact_area[synthetic.force.argmax()]
    assert record["contact_area_mm2"] == pytest.approx(area)
    assert record["files"] == []


def test_run_tells_how_friction_ended(capsys, monkeypatch, synthetic):
    force = np.tile([[0.3, -0.4]], (len(synthetic.time), 1))
    slid = Lateral(np.zeros_like(force), force, outcome="Sticking: no part slips.")
    result = replace(synthetic, response=replace(synthetic.response, lateral=slid))
    monkeypatch.setattr("fefinger.pipeline.run", lambda scene, **options: result)
    assert main(["run", "slide-dots", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["peak_lateral_force_N"] == pytest.approx(0.5)
    assert record["friction"] == slid.outcome
    assert main(["run", "slide-dots"]) == 0
    assert slid.outcome in capsys.readouterr().out


def test_run_json_is_null_where_nothing_was_asked(capsys, monkeypatch, synthetic):
    scene = replace(synthetic.scene, ask=Ask(force=False, pressure=False))
    response = replace(
        synthetic.response, contact_area=None, centroid=None, pad=None, pressure=None
    )
    plan = replace(synthetic.plan, trust=trust(synthetic.plan.chosen, scene.ask))
    bare = replace(synthetic, scene=scene, plan=plan, response=response, spikes=None)
    monkeypatch.setattr("fefinger.pipeline.run", lambda scene, **options: bare)
    assert main(["run", "flat-press", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    for key in ("peak_force_N", "final_force_N", "contact_area_mm2", "centroid_mm"):
        assert record[key] is None
    assert main(["run", "flat-press"]) == 0
    assert "force" not in capsys.readouterr().out.replace("mechanics", "")


@pytest.mark.usefixtures("plain_report")
def test_run_writes_what_it_names_and_a_picture_can_be_had_from_it(capsys, answered, tmp_path):
    out = tmp_path / "deep" / "out"
    assert main(["run", "flat-press", "--json", "-o", str(out)]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["files"]
    assert all(os.path.isfile(file) for file in record["files"])
    assert "save" in record["seconds"]
    assert load(out).scene.name == "synthetic"


def test_a_scene_is_answered_for_real(capsys):
    assert main(["run", "flat-press", "--json", "--mechanics", "linear", *QUICK]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["mechanics"] == "linear"
    assert 0.1 < record["final_force_N"] < record["peak_force_N"] < 10
    assert record["centroid_mm"][1] == pytest.approx(0, abs=1e-9)
    assert {"mesh", "contact", "neural"} <= set(record["seconds"])


def test_a_result_says_how_to_make_it_again():
    scene = published.load("flat-press", builtin.settings(QUICK[1::2]))
    requested = replace(scene, ask=Ask(strain=False, spikes=("FAI",), fields=False))
    result = ff.run(requested, mechanics="linear")
    assert (result.strain, result.fields) == (None, None)
    assert result.spikes.types == ("FAI",)
    assert result.provenance["fefinger"] == ff.__version__
    assert set(result.provenance["packages"]) == {"numpy", "scipy", "scikit-fem", "numba"}
    assert len(result.provenance["scene_sha256"]) == 64
    assert "Spikes: FAI" in result.status


def test_progress_is_a_bar_on_a_terminal_and_nothing_in_a_pipe(capsys, monkeypatch):
    with console.progress() as report:
        assert report is None
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with console.progress() as report:
        for fraction in (0.0, 0.5, 1.0):
            report("contact", fraction)
    out, err = capsys.readouterr()
    assert out == ""
    assert "contact" in err


def test_explain_prints_the_choice_and_the_ladder(capsys):
    assert main(["explain", "flat-press"]) == 0
    out = capsys.readouterr().out
    assert "cheapest that does not refuse" in out
    assert "evidence" in out
    assert main(["explain", "flat-press", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["mechanics"] in [rung["mechanics"] for rung in record["rungs"]]


@pytest.mark.parametrize(
    ("changes", "warned"),
    [
        (["motion.speed=60"], False),
        (["motion.speed=1e3", "ask.rel_error=0.3"], False),  # answered with inertia
        (["motion.speed=1e3", "finger.relaxation=deviatoric"], True),
    ],
)
def test_explain_warns_of_a_motion_that_is_too_fast_as_its_answer_will(changes, warned, capsys):
    options = [part for change in changes for part in ("--set", change)]
    assert main(["explain", "flat-press", *options]) == 0
    assert ("Warning: not quasi-static" in capsys.readouterr().err) is warned


def test_explain_begins_with_the_choice_and_ends_with_its_notes(monkeypatch):
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "stdout", terminal)
    monkeypatch.setattr(sys, "stderr", terminal)
    tissue = "--set", "finger.tissue=calibrated_means"
    assert main(["explain", "flat-press", *tissue]) == 0
    first, *_, last = terminal.getvalue().strip().splitlines()
    assert first.startswith("pressed on the standard mesh")
    assert last.startswith("The tissue was fitted")


def test_explain_writes_null_for_the_cost_of_what_cannot_be_done(capsys, monkeypatch):
    refusal = Refusal("hertz", "ability", "never")
    monkeypatch.setattr(mechanics, "names", lambda: ("hertz", "linear"))
    unable = type("Unable", (), {"refuse": staticmethod(lambda scene: (refusal,))})
    monkeypatch.setattr(mechanics, "get", {"hertz": unable, "linear": linear}.__getitem__)
    changes = ("--set", "ask.rel_error=0.5", "--set", "finger.tissue=maeno1998")
    assert main(["explain", "flat-press", "--json", *changes]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["rungs"][0]["seconds"], record["rungs"][0]["error"]) == (None, None)


def test_scenes_prints_the_schema_of_scene_files(capsys):
    assert main(["scenes", "--schema"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(schema()))


def test_scenes_lists_all_and_prints_one_that_loads(capsys):
    assert main(["scenes"]) == 0
    out = capsys.readouterr().out
    assert [line.split()[0] for line in out.splitlines()] == list(builtin.names())
    assert main(["scenes", "press-to-1N"]) == 0
    assert Scene.from_toml(capsys.readouterr().out) == builtin.load("press-to-1N")
    assert main(["scenes", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["scenes"]
    assert [entry["name"] for entry in listed] == list(builtin.names())
    assert main(["scenes", "press-to-1N", "--json"]) == 0
    # exact: JSON has every digit
    assert Scene.from_dict(json.loads(capsys.readouterr().out)) == builtin.load("press-to-1N")


def test_mesh_takes_the_ready_one_and_writes_it(capsys, tmp_path):
    file = tmp_path / "finger.vtu"
    assert main(["mesh", *QUICK[:2], "-o", str(file), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["half"] is True
    assert record["tetrahedra"] > 1000
    assert record["quality"]["min_volume"] > 0
    assert file.is_file()
    assert main(["mesh", *QUICK[:2], "--whole"]) == 0
    text = capsys.readouterr().out
    assert "the whole finger" in text
    assert "14 mm wide, 10 mm thick, pad radius 14 mm" in text
    points, cells = 2 * record["points"], 2 * record["tetrahedra"]
    assert int(text.split(" points")[0].split()[-1]) < points  # the medial plane's once
    assert f"{cells} tetrahedra" in text


def test_validate_fails_only_on_a_verdict_that_says_so(capsys, monkeypatch, tmp_path):
    suites = pytest.importorskip("fefinger.validation.suites")
    cases = {
        "name": "n",
        "value": 1.0,
        "expected": 1.0,
        "tolerance": 0.1,
        "unit": "N",
        "failure": "",
        "erratum": "",
    }

    def outcome(verdict):
        return {"suites": [{"suite": "s", "cases": [cases | {"source": "", "verdict": verdict}]}]}

    monkeypatch.setattr(suites, "run", lambda suites, **options: suites)
    monkeypatch.setattr(suites, "figures", lambda record: {})
    monkeypatch.setattr(suites, "findings", lambda record: {})
    for verdict, status in (("pass", 0), ("documented", 0), ("short", 0), ("fail", 1)):
        monkeypatch.setattr(suites, "as_json", lambda _, verdict=verdict: outcome(verdict))
        assert main(["validate", "--quick", "--json", "-o", str(tmp_path)]) == status
        files = [str(tmp_path / name) for name in ("validation.json", "validation.html")]
        assert json.loads(capsys.readouterr().out) == outcome(verdict) | {"files": files}
        written = json.loads((tmp_path / "validation.json").read_text())
        assert written["provenance"]["command"] == "fefinger validate --quick"
        assert written["suites"] == outcome(verdict)["suites"]
        assert f">{verdict}<" in (tmp_path / "validation.html").read_text()
        assert main(["validate", "s"]) == status
        assert verdict in capsys.readouterr().out


def test_validate_says_where_its_files_and_the_index_are(capsys, monkeypatch, tmp_path):
    suites = pytest.importorskip("fefinger.validation.suites")
    monkeypatch.setattr(suites, "run", lambda suites, **options: {})
    message = [f"file  {tmp_path / 'validation'}.{kind}" for kind in ("json", "html")]
    assert main(["validate", "--quick", "-o", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines()[-2:] == message
    (tmp_path / "index.html").write_text("")
    assert main(["validate", "--quick", "-o", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines()[-3:] == [
        *message,
        f"file  {tmp_path / 'index.html'}",
    ]


@pytest.mark.parametrize(
    ("error", "status"), [(KeyboardInterrupt(), 130), (MemoryError(), 1)], ids=repr
)
def test_a_run_that_ends_early_leaves_no_empty_folder(monkeypatch, tmp_path, error, status):
    def end(*args, **options):
        raise error

    monkeypatch.setattr("fefinger.pipeline.run", end)
    (tmp_path / "mine").mkdir()
    for folder in ("new/deep", "mine"):
        assert main(["run", "flat-press", "-o", str(tmp_path / folder)]) == status
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


SIZE = ("--set", "finger.width=15")


def test_a_subject_of_another_size_is_told(capsys, tmp_path):
    message = "The finger differs from subject a.h.: width 15 mm instead of 14 mm."
    assert main(["explain", "flat-press", *SIZE]) == 0
    assert capsys.readouterr().err.strip() == message
    force = ("pressure=false", "strain=false", "fields=false", "spikes=[]")
    only = [word for each in force for word in ("--set", f"ask.{each}")]
    assert main(["run", "flat-press", *only, *SIZE, "--mechanics", "lumped", "-v"]) == 0
    assert message in capsys.readouterr().out
    assert main(["explain", "flat-press", "--set", "finger.tissue=calibrated_ah"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("name", ["d.p.", None])
def test_tissue_that_was_fitted_to_another_subject_is_told(name):
    message = "The tissue was fitted to subject a.h., another finger (calibrated_ah)."
    finger = ff.Finger.subject(name or "a.h.", tissue="calibrated_ah")
    assert origin_notes(replace(finger, subject_name=name)) == (message,)
    assert origin_notes(ff.Finger.subject("a.h.", tissue="calibrated_ah")) == ()


def test_layers_that_are_not_those_of_the_set_that_is_named_are_told():
    finger = replace(ff.Finger.subject("a.h.", tissue="maeno1998"), tissue="calibrated_dp")
    message = origin_notes(finger)
    assert message[0] == (
        "The tissue differs from calibrated_dp: finger.skin and finger.subcutaneous as given in "
        "the scene."
    )
    assert not any("fitted" in sentence for sentence in message)
    assert origin_notes(ff.Finger.subject("a.h.", skin=ff.Tissue(90, 0.48, 1.0))) == (
        "The tissue differs from calibrated_ah: finger.skin as given in the scene.",
    )


@pytest.mark.parametrize("words", [[], ["--quick"], ["tradeoff", "human"]])
def test_validate_runs_the_suites_that_are_named_or_all(capsys, monkeypatch, words):
    suites = pytest.importorskip("fefinger.validation.suites")
    ran = []
    monkeypatch.setattr(suites, "cases", lambda suite, quick: ran.append(suite) or ())
    assert main(["validate", *words]) == 0
    named = [word for word in words if word in suites.SUITES]
    assert ran == (named or list(suites.SUITES))


def test_view_draws_what_run_wrote(monkeypatch, tmp_path, saved):
    drawn = []
    screenshot = "fefinger.view.screenshot"
    monkeypatch.setattr(screenshot, lambda *args, **kwargs: drawn.append((args, kwargs)))
    picture = str(tmp_path / "a.png")
    command = ["view", str(tmp_path / "out"), "--screenshot", picture]
    assert main([*command, "--field", "pressure", "--time", "0.5"]) == 0
    (((_, path), options),) = drawn
    assert path == picture
    folders = (str(tmp_path / "out"),)
    assert options == {"field": "pressure", "time": 0.5, "limits": None, "folders": folders}


@pytest.mark.parametrize("arguments", [["--help"], ["scenes"], ["scenes", "flat-press"]], ids=str)
def test_help_and_scenes_load_no_library_that_takes_its_time(arguments):
    slow = ("numpy", "scipy", "skfem", "pyvista", "numba", "rich", "xarray", "matplotlib")
    code = (
        "import sys\nfrom fefinger.__main__ import main\n"
        f"main({arguments!r})\n"
        f"print([name for name in {slow!r} if name in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"


def test_the_help_loads_the_commands_and_little_else():
    code = (
        "import sys\nbefore = set(sys.modules)\nfrom fefinger.__main__ import main\n"
        "main(['--help'])\nprint(*set(sys.modules) - before, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stderr.split())
    files = Path(__file__).parents[2].joinpath("fefinger", "commands").glob("[a-z]*.py")
    commands = {f"fefinger.commands.{file.stem}" for file in files}
    support = {
        f"fefinger.support.{name}"
        for name in (
            "atomic_write",
            "checks",
            "compiled",
            "interrupt",
            "processes",
            "registry",
            "text",
        )
    }
    rooms = {"fefinger", "fefinger.__main__", "fefinger.commands", "fefinger.support"}
    package = {name for name in loaded if name.partition(".")[0] == "fefinger"}
    assert package == commands | support | rooms
    libraries = {name.partition(".")[0] for name in loaded - package} - sys.stdlib_module_names
    assert libraries == {"click"}


def test_the_version_is_the_one_of_the_project():
    with open(os.path.join(os.path.dirname(__file__), "..", "..", "pyproject.toml"), "rb") as file:
        project = tomllib.load(file)["project"]
    assert project.get("version", ff.__version__) == ff.__version__


def test_every_public_name_can_be_had_from_the_package():
    assert {name for name in ff.__all__ if not hasattr(ff, name)} == set()
    seen = [name for name in dir(ff) if not name.startswith("__")]
    assert seen == ff.__all__
    with pytest.raises(AttributeError, match="no attribute 'Fingr'"):
        _ = ff.Fingr


@pytest.mark.skipif(os.name != "posix", reason="the shell of POSIX closes streams")
def test_a_run_whose_streams_are_closed_is_saved(tmp_path):
    """As under a supervisor that gives none: no answer is lost on the way to nowhere."""
    command = [sys.executable, "-m", "fefinger", "run", "flat-press", "--mechanics", "hertz"]
    for part in ("fields=false", "pressure=false", "strain=false", "spikes=[]"):
        command += ["--set", f"ask.{part}"]
    command += [*QUICK, "-o", str(tmp_path / "out")]
    closed = ["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh", *command]
    assert subprocess.run(closed, check=False).returncode == 0
    assert ff.load(tmp_path / "out").force.max() > 0
