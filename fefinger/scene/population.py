"""Layouts of a population of afferent units: the table [ask.population]."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from fefinger.support.checks import (
    FrozenDict,
    InputError,
    boolean,
    choice,
    integer,
    number,
    numbers,
    reject_unknown,
    set_number,
)
from fefinger.support.vocabulary import RULES, TYPES


LARGEST_RADIUS = 10.0
"""Upper bound in mm of the radius of a population; no finger pad is wider."""


def by_type(name: str, table: Any, example: str = "...") -> Mapping[str, Any]:
    """Check that the keys of a table are afferent types; InputError for others, or no table."""
    if not isinstance(table, Mapping):
        msg = f"{name}: expected a table such as {{SAI = {example}}}, received {table!r}"
        raise InputError(msg)
    reject_unknown(name, table, TYPES)
    return table


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Positions of the units of the types in `ask.spikes`, relative to first touch of the plate.

    Parameters
    ----------
    branched
        True: units have the published numbers of end organs. False: one each, at their place.
    rule
        Combination of a unit's end organs: "mean", "max" or "first"; None: "mean" of the currents
        for the afferents "thesis", "max" of the inputs for "recorded", which has no "first".
    distance
        Length in mm of the nerve up to the recording site, at which times of spikes are given: a
        conduction delay later, which `SpikeTrains.delays` holds.
    spread, noise
        Standard deviations of the logarithm of the units' gains and of the membrane noise in
        µA/cm²; 0: units of a type are identical and fire the same spikes every time. None: those
        of the recorded units for the afferents "recorded", 0 for "thesis".
    seed
        Seed of all random draws: places, end organs, gains and noise. Those of a unit depend on it,
        on the type, and on the unit's place among those of its type, not on the other types.
        `ask.trial` varies the noise alone.
    """

    kind: ClassVar[str]

    branched: bool = True
    rule: str | None = None
    distance: float = 0.0
    spread: float | None = None
    noise: float | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        boolean("ask.population.branched", self.branched)
        if self.rule is not None:
            choice("ask.population.rule", self.rule, RULES)
        integer("ask.population.seed", self.seed)
        set_number(self, "ask.population.distance", at_least=0.0, at_most=2000.0, unit="mm")
        if self.spread is not None:
            set_number(self, "ask.population.spread", at_least=0.0, at_most=3.0)
        if self.noise is not None:
            set_number(self, "ask.population.noise", at_least=0.0, at_most=100.0, unit="µA/cm²")


@dataclass(frozen=True, kw_only=True)
class Scatter(Layout):
    """Units at random places within `radius` mm, at their published densities.

    densities: units per cm² across the first touch, for the types that differ from the library.
    """

    kind = "scatter"

    radius: float = 5.0
    densities: Mapping[str, float] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        set_number(self, "ask.population.radius", above=0.0, at_most=LARGEST_RADIUS, unit="mm")
        name = "ask.population.densities"
        checked = {
            kind: number(f"{name}.{kind}", value, above=0.0, at_most=1e4, unit="per cm²")
            for kind, value in by_type(name, self.densities, "70").items()
        }
        object.__setattr__(self, "densities", FrozenDict(checked))


@dataclass(frozen=True, kw_only=True)
class Grid(Layout):
    """A unit of each type every `spacing` mm in x and y, within `radius` mm."""

    kind = "grid"

    branched: bool = False
    spacing: float = 1.0
    radius: float = 5.0

    def __post_init__(self) -> None:
        super().__post_init__()
        set_number(self, "ask.population.radius", above=0.0, at_most=LARGEST_RADIUS, unit="mm")
        set_number(self, "ask.population.spacing", at_least=0.1, at_most=self.radius, unit="mm")


@dataclass(frozen=True, kw_only=True)
class Line(Layout):
    """`count` units of each type along a straight line in x and y, from `start` to `stop` (mm)."""

    kind = "line"

    start: tuple[float, float]
    stop: tuple[float, float]
    count: int = 11
    branched: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("start", "stop"):
            place = numbers(f"ask.population.{name}", getattr(self, name), count=2, unit="mm")
            object.__setattr__(self, name, place)
        if self.start == self.stop:
            msg = f"ask.population.stop: expected a place other than start, received {self.stop}"
            raise InputError(msg)
        if isinstance(self.count, bool) or not isinstance(self.count, int) or self.count < 2:
            msg = f"ask.population.count: expected 2 or more places, received {self.count!r}"
            raise InputError(msg)


@dataclass(frozen=True, kw_only=True)
class Places(Layout):
    """A unit of each type at each of `places`, a list of [x, y] in mm."""

    kind = "places"

    places: tuple[tuple[float, float], ...]
    branched: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        name = "ask.population.places"
        given: Any = self.places
        if isinstance(given, str | bytes) or not isinstance(given, Iterable):
            raise InputError(f"{name}: expected a list of [x, y] in mm, received {given!r}")
        places = tuple(
            numbers(f"{name}[{i}]", place, count=2, unit="mm") for i, place in enumerate(given)
        )
        if not places:
            raise InputError(f"{name}: expected one place [x, y] or more, received none")
        object.__setattr__(self, "places", places)


LAYOUTS: dict[str, type[Layout]] = {cls.kind: cls for cls in (Scatter, Grid, Line, Places)}
