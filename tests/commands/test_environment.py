"""Environments in which the command line has to live: one sentence each, no traceback, no hang."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fefinger.__main__ import main
from fefinger.commands.cli import LEAST_MEMORY


resource = pytest.importorskip("resource", reason="limits of a process")

COMMAND = [sys.executable, "-m", "fefinger"]


def limited(megabytes):
    """Run `explain` with so much address space."""

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, 2 * (int(megabytes * 1e6),))

    words = [*COMMAND, "explain", "flat-press"]
    one_thread = {name: "1" for name in ("OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")}
    return subprocess.run(
        words,
        preexec_fn=limit,
        env={**os.environ, **one_thread},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_too_little_address_space_is_refused_and_enough_is_enough():
    for megabytes in (300, LEAST_MEMORY - 1):
        refused = limited(megabytes)
        assert (refused.returncode, refused.stdout) == (2, "")
        assert refused.stderr == (
            f"error: memory: expected an address space of at least {LEAST_MEMORY} MB, received a "
            f"limit of {megabytes} MB; raise it (ulimit -v)\n"
        )
    enough = limited(LEAST_MEMORY + 1)
    assert (enough.returncode, enough.stderr) == (0, "")


@pytest.mark.parametrize("limit", ["0", "abc", "\N{SUPERSCRIPT TWO}"])
def test_a_wrong_number_of_threads_is_refused_before_numba_reads_it(limit):
    words = [*COMMAND, "explain", "flat-press"]
    env = {**os.environ, "NUMBA_NUM_THREADS": limit}
    done = subprocess.run(words, env=env, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    said = "error: NUMBA_NUM_THREADS: expected a number of threads of at least 1, received "
    assert done.stderr == f"{said}{limit!r}\n"


@pytest.mark.parametrize(
    "error",
    [
        MemoryError("std::bad_alloc"),
        OSError(errno.ENOMEM, "Cannot allocate memory"),
        ImportError("libvtkCommonCore.so: failed to map segment from shared object"),
    ],
)
def test_memory_that_runs_out_is_a_sentence(error, monkeypatch, capsys):
    def load(*given):
        raise error

    monkeypatch.setattr("fefinger.scene.builtin.load", load)
    assert main(["explain", "flat-press"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("failed: memory ran out; ")
    assert err.count("\n") == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
@pytest.mark.parametrize("words", [["run", "nothing"], ["run", "--nothing"], ["scenes"]])
def test_an_error_keeps_its_status_where_it_cannot_be_told(words):
    with open("/dev/full", "w") as full:
        buffered = {**os.environ, "PYTHONUNBUFFERED": ""}  # what is left is written at the end
        command = [*COMMAND, *words]
        done = subprocess.run(command, stdout=full, stderr=full, env=buffered, check=False)
    assert done.returncode == 2


def test_figures_need_no_window(monkeypatch, capsys):
    """The variable is for windows, which no command opens by matplotlib."""
    monkeypatch.setenv("MPLBACKEND", "nonsense")
    assert main(["scenes"]) == 0
    capsys.readouterr()
    drawn = "from fefinger.view import figures\nwith figures.style(): figures.figure(1, 1)"
    subprocess.run([sys.executable, "-c", drawn], check=True)
