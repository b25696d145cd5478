"""Limit BLAS to one thread, for work on many small dense blocks.

Spinning idle threads cost more than they save. Measured on two cores under other load: 6676 steps
of contact took 13.5 s with the default number of threads and 1.3 s with one; the factor of the
standard finger 3.4 s and 1.9 s.
"""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits


P = ParamSpec("P")
R = TypeVar("R")


def one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate `function` to run with one BLAS thread."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        with threadpool_limits(1, user_api="blas"):
            return function(*args, **kwargs)

    return limited
