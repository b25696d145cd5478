"""What is kept to be used again: listed, pruned, limited, and safe while it is read."""

import json
import os
import subprocess
import sys
import time
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from damage import flip
from scipy import sparse

import fefinger as ff
from fefinger.__main__ import main
from fefinger.fem.body import Reduced
from fefinger.fem.condensation import Compliance
from fefinger.fem.linalg.multifrontal import Eliminated, Front
from fefinger.mechanics.press import operator as _operator
from fefinger.mechanics.press import operator_cache
from fefinger.mesh import store
from fefinger.mesh.recipe import Recipe
from fefinger.support import cache


DAY = 24 * 3600.0


@pytest.fixture
def root(tmp_path, monkeypatch):
    """Return an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "fefinger"


def keep(place, *, days, megabytes=1.0):
    """Keep an array that was last used so many days ago."""
    with cache.appearing(place, f"array {place.name}") as new:
        np.save(new / "array.npy", np.arange(int(megabytes * 125_000), dtype=float))
    used = time.time() - days * DAY
    os.utime(place, (used, used))
    return place


def read(place):
    """Read the array of an entry."""
    return np.load(place / "array.npy", mmap_mode="r")


def test_what_is_kept_is_listed_with_its_size(root):
    assert cache.entries() == ()
    keep(root / "patches" / "a", days=3)
    keep(root / "operators" / "b", days=1, megabytes=2)
    operator, patch = cache.entries()
    assert (operator.kind, patch.kind) == ("operators", "patches")
    assert (operator.what, patch.what) == ("array b", "array a")
    assert operator.size == pytest.approx(2e6, rel=1e-3)
    assert time.time() - patch.used == pytest.approx(3 * DAY, abs=DAY / 2)


def _remade(file, make):
    file.unlink()
    make()


DAMAGE: dict[str, Callable[[Path], object]] = {
    "one bit": flip,
    "first bit": lambda file: flip(file, at=0.0),
    "last bit": lambda file: flip(file, at=1.0),
    "empty": lambda file: file.write_bytes(b""),
    "half": lambda file: file.write_bytes(file.read_bytes()[: file.stat().st_size // 2]),
    "zeros": lambda file: file.write_bytes(bytes(file.stat().st_size)),
    "missing": Path.unlink,
    "folder": lambda file: _remade(file, file.mkdir),
    "link to itself": lambda file: _remade(file, lambda: file.symlink_to(file)),
    "pipe": lambda file: _remade(file, lambda: os.mkfifo(file)),
    "another file": lambda file: file.with_name("other").write_bytes(b""),
}


@pytest.mark.parametrize("name", ["array.npy", "what.txt", "checksums.txt"])
@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_entry_is_none_and_goes(root, damage, name):
    place = keep(root / "patches" / "a", days=0)
    assert cache.load(place, read)[-1] == 124_999
    DAMAGE[damage](place / name)
    assert cache.load(place, read) is None
    assert not os.path.lexists(place)
    keep(place, days=0)
    assert cache.load(place, read)[-1] == 124_999


def test_an_entry_that_is_no_folder_or_that_of_another_goes(root):
    place, other = keep(root / "patches" / "a", days=0), root / "patches" / "b"
    place.rename(other)
    assert cache.load(other, read) is None
    for make in (other.touch, other.mkdir, lambda: other.symlink_to(other)):
        make()
        assert cache.load(other, read) is None
        assert not os.path.lexists(other)


def test_an_entry_whose_reader_expects_another_version_goes(root):
    place = keep(root / "patches" / "a", days=0)
    assert cache.load(place, lambda folder: np.load(folder / "later.npy")) is None
    assert not place.exists()


def test_a_cache_that_may_not_be_written_is_read(root, monkeypatch):
    def refuse(*given, **options):
        raise PermissionError

    place = keep(root / "patches" / "a", days=0)
    for name in ("utime", "rename", "unlink", "mkdir"):
        monkeypatch.setattr(os, name, refuse)
    assert cache.load(place, read)[-1] == 124_999
    with pytest.raises(PermissionError), cache.appearing(place.with_name("b"), "b"):
        pass


def test_an_entry_that_is_there_stays_unless_it_is_replaced(root):
    place = root / "elastic" / "a"
    for size, replacing in ((1, False), (2, False), (3, True)):
        with cache.appearing(place, "an array", replacing=replacing) as new:
            np.save(new / "array.npy", np.arange(size))
    assert len(cache.load(place, read)) == 3
    assert list(place.parent.iterdir()) == [place]


def test_the_checksum_of_a_file_is_computed_once(root, monkeypatch):
    place = keep(root / "patches" / "a", days=0)
    cache.load(place, read)
    monkeypatch.setattr(zlib, "crc32", lambda *given: pytest.fail("computed again"))
    assert cache.load(place, read) is not None


def test_what_was_not_used_for_days_is_pruned(root, capsys):
    old, new = keep(root / "patches" / "old", days=40), keep(root / "patches" / "new", days=2)
    assert main(["cache"]) == 0
    assert "2 entries, 2 MB" in capsys.readouterr().out
    assert main(["cache", "--prune", "30", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert [entry["paths"] for entry in record["removed"]] == [[str(old)]]
    assert [entry["paths"] for entry in record["entries"]] == [[str(new)]]
    assert main(["cache", "--prune", "0"]) == 0
    assert "0 entries, 0 MB\n1 removed, 1 MB" in capsys.readouterr().out
    assert list((root / "patches").iterdir()) == []
    assert main(["cache", "--prune", "-1"]) == 2


@pytest.mark.parametrize("make", [Path.touch, Path.mkdir], ids=["a file", "a folder"])
def test_what_is_no_entry_is_listed_and_goes(root, capsys, make):
    place = root / "meshes" / "x"
    place.parent.mkdir(parents=True)
    make(place)
    assert main(["cache", "--json"]) == 0
    (entry,) = json.loads(capsys.readouterr().out)["entries"]
    assert (entry["paths"], entry["what"]) == ([str(place)], "")
    assert main(["cache", "--prune", "0"]) == 0
    assert list(place.parent.iterdir()) == []


@pytest.mark.parametrize("name", ["file", "x" * 300], ids=["a file", "a name too long"])
def test_a_cache_that_cannot_be_written_is_one_that_keeps_nothing(tmp_path, monkeypatch, name):
    (tmp_path / "file").write_text("a file where the folder should be")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / name))
    assert cache.entries() == ()
    finger, recipe = ff.Finger.subject("a.h.", tissue="maeno1998"), Recipe(15, 11, 14)
    assert not operator_cache.available(finger, half=True)
    assert not store.available(ff.Finger(15, 11, tissue="maeno1998"))
    mesh = store.load_or_build(finger, half=True)
    monkeypatch.setattr("fefinger.mesh.build.build", lambda recipe, **_: mesh)
    assert store.load_or_build(recipe, half=True) is mesh
    made = Reduced(None, np.eye(2), np.ones((6, 2)), np.ones((2, 2)))
    monkeypatch.setattr(_operator.reduction, "reduce", lambda *parts: made)
    nothing = sparse.eye(2, format="csr")
    patch = SimpleNamespace(loads=nothing, places=nothing, vertices=np.arange(2))
    solid, points = SimpleNamespace(half=True, identities=({},)), np.zeros((1, 3))
    assert _operator.reduced(finger, solid, patch, points, lambda: None) is made


def test_who_reads_keeps_what_is_open(root):
    place = keep(root / "patches" / "read", days=0)
    mapped = cache.load(place, read)
    assert len(cache.remove(cache.entries())) == 1
    assert not place.exists()
    assert mapped[-1] == len(mapped) - 1


def test_what_is_being_made_is_left_alone_until_it_is_abandoned(root):
    with cache.appearing(root / "operators" / "x", "x") as building:
        (building / "values.npy").write_bytes(b"half")
        assert cache.unused(0.0) == ()
        os.utime(building, (0, 0))
        (entry,) = cache.unused(1e9)
        assert entry.what == cache.UNFINISHED


def test_what_a_killed_process_left_goes_when_the_next_one_builds(root):
    pytest.importorskip("fcntl", reason="this system has no locks of files")
    killed = (
        "import os, signal, sys; from pathlib import Path; from fefinger.support import cache\n"
        "with cache.appearing(Path(sys.argv[1]), 'x') as new:\n"
        "    (new / 'part').touch(); os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    place = root / "operators" / "x"
    assert subprocess.run([sys.executable, "-c", killed, str(place)]).returncode < 0
    assert [entry.what for entry in cache.entries()] == [cache.UNFINISHED]
    with cache.appearing(place, "x") as ours, cache.appearing(place.with_name("y"), "y") as others:
        assert set(place.parent.iterdir()) == {ours, others}
    assert {path.name for path in place.parent.iterdir()} == {"x", "y"}


def test_a_kind_that_takes_too_much_loses_what_was_used_least_recently(root, monkeypatch):
    monkeypatch.setitem(cache.LIMITS_MB, "patches", 2.5)
    for days in (3, 1, 2, 0):
        keep(root / "patches" / f"d{days}", days=days)
    cache.limit("patches")
    assert sorted(path.name for path in (root / "patches").iterdir()) == ["d0", "d1"]
    monkeypatch.setitem(cache.LIMITS_MB, "patches", 0.5)
    cache.limit("patches")
    assert [path.name for path in (root / "patches").iterdir()] == ["d0"]


def test_an_operator_that_is_pruned_while_it_is_read_is_built_anew(root, monkeypatch):
    made = []

    def build(*mesh, odd):
        made.append(_made_up(float(len(made))))
        return made[-1]

    monkeypatch.setattr(_operator, "build", build)
    finger = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
    _operator.operator(finger, half=True)
    place = operator_cache.folder(operator_cache.identity(finger, odd=False))
    (kept,) = _operator.operator(finger, half=True).parts
    assert (kept.compliance.matrix, len(made)) == (0.0, 1)
    os.utime(place, (0, 0))
    read = _operator.read

    def late(where):
        assert time.time() - where.stat().st_mtime < DAY  # its use is noted before
        cache.remove(cache.entries())
        return read(where)

    monkeypatch.setattr(_operator, "read", late)
    (anew,) = _operator.operator(finger, half=True).parts
    assert (anew.compliance.matrix, len(made)) == (1.0, 2)
    assert place.is_dir()


def test_an_operator_is_known_by_the_mesh_that_it_was_built_on(root, monkeypatch):
    finger = ff.Finger(14.2, 10.2, resolution="coarse", tissue="maeno1998")
    shipped = store.load_or_build(
        ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998"), half=True
    )
    recipe = Recipe.of(finger)
    store.keep(shipped, recipe)
    prepared, other = _operator.solid, replace(shipped, points=1.001 * shipped.points)

    def late(*mesh):
        cache.remove(cache.entries())
        store.keep(other, recipe)  # by another process
        return prepared(*mesh)

    monkeypatch.setattr(_operator, "solid", late)
    monkeypatch.setattr(_operator, "build", lambda *mesh, odd: compliance)
    compliance = _made_up()
    old = store.sha256(finger)
    actual = _operator.operator(finger, half=True)
    assert old != store.sha256(finger)
    assert not operator_cache.available(finger, half=True)
    assert [expected["mesh_file_sha256"] for expected in actual.identities] == [old]


def _made_up(value=1.0):
    """Return a compliance that can be kept."""
    one = np.ones((1, 1))
    front = Eliminated(Front(0, 1, 1, np.arange(1), ()), one, one, one)
    return Compliance(np.arange(1), (front,), value * one)


def test_the_lock_of_a_process_that_was_killed_holds_up_nobody(root):
    pytest.importorskip("fcntl", reason="this system has no locks of files")
    killed = (
        "import os, signal, sys; from pathlib import Path; from fefinger.support import cache\n"
        "with cache.alone(Path(sys.argv[1])):\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    place, waited = root / "meshes" / "x.vtu", []
    assert subprocess.run([sys.executable, "-c", killed, str(place)]).returncode < 0
    (left,) = (root / "meshes").iterdir()
    with cache.alone(place, lambda: waited.append(left)):
        assert left.exists()
    assert not waited
    assert not left.exists()


def test_where_there_can_be_no_lock_nobody_waits(tmp_path):
    (tmp_path / "file").write_text("a file where the folder should be")
    place = tmp_path / "file" / "meshes" / "x.vtu"
    with cache.alone(place), cache.alone(place):
        pass
