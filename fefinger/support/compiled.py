"""Functions that numba compiles, and keeps for later processes where a folder can be written."""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast


P = ParamSpec("P")
R = TypeVar("R")

_not_kept: list[Any] = []


def njit(**options: Any) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator that compiles a function with options of `numba.njit`.

    To type checkers it is the function as before.

    Where neither the folder of the package nor the user's cache can be written, `cache=True` is no
    error: every process compiles the function again, as `notice` says.
    """
    import numba

    def compiled(function: Callable[P, R]) -> Callable[P, R]:
        try:
            return cast(Callable[P, R], numba.njit(**options)(function))
        except RuntimeError:  # "cannot cache function"
            _not_kept.append(function)
            return cast(Callable[P, R], numba.njit(**(options | {"cache": False}))(function))

    return compiled


def callback(function: Callable[..., Any], numbers: int, results: int) -> Any:
    """Compile a function that compiled loops take as an argument.

    Its arguments are so many `numbers` and an array (n,), and it returns so many `results`.

    Raises
    ------
    TypeError
        A function that numba does not compile.
    """
    from numba import cfunc, float64, types
    from numba.core.errors import NumbaError

    signature = types.UniTuple(float64, results)(*[float64] * numbers, float64[::1])
    try:
        try:
            return cfunc(signature, cache=True)(function)
        except RuntimeError:  # no folder to keep it in, or no file, as in a console
            return cfunc(signature)(function)
    except NumbaError as error:
        raise TypeError(str(error).strip().partition("\n")[0]) from error


def notice() -> str:
    """Return a sentence where compiled functions cannot be kept, else ""."""
    if not _not_kept:
        return ""
    return (
        "Compiled code could not be kept, as neither the folder of the package nor the user's "
        "cache can be written: every process compiles it again, some 15 to 30 s; name a folder "
        "that can be written in the variable NUMBA_CACHE_DIR."
    )
