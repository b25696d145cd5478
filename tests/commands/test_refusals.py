"""What the command line refuses, with which words and exit status."""

import os
import re
import stat

import pytest
from fefinger.validation import suites

from fefinger.__main__ import main
from fefinger.support.checks import ConvergenceError, InputError


TOML = '[finger]\nsubject = "a.h."\n[motion]\nkind = "ramp-hold"\nspeed = 60\ndepth = 1\nhold = 1\n'
BAD_FILES = {
    "empty": ("", "empty; expected a scene with at least the tables"),
    "not TOML further down": (TOML + "corner = = 3\n", r"not TOML: .* \(at line 8"),
    "misspelt": (TOML + "cornr = 0\n", r"cornr: unknown key in \[motion\]. Did you mean 'corner'?"),
    "a name that no file can hold": (
        'name = "a\\u0000"\n' + TOML,
        "name: expected a name for the scene that can be printed",
    ),
}
BAD_SETTINGS = {
    "motion.hold=1e300": "motion.hold: expected a finite number in s at least 0 and at most 1e",
    "motion.corner=0.1": "the shortest straight part, received 0.1; take a shorter one",
    "finger.thickness=1": "finger.skin.thickness: expected less than 0.5 mm, half of finger.thickn",
    "depth": "--set 'depth': expected FIELD=VALUE, as in motion.depth=2",
}


def refused(capsys, arguments):
    """Return the one sentence with which the command line refuses `arguments`."""
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert "Traceback" not in err
    return err


@pytest.mark.parametrize(("text", "message"), BAD_FILES.values(), ids=BAD_FILES)
@pytest.mark.parametrize("command", ["run", "explain", "mesh"])
def test_a_file_that_is_no_scene_is_refused(capsys, tmp_path, command, text, message):
    file = tmp_path / "scene.toml"
    file.write_text(text)
    err = refused(capsys, [command, str(file)])
    assert re.search(message, err)


@pytest.mark.parametrize(("setting", "message"), BAD_SETTINGS.items(), ids=BAD_SETTINGS)
def test_a_value_that_cannot_be_used_is_refused_before_any_work(
    capsys, answered, tmp_path, setting, message
):
    out = tmp_path / "out"
    assert message in refused(capsys, ["run", "flat-press", "-o", str(out), "--set", setting])
    assert not answered
    assert not out.exists()


SMALL = ["--set", "finger={width=1.4, thickness=10, tissue='maeno1998'}"]


@pytest.mark.parametrize(("width", "unit"), [("0.014", "m"), ("0.5", "cm")])
def test_a_finger_in_another_unit_is_refused_in_one_line(capsys, width, unit):
    err = refused(capsys, ["explain", "sphere-press", "--set", f"finger.width={width}"])
    assert (
        f"finger.width: expected mm, 5 to 40 for a mesh, received {width}, as if it were in {unit};"
        in err
    )
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (SMALL, "finger.width: expected a finite number in mm at least 5 and at most 40, received"),
        (["--set", "finger.width=150"], "at least 5 and at most 40, received 150.0. No mesh can"),
        (["--set", "finger.tip_tissue=50"], "finger.tip_tissue: expected at most 15.4 mm, so that"),
    ],
)
def test_a_finger_that_nothing_can_be_made_of_is_refused_in_one_sentence(capsys, settings, message):
    assert main(["explain", "flat-press", *settings]) == 2
    *notes, error = capsys.readouterr().err.splitlines()
    assert all(note.startswith("The ") for note in notes)
    assert error.startswith("error: finger.")
    assert message in error


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"amplitude": 0.1}, "motion.preload: missing; a WAV file needs amplitude and preload"),
        ({"preload": 0.1}, "motion.amplitude: missing; a WAV file needs amplitude and preload"),
        ({"corner": 0.1}, "corner: unknown key in [motion]"),
    ],
)
def test_a_wave_needs_its_scale(capsys, settings, message):
    given = {"kind": "sampled", "file": "a.wav"} | settings
    options = [word for key, value in given.items() for word in ("--set", f"motion.{key}={value}")]
    assert message in refused(capsys, ["explain", "flat-press", *options])


def test_a_scene_that_does_not_exist_is_refused_with_the_names_that_do(capsys):
    err = refused(capsys, ["run", "flat-pres"])
    assert "no file of that name" in err
    assert "Did you mean 'flat-press'?" in err
    assert "Did you mean 'flat-press'?" in refused(capsys, ["scenes", "flat-pres"])


def test_an_indenter_that_never_touches_is_refused(capsys):
    sphere = ("--set", "indenter.kind=sphere", "--set", "indenter.radius=2")
    err = refused(capsys, ["run", "flat-press", *sphere, "--set", "indenter.at=[0, 9]"])
    assert "from which the object covers a part of the pad, x within 30 and y within 9 mm" in err


@pytest.mark.parametrize("command", [["run", "flat-press"], ["mesh"], ["validate"]], ids=str)
def test_an_output_folder_that_cannot_be_written_is_refused_before_any_work(
    capsys, answered, monkeypatch, tmp_path, command
):
    monkeypatch.setattr(
        "fefinger.mesh.store.load_or_build", lambda *a, **k: pytest.fail("work began")
    )
    (tmp_path / "file").write_text("")
    name = "m.vtu" if command == ["mesh"] else ""
    err = refused(capsys, [*command, "-o", str(tmp_path / "file" / name)])
    assert "output folder: expected a folder" in err
    assert not answered


@pytest.mark.parametrize(
    "option", ["--screenshot a.png", "--html a.html", "--movie a.gif"], ids=str
)
def test_a_folder_in_the_place_of_a_file_is_refused(
    capsys, monkeypatch, tmp_path, synthetic, option
):
    monkeypatch.setattr("fefinger.result.load", lambda folder: synthetic)
    monkeypatch.chdir(tmp_path)
    name = option.split()[1]
    (tmp_path / name).mkdir()
    err = refused(capsys, ["view", "out", *option.split()])
    assert f"expected a file, received the folder {name!r}" in err
    assert not list((tmp_path / name).iterdir())


@pytest.mark.parametrize("name", ["", "a/b", "../a"])
def test_a_name_of_files_is_no_path(capsys, monkeypatch, tmp_path, name):
    suites = pytest.importorskip("fefinger.validation.suites")
    monkeypatch.setattr(suites, "run", lambda *a, **k: pytest.fail("work began"))
    err = refused(capsys, ["validate", "--quick", "--name", name, "-o", str(tmp_path)])
    assert f"--name: expected a base name of files, such as validation, received {name!r}" in err


SCALE = ["--set", "motion.amplitude=0.1", "--set", "motion.preload=0.5"]
EXPLAIN = ["explain", "flat-press", "--set"]
FILES = {
    "run": ["run", "PATH.toml"],
    "surface": [*EXPLAIN, "finger.surface=PATH.stl"],
    "tissue": [*EXPLAIN, "finger.tissue=PATH.toml"],
    "relief": [*EXPLAIN, "indenter.kind=relief", "--set", "indenter.file=PATH.csv"],
    "motion": [*EXPLAIN, "motion.kind=sampled", "--set", "motion.file=PATH.csv"],
    "wave": [*EXPLAIN, "motion.kind=sampled", "--set", "motion.file=PATH.wav", *SCALE],
    "fit": ["fit", "PATH.csv"],
    "calibrate": ["calibrate", "PATH.csv", "--width", "15", "--thickness", "11"],
    "spikes": ["spikes", "--from", "PATH.csv"],
}


@pytest.mark.parametrize("arguments", FILES.values(), ids=FILES)
@pytest.mark.parametrize(
    "what", ["does not exist", "is a folder", "is a pipe", "is a socket", "other bytes"]
)
def test_an_input_file_that_cannot_be_read_is_named(capsys, monkeypatch, tmp_path, arguments, what):
    monkeypatch.chdir(tmp_path)
    words = [word.replace("PATH", "none") for word in arguments]
    name = next(word.rpartition("=")[2] for word in words if "none." in word)
    if what == "is a folder":
        (tmp_path / name).mkdir()
    if what == "is a pipe":
        os.mkfifo(name)
    if what == "is a socket":
        os.mknod(name, stat.S_IFSOCK)
    if what == "other bytes":
        (tmp_path / name).write_bytes(b"\x00\xff\xa0" * 40)
    if what == "does not exist" and words[0] == "run":
        what = "no such file"
    err = refused(capsys, words)
    assert name in err
    assert what == "other bytes" or what in err
    assert "codec" not in err
    assert "Errno" not in err


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ("--tolerance=-1", "--tolerance: expected"),
        ("--length=0", "--length: expected a finite number in mm above 0"),
        ("--type=SA1", "--type: expected one of 'SAI', 'SAII', 'FAI', 'FAII', received 'SA1'"),
        ("--afferents=both", "--afferents: expected one of 'recorded', 'thesis'"),
    ],
)
def test_an_option_of_spikes_is_checked_before_the_sampling(capsys, tmp_path, option, words):
    coarse = tmp_path / "coarse.csv"
    coarse.write_text("time,displacement_mm\n0,0\n1,1\n1.5,1\n")
    assert words in refused(capsys, ["spikes", "--from", str(coarse), option])


def test_a_field_that_is_both_varied_and_set_is_refused(capsys):
    both = ["--over", "motion.depth=0.5,1", "--set", "motion.depth=1"]
    err = refused(capsys, ["study", "flat-press", *both])
    assert "motion.depth: expected in --over or in --set, received in both" in err


@pytest.mark.parametrize("command", ["run", "explain", "mesh"])
def test_an_empty_name_is_no_scene(capsys, command):
    assert "scene: expected a TOML file or one of " in refused(capsys, [command, ""])


@pytest.mark.parametrize(
    "command", [["run", "flat-press"], ["validate"], ["fit", "a.csv"], ["study", "flat-press"]],
    ids=str,
)  # fmt: skip
@pytest.mark.parametrize("path", ["", " "])
def test_an_empty_path_is_no_folder(capsys, answered, command, path):
    over = ("--over", "motion.depth=0.5,1") if command[0] == "study" else ()
    err = refused(capsys, [*command, *over, "-o", path])
    assert "output folder: expected a name, received an empty one" in err
    assert not answered


@pytest.mark.parametrize(
    ("arguments", "ending"),
    [
        (["view", "out", "--screenshot", "a.xyz"], ".png"),
        (["view", "out", "--html", "a.txt"], ".html"),
        (["mesh", "flat-press", "--picture", "a"], ".png"),
    ],
)
def test_a_picture_under_a_name_of_another_kind_is_refused(capsys, arguments, ending):
    assert f"expected a file that ends in {ending}, received 'a" in refused(capsys, arguments)


def test_keys_beside_those_of_an_object_are_refused(capsys):
    """What closes the table of the object and goes on was read, and left out in silence."""
    table = 'kind="sphere", radius=5}\nx = {'
    words = ["calibrate", "a.csv", "--width", "15", "--thickness", "11", "--indenter", table]
    assert "received the key 'x' after it" in refused(capsys, words)


LONG = "x" * 5000
LONG_NAMES = {
    "mesh": ["mesh", "flat-press", "-o", f"{LONG}.vtu"],
    "picture": ["mesh", "flat-press", "--picture", f"{LONG}.png"],
    "table": ["study", "flat-press", "--over", "motion.depth=1,2", "--table", f"{LONG}.csv"],
    "page": ["view", "out", "--html", f"{LONG}.html"],
    "validation": ["validate", "neural", "--quick", "-o", "out", "--name", LONG],
    "suite": ["validate", LONG, "--quick"],
}


@pytest.mark.parametrize("arguments", LONG_NAMES.values(), ids=LONG_NAMES)
def test_a_name_that_no_file_can_have_is_refused_before_any_work(
    capsys, monkeypatch, tmp_path, arguments
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(suites, "cases", None)
    assert len(refused(capsys, arguments)) < 500
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "over", [["indenter.angle=0:60:1000000"], ["indenter.angle=0:60:200", "motion.depth=0.7:1:200"]]
)
def test_a_study_too_large_to_end_is_refused_at_once(capsys, over):
    options = [word for each in over for word in ("--over", each)]
    assert "10000" in refused(capsys, ["study", "flat-press", *options, "-o", "none"])


def test_a_folder_without_a_result_cannot_be_viewed(capsys, tmp_path):
    assert "result: expected a folder" in refused(capsys, ["view", str(tmp_path)])


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (InputError("x: expected y"), 2, "error: x: expected y"),
        (ConvergenceError("contact: reached 1e-3"), 1, "failed: contact: reached 1e-3"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
)
def test_what_goes_wrong_inside_decides_the_exit_status(capsys, monkeypatch, error, status, words):
    def fail(scene, **options):
        raise error

    monkeypatch.setattr("fefinger.pipeline.run", fail)
    assert main(["run", "flat-press", "--json"]) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["rn"], "No such command 'rn'"),
        (["run"], "Missing argument"),
        (["run", "--x"], "--x"),
        ([LONG], "xxx [...] xxx"),
        (["cache", "--prune", LONG], "[...]"),
    ],
)
def test_a_command_that_is_no_command_is_refused(capsys, arguments, words):
    assert main(arguments) == 2
    err = capsys.readouterr().err
    assert words in err
    assert len(err) < 500
