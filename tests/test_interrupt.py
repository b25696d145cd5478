"""Ctrl-C ends the process with status 130, also where compiled code swallows it."""

import os
import signal
import subprocess
import sys
import time

import pytest


pytestmark = pytest.mark.skipif(os.name == "nt", reason="sends SIGINT")

SETUP = """
import os, signal, sys, time
from fefinger import interrupt
interrupt.GRACE = 0.2

def press():
    try:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(1)
    except KeyboardInterrupt:
        return
"""
WORKS = {
    "passed on": "press(); raise KeyboardInterrupt",
    "turned into another error": "press(); raise SystemError('with an exception set')",
    "lost": "press(); return 0",
    "lost in an endless loop": "press(); time.sleep(30)",
}


def run(work):
    code = f"{SETUP}\ndef work():\n    {work}\nsys.exit(interrupt.interruptible(work))\n"
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=20)


@pytest.mark.parametrize("work", WORKS.values(), ids=WORKS)
def test_an_interruption_ends_with_130_whatever_becomes_of_it(work):
    done = run(work)
    assert done.returncode == 130
    assert "Traceback" not in done.stderr


LOADING = """
library = {"__name__": "numba.core", "os": os, "signal": signal, "time": time}
exec('''
def load():
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(1e-3)
    print("loaded", flush=True)
''', library)
interrupt.GRACE = 15
"""


def test_compiled_code_is_loaded_to_its_end_before_an_interruption():
    """An exception inside of that ended one of twelve processes by SIGSEGV."""
    code = f"{SETUP}{LOADING}\ndef work():\n    library['load'](); time.sleep(10)\n"
    code += "sys.exit(interrupt.interruptible(work))\n"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=8)
    assert (done.returncode, done.stdout) == (130, "loaded\n")


@pytest.mark.parametrize("status", [0, 2])
def test_work_that_is_not_interrupted_keeps_its_status(status):
    assert run(f"return {status}").returncode == status


def test_an_error_without_an_interruption_is_passed_on():
    done = run("raise SystemError('a fault')")
    assert done.returncode == 1
    assert "SystemError: a fault" in done.stderr


CALIBRATE = """
import sys
from fefinger.calibration import jobs
from fefinger.finger import Finger
from fefinger.interrupt import interruptible

def work():
    options = {"finger": Finger.subject("a.h.")}
    jobs.run([jobs.Job(file, options) for file in sys.argv[1:]], workers=2)
    return 0

if __name__ == "__main__":
    sys.exit(interruptible(work))
"""
PATIENCE = 60.0
"""s that a process is waited for, before the test fails."""


def soon(what):
    """Return what a function gives once it no longer raises an OSError."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return what()
        except OSError:
            if time.monotonic() > end:
                raise
            time.sleep(0.05)


def gone(line):
    """Return whether nobody reads from a pipe, within PATIENCE."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        try:
            os.write(line, b"\n")
        except BrokenPipeError:
            return True
        time.sleep(0.05)
    return False


@pytest.mark.parametrize("end", ["SIGINT", "SIGKILL"])
def test_the_processes_of_a_calibration_end_with_it(end, tmp_path):
    """Each reads a record from a pipe that never ends."""
    files = [tmp_path / name for name in ("one.csv", "two.csv")]
    for file in files:
        os.mkfifo(file)
    with subprocess.Popen(
        [sys.executable, "-c", CALIBRATE, *map(str, files)],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # so that the signal is for one alone
    ) as running:
        wanted = os.O_WRONLY | os.O_NONBLOCK
        lines = [soon(lambda file=file: os.open(file, wanted)) for file in files]
        try:
            running.send_signal(getattr(signal, end))
            assert all(gone(line) for line in lines)
            status = running.wait(PATIENCE)
        finally:
            for line in lines:
                os.close(line)
            running.kill()
        said = running.stderr.read()
    assert status == (130 if end == "SIGINT" else -signal.SIGKILL)
    assert "Traceback" not in said
