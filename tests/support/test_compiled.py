"""Compiled functions: kept as long as their sources are the same, and said where they cannot be."""

import gc
import importlib
import os
import subprocess
import sys
from functools import partial

import numpy as np
import pytest
from fefinger.validation.problems.grids import box
from numba.core import event
from numba.core.errors import NumbaError

from fefinger.__main__ import main
from fefinger.contact.readout import readout
from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.linalg.multifrontal import _add_lower
from fefinger.fem.linalg.system import factor
from fefinger.neural.endorgans import respond_modes
from fefinger.neural.endorgans_compiled import between
from fefinger.result import Result
from fefinger.support import compiled
from fefinger.support.tensors import _extremes, extremes


SQUARE = """
from fefinger.support.compiled import njit, notice

@njit(cache=True, fastmath={"contract"})
def square(x):
    return x * x

print(square(3), notice().partition(",")[0])
"""


@pytest.fixture
def script(tmp_path):
    """Return a script in whose folder nothing compiled can be kept, also not by root."""
    (tmp_path / "__pycache__").write_text("a file where the folder should be")
    (tmp_path / "square.py").write_text(SQUARE)
    return tmp_path / "square.py"


def printed(script, cache, begin=None):
    """Run a script with the user's cache in a folder, and return what it prints.

    begin: a function that its process calls first.
    """
    environment = {**os.environ, "XDG_CACHE_HOME": str(cache), "NUMBA_CACHE_DIR": ""}
    command = [sys.executable, str(script)]
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, check=True, preexec_fn=begin
    )
    assert done.stderr == ""
    return done.stdout.strip()


def test_without_a_folder_code_is_compiled_every_time_and_it_is_said(script):
    assert printed(script, script) == "9 Compiled code could not be kept"


def test_code_is_kept_in_the_cache_where_that_can_be_written(script, tmp_path):
    assert printed(script, tmp_path / "cache") == "9"
    assert list((tmp_path / "cache").rglob("*.nbi"))


def test_code_that_finds_no_room_is_compiled_every_time_and_it_is_said(script, tmp_path):
    resource = pytest.importorskip("resource", reason="limits the size of files")
    room = partial(resource.setrlimit, resource.RLIMIT_FSIZE, (100, 100))  # bytes of a file
    assert printed(script, tmp_path / "cache", room) == "9 Compiled code could not be kept"


def test_functions_are_left_as_they_are_where_numba_is_told_to(script):
    env = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, str(script)], env=env, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["9"]


def test_no_garbage_is_collected_while_a_function_is_compiled():
    seen = []

    class Watch(event.Listener):
        def on_start(self, _):
            seen.append(gc.isenabled())

        def on_end(self, _):
            pass

    with event.install_listener("numba:compile", Watch()):
        assert compiled.njit()(lambda x: x + 1)(1) == 2
        with pytest.raises(NumbaError):
            compiled.njit()(lambda x: x.none)(1)
    assert seen == [False, False]
    assert gc.isenabled()


CALLER = """
from fefinger.support.compiled import njit
from pack.called import FACTOR, twice

@njit(cache=True)
def both(x):
    return FACTOR * twice(x)
"""

CALLED = """
from fefinger.support.compiled import njit
from pack import deep

FACTOR = 1

@njit(cache=True)
def twice(x):
    return deep.add(x, x)
"""

DEEP = """
from fefinger.support.compiled import njit

@njit(cache=True)
def add(x, y):
    return x + y
"""


def test_an_edit_of_an_imported_file_is_noticed(tmp_path, monkeypatch):
    """Of a constant, and of a function that a called function calls, as by an update."""
    (tmp_path / "pack").mkdir()
    monkeypatch.syspath_prepend(tmp_path)

    def answer(**texts):
        for name, text in texts.items():
            (tmp_path / "pack" / f"{name}.py").write_text(text)
        for name in [name for name in sys.modules if name.partition(".")[0] == "pack"]:
            del sys.modules[name]
        importlib.invalidate_caches()
        compiled._module.cache_clear()
        compiled._sources.cache_clear()
        both = importlib.import_module("pack.caller").both
        return both(3), sum(both.stats.cache_hits.values())

    assert answer(__init__="", caller=CALLER, called=CALLED, deep=DEEP) == (6, 0)
    assert answer() == (6, 1)
    assert answer(called=CALLED.replace("FACTOR = 1", "FACTOR = 50")) == (300, 0)
    assert answer(deep=DEEP.replace("x + y", "x + 2 * y")) == (450, 0)


def test_a_command_and_its_result_say_it(synthetic, answered, capsys, monkeypatch):
    assert main(["run", "flat-press"]) == 0
    assert "note:" not in capsys.readouterr().err
    monkeypatch.setattr(compiled, "_not_kept", [test_a_command_and_its_result_say_it])
    assert main(["run", "flat-press"]) == 0
    assert capsys.readouterr().err == f"note: {compiled.notice()}\n"
    again = Result.of(synthetic.scene, synthetic.plan, synthetic.response)
    assert compiled.notice() in again.notes


def test_arrays_of_any_layout_are_compiled_once():
    """Strided, by columns, or of one column, which counts as of either layout."""
    before = {each: set(each.signatures) for each in (_extremes, between, _add_lower)}
    tensors = np.random.default_rng(0).normal(size=(3, 3, 8))
    extremes(tensors.transpose(2, 0, 1))
    extremes(tensors.transpose(2, 0, 1).copy())
    time, columns = np.linspace(0.0, 1.0, 5), np.ones((5, 4))
    for given in (columns, np.asfortranarray(columns), columns[:, ::2]):
        respond_modes(1.0, np.array([1.0]), np.array([2.0]), time, given, time[1:])
    space = box(*3 * (np.linspace(0, 1, 5),))
    held = np.flatnonzero(np.repeat(space.node_points[:, 2] == 0, 3))
    factor(space, stiffness(space, {1: Elastic(5.0, 0.4)}), held)
    for function, known in before.items():
        assert len(set(function.signatures) - known) <= 1
    strains = np.ones((4, 2))
    moments = readout(np.ones(2), np.ones(2), np.ones((2, 2)).T, strains, np.float64).moments
    assert moments.flags.c_contiguous
