"""Where a disk is full: a sentence, the answer all the same, and nothing that is half-written."""

import errno
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from fefinger.validation import page
from fefinger.validation.oracles.synthetic import ramp_and_hold

import fefinger as ff
from fefinger.__main__ import main
from fefinger.calibration import lumped_fit
from fefinger.mesh import mesh_record
from fefinger.mesh.recipe import data_folder
from fefinger.pages import viewer
from fefinger.scene import library
from fefinger.support import atomic_write
from fefinger.support.checks import InputError
from fefinger.theory.lumped.spring import Spring
from fefinger.view import pictures


resource = pytest.importorskip("resource", reason="limits the size of files")

ROOM = 1000
"""Bytes that a file may have."""

FULL = "cannot write .*; free some space or choose another folder"


@contextmanager
def full() -> Iterator[None]:
    """Let files have no more than ROOM bytes, as on a disk that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_the_answer_of_a_run_is_told_where_it_cannot_be_saved(answered, capsys, tmp_path):
    with full():
        status = main(["run", "flat-press", "-o", str(tmp_path / "out")])
    out, err = capsys.readouterr()
    assert status == 2
    assert "peak force" in out
    assert "cannot write" in err
    assert "free some space or choose another folder" in err
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("plain_report")
def test_a_result_that_cannot_be_saved_leaves_the_one_before(synthetic, tmp_path):
    synthetic.save(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with full(), pytest.raises(InputError, match=FULL):
        synthetic.save(tmp_path)
    # exact: the files are the same ones
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_why_a_run_stopped_is_told_where_what_it_reached_cannot_be_kept(
    monkeypatch, capsys, synthetic, tmp_path
):
    def stopped(*given, **options):
        msg = "it buckled"
        raise ff.Stopped(msg, synthetic)

    monkeypatch.setattr("fefinger.pipeline.run", stopped)
    with full():
        assert main(["run", "flat-press", "-o", str(tmp_path / "out")]) == 1
    err = capsys.readouterr().err
    assert "not saved: cannot write" in err
    assert "it buckled" in err
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def press(tmp_path):
    """Return the file of a trial with the noise of the thesis."""
    row = library.lumped()["a.h."]
    made = ramp_and_hold(Spring(row.b, row.m, 0.5), row.prony, seed=0, hold=2)
    table = np.column_stack([made.time, made.position, made.force])
    file = tmp_path / "press.csv"
    np.savetxt(file, table, "%.7g", ",", header="time,position,force", comments="")
    return file


def test_a_fit_is_told_where_it_cannot_be_saved(capsys, press, tmp_path):
    with full():
        assert main(["fit", str(press), "-o", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert "ramp and hold together" in out
    assert "cannot write" in err
    assert list(tmp_path.iterdir()) == [press]


def test_a_table_of_a_fit_without_room_takes_its_record_along(monkeypatch, press, tmp_path):
    fit = lumped_fit.fit(press)
    (tmp_path / "out").mkdir()
    monkeypatch.setattr(lumped_fit, "record", lambda fit: {})  # small enough
    with full(), pytest.raises(InputError, match=FULL):
        lumped_fit.save(fit, tmp_path / "out")
    assert list((tmp_path / "out").iterdir()) == []


@pytest.fixture(scope="module")
def study():
    """Return a function that answers two scenes by a force law."""
    lean = {"ask.spikes": [], "ask.pressure": False, "ask.strain": False, "motion.hold": 0.05}
    grid = {"motion.depth": (0.2, 0.4)}
    return lambda **more: ff.study(
        "flat-press", grid, changes=lean, mechanics="lumped", workers=1, **more
    )


def test_a_study_is_told_where_it_cannot_be_saved(monkeypatch, capsys, study, tmp_path):
    answered = study()  # not while files are limited: it asks git, whose own files would be cut
    monkeypatch.setattr("fefinger.studies.study.study", lambda *given, **options: answered)
    words = ["study", "flat-press", "--over", "motion.depth=0.2,0.4", "-o", str(tmp_path)]
    with full():
        assert main(words) == 2
    out, err = capsys.readouterr()
    assert "2 of 2 scenes" in out
    assert "cannot write" in err
    assert list(tmp_path.iterdir()) == []


def test_a_netcdf_without_room_leaves_nothing(study, tmp_path):
    answered = study()
    with full(), pytest.raises(InputError, match=FULL):
        answered.write(tmp_path / "table.nc")
    assert list(tmp_path.iterdir()) == []


def test_a_scene_of_a_study_that_cannot_be_kept_is_told_all_the_same(monkeypatch, study, tmp_path):
    def store(place, answer):
        raise InputError(
            atomic_write.write_error(OSError(errno.ENOSPC, "No space left on device"), place)
        )

    monkeypatch.setattr("fefinger.studies.study.write_record", store)
    answered = study(folder=tmp_path)
    assert (answered.failures, answered.rows[0]["status"]) == ((), "done")
    assert list((tmp_path / "scenes").iterdir()) == []


@pytest.mark.parametrize("name", ["finger.vtu", "page.html", "film.gif"])
def test_a_file_of_the_user_that_cannot_be_written_is_named(name, synthetic, tmp_path):
    mesh = mesh_record.read(data_folder() / "ah-coarse.vtu")
    picture = np.random.default_rng(0).integers(0, 255, (40, 40, 3), np.uint8)
    write = {
        "finger.vtu": lambda path: mesh_record.write(mesh, path),
        "page.html": lambda path: viewer.write([synthetic], path),
        "film.gif": lambda path: pictures.write(path, [picture] * 2, 8),
    }[name]
    with full(), pytest.raises(InputError, match=FULL.replace(".*", rf".*{name}.*")):
        write(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_texts_appear_together_or_not_at_all(tmp_path):
    (tmp_path / "a.json").write_text("before")
    with full(), pytest.raises(InputError, match=FULL):
        atomic_write.write(tmp_path, {"a.json": "now", "b.toml": "x" * 2 * ROOM})
    assert [path.read_text() for path in tmp_path.iterdir()] == ["before"]
    atomic_write.write(tmp_path, {"a.json": "now", "b.toml": "y"})
    assert sorted(path.read_text() for path in tmp_path.iterdir()) == ["now", "y"]


def test_a_page_of_validation_without_room_leaves_nothing(tmp_path):
    record = {"suites": []}
    with full(), pytest.raises(InputError, match=FULL):
        page.save(record, tmp_path, {}, {})
    assert list(tmp_path.iterdir()) == []


def test_the_sentence_advises_on_what_is_wrong():
    forbidden = OSError(errno.EACCES, "Permission denied")
    assert atomic_write.write_error(forbidden, "out") == (
        "cannot write 'out': Permission denied; choose another folder"
    )
    assert "free some space" in atomic_write.write_error(
        OSError(errno.ENOSPC, "No space left on device")
    )


def test_a_full_disk_elsewhere_is_a_sentence_too(monkeypatch, capsys):
    def load(*given):
        raise OSError(errno.ENOSPC, "No space left on device", "somewhere")

    monkeypatch.setattr("fefinger.scene.builtin.load", load)
    assert main(["explain", "flat-press"]) == 2
    assert "error: cannot write 'somewhere': No space left" in capsys.readouterr().err


KILLED = """
import os, signal, sys
from pathlib import Path
from fefinger.support import atomic_write
place = Path(sys.argv[1], "a.vtu")
with atomic_write.in_place(place) as new, atomic_write.temporary_folder(place.parent):
    new.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_a_killed_process_left_goes_at_the_next_use_of_the_folder(tmp_path):
    pytest.importorskip("fcntl", reason="this system has no locks of files")
    subprocess.run([sys.executable, "-c", KILLED, str(tmp_path)], check=False)
    names = sorted(path.name.rpartition("-")[0] for path in tmp_path.iterdir())
    assert names == [".saving", "fefinger"]
    ours = [tmp_path / "fefinger-out", tmp_path / "fefinger-0123456789abcdef", tmp_path / ".saving"]
    for folder in ours:  # none of these names is that of a temporary folder
        folder.mkdir()
    with (
        atomic_write.in_place(tmp_path / "a.vtu") as new,
        atomic_write.temporary_folder(tmp_path) as folder,
        atomic_write.temporary_folder(tmp_path) as another,
    ):
        new.write_text("whole")
        assert set(tmp_path.iterdir()) == {*ours, new.parent, folder, another}
    assert set(tmp_path.iterdir()) == {*ours, tmp_path / "a.vtu"}
    assert (tmp_path / "a.vtu").read_text() == "whole"


def test_a_folder_that_another_process_removes_before_it_is_locked_is_made_again(
    monkeypatch, tmp_path
):
    lock, taken = atomic_write.lock, []

    def late(path, *given):
        if not taken:
            taken.append(path)
            path.rmdir()
        return lock(path, *given)

    monkeypatch.setattr(atomic_write, "lock", late)
    with atomic_write.temporary_folder(tmp_path) as folder:
        assert folder.is_dir()
        assert folder not in taken
    assert list(tmp_path.iterdir()) == []
