"""What is known of a key of a scene file: unit, limits, choices and meaning, in one place.

A key is a field of a record: `radius: Annotated[float, Key("Radius", unit="mm", above=0)]`. The
reader, the schema, the page of keys, the columns of a study and all messages read it from there. An
annotation leaves the default of the field to the dataclass, so that type checkers know which fields
a record needs. Keys that mean the same in every record of a table stand in its `common`, by name.
"""

import inspect
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from types import NoneType, UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin, get_type_hints

from fefinger.support.checks import (
    FrozenDict,
    InputError,
    boolean,
    choice,
    choices,
    number,
    numbers,
    reject_unknown,
)
from fefinger.support.registry import Registry
from fefinger.support.vocabulary import TYPES, Control


BOUNDS = ("above", "at_least", "below", "at_most")
"""Names of the limits of a number."""


@dataclass(frozen=True)
class Key:
    """Meaning, unit, limits and choices of a key.

    Parameters
    ----------
    text
        Its meaning in one line, without the unit; "" where the docstring of the record says it.
    unit
        Unit of the number or of all numbers in it, as "mm" or "N/s"; "" for a pure number.
    above, at_least, below, at_most
        Limits of the number, or of each one.
    words
        Texts that it is chosen from.
    synonyms
        Other words for some of these, which are not accepted, but understood.
    written
        Whether a scene writes it at its default: one that came later is left out there, so that
        the text of a scene and what is stored under it stay the same.
    free
        Whether a table has names of its own; otherwise it has afferent types.
    control
        Of a motion: only kinds that prescribe this have the key.
    usual
        Values by depth and by force that a motion fills in where the key is left out.
    """

    text: str = ""
    unit: str = ""
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    words: Collection[str] = ()
    synonyms: Mapping[str, str] = field(default_factory=dict)
    written: bool = True
    free: bool = False
    control: Control | None = None
    usual: tuple[float, float] | None = None

    def unit_of(self, kind: str) -> str:
        """Return its unit in a motion of a kind: of "mm or N" the latter where it is of force."""
        depth, _, force = self.unit.partition(" or ")
        return Control.of_kind(kind).of(depth, force or depth)

    @property
    def bounds(self) -> dict[str, float]:
        """Its limits, by BOUNDS."""
        return {name: getattr(self, name) for name in BOUNDS if getattr(self, name) is not None}

    @property
    def limits(self) -> dict[str, Any]:
        """Limits and unit, as `checks.number` takes them."""
        return {**self.bounds, "unit": self.unit}


class KeyField(NamedTuple):
    """A field of a record: its key, type and default (None where it has none, see `needed`)."""

    key: Key
    hint: Any
    default: Any
    needed: bool


def keys_of(record: type[object]) -> Mapping[str, KeyField]:
    """Return the fields of a record by name; `common` has the Key of a field without one."""
    if record not in _KEYS:
        _KEYS[record] = _read_keys(record)
    return _KEYS[record]


_KEYS: dict[type[object], Mapping[str, KeyField]] = {}


def _read_keys(record: type[Any]) -> Mapping[str, KeyField]:
    unread = inspect.get_annotations(record).keys() - {each.name for each in fields(record)}
    if unread and "__dataclass_fields__" not in record.__dict__:
        raise InputError(
            f"{record.__name__}: expected a dataclass, received a class with the field "
            f"{min(unread)!r} and no decorator; write @dataclass(frozen=True) above it"
        )
    hints, common = get_type_hints(record, include_extras=True), getattr(record, "common", {})
    found = {}
    for each in fields(record):
        hint, key = hints[each.name], common.get(each.name, Key())
        if get_origin(hint) is Annotated:
            hint, *extras = get_args(hint)
            key = next((extra for extra in extras if isinstance(extra, Key)), key)
        without = each.default is MISSING
        needed = without and each.default_factory is MISSING
        found[each.name] = KeyField(key, hint, None if without else each.default, needed)
    return found


def keys_of_kind(record: type[object], kind: str = "") -> Mapping[str, KeyField]:
    """Return the keys that a scene has for a record of a `kind`: what the kind says is no key."""
    control, found = Control.of_kind(kind), {}
    for name, each in keys_of(record).items():
        if each.hint is Control or each.key.control not in (None, control):
            continue
        usual = each.key.usual
        default = control.of(*usual) if usual else each.default
        needs = each.needed or (each.key.control is not None and usual is None)
        found[name] = each._replace(default=default, needed=needs)
    return found


def needed(record: type[object], kind: str = "") -> list[str]:
    """Return the names of the keys of a record of a `kind` that have no default."""
    return [name for name, each in keys_of_kind(record, kind).items() if each.needed]


def check(record: Any, *names: str) -> None:
    """Check fields of a frozen record by their keys and types, and store them in their types.

    By default all of them; messages call them after the `table` of the record. Where None is the
    default the record fills it in, or does without.

    Raises InputError for a value of another type, outside its limits or not among its words.
    """
    known = keys_of(type(record))
    for name in names or known:
        value = checked(f"{record.table}.{name}", getattr(record, name), known[name])
        object.__setattr__(record, name, value)


def checked(name: str, value: object, known: KeyField) -> Any:
    """Return the value of the field called `name`, if its type and key allow it."""
    key, hint = known.key, known.hint
    if value is None and not known.needed and known.default is None:
        return None
    types = records(hint)
    if isinstance(value, tuple(types)):
        return value
    plain = [each for each in forms(hint) if each not in types]
    if not plain:
        what = " or ".join(each.__name__ for each in types)
        raise InputError(f"{name}: expected a {what}, received {value!r}")
    return _plain(name, value, plain[0], key)


def forms(hint: object) -> list[Any]:
    """Return the types that a field may have besides None."""
    either = get_args(hint) if get_origin(hint) in (UnionType, Union) else (hint,)
    return [each for each in either if each is not NoneType]


def records(hint: object) -> list[type[object]]:
    """Return the records among the types that a field may have."""
    return [each for each in forms(hint) if isinstance(each, type) and is_dataclass(each)]


def _plain(name: str, value: object, hint: object, key: Key) -> object:
    """Return a value of a type that is no record."""
    if hint is bool:
        return boolean(name, value)
    if hint is int:
        return _whole(name, value, key)
    if hint is float:
        return number(name, value, **key.limits)
    if hint is Control:
        return Control(choice(name, value, tuple(Control)))
    if hint is str:
        if isinstance(key.words, Registry):
            return key.words.chosen(name, value)
        if key.words:
            return choice(name, value, key.words, key.synonyms)
        if not isinstance(value, str):
            raise InputError(f"{name}: expected a text, received {value!r}")
        return value
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Mapping:
        items = table(name, value) if key.free else by_type(name, value, key)
        return FrozenDict({at: _plain(f"{name}.{at}", x, parts[1], key) for at, x in items.items()})
    if origin is tuple:
        return _listed(name, value, parts, key)
    raise InputError(f"{name}: expected a field of a type that a scene file has, received {hint!r}")


def _whole(name: str, value: Any, key: Key) -> int:
    """Return a whole number, 3.0 too."""
    with suppress(InputError):
        if number(name, value, **key.limits).is_integer():
            return int(value)
    limits = " and ".join(f"{word.replace('_', ' ')} {x:g}" for word, x in key.bounds.items())
    expected = f"expected a whole number {limits}".rstrip()
    raise InputError(f"{name}: {expected}, received {value!r}")


def _listed(name: str, value: object, parts: tuple[object, ...], key: Key) -> tuple[object, ...]:
    """Return a list as a tuple: of words, of numbers, or of lists of numbers."""
    item, count = parts[0], None if parts[-1] is Ellipsis else len(parts)
    if item is str:
        return choices(name, value, key.words, key.synonyms)
    if get_origin(item) is not tuple:
        return numbers(name, value, count=count, **key.limits)
    given = value.tolist() if hasattr(value, "tolist") else value  # arrays of NumPy
    if isinstance(given, str | bytes) or not isinstance(given, Iterable):
        raise InputError(f"{name}: expected a list of lists of numbers, received {value!r}")
    rows = (_listed(f"{name}[{i}]", row, get_args(item), key) for i, row in enumerate(given))
    return tuple(rows)


def by_type(name: str, given: object, key: Key) -> Mapping[str, object]:
    """Return a table by afferent type; InputError for other keys, or no table."""
    found = table(name, given, "SAI = ..." if key.words else "SAI = 1.0")
    reject_unknown(name, found, TYPES)
    return found


def table(name: str, given: object, example: str = "name = 1.0") -> Mapping[str, object]:
    """Return a table; InputError for another value."""
    if not isinstance(given, Mapping):
        msg = f"{name}: expected a table such as {{{example}}}, received {given!r}"
        raise InputError(msg)
    return given
