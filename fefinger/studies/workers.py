"""Who answers the scenes of a study: processes of this machine, or a Dask cluster.

A process reads tasks and writes answers as lines of JSON: one that dies costs the scene it was on,
and it ends by itself when its parent is gone. It needs no guard in the script that starts it.
"""

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from queue import SimpleQueue

from fefinger import beside
from fefinger.checks import ConvergenceError, InputError
from fefinger.cores import cores
from fefinger.studies.tasks import Answer, Task


SERVE = "from fefinger.studies.workers import serve; serve()"


def answer(task: Task) -> Answer:
    """Run the scene of a task with one BLAS thread and measure it; an error is a sentence."""
    try:
        from threadpoolctl import threadpool_limits

        from fefinger.run import run
        from fefinger.scene import Scene
        from fefinger.studies.measures import rows

        with threadpool_limits(1, user_api="blas"):
            result = run(Scene.from_dict(task["scene"]), mechanics=task["mechanics"])
            return {"rows": rows(result, forces=task["forces"], depths=task["depths"])}
    except (InputError, ConvergenceError) as error:
        return {"error": str(error)}
    except Exception as error:  # of one scene: the others go on
        return {"error": f"unexpected {type(error).__name__}: {error}"}


def serve() -> None:
    """Answer tasks, one a line on standard input; other prints go to standard error."""
    out = sys.stdout
    with contextlib.redirect_stdout(sys.stderr):
        for line in sys.stdin:
            told = json.dumps(answer(json.loads(line)))
            try:
                out.write(told + "\n")
                out.flush()
            except BrokenPipeError:  # the parent is gone, which has told why
                os._exit(1)


class Worker:
    """A process that answers one task after the other, started again when it has died."""

    def __init__(self) -> None:
        self._process = self._started()

    def ask(self, task: Task) -> Answer:
        """Return the answer to a task."""
        if self._process.poll() is not None:
            self.end()
            self._process = self._started()
        given, told = self._process.stdin, self._process.stdout
        assert given is not None
        assert told is not None
        line = ""
        with contextlib.suppress(OSError):
            given.write(json.dumps(task) + "\n")
            given.flush()
            line = told.readline()
        return json.loads(line) if line else {"error": self._end()}

    def end(self) -> None:
        """End the process, whatever it is doing."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError):  # what was not read yet
                pipe.close()

    def _end(self) -> str:
        status = self._process.wait()
        return (
            f"the process that answered it ended with status {status}; -9 often means that memory "
            "ran out: take fewer --workers or a coarser mesh (finger.resolution)"
        )

    @staticmethod
    def _started() -> "subprocess.Popen[str]":
        """Start a process that imports what this one does, and that Ctrl-C does not reach."""
        return subprocess.Popen(
            beside.command("-c", SERVE),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=beside.environment() | {"OPENBLAS_NUM_THREADS": "1"},
            start_new_session=True,
        )


def local(tasks: Sequence[Task], workers: int | None = None) -> Iterator[tuple[int, Answer]]:
    """Give the number of every task and its answer, as they come.

    They come from processes of this machine, by default one per core.
    """
    team = [Worker() for _ in range(min(workers or cores(), len(tasks)))]
    free: SimpleQueue[Worker] = SimpleQueue()
    for worker in team:
        free.put(worker)

    def one(task: Task) -> Answer:
        worker = free.get()
        try:
            return worker.ask(task)
        finally:
            free.put(worker)

    pool = ThreadPoolExecutor(max(len(team), 1))
    try:
        futures = {pool.submit(one, task): number for number, task in enumerate(tasks)}
        for done in as_completed(futures):
            yield futures[done], done.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in team:
            worker.end()


def cluster(tasks: Sequence[Task], address: str) -> Iterator[tuple[int, Answer]]:
    """Give the same from the workers of the Dask scheduler at `address`.

    Raises
    ------
    InputError
        Without the extra `distributed`, or a scheduler at that address.
    """
    try:
        from dask.distributed import Client
        from dask.distributed import as_completed as completed
    except ImportError as error:
        msg = (
            "--scheduler: expected the extra 'distributed' to be installed, "
            f"received {error}; pip install 'fefinger[distributed]'"
        )
        raise InputError(msg) from None
    try:
        client = Client(address)
    except (OSError, ValueError) as error:
        msg = f"--scheduler: expected a Dask scheduler at {address!r}, received: {error}"
        raise InputError(msg) from None
    with client:
        futures = {client.submit(answer, task, pure=False): i for i, task in enumerate(tasks)}
        for done in completed(futures):
            lost = done.exception()
            found = {"error": f"the cluster lost it: {lost}"} if lost else done.result()
            yield futures[done], found
