"""Ctrl-C and SIGTERM end the command line at once, whatever it is doing, and leave nothing."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import interrupts
import pytest

import fefinger


pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")

SETUP = """
import ctypes, os, signal, sys, threading, time
from pathlib import Path
from fefinger.support import atomic_write, interrupt, processes

def press(name="SIGINT"):
    os.kill(os.getpid(), getattr(signal, name))

earlier = threading.Event()  # the thread of a library, started before signals are blocked
threading.Thread(target=lambda: earlier.wait() and time.sleep(30), daemon=True).start()

class Last:
    def __del__(self):
        press(); time.sleep(30)
"""


@pytest.fixture(autouse=True, scope="module")
def _signals_that_are_not_ignored():
    interrupts.stop_ignoring()


PLACES = {
    "in a loop": "press(); time.sleep(30)",
    "where errors are swallowed": "press()\n    try:\n        time.sleep(30)\n    except: pass",
    "in a destructor": "x = Last(); del x; time.sleep(30)",
    "in compiled code": "press(); ctypes.CDLL(None).sleep(30)",
    "in a callback of compiled code": (
        "kind = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)\n"
        "    def compare(a, b): press(); time.sleep(30); return 0\n"
        "    ctypes.CDLL(None).qsort((ctypes.c_int * 2)(), 2, 4, kind(compare))"
    ),
    "in another thread": "threading.Thread(target=press).start(); time.sleep(30)",
    "in a thread that does not block it": "earlier.set(); press(); ctypes.CDLL(None).sleep(30)",
    "where a library let signals through": (
        "signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT}); press(); time.sleep(30)"
    ),
}


def run(work, **options):
    code = f"{SETUP}\ndef work():\n    {work}\nsys.exit(interrupt.interruptible(work))\n"
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, timeout=20, **options)


@pytest.mark.parametrize("work", PLACES.values(), ids=PLACES)
def test_an_interruption_ends_with_130_and_a_sentence_wherever_it_comes(work):
    done = run(work)
    assert (done.returncode, done.stderr) == (130, interrupts.SENTENCES[130])


@pytest.mark.parametrize("name", ["SIGINT", "SIGHUP"])
def test_a_signal_that_was_ignored_before_is_ignored(name):
    """As under nohup, or in a job that a script runs in the background."""
    code = f"{SETUP}\nsignal.signal(signal.{name}, signal.SIG_IGN)\n"
    code += f"def work():\n    press({name!r}); time.sleep(0.2); return 0\n"
    code += "sys.exit(interrupt.interruptible(work))\n"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=20)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(("name", "status"), [("SIGTERM", 143), ("SIGHUP", 129)])
def test_other_signals_that_end_a_process_do_the_same(name, status):
    done = run(f"press({name!r}); time.sleep(30)")
    assert (done.returncode, done.stderr) == (status, interrupts.SENTENCES.get(status, ""))


def test_what_the_main_thread_still_prints_goes_nowhere():
    """A temporary file that is taken from under it makes an error of what it was doing."""
    work = (
        "with atomic_write.temporary_folder(sys.argv[0] and '.') as folder:\n"
        "        press()\n"
        "        while folder.exists(): time.sleep(1e-4)\n"
        "        print('lost', file=sys.stderr, flush=True)\n"
        "        (folder / 'more').write_text('')"
    )
    done = run(work)
    assert (done.returncode, done.stderr) == (130, interrupts.SENTENCES[130])


def test_files_that_are_being_moved_into_place_are_moved_before_the_end(tmp_path):
    work = (
        "with interrupt.shielded():\n"
        "        press(); time.sleep(0.3)\n"
        "        Path('whole').write_text('all of it')\n"
        "    time.sleep(30)"
    )
    assert run(work, cwd=tmp_path).returncode == 130
    assert (tmp_path / "whole").read_text() == "all of it"


def test_temporary_files_and_children_go_the_last_first(tmp_path):
    work = (
        "temporary, in_place = atomic_write.temporary_folder, atomic_write.in_place\n"
        "    with temporary('.') as folder, in_place('a.txt') as new:\n"
        "        new.write_text('half'); (folder / 'b').write_text('')\n"
        "        code = 'import time; time.sleep(60)'\n"
        "        with processes.running(processes.command('-c', code)) as child:\n"
        "            print(child.pid, flush=True); press(); time.sleep(30)"
    )
    done = run(work, cwd=tmp_path)
    assert done.returncode == 130
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(ProcessLookupError):
        os.kill(int(done.stdout), 0)


def test_a_child_is_ended_by_the_signals_that_its_parent_blocks():
    """Also before it runs any code of its own: it would else be killed, with what it made left."""
    work = (
        "mask = 'import signal; print(len(signal.pthread_sigmask(signal.SIG_BLOCK, [])))'\n"
        "    with processes.running(processes.command('-c', mask)) as child: child.wait()\n"
        "    print(len(signal.pthread_sigmask(signal.SIG_BLOCK, [])))"
    )
    assert run(work).stdout.split() == ["0", "3"]


def test_advice_takes_the_place_of_the_ordinary_sentence():
    done = run("with interrupt.advice('go on'):\n        press(); time.sleep(30)")
    assert done.stderr == "interrupted; go on\n"


@pytest.mark.parametrize("status", [0, 2])
def test_work_that_is_not_interrupted_keeps_its_status(status):
    assert run(f"return {status}").returncode == status


def test_an_error_without_an_interruption_is_passed_on():
    done = run("raise SystemError('a fault')")
    assert done.returncode == 1
    assert "SystemError: a fault" in done.stderr


def test_ctrl_c_before_signals_are_blocked_is_a_sentence_too():
    """The module that blocks them is interrupted while it is imported."""
    code = """
import sys
class Pressed:
    def find_spec(self, name, *rest):
        if name == "fefinger.support.interrupt":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Pressed())
import fefinger.__main__
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "interrupted; nothing was begun\n"


@pytest.mark.parametrize("step", ["_open_streams", "interruptible"])
def test_ctrl_c_while_signals_are_being_blocked_is_a_sentence_too(step):
    code = f"""
import fefinger.__main__ as it
def pressed(*given):
    raise KeyboardInterrupt
it.{step} = pressed
raise SystemExit(it.main())
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "interrupted; nothing was begun\n"


def test_the_package_imports_nothing_of_others_before_signals_can_be_blocked():
    """Ctrl-C in such an import ends in a traceback: no code runs yet that could catch it."""
    code = f"""
import sys
sys.path.insert(0, {os.fspath(Path(fefinger.__file__).parents[1])!r})
class Others:
    def find_spec(self, name, *rest):
        if name.partition(".")[0] != "fefinger":
            raise SystemError(name)
sys.meta_path.insert(0, Others())
import fefinger
"""
    subprocess.run([sys.executable, "-S", "-E", "-c", code], check=True)


def test_a_library_leaves_ctrl_c_to_python():
    code = "import fefinger as ff, signal\nff.Finger\nprint(signal.getsignal(2).__name__)\n"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "default_int_handler\n"


DRAWS = {"run": 1, "mesh": 1, "study": 1, "calibrate": 1, "validate": 1}


@pytest.mark.parametrize("name", DRAWS)
def test_a_command_that_is_interrupted_leaves_nothing_behind(name):
    """One draw of each; `python tests/interrupts.py` makes two hundred."""
    drawn = random.Random(name)
    after = drawn.uniform(0, interrupts.COMMANDS[name].seconds / 3)
    outcome = interrupts.draw(name, after, drawn.choice([signal.SIGINT, signal.SIGTERM]))
    assert not outcome.wrong


READ = """
import sys
sys.path.insert(0, sys.argv[1])
import process_calls
from fefinger.support import processes
from fefinger.support.interrupt import interruptible

def work():
    list(processes.each(process_calls.read, sys.argv[2:], workers=2))
    return 0

sys.exit(interruptible(work))
"""
PATIENCE = 60.0
"""s that a process is waited for, before the test fails."""


def soon(what):
    """Call a function until it raises no OSError, and return its value."""
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
def test_the_workers_of_a_process_end_with_it(end, tmp_path):
    """Each reads from a pipe that never ends."""
    files = [tmp_path / name for name in ("one.csv", "two.csv")]
    for file in files:
        os.mkfifo(file)
    with subprocess.Popen(
        [sys.executable, "-c", READ, str(Path(__file__).parents[1]), *map(str, files)],
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
        message = running.stderr.read()
    assert status == (130 if end == "SIGINT" else -signal.SIGKILL)
    assert "Traceback" not in message
