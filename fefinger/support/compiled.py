"""Functions that numba compiles, and keeps for later processes where a folder can be written."""

from collections.abc import Callable
from typing import Any


_not_kept: list[Any] = []


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function with options of `numba.njit`.

    Where neither the folder of the package nor the user's cache can be written, `cache=True` is no
    error: every process compiles the function again, as `notice` says.
    """
    import numba

    def compiled(function: Callable[..., Any]) -> Any:
        try:
            return numba.njit(**options)(function)
        except RuntimeError:  # "cannot cache function"
            _not_kept.append(function)
            return numba.njit(**(options | {"cache": False}))(function)

    return compiled


def notice() -> str:
    """Return a sentence where compiled functions cannot be kept, else ""."""
    if not _not_kept:
        return ""
    return (
        "Compiled code could not be kept, as neither the folder of the package nor the user's "
        "cache can be written: every process compiles it again, some 15 to 30 s; name a folder "
        "that can be written in the variable NUMBA_CACHE_DIR."
    )
