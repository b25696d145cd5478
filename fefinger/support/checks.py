"""Input checks that speak in sentences: what was expected, what was received, what to do."""

import difflib
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Any


class InputError(ValueError):
    """Input that cannot be used; the message names the field, the expectation and what came."""


class ConvergenceError(RuntimeError):
    """An iteration that failed; the message says what was asked, what was reached, what to try."""


class Stopped(ConvergenceError):
    """A run that had to stop; `reached` is the Response or Result of what came before."""

    def __init__(self, message: str, reached: Any) -> None:
        super().__init__(message)
        self.reached = reached


def number(
    name: str,
    value: Any,
    *,
    above: float | None = None,
    at_least: float | None = None,
    below: float | None = None,
    at_most: float | None = None,
    unit: str = "",
) -> float:
    """Return `value` as a finite float inside the given limits, or raise InputError."""
    limits = [
        (above, "above", lambda v, x: v > x),
        (at_least, "at least", lambda v, x: v >= x),
        (below, "below", lambda v, x: v < x),
        (at_most, "at most", lambda v, x: v <= x),
    ]
    suffix = f" in {unit}" if unit else ""
    wanted = " and ".join(f"{word} {limit:g}" for limit, word, _ in limits if limit is not None)
    expected = f"expected a finite number{suffix}" + (f" {wanted}" if wanted else "")
    message = f"{name}: {expected}, received {value!r}"
    if isinstance(value, bool | str | bytes) or not hasattr(value, "__float__"):
        raise InputError(message)
    try:
        result = float(value)
    except (OverflowError, TypeError) as error:
        raise InputError(message) from error
    if not math.isfinite(result):
        raise InputError(message)
    if not all(holds(result, limit) for limit, _, holds in limits if limit is not None):
        raise InputError(message)
    return result


def nearest(name: str, options: Iterable[str]) -> str:
    """Return the sentence " Did you mean 'x'?" for the closest option, or an empty string."""
    known = {option.lower(): option for option in options}
    close = difflib.get_close_matches(str(name).lower(), list(known), n=1, cutoff=0.5)
    return f" Did you mean {known[close[0]]!r}?" if close else ""


def choice(name: str, value: Any, options: Iterable[str]) -> str:
    """Return `value` if it is one of `options`, or raise InputError with the nearest of them."""
    known = list(options)
    if value not in known:
        listed = ", ".join(repr(option) for option in known)
        message = f"{name}: expected one of {listed}, received {value!r}.{nearest(value, known)}"
        raise InputError(message)
    return str(value)


def repeated(values: Iterable[str]) -> list[str]:
    """Return, once each and in their order, the values that stand more than once."""
    return [value for value, count in Counter(values).items() if count > 1]


def names(field: str, values: Iterable[str]) -> tuple[str, ...]:
    """Return `values` as a tuple of different strings, or raise InputError."""
    result = (values,) if isinstance(values, str) else tuple(values)
    twice = repeated(map(str, result))
    if isinstance(values, str) or twice or not all(isinstance(value, str) for value in result):
        received = f"{', '.join(twice)} more than once" if twice else repr(values)
        message = (
            f"{field}: expected a list of strings, no two alike, received {received}; give each "
            "a name of its own"
        )
        raise InputError(message)
    return result


def flag(name: str, value: Any) -> bool:
    """Return `value` if it is true or false, or raise InputError."""
    if not isinstance(value, bool):
        message = f"{name}: expected true or false, received {value!r}"
        raise InputError(message)
    return value


def reject_unknown(table: str, keys: Mapping[str, Any], options: Iterable[str]) -> None:
    """Raise InputError for the first key that is not among `options`, with the nearest name."""
    known = list(options)
    for key in keys:
        if key not in known:
            where = f" in [{table}]" if table else ""
            listed = ", ".join(known)
            message = f"{key}: unknown key{where}.{nearest(key, known)} Known keys: {listed}"
            raise InputError(message)


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


class Frozen(Mapping[str, Any]):
    """A mapping that cannot be changed, equal to a dict of the same items.

    Unlike a MappingProxyType it can be pickled, as scenes are on their way to other processes, and
    follows no dict that someone else still holds.
    """

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[str, Any]) -> None:
        self._items = dict(items)

    def __getitem__(self, key: str) -> Any:
        return self._items[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __repr__(self) -> str:
        return repr(self._items)
