"""Child processes with the import path of this one, which end with it, and threads.

`each` is a process pool. That of `concurrent.futures` is not used: its processes need a guard in
the script that starts them, one that dies breaks the pool, and its semaphores outlive a process
that exits at once.

The parts that threads get and the order of their sums are fixed by the job, so that no result
depends on how many threads there are. BLAS is limited to one thread, for work on many small dense
blocks: spinning idle threads cost more than they save. Measured on two cores under other load: 6676
steps of contact took 13.5 s with the default number of threads and 1.3 s with one; the factor of
the standard finger 3.4 s and 1.9 s.
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
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from functools import cache, wraps
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, cast

from fefinger.support import interrupt, registry
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

Item = TypeVar("Item")
Value = TypeVar("Value")

SERVE = "from fefinger.support.processes import serve; serve()"

THREADS = "NUMBA_NUM_THREADS"
"""Variable of the environment that limits the threads of a process, as it does those of numba."""

GRACE = 2.0
"""Seconds that a child process has to end its own children and to remove its temporary files."""


def command(*words: str) -> list[str]:
    """Command line of a child: this Python, without its working folder on the import path."""
    return [sys.executable, "-P", *words]


def environment() -> dict[str, str]:
    """Environment of a child process: a copy of this one's, with its import path and plugins."""
    path = os.pathsep.join(entry or os.getcwd() for entry in sys.path)
    plugins = os.pathsep.join(sorted(registry.modules()))
    return {**os.environ, "PYTHONPATH": path, registry.PLUGINS: plugins}


@contextmanager
def running(words: Sequence[str], **options: Any) -> "Iterator[subprocess.Popen[Any]]":
    """Start a child process with options of `subprocess.Popen`; end it after the enclosed block.

    It also ends when a signal ends this process.
    """
    started: list[subprocess.Popen[Any]] = []
    with interrupt.on_end(lambda: end(*started)):
        # No child without an entry in the list, and none that a signal does not end.
        with interrupt.shielded(), interrupt.unblocked():
            started.append(subprocess.Popen(words, **options))
        try:
            yield started[0]
        finally:
            end(*started)


def end(*processes: "subprocess.Popen[bytes] | subprocess.Popen[str]") -> None:
    """Send SIGTERM, so that processes can clean up, and SIGKILL after GRACE seconds."""
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


class WorkerExit(Exception):
    """A worker process that ended before it returned its result; `status` is its exit status."""

    def __init__(self, status: int) -> None:
        super().__init__(
            f"the worker process ended with status {status}; -9 often means that memory ran out: "
            "use fewer --workers or a coarser mesh (finger.resolution)"
        )
        self.status = status


class Worker:
    """A child process that evaluates function calls, restarted after it has died.

    It has `threads` threads.
    """

    def __init__(self, threads: int = 1) -> None:
        self._opened, self._threads = ExitStack(), threads
        self._process = self._started()

    def start(self, function: Callable[[Item], object], item: Item) -> None:
        """Start the evaluation of `function(item)` in the child; `wait` returns its value.

        The function must be picklable, as in a module.
        """
        if self._process.poll() is not None:
            self._process = self._started()
        requests = self._process.stdin
        assert requests is not None
        with suppress(OSError):  # it has ended, as `wait` will say
            # Bytes in bytes: what the child cannot import is a reply there, and not half a call.
            pickle.dump(pickle.dumps((function, item)), requests)
            requests.flush()

    def wait(self) -> Any:
        """Return the value of what was started.

        Raises what the function raises, and WorkerExit where the process ends meanwhile.
        """
        replies = self._process.stdout
        assert replies is not None
        with suppress(OSError, EOFError, pickle.UnpicklingError):
            done, value = pickle.load(replies)
            if done:
                return value
            raise value
        raise WorkerExit(self._process.wait())

    def end(self) -> None:
        """End the process, also during a call."""
        self._opened.close()

    def _started(self) -> "subprocess.Popen[bytes]":
        """Start a process in place of the last one, in a session that Ctrl-C does not reach."""
        self._opened.close()
        return self._opened.enter_context(
            running(
                command("-c", SERVE),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=environment() | {"OPENBLAS_NUM_THREADS": "1", THREADS: str(self._threads)},
                start_new_session=True,
            )
        )


def serve() -> None:
    """Run the main loop of a worker process: evaluate calls from standard input until it is closed.

    The system closes it when the parent ends in any way. What a call prints goes to standard error.
    """
    interrupt.watch()
    calls: SimpleQueue[bytes] = SimpleQueue()

    def listen() -> None:
        with suppress(EOFError, OSError):
            while True:
                calls.put(pickle.load(sys.stdin.buffer))
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=listen, daemon=True).start()
    out = sys.stdout.buffer
    with contextlib.redirect_stdout(sys.stderr):
        while True:
            call = calls.get()
            try:
                function, item = pickle.loads(call)
                reply = pickle.dumps((True, function(item)))
            except Exception as error:
                reply = pickle.dumps((False, error))
            with suppress(BrokenPipeError):  # the parent is gone
                out.write(reply)
                out.flush()


@contextmanager
def in_background(function: Callable[[Item], Value], item: Item) -> Iterator[Callable[[], Value]]:
    """Evaluate `function(item)` in a process of its own; yield a function that waits for it.

    It returns or raises as `Worker.wait`. The process ends with the block.
    """
    worker = Worker()
    try:
        worker.start(function, item)
        yield worker.wait
    finally:
        worker.end()


def each(
    function: Callable[[Item], Value], items: Sequence[Item], workers: int
) -> Iterator[tuple[int, Value | WorkerExit]]:
    """Evaluate `function` for all items in `workers` processes; yield (index, value) as they come.

    The value is a WorkerExit where the process ended; any other exception of the function ends all
    processes and is raised here.
    """
    team = [Worker(max(cores() // workers, 1)) for _ in range(min(workers, len(items)))]
    free: SimpleQueue[Worker] = SimpleQueue()
    for worker in team:
        free.put(worker)

    def one(item: Item) -> Value | WorkerExit:
        worker = free.get()
        try:
            worker.start(function, item)
            value: Value = worker.wait()
            return value
        except WorkerExit as error:
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
    """Count the processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def threads() -> int:
    """Count the threads that computations of this process may use: its cores, or fewer by THREADS.

    Raises InputError if THREADS is no positive number.
    """
    limit = os.environ.get(THREADS, "")
    if not limit:
        return cores()
    if not limit.isdecimal() or not int(limit):
        msg = f"{THREADS}: expected a number of threads of at least 1, received {limit!r}"
        raise InputError(msg)
    return min(cores(), int(limit))


P = ParamSpec("P")
R = TypeVar("R")
Part = TypeVar("Part")


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate `function` to run with one BLAS thread."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        with one_blas_thread():
            return function(*args, **kwargs)

    return limited


def one_blas_thread() -> AbstractContextManager[object]:
    """Return a context in which BLAS has one thread."""
    return cast(AbstractContextManager[object], _libraries().limit(limits=1, user_api="blas"))


@cache
def _libraries() -> "ThreadpoolController":
    """Find the loaded BLAS: that takes some 4 ms, and a small factor less."""
    # Imported here, so that the command line loads without them.
    import scipy.linalg  # noqa: F401 - has a BLAS of its own, found only once it is loaded
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def together(work: Callable[[Part], R], parts: Sequence[Part]) -> list[R]:
    """Return the values of `work` for all parts, in order, evaluated in all threads.

    The work should release Python's lock most of the time, as compiled loops and BLAS do. This
    thread takes parts too, and helpers only what is left, so that parts may have parts of their
    own.
    """
    helpers = min(threads(), len(parts)) - 1
    if helpers < 1:
        return [work(part) for part in parts]
    left = iter(enumerate(parts))  # shared: each thread takes the next one
    values: dict[int, R] = {}

    def take() -> None:
        for number, part in left:
            values[number] = work(part)

    started = [_pool().submit(take) for _ in range(helpers)]
    try:
        take()
    finally:
        for _ in left:  # where it failed, nothing more is begun
            pass
        ended = [helper for helper in started if not helper.cancel()]
        for helper in ended:
            helper.exception()
    for helper in ended:
        helper.result()
    return [values[number] for number in range(len(parts))]


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(threads() - 1, 1), thread_name_prefix="elements")
