"""Threads: fixed parts of a job on all cores, and BLAS on one thread each.

The parts and the order of their sums are fixed by the job, so that no result depends on how many
threads there are. BLAS is limited to one thread, for work on many small dense blocks: spinning idle
threads cost more than they save. Measured on two cores under other load: 6676 steps of contact took
13.5 s with the default number of threads and 1.3 s with one; the factor of the standard finger
3.4 s and 1.9 s.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from functools import cache, wraps
from typing import ParamSpec, TypeVar, cast

from threadpoolctl import ThreadpoolController

from fefinger.support.processes import threads


P = ParamSpec("P")
R = TypeVar("R")
Item = TypeVar("Item")


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
def _libraries() -> ThreadpoolController:
    """Find the loaded BLAS: that takes some 4 ms, and a small factor less."""
    import scipy.linalg  # noqa: F401 - has a BLAS of its own, found only once it is loaded

    return ThreadpoolController()


def together(work: Callable[[Item], R], parts: Sequence[Item]) -> list[R]:
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
