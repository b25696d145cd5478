"""Run the scenes of a study in processes of this machine or on a Dask cluster."""

from collections.abc import Iterator, Sequence

from fefinger.studies.tasks import Answer, Task
from fefinger.support import processes
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.processes import cores


def answer(task: Task) -> Answer:
    """Run the scene of a task with one BLAS thread; return its rows, or its error as a sentence."""
    try:
        from threadpoolctl import threadpool_limits

        from fefinger.pipeline import run
        from fefinger.scene.scene import Scene
        from fefinger.studies.measures import rows

        with threadpool_limits(1, user_api="blas"):
            result = run(Scene.from_dict(task["scene"]), mechanics=task["mechanics"])
            return {"rows": rows(result, forces=task["forces"], depths=task["depths"])}
    except (InputError, ConvergenceError) as error:
        return {"error": str(error)}
    except Exception as error:  # an error of one scene must not stop the others
        return {"error": f"unexpected {type(error).__name__}: {error}"}


def local(tasks: Sequence[Task], workers: int | None = None) -> Iterator[tuple[int, Answer]]:
    """Run tasks in local processes; yield the number and answer of each as it finishes.

    By default one process per core; a process that dies loses only its current scene.
    """
    for number, outcome in processes.each(answer, tasks, workers or cores()):
        if isinstance(outcome, processes.WorkerExit):
            outcome = {"error": str(outcome)}
        yield number, outcome


def cluster(tasks: Sequence[Task], address: str) -> Iterator[tuple[int, Answer]]:
    """Run tasks on the Dask cluster at `address`; yield as `local`.

    Raises
    ------
    InputError
        Without the extra `distributed`, or a scheduler at that address.
    """
    try:
        from dask.distributed import Client
        from dask.distributed import as_completed as completed
    except ImportError as error:
        raise InputError(
            "--scheduler: expected the extra 'distributed' to be installed, "
            f"received {error}; pip install 'fefinger[distributed]'"
        ) from None
    try:
        client = Client(address)
    except (OSError, ValueError) as error:
        raise InputError(
            "--scheduler: expected the address of a Dask scheduler, such as tcp://host:8786, "
            f"received {address!r} ({error})"
        ) from None
    with client:
        futures = {client.submit(answer, task, pure=False): i for i, task in enumerate(tasks)}
        for done in completed(futures):
            failure = done.exception()
            lost = {"error": f"the cluster lost this scene: {failure}"}
            yield futures[done], lost if failure else done.result()
