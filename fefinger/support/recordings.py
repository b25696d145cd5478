"""Records of rigs: columns of a file in any order, unit and format, picked by what they measure.

`recording_files.read` reads text, LabVIEW, MATLAB and HDF5 files to a `Recording`; its `pick`
finds the columns of quantities by their names and units. What cannot be told is asked for.
"""

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.csv_columns import shortened, stated_unit
from fefinger.support.units import in_milliseconds, seconds_or_milliseconds


@dataclass(frozen=True)
class Quantity:
    """What a column can measure: its unit in the package, and its usual names, in small letters."""

    unit: str
    names: tuple[str, ...]


LENGTHS = (
    *("position", "depth", "displacement", "indentation", "travel", "stroke", "pos", "disp"),
    *("extension", "weg", "x", "z"),
)
QUANTITIES = {
    "time": Quantity("s", ("time", "t", "timestamp", "elapsed time", "seconds", "zeit", "x_value")),
    "position": Quantity("mm", LENGTHS),
    "depth": Quantity("mm", ("depth", *(name for name in LENGTHS if name != "depth"))),
    "force": Quantity("N", ("force", "normal force", "load", "fz", "fn", "f", "kraft", "last")),
    **{name: Quantity("mm", (name,)) for name in ("x", "y")},
    **{name: Quantity("degrees", (name,)) for name in ("angle", "tilt")},
}
"""Quantities of a record, their own name first."""

SIZES = {
    "s": {
        **{"s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "sek": 1.0},
        **{"ms": 1e-3, "msec": 1e-3, "millisecond": 1e-3, "milliseconds": 1e-3},
        **{"us": 1e-6, "min": 60.0, "minute": 60.0, "minutes": 60.0},
    },
    "mm": {
        **{"mm": 1.0, "millimeter": 1.0, "millimeters": 1.0, "cm": 10.0, "m": 1e3},
        **{"um": 1e-3, "micron": 1e-3, "microns": 1e-3, "micrometer": 1e-3, "nm": 1e-6},
    },
    "N": {
        **{"n": 1.0, "newton": 1.0, "newtons": 1.0, "mn": 1e-3, "cn": 1e-2, "kn": 1e3},
        **{"gf": 9.80665e-3, "g": 9.80665e-3, "kgf": 9.80665, "kg": 9.80665},
    },
    "kPa": {"kpa": 1.0, "pa": 1e-3, "mpa": 1e3},
    "degrees": {"degrees": 1.0, "degree": 1.0, "deg": 1.0},
}
"""By unit, the sizes in it of units that headers state, in small letters."""


class Way(NamedTuple):
    """How a user says which column is a quantity: name of the field, and text with both in it."""

    field: str
    text: str


OPTION = Way("--column", "--column '{name}={column}'")
"""An option of the command line."""


@dataclass(frozen=True)
class Recording:
    """The columns of a file.

    source: name of the file in messages; headers and units, "" where none is stated apart from the
    header, by column; values (n, n_columns); line: number of the line of a row, or of the row.
    """

    source: str
    headers: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    line: Callable[[int], int]

    def pick(
        self,
        wanted: Sequence[str],
        named: Mapping[str, str] | None = None,
        *,
        slow: bool = False,
        also: str = "",
        say: Way = OPTION,
    ) -> Array:
        """Return columns (n, len(wanted)) of quantities, such as "time", in the package's units.

        wanted: names of QUANTITIES, or of other columns with their units as "p1 in kPa"; named: for
        some of them the header or the number of the column, with its unit where it has none, as
        "channel 2 in mN"; slow: samples may be seconds apart; also: a quantity that comes last
        where one column can be it; say: for messages.

        Raises
        ------
        InputError
            For a quantity that no column, or more than one, can be, a column without a unit that
            is likely in another, and times that do not rise. The message asks for what is missing.
        """
        named = named or {}
        known = [*wanted, *filter(None, [also])]
        unknown = [name for name in named if name not in known]
        if unknown:
            expected = ", ".join(known)
            msg = f"{say.field}: expected one of {expected} before '=', received {unknown[0]!r}"
            raise InputError(msg)
        sizes: dict[int, float] = {}
        for name in known:
            with suppress(*[InputError] * (name == also and name not in named)):
                place, size = self._place(name, named, sizes, say)
                if place in sizes:
                    raise InputError(
                        f"{say.field}: expected a column for each of {', '.join(known)}, received "
                        f"{self.headers[place]!r} for {name} and another one"
                    )
                sizes[place] = size
        values: Array = self.values[:, list(sizes)] * np.array(list(sizes.values()))
        if "time" in wanted:
            at = list(wanted).index("time")
            self._check_times(list(sizes)[at], values[:, at], slow=slow)
        return values

    def _check_times(self, place: int, time: Array, *, slow: bool) -> None:
        wrong = np.flatnonzero(np.diff(time) <= 0)
        if wrong.size:
            i = int(wrong[0]) + 1
            what = "a repeated time" if time[i] == time[i - 1] else "an earlier time"
            raise InputError(
                f"{self.source}: line {self.line(i)}: expected a time above {time[i - 1]:g} s, "
                f"received {what}, {time[i]:g}; sort the rows and keep one of each time"
            )
        cell = self.headers[place]
        if not slow and self._unit(place, "s") is None and in_milliseconds(time):
            raise InputError(f"{self.source}: {cell}: {seconds_or_milliseconds(time)}")

    def _place(
        self, wanted: str, named: Mapping[str, str], taken: Collection[int], say: Way
    ) -> tuple[int, float]:
        """Return the column of a quantity that is not taken, and the size of its unit."""
        name, _, stated = wanted.partition(" in ")
        quantity = QUANTITIES.get(name) or Quantity(stated, (name,))
        if wanted in named:
            return self._named(wanted, named[wanted], quantity)
        free = [i for i in range(len(self.headers)) if i not in taken]
        for candidate in quantity.names:
            found = [(i, self._size(i, candidate, quantity.unit)) for i in free]
            matches = [(i, size) for i, size in found if size is not None]
            if len(matches) == 1:
                return matches[0]
            if matches:
                return self._ask(name, quantity, [self.headers[i] for i, _ in matches], say)
        sizes = {i: self._unit(i, quantity.unit) for i in free}
        places = [i for i, size in sizes.items() if size is not None]
        if name in QUANTITIES and len(places) == 1:
            return places[0], sizes[places[0]] or 1.0
        return self._ask(name, quantity, [self.headers[i] for i in places], say)

    def _named(self, wanted: str, given: str, quantity: Quantity) -> tuple[int, float]:
        header, _, unit = given.rpartition(" in ")
        header, unit = (header, unit) if header else (unit, "")
        matches = [i for i, each in enumerate(self.headers) if each.lower() == header.lower()]
        if not matches and header.isdecimal() and 1 <= int(header) <= len(self.headers):
            matches = [int(header) - 1]
        if len(matches) != 1:
            raise InputError(
                f"{self.source}: {wanted}: expected one of the columns {self._listed()}, or its "
                f"number, received {header!r}"
            )
        at = matches[0]
        size = SIZES[quantity.unit].get(plain_unit(unit)) if unit else self._unit(at, quantity.unit)
        if unit and size is None:
            raise InputError(
                f"{self.source}: {wanted}: expected a unit of {quantity.unit}, such as "
                f"{', '.join(list(SIZES[quantity.unit])[:6])}, received {unit!r}"
            )
        return at, 1.0 if size is None else size

    def _size(self, at: int, name: str, unit: str) -> float | None:
        """Size of the unit of a column whose header begins with a name; None for another one."""
        stated = _size(self.headers[at], name, unit)
        if stated is None or not self.units[at]:
            return stated
        return SIZES[unit].get(plain_unit(self.units[at]))

    def _unit(self, at: int, unit: str) -> float | None:
        """Size of the unit that stands at the end of a header, or apart from it; None without."""
        said = self.units[at]
        if not said:
            found = re.search(r"[(\[_/,\s]\s*([^()\[\]_/,\s]+)\s*[)\]]?\s*$", self.headers[at])
            said = found[1] if found else ""
        return SIZES[unit].get(plain_unit(said))

    def _ask(
        self, name: str, quantity: Quantity, found: Sequence[str], say: Way
    ) -> tuple[int, float]:
        """Raise InputError that asks for the column of a quantity."""
        begins = re.compile(rf"{re.escape(name)}(?![a-z\d])")
        foreign = [each for each in self.headers if begins.match(each.lower())]
        if len(foreign) == 1 and not found:
            how = say.text.format(name=name, column=f"{foreign[0]} in {quantity.unit}")
            raise InputError(
                f"{self.source}: column {foreign[0]!r}: expected {name} in {quantity.unit}; "
                f"convert it, or give its unit: {how}"
            )
        several = found or foreign
        received = f"{len(several)}, {', '.join(several)}," if several else "none"
        unknown = [
            self.headers[i]
            for i in range(len(self.headers))
            if not self._is_other(i, quantity.unit)
        ]
        column = f"{(several or unknown or ['HEADER'])[-1]} in {quantity.unit}"
        raise InputError(
            f"{self.source}: expected one column {name!r} ({quantity.unit}), received {received} "
            f"of the columns {self._listed()}; say which it is: "
            f"{say.text.format(name=name, column=column)}"
        )

    def _is_other(self, at: int, unit: str) -> bool:
        """Whether a column has the name of a quantity in another unit than this."""
        return any(
            self._size(at, each, other.unit) is not None
            for other in QUANTITIES.values()
            for each in other.names
            if other.unit != unit
        )

    def _listed(self) -> str:
        return shortened(self.headers)


def plain_unit(text: str) -> str:
    """Return a unit in small letters, without brackets, with u for micro."""
    text = text.strip().strip("()[]{}<>").strip().lower()
    return text.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")


def is_unit(text: str) -> bool:
    """Return whether a text is a unit alone; "" and "-" count as one of a column without."""
    unit = plain_unit(text)
    return unit in ("", "-", "1", "v", "mv", "deg", "hz") or any(
        unit in each for each in SIZES.values()
    )


def _size(cell: str, name: str, unit: str) -> float | None:
    """Size in `unit` of the unit in a header that begins with a name; None for another header."""
    stated = stated_unit(cell, re.escape(name).replace(r"\ ", "[ _]"))
    return 1.0 if stated == "" else SIZES[unit].get(stated or "-")
