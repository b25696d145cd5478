"""Signal handling of the command line: SIGINT, SIGTERM and SIGHUP clean up and end the process.

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


INTERRUPTED: Final = 130  # 128 + SIGINT, as shells have it
MESSAGE: Final = "interrupted; nothing was left half-written"

NAMES: Final = {"SIGINT": MESSAGE, "SIGTERM": "terminated; nothing was left half-written"}
"""Signals that end the process, with the message; after SIGHUP there is no terminal to read one."""

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


def watch(messages: dict[str, str] | None = None) -> None:
    """Block the signals in this thread and those it starts, and start the watcher.

    `messages` are printed on standard error, by signal name; by default nothing is printed.
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
        _end(number, messages or {})

    for target in (forward, read):
        threading.Thread(target=target, name="signals", daemon=True).start()


@contextmanager
def unblocked() -> Iterator[None]:
    """Let the signals through for a moment: a process that is started then does not block them.

    A signal that comes meanwhile reaches the watcher by its handler.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_UNBLOCK, _signals())
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def on_end(action: Callable[[], object]) -> Iterator[None]:
    """Register `action` to run if a signal ends the process during the enclosed block.

    Actions run in the watcher thread, the last registered first, while the work goes on; their
    exceptions are ignored.
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
    """Replace "nothing was left half-written" in the message of a signal during the block."""
    _advice.append(text)
    try:
        yield
    finally:
        _advice.remove(text)


def shielded() -> AbstractContextManager[object]:
    """Context of a few milliseconds during which a signal does not end the process."""
    return _lock


def _signals() -> set[signal.Signals]:
    return {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}


def _end(number: int, messages: dict[str, str]) -> None:
    """Clean up, print the message of the signal and exit with status 128 + number."""
    patience = 5.0  # seconds that the watcher waits for files that are being moved into place
    _lock.acquire(timeout=patience)  # and never released: no other thread registers or moves
    screen = _silence()
    for action in reversed(tuple(_actions.values())):
        with suppress(Exception):
            action()
    sentence = messages.get(signal.Signals(number).name, "")
    if sentence:
        if _advice:
            sentence = f"{sentence.partition(';')[0]}; {_advice[-1]}"
        # A progress bar has hidden the cursor of a terminal.
        shown = "\033[?25h\r\033[K" if os.isatty(screen) else ""
        with suppress(OSError):  # standard error is closed
            os.write(screen, f"{shown}{sentence}\n".encode())
    os._exit(128 + number)


def _silence() -> int:
    """Redirect standard error to the null device, for other threads; return a copy of it."""
    with suppress(OSError, ValueError):
        sys.stderr.flush()
    try:
        screen = os.dup(2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    except OSError:
        return 2
    return screen
