"""Ctrl-C (SIGINT), SIGTERM and SIGHUP end the command line at once and leave nothing behind.

Python raises KeyboardInterrupt wherever the main thread happens to be. Inside numba, VTK, HDF5, a
callback or a destructor that is a crash, a stray message, or lost. So the command line blocks these
signals in every thread, and a watcher thread takes them: it ends child processes and removes
temporary files, which are registered here where they are made, then leaves by `os._exit`. Files
under final names are whole at any time, because they are moved there when they are complete.

Used as a library, fefinger installs nothing: Python's own KeyboardInterrupt works as always.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from typing import Final


INTERRUPTED: Final = 130
MESSAGE: Final = "interrupted; nothing was left half-written"

PATIENCE: Final = 5.0
"""Seconds that the watcher waits for files that are being moved into place."""

NAMES: Final = {"SIGINT": MESSAGE, "SIGTERM": "terminated; nothing was left half-written"}
"""Signals that end the process, and what it then says; SIGHUP has nobody left to read it."""

_actions: dict[object, Callable[[], object]] = {}
_advice: list[str] = []
_lock = threading.RLock()  # re-entrant: files are moved into place inside registered work


def interruptible(work: Callable[[], int]) -> int:
    """Run the `work` of the whole process and return its exit status, unless a signal ends it.

    The status is then 128 plus the number of the signal: 130 after Ctrl-C, 143 after SIGTERM. On
    Windows, which cannot block signals, KeyboardInterrupt is left to `work`.
    """
    watch(NAMES)
    try:
        return work()
    finally:
        with _lock:  # held for good by a watcher that is ending the process
            pass


def watch(said: dict[str, str] | None = None) -> None:
    """Block the signals in this thread and those it starts, and start the watcher.

    `said` has a sentence per signal name for standard error; by default nothing is printed.
    Signals that were ignored at the start, as under nohup, are still ignored.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        return
    taken = {number for number in _signals() if signal.getsignal(number) is not signal.SIG_IGN}
    signal.pthread_sigmask(signal.SIG_BLOCK, taken)
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    # Two ways lead to the watcher. A signal that every thread blocks waits for `sigwait`. One that
    # lands in a thread of a library that does not block it (OpenBLAS starts its own when numpy is
    # imported) is written to the pipe by the handler in C: a handler in Python would wait for the
    # main thread, which may be in compiled code.
    for number in taken:
        signal.signal(number, lambda number, frame: None)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)

    def forward() -> None:
        os.write(writer, bytes([signal.sigwait(taken)]))

    def read() -> None:
        number = 0
        while number not in taken:  # the handlers of others write their signals too
            number = os.read(reader, 1)[0]
        _end(number, said or {})

    for target in (forward, read):
        threading.Thread(target=target, name="signals", daemon=True).start()


def unblock() -> None:
    """Let the signals through again, in a child process that inherited their block."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _signals())


@contextmanager
def on_end(action: Callable[[], object]) -> Iterator[None]:
    """Have `action` called if a signal ends the process during the work inside, the last first.

    It runs in the watcher thread while the work goes on, and its exceptions are ignored.
    """
    key = object()
    with _lock:
        _actions[key] = action
    try:
        yield
    finally:
        with _lock:
            del _actions[key]


@contextmanager
def advice(text: str) -> Iterator[None]:
    """Say this instead of "nothing was left half-written" if a signal ends the work inside."""
    _advice.append(text)
    try:
        yield
    finally:
        _advice.remove(text)


def shielded() -> AbstractContextManager[object]:
    """Return a context that a signal does not end before its few milliseconds are over."""
    return _lock


def _signals() -> set[signal.Signals]:
    return {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}


def _end(number: int, said: dict[str, str]) -> None:
    """End the process: clean up, print the sentence of the signal, and leave with its status."""
    _lock.acquire(timeout=PATIENCE)  # and never released: no other thread registers or moves
    screen = _silence()
    for action in reversed(tuple(_actions.values())):
        with suppress(Exception):
            action()
    sentence = said.get(signal.Signals(number).name, "")
    if sentence:
        if _advice:
            sentence = f"{sentence.partition(';')[0]}; {_advice[-1]}"
        # A progress bar has hidden the cursor of a terminal.
        shown = "\033[?25h\r\033[K" if os.isatty(screen) else ""
        with suppress(OSError):  # standard error is closed
            os.write(screen, f"{shown}{sentence}\n".encode())
    os._exit(128 + number)


def _silence() -> int:
    """Return a copy of standard error, and let what other threads still print go nowhere."""
    with suppress(OSError, ValueError):
        sys.stderr.flush()
    try:
        screen = os.dup(2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    except OSError:
        return 2
    return screen
