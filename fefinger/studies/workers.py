"""Who answers the scenes of a study: processes of this machine, or a Dask cluster."""

from collections.abc import Iterator, Sequence

from fefinger.studies.tasks import Answer, Task
from fefinger.support import processes
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.processes import cores


def answer(task: Task) -> Answer:
    """Run the scene of a task with one BLAS thread and measure it; an error is a sentence."""
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
    except Exception as error:  # of one scene: the others go on
        return {"error": f"unexpected {type(error).__name__}: {error}"}


def local(tasks: Sequence[Task], workers: int | None = None) -> Iterator[tuple[int, Answer]]:
    """Give the number of every task and its answer, as they come.

    They come from processes of this machine, by default one per core; one that dies costs the scene
    it was on.
    """
    for number, found in processes.each(answer, tasks, workers or cores()):
        yield number, {"error": str(found)} if isinstance(found, processes.Died) else found


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
