"""Checks of lists, one entry at a time."""

from collections.abc import Iterable
from typing import Any

from fefinger.checks import InputError, choice, number


def numbers(
    name: str, values: Any, *, count: int | None = None, **limits: Any
) -> tuple[float, ...]:
    """Return `values` as a tuple of `count` floats inside the limits that `checks.number` takes."""
    wanted = "a list of numbers" if count is None else f"a list of {count} numbers"
    if isinstance(values, str | bytes) or not isinstance(values, Iterable):
        msg = f"{name}: expected {wanted}, received {values!r}"
        raise InputError(msg)
    result = tuple(number(f"{name}[{i}]", value, **limits) for i, value in enumerate(values))
    if count is not None and len(result) != count:
        msg = f"{name}: expected {wanted}, received {len(result)}: {list(result)}"
        raise InputError(msg)
    return result


def choices(name: str, values: Any, options: Iterable[str]) -> tuple[str, ...]:
    """Return `values` as a tuple of different strings, all of them among `options`."""
    known = list(options)
    if isinstance(values, str | bytes) or not isinstance(values, Iterable):
        msg = f"{name}: expected a list out of {', '.join(known)}, received {values!r}"
        raise InputError(msg)
    result = tuple(choice(f"{name}[{i}]", value, known) for i, value in enumerate(values))
    if len(set(result)) != len(result):
        msg = f"{name}: expected every name once, received {list(result)}"
        raise InputError(msg)
    return result
