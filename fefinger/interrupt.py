"""Ctrl-C that ends the process with status 130 wherever it comes.

A KeyboardInterrupt alone is not enough: compiled code turns it into another exception, one that is
raised in a finalizer is lost, and one inside numba, as it loads or compiles, crashes the process.
"""

import _thread
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType


INTERRUPTED = 130
MESSAGE = "interrupted; nothing was left half-written"

GRACE = 3.0
"""Seconds that an interrupted process has to clean up, before it is ended as it stands."""

FRAGILE = "numba", "llvmlite"
SOON = 0.02
"""Seconds after which an interrupt that came in one of these libraries is tried again."""


def interruptible(work: Callable[[], int]) -> int:
    """Run the `work` of the whole process and return its exit status; ends it after Ctrl-C."""
    seen = threading.Event()

    def stop(signum: int, frame: FrameType | None) -> None:
        if not seen.is_set():
            seen.set()
            threading.Thread(target=_end_later, daemon=True).start()
        if _fragile(frame):
            threading.Thread(target=_again_soon, daemon=True).start()
            return
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, stop)
    try:
        status = work()
    except BaseException:
        if not seen.is_set():
            raise
        print(MESSAGE, file=sys.stderr)
        status = INTERRUPTED
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if seen.is_set():
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(INTERRUPTED)  # not sys.exit: the interpreter may end by the signal itself
    return status


def _fragile(frame: FrameType | None) -> bool:
    """Return whether a frame is called by a library that an exception from a signal crashes."""
    while frame is not None:
        if str(frame.f_globals.get("__name__")).partition(".")[0] in FRAGILE:
            return True
        frame = frame.f_back
    return False


def _again_soon() -> None:
    time.sleep(SOON)
    main = threading.main_thread().ident
    if hasattr(signal, "pthread_kill") and main is not None:
        signal.pthread_kill(main, signal.SIGINT)  # which also wakes what waits
    else:
        _thread.interrupt_main()


def _end_later() -> None:
    time.sleep(GRACE)
    os.write(2, f"{MESSAGE}\n".encode())
    os._exit(INTERRUPTED)
