"""Functions that numba compiles, and keeps for later processes where a folder can be written."""

import gc
import re
import sys
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, ParamSpec, TypedDict, TypeVar, Unpack, cast


P = ParamSpec("P")
R = TypeVar("R")

IMPORTS = re.compile(r"^(?:from|import) +([\w.]+)(?: +import +(\([^)]*\)|.*))?", re.MULTILINE)

_not_kept: list[Any] = []


class NumbaOptions(TypedDict, total=False):
    """The options of `numba.njit` that the package uses."""

    cache: bool
    nogil: bool
    inline: str
    forceinline: bool
    fastmath: bool | set[str]
    error_model: str


def njit(**options: Unpack[NumbaOptions]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator that compiles a function with options of `numba.njit`.

    To type checkers it is the function as before.

    Where neither the folder of the package nor the user's cache can be written, or the disk is
    full, `cache=True` is no error: every process compiles the function again, as `notice` says.
    What was kept counts as long as the file of the function and the files of its package that it
    imports are the same.
    """
    import numba

    _pause_collections()
    decorator: Any = numba.njit  # whose stubs do not know all of its options
    # Without the entry for callers in C, which nothing has: it takes some 6 % of the time.
    given: dict[str, object] = {"no_cfunc_wrapper": True, **options}

    def compiled(function: Callable[P, R]) -> Callable[P, R]:
        try:
            kept = decorator(**given)(function)
        except RuntimeError:  # "cannot cache function"
            _not_kept.append(function)
            return cast(Callable[P, R], decorator(**(given | {"cache": False}))(function))
        if options.get("cache") and hasattr(kept, "_cache"):  # not where NUMBA_DISABLE_JIT is set
            # numba looks at the file of the function alone, and not at what it calls: after an
            # update of the package old code of an imported function would go on in silence.
            kept._cache._cache_file._source_stamp = _sources(function.__module__)
            kept._cache.save_overload = _unless_full(kept._cache.save_overload, function)
        return cast(Callable[P, R], kept)

    return compiled


def _unless_full(save: Callable[..., None], function: object) -> Callable[..., None]:
    """Let numba go on where it cannot save what it has compiled."""

    def attempt(*compiled: object) -> None:
        try:
            save(*compiled)
        except OSError:
            _not_kept.append(function)

    return attempt


@cache
def _pause_collections() -> None:
    """Let numba compile without collections of garbage, which take a tenth of its time."""
    from numba.core import event

    class Pause(event.Listener):
        depth, enabled = 0, False  # numba holds a lock from start to end

        def on_start(self, _: object) -> None:
            if self.depth == 0:
                self.enabled = gc.isenabled()
                gc.disable()
            self.depth += 1

        def on_end(self, _: object) -> None:
            self.depth -= 1
            if self.depth == 0 and self.enabled:
                gc.enable()

    event.register("numba:compile", Pause())


@cache
def _sources(module: str) -> str:
    """Return a checksum of a module and all modules of its package that it imports."""
    found: dict[str, str] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name], imported = _module(name)
            waiting += imported
    return sha256("".join(found[name] for name in sorted(found)).encode()).hexdigest()


@cache
def _module(name: str) -> tuple[str, list[str]]:
    """Return the checksum of a module, and the modules of the same package that it imports."""
    file = getattr(sys.modules[name], "__file__", None)
    text = Path(file).read_text(encoding="utf-8") if file else ""
    package, imported = name.partition(".")[0], []
    for source, names in IMPORTS.findall(text):
        if source.partition(".")[0] == package:
            words = re.findall(r"\w+", names)
            imported += [source, *(f"{source}.{word}" for word in words)]
    return sha256(text.encode()).hexdigest(), [one for one in imported if one in sys.modules]


def callback(function: Callable[..., object], numbers: int, results: int) -> Any:
    """Compile a function that compiled loops take as an argument.

    Its arguments are so many `numbers` and an array (n,), and it returns so many `results`.

    Raises TypeError for a function that numba does not compile.
    """
    from numba import cfunc, float64, types
    from numba.core.errors import NumbaError

    signature = types.UniTuple(float64, results)(*[float64] * numbers, float64[::1])
    try:
        try:
            return cfunc(signature, cache=True)(function)
        except (RuntimeError, OSError):  # no folder or no room for it, or no file, as in a console
            return cfunc(signature)(function)
    except NumbaError as error:
        raise TypeError(str(error).strip().partition("\n")[0]) from error


def notice() -> str:
    """Return a sentence where compiled functions cannot be kept, else ""."""
    if not _not_kept:
        return ""
    return (
        "Compiled code could not be kept, as the folder of the package and the user's cache are "
        "full or cannot be written: every process compiles it again, some 15 to 30 s; name a "
        "folder that can be written in the variable NUMBA_CACHE_DIR."
    )
