"""Input checks whose errors say what was expected, what was received and what to do."""

import difflib
import math
import operator
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any, SupportsFloat, SupportsIndex, TypedDict, Unpack, cast


PRESS_LESS = "press less deep, more slowly, or on another mesh (finger.resolution)"
"""Advice of an error that a scene causes where a contact or an equilibrium is not found."""


LONGEST = 2000
"""Characters of a line of a message; the middle of a longer line, a value, is left out."""

LONG_VALUE = 160
"""Characters of a value in a message, of which the middle of a longer one is left out."""

WORD = re.compile(rf"\S{{{LONG_VALUE + 1},}}")
"""A value without a space that is longer."""

TINY, HUGE = 1e-30, 1e30
"""Least number above 0, and largest size of a number: powers and quotients of them stay finite."""

FIELD = re.compile(
    r"((?:--)?[\w.\[\]-]+)(?:, [\w.\[\]-]+)*:(?:\s|$)"
    r"|(--[\w-]+|family|law|mechanics|mesh) \S.*?:(?:\s|$)"
)
"""Beginning of a message: a field, alone or the first of several, or an option or a thing that is
named with what was given for it."""


class Limits(TypedDict, total=False):
    """Limits and unit of a number, as `number` takes them."""

    above: float | None
    at_least: float | None
    below: float | None
    at_most: float | None
    unit: str


class InputError(ValueError):
    """Invalid input; the message names the field, the expected and the received value.

    `field` is the name that the message begins with, as in a scene file or on the command line,
    such as "motion.depth", "indenter.heights[2]" or "--at", the first of several; "" without one.
    As received values may be anything, the message is made printable, and its lines are at most
    LONGEST characters long.
    """

    def __init__(self, message: str, *, field: str | None = None) -> None:
        super().__init__(printable(message))
        begins = FIELD.match(message)
        self.field = field if field is not None else (begins[1] or begins[2]) if begins else ""


class BeyondError(InputError):
    """A scene beyond the limits of one mechanics, as found while solving: another may answer it."""


class ConvergenceError(RuntimeError):
    """A failed iteration; the message says what was wanted, what was reached and what to try."""


class Stopped(ConvergenceError):
    """A run that stopped early; `reached` is its Response or Result up to there."""

    def __init__(self, message: str, reached: Any) -> None:
        super().__init__(message)
        self.reached = reached


def printable(message: str) -> str:
    """Return a message with its lines shortened and unprintable characters escaped."""
    lines = []
    for line in message.split("\n"):
        line = _without_middle(WORD.sub(lambda found: _without_middle(found[0], LONG_VALUE), line))
        if not line.isprintable():
            line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)
        lines.append(line)
    return "\n".join(lines)


def _without_middle(text: str, longest: int = LONGEST) -> str:
    """Return a text, or the beginning and the end of a longer one."""
    if len(text) <= longest:
        return text
    return f"{text[: 2 * longest // 3]} [...] {text[-longest // 4 :]}"


def shown(value: object) -> str:
    """Return a value as text of one line for messages, at most LONG_VALUE characters of it.

    Its type if it is too long or deep to print.
    """
    try:
        return _without_middle(re.sub(r"\s*\n\s*", " ", repr(value)), LONG_VALUE)
    except (ValueError, RecursionError):  # ValueError: a whole number of thousands of digits
        return f"a {type(value).__name__} that is too long to print"


def number(
    name: str,
    value: object,
    *,
    above: float | None = None,
    at_least: float | None = None,
    below: float | None = None,
    at_most: float | None = None,
    unit: str = "",
) -> float:
    """Return `value` as a finite float inside the given limits, or raise InputError.

    Its size is at most HUGE and, if it is above a limit of 0, at least TINY.
    """
    result = math.nan
    if hasattr(value, "__float__") and not isinstance(value, bool | str | bytes):
        with suppress(OverflowError, TypeError):
            result = float(cast(SupportsFloat, value))
    inside = (
        math.isfinite(result)
        and (above is None or result > above)
        and (at_least is None or result >= at_least)
        and (below is None or result < below)
        and (at_most is None or result <= at_most)
    )
    if inside and abs(result) <= HUGE and (above != 0 or result >= TINY):
        return result
    if inside:
        least = -HUGE if at_least is None else at_least
        above, at_least, below, at_most = None, TINY if above == 0 else least, None, HUGE
    limits = {"above": above, "at least": at_least, "below": below, "at most": at_most}
    suffix = f" in {unit}" if unit else ""
    wanted = " and ".join(f"{word} {x:g}" for word, x in limits.items() if x is not None)
    expected = f"expected a finite number{suffix}" + (f" {wanted}" if wanted else "")
    raise InputError(f"{name}: {expected}, received {shown(value)}")


def set_number(record: object, field: str, **limits: Unpack[Limits]) -> None:
    """Check a number of a frozen record and store it as a float.

    `field` is its name in messages, such as "indenter.edge", of the attribute `edge`.
    """
    name = field.rpartition(".")[2]
    object.__setattr__(record, name, number(field, getattr(record, name), **limits))


def integer(name: str, value: object, *, at_least: int = 0, at_most: float = math.inf) -> int:
    """Return a whole number of Python's or numpy's within limits, or raise InputError."""
    whole: int | None = None
    if not isinstance(value, bool):
        with suppress(TypeError):
            whole = operator.index(cast(SupportsIndex, value))
    if whole is None or not at_least <= whole <= at_most:
        limits = f"of {at_least} or more" if at_most == math.inf else f"of {at_least} to {at_most}"
        raise InputError(f"{name}: expected a whole number {limits}, received {shown(value)}")
    return whole


def set_integer(
    record: object, field: str, *, at_least: int = 0, at_most: float = math.inf
) -> None:
    """Check a whole number of a frozen record and store it as Python's, as `set_number` does."""
    name = field.rpartition(".")[2]
    whole = integer(field, getattr(record, name), at_least=at_least, at_most=at_most)
    object.__setattr__(record, name, whole)


def instance(name: str, value: object, kind: type[object], expected: str) -> None:
    """Raise InputError, which says what is expected, unless `value` is of a class."""
    if not isinstance(value, kind):
        raise InputError(f"{name}: expected {expected}, received {shown(value)}")


def suggestion(
    name: object, options: Iterable[str], synonyms: Mapping[str, str] | None = None
) -> str:
    """Return the sentence " Did you mean 'x'?" for the closest option, or an empty string.

    `synonyms`: options by other words for them.
    """
    meant = {option.lower(): option for option in options} | dict(synonyms or {})
    text = name if isinstance(name, str) else shown(name)
    close = difflib.get_close_matches(text.lower(), list(meant), n=1, cutoff=0.5)
    return f" Did you mean {meant[close[0]]!r}?" if close else ""


def choice(
    name: str, value: object, options: Iterable[str], synonyms: Mapping[str, str] | None = None
) -> str:
    """Return `value` if it is one of `options`, or raise InputError that suggests one of them.

    `synonyms`: options by other words for them, which are not accepted.
    """
    allowed = list(options)
    if not isinstance(value, str) or value not in allowed:
        listed = ", ".join(repr(option) for option in allowed)
        advice = suggestion(value, allowed, synonyms)
        message = f"{name}: expected one of {listed}, received {shown(value)}.{advice}"
        raise InputError(message)
    return str(value)


def repeated(values: Iterable[str]) -> list[str]:
    """Return the values that occur more than once, in their order."""
    return [value for value, count in Counter(values).items() if count > 1]


def names(field: str, values: object) -> tuple[str, ...]:
    """Return `values` as a tuple of different strings, or raise InputError."""
    result = None
    if isinstance(values, Iterable) and not isinstance(values, str):
        result = tuple(values)
    twice = repeated(map(str, result or ()))
    if result is None or twice or not all(isinstance(value, str) for value in result):
        received = f"{', '.join(twice)} more than once" if twice else shown(values)
        raise InputError(
            f"{field}: expected a list of strings, no two alike, received {received}; give each "
            "a different name"
        )
    return result


def boolean(name: str, value: object) -> bool:
    """Return a truth value of Python's or numpy's, or raise InputError."""
    of_numpy = str(getattr(value, "dtype", "")) == "bool" and getattr(value, "shape", None) == ()
    if not (of_numpy or isinstance(value, bool)):
        raise InputError(f"{name}: expected true or false, received {shown(value)}")
    return bool(value)


def reject_unknown(table: str, keys: Iterable[str], options: Iterable[str], file: str = "") -> None:
    """Raise InputError for the first key that is not among `options`, with the nearest name.

    file: that the keys of a table come from, where it is not the scene's own.
    """
    allowed = list(options)
    for key in keys:
        if key not in allowed:
            where = f" in [{table}]" if table else ""
            where += f" of {file}" if file else ""
            listed = ", ".join(allowed)
            message = f"{key}: unknown key{where}.{suggestion(key, allowed)} Known keys: {listed}"
            raise InputError(message, field=f"{table}.{key}" if table else key)


def numbers(
    name: str, values: object, *, count: int | None = None, **limits: Unpack[Limits]
) -> tuple[float, ...]:
    """Return `values` as a tuple of `count` floats inside limits, or raise InputError."""
    wanted = "a list of numbers" if count is None else f"a list of {count} numbers"
    if isinstance(values, str | bytes) or not isinstance(values, Iterable):
        raise InputError(f"{name}: expected {wanted}, received {shown(values)}")
    result = tuple(values)
    # Quick for a million numbers of a file; the comparison is false for nan.
    sized = set(map(type, result)) == {float} and all(-HUGE <= x <= HUGE for x in result)
    if limits.keys() - {"unit"} or not sized:
        result = tuple(number(f"{name}[{i}]", value, **limits) for i, value in enumerate(result))
    if count is not None and len(result) != count:
        raise InputError(
            f"{name}: expected {wanted}, received {len(result)}: {shown(list(result))}"
        )
    return result


def choices(
    name: str, values: object, options: Iterable[str], synonyms: Mapping[str, str] | None = None
) -> tuple[str, ...]:
    """Return `values` as a tuple of different options, or raise InputError as `choice`."""
    allowed = list(options)
    if isinstance(values, str | bytes) or not isinstance(values, Iterable):
        advice = f'; write ["{values}"]' if values in allowed else ""
        msg = f"{name}: expected a list out of {', '.join(allowed)}, received {values!r}{advice}"
        raise InputError(msg)
    result = tuple(
        choice(f"{name}[{i}]", value, allowed, synonyms) for i, value in enumerate(values)
    )
    if len(set(result)) != len(result):
        raise InputError(f"{name}: expected every name once, received {list(result)}")
    return result


class FrozenDict(Mapping[str, Any]):
    """An immutable mapping, equal to a dict of the same items.

    Unlike MappingProxyType it can be pickled, for other processes, and copies its items.
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


def address_space() -> float:
    """Return the limit in MB of the address space of this process, infinite without one."""
    try:
        import resource
    except ImportError:  # on Windows
        return math.inf
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return math.inf if limit == resource.RLIM_INFINITY else limit / 1e6
