"""Child processes of Python that import what this process does, and that end with it.

`each` is a pool of them. It is not that of `concurrent.futures`, because its processes need a guard
in the script that starts them, one that dies takes the others with it, and its semaphores outlive a
process that is ended at once.
"""

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import ExitStack, contextmanager, suppress
from queue import SimpleQueue
from typing import Any, TypeVar

from fefinger.support import interrupt


Item = TypeVar("Item")
Value = TypeVar("Value")

SERVE = "from fefinger.support.processes import serve; serve()"

GRACE = 2.0
"""Seconds that a child process has to end its own children and to remove its temporary files."""


def command(*words: str) -> list[str]:
    """Return the command of one: this Python, that takes nothing from the folder it starts in."""
    return [sys.executable, "-P", *words]


def environment() -> dict[str, str]:
    """Return its environment: this one's, with what this process imports from."""
    path = os.pathsep.join(entry or os.getcwd() for entry in sys.path)
    return {**os.environ, "PYTHONPATH": path}


@contextmanager
def running(words: Sequence[str], **options: Any) -> "Iterator[subprocess.Popen[Any]]":
    """Start a child process, by the options of `subprocess.Popen`, and end it after the work.

    It also ends when a signal ends this process.
    """
    started: list[subprocess.Popen[Any]] = []
    with interrupt.on_end(lambda: end(*started)):
        with interrupt.shielded():  # no child without an entry in the list
            started.append(subprocess.Popen(words, **options))
        try:
            yield started[0]
        finally:
            end(*started)


def end(*processes: "subprocess.Popen[Any]") -> None:
    """End processes: SIGTERM, so that they can clean up, and SIGKILL after GRACE seconds."""
    for process in processes:
        with suppress(OSError):
            process.terminate()
    for process in processes:
        try:
            process.wait(GRACE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        for pipe in (process.stdin, process.stdout, process.stderr):
            if pipe is not None:
                with suppress(OSError):  # what was not read yet
                    pipe.close()


class Died(Exception):
    """A worker that ended before it had answered; `status` is its exit status."""

    def __init__(self, status: int) -> None:
        super().__init__(
            f"the process that answered it ended with status {status}; -9 often means that memory "
            "ran out: take fewer --workers or a coarser mesh (finger.resolution)"
        )
        self.status = status


class Worker:
    """A process that calls one function after the other, started again when it has died."""

    def __init__(self) -> None:
        self._opened = ExitStack()
        self._process = self._started()

    def call(self, function: Callable[[Item], Value], item: Item) -> Value:
        """Return `function(item)`; both are pickled, so the function is one of a module.

        Raises what it raises, and Died where the process ends meanwhile.
        """
        if self._process.poll() is not None:
            self._process = self._started()
        given, told = self._process.stdin, self._process.stdout
        assert given is not None
        assert told is not None
        with suppress(OSError, EOFError, pickle.UnpicklingError):
            pickle.dump((function, item), given)
            given.flush()
            done, value = pickle.load(told)
            if done:
                return value
            raise value
        raise Died(self._process.wait())

    def end(self) -> None:
        """End the process, whatever it is doing."""
        self._opened.close()

    def _started(self) -> "subprocess.Popen[bytes]":
        """Start a process in place of the one before; Ctrl-C in a terminal does not reach it."""
        self._opened.close()
        return self._opened.enter_context(
            running(
                command("-c", SERVE),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=environment() | {"OPENBLAS_NUM_THREADS": "1"},
                start_new_session=True,
            )
        )


def serve() -> None:
    """Be a Worker: answer calls from standard input, and end when that is closed.

    It is when the parent is gone, however that ended. Other prints go to standard error.
    """
    interrupt.watch()
    calls: SimpleQueue[tuple[Callable[[Any], Any], Any]] = SimpleQueue()

    def listen() -> None:
        with suppress(EOFError, OSError):
            while True:
                calls.put(pickle.load(sys.stdin.buffer))
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=listen, daemon=True).start()
    out = sys.stdout.buffer
    with contextlib.redirect_stdout(sys.stderr):
        while True:
            function, item = calls.get()
            try:
                told = pickle.dumps((True, function(item)))
            except Exception as error:
                told = pickle.dumps((False, error))
            with suppress(BrokenPipeError):  # the parent is gone
                out.write(told)
                out.flush()


def each(
    function: Callable[[Item], Value], items: Sequence[Item], workers: int
) -> Iterator[tuple[int, Value | Died]]:
    """Give the number of every item and `function(item)`, as they come, from so many processes.

    Died stands for the value of an item on which a process ended; another exception of the function
    ends all of them and is raised here.
    """
    team = [Worker() for _ in range(min(workers, len(items)))]
    free: SimpleQueue[Worker] = SimpleQueue()
    for worker in team:
        free.put(worker)

    def one(item: Item) -> Value | Died:
        worker = free.get()
        try:
            return worker.call(function, item)
        except Died as error:
            return error
        finally:
            free.put(worker)

    pool = ThreadPoolExecutor(max(len(team), 1))
    try:
        futures = {pool.submit(one, item): number for number, item in enumerate(items)}
        for done in as_completed(futures):
            yield futures[done], done.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in team:
            worker.end()


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
