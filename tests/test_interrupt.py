"""Ctrl-C ends the process with status 130, also where compiled code swallows it."""

import os
import subprocess
import sys

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


@pytest.mark.parametrize("status", [0, 2])
def test_work_that_is_not_interrupted_keeps_its_status(status):
    assert run(f"return {status}").returncode == status


def test_an_error_without_an_interruption_is_passed_on():
    done = run("raise SystemError('a fault')")
    assert done.returncode == 1
    assert "SystemError: a fault" in done.stderr
