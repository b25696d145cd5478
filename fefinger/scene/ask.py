"""The table [ask]: requested outputs, accuracy, and how units of a population are laid out."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, ClassVar, Self

from fefinger.scene.key import Key, check
from fefinger.support.checks import InputError, set_number
from fefinger.support.registry import AFFERENTS
from fefinger.support.vocabulary import (
    DRIVES,
    FAMILIES,
    GENERATORS,
    RULES,
    TYPE_SYNONYMS,
    TYPES,
)


LARGEST_RADIUS = 10.0
"""Upper bound in mm of the radius of a population; no finger pad is wider."""


MOST_PLACES = 31_416
"""Largest number of places of a layout: of the closest grid in the widest disc."""


Within = Annotated[
    float,
    Key(
        "Radius about first touch within which units lie",
        unit="mm",
        above=0,
        at_most=LARGEST_RADIUS,
    ),
]


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

    table: ClassVar[str] = "ask.population"
    kind: ClassVar[str]

    branched: bool = True
    rule: Annotated[str | None, Key(words=RULES)] = None
    distance: Annotated[float, Key(unit="mm", at_least=0, at_most=2000)] = 0.0
    spread: Annotated[float | None, Key(at_least=0, at_most=3)] = None
    noise: Annotated[float | None, Key(unit="µA/cm²", at_least=0, at_most=100)] = None
    seed: Annotated[int, Key(at_least=0)] = 0

    def __post_init__(self) -> None:
        check(self)


Densities = Annotated[
    Mapping[str, float],
    Key("Units by type, where they differ from the published ones", "1/cm²", 0, at_most=1e4),
]


@dataclass(frozen=True, kw_only=True)
class Disc(Layout):
    """Units at random places of a disc of `radius` mm; those beside the skin are left out."""

    radius: float
    densities: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class Scatter(Disc):
    """Units at random places within `radius` mm, at `densities` per cm² across first touch."""

    kind = "scatter"

    radius: Within = 5.0
    densities: Densities = field(default_factory=dict, hash=False)


@dataclass(frozen=True, kw_only=True)
class Fingertip(Disc):
    """Units at random places of the whole pad, at `densities` per cm² across first touch.

    By default those published: 241 per cm² of all types (Johansson & Vallbo 1979, J Physiol
    286:283), SAI 70, FAI 140 and FAII 25 (Saal et al. 2017). Those of a disc as wide as any pad are
    drawn, and the ones that lie beside the skin are left out, as a note counts.
    """

    kind = "fingertip"

    radius: Within = LARGEST_RADIUS
    densities: Densities = field(default_factory=dict, hash=False)


@dataclass(frozen=True, kw_only=True)
class Grid(Layout):
    """A unit of each type every `spacing` mm in x and y, within `radius` mm."""

    kind = "grid"

    spacing: Annotated[float, Key("Distance of neighbors", unit="mm", at_least=0.1)] = 1.0
    radius: Within = 5.0

    def __post_init__(self) -> None:
        super().__post_init__()
        set_number(self, "ask.population.spacing", at_least=0.1, at_most=self.radius, unit="mm")


@dataclass(frozen=True, kw_only=True)
class Line(Layout):
    """`count` units of each type along a straight line in x and y, from `start` to `stop` (mm)."""

    kind = "line"

    start: Annotated[tuple[float, float], Key("One end [x, y]", unit="mm")]
    stop: Annotated[tuple[float, float], Key("Other end [x, y]", unit="mm")]
    count: Annotated[int, Key("Number of places", at_least=2, at_most=MOST_PLACES)] = 11

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.start == self.stop:
            msg = f"ask.population.stop: expected a place other than start, received {self.stop}"
            raise InputError(msg)


@dataclass(frozen=True, kw_only=True)
class Places(Layout):
    """A unit of each type at each of `places`, a list of [x, y] in mm."""

    kind = "places"

    places: Annotated[tuple[tuple[float, float], ...], Key("List of places [x, y]", unit="mm")]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 1 <= len(self.places) <= MOST_PLACES:
            raise InputError(
                f"ask.population.places: expected 1 to {MOST_PLACES} places [x, y], received "
                f"{len(self.places) or 'none'}"
            )


LAYOUTS: dict[str, type[Layout]] = {
    cls.kind: cls for cls in (Scatter, Fingertip, Grid, Line, Places)
}


@dataclass(frozen=True)
class Innervation:
    """Innervation of the fingertip by one afferent type.

    depth: mm of the end organs under the surface of the skin. density: units per cm². organs:
    smallest and largest number of end organs of a unit. field: diameter in mm of the disc over
    which they are spread; None for one end organ. velocity: m/s of the impulses in the nerve.
    """

    depth: float
    density: float
    organs: tuple[int, int]
    field: float | None
    velocity: float


def innervation() -> dict[str, Innervation]:
    """Innervation of the fingertip by the four afferent types.

    Depths: Merkel cells under the epidermis, at the base of the intermediate ridges (SAI, 0.7 to
    1.0 mm are quoted), Ruffini corpuscles in the deep dermis (SAII, 1.0 to 1.5), Meissner
    corpuscles in the dermal papillae just below the epidermis (FAI, 0.5), Pacinian corpuscles under
    the dermis (FAII, 2.0 to 3.0). We know no primary measurement of them in the human fingertip, so
    each is a parameter of the user (`ask.depths`) with confidence medium at best, low for SAII. The
    effective depths of TouchSim (SAI 0.3, FAI 1.6, FAII 2.0 mm) are fits of a half-space model, not
    anatomy.

    Densities of SAI, FAI and FAII: TouchSim (Saal et al. 2017, constants.py), confidence medium.
    Johansson & Vallbo (1979), J Physiol 286:283, give 241 per cm² for all types together; the rest,
    6, is assigned to SAII, which TouchSim lacks: an inference, confidence low. Numbers of end
    organs: Pawluk (1997), 1.1.2, from zones of maximal sensitivity, confidence medium. Fields: 2 to
    8 mm in diameter there, about 4 mm in a page that cites Johansson (1978); the skin spreads
    strain beyond the end organs, so their disc is narrower by a guess, confidence low. Velocities
    of FAI and FAII: means of Knibestol (1973), PMC1350502, confidence high; of SAI and SAII: taken
    to be as of the fast type with like fields, a guess, confidence low.
    """
    return {
        "SAI": Innervation(0.8, 70.0, (4, 7), 3.0, 55.3),
        "SAII": Innervation(1.25, 6.0, (1, 1), None, 46.9),
        "FAI": Innervation(0.5, 140.0, (12, 17), 3.0, 55.3),
        "FAII": Innervation(2.5, 25.0, (1, 1), None, 46.9),
    }


OUTPUTS = ("pressure", "strain", "fields")
"""Outputs besides the force, which not every mechanics can give."""


@dataclass(frozen=True, kw_only=True)
class Ask:
    """Requested outputs, accuracy and options of the afferents.

    Parameters
    ----------
    force, pressure, strain, fields
        Whether the result holds the force, the pressure on the pad, the strain at the end organs
        and the fields on the mesh. None: of a mechanics that is named, what it can give; where the
        planner chooses one, it is asked for all.
    spikes
        Afferent types out of SAI, SAII, FAI, FAII; one unit of each, under first touch, unless
        there is a population.
    population
        Where units of these types lie, and how each is built: a Scatter, Fingertip, Grid, Line
        or Places.
    trial
        Number of the trial, 0 or more: another one is other noise and jitter of the same units at
        the same places. `Result.fire` gives further trials of a result.
    check
        Whether the spike counts are compared on the next coarser mesh, where there is one; of a
        large population that takes as long as the answer. Where they are not, a note says so.
    rel_error
        Allowed relative error of the force, above 0 to 1. It does not govern the other outputs:
        `Plan.trust` states the errors of pressure, contact area and strain.
    seconds
        Longest computing time in s; None is no limit.
    mechanics
        Name of the mechanics that answers where none is named otherwise: as one that is named on
        the command line, it runs in spite of refusals about accuracy. None: the cheapest one.
    depths
        Depth of the end organs in mm under the skin, for types that differ from the library.
    drives
        Component of the strain that drives a type, where it differs from the default.
    generator
        Law from the output of an end organ to its current: "saturating", or "linear" (thesis).
    afferents
        Family of the afferents: "thesis", the chain of the source with its squid membrane,
        "recorded", fitted to responses of single units, or one of your own (`fefinger.Family`).
        `generator` is a choice of "thesis" alone; "recorded" has no choice of `drives` either.
    """

    table: ClassVar[str] = "ask"

    force: bool = True
    pressure: bool | None = None
    strain: bool | None = None
    fields: bool | None = None
    spikes: Annotated[tuple[str, ...], Key(words=TYPES, synonyms=TYPE_SYNONYMS)] = ()
    rel_error: Annotated[float, Key(above=0, at_most=1)] = 0.05
    seconds: Annotated[float | None, Key(unit="s", above=0)] = None
    mechanics: str | None = None
    depths: Annotated[Mapping[str, float], Key(unit="mm", above=0)] = field(
        default_factory=dict, hash=False
    )
    drives: Annotated[Mapping[str, str], Key(words=DRIVES)] = field(
        default_factory=dict, hash=False
    )
    generator: Annotated[str, Key(words=GENERATORS)] = GENERATORS[0]
    afferents: Annotated[str, Key(words=AFFERENTS)] = FAMILIES[0]
    population: Layout | None = None
    trial: Annotated[int, Key(at_least=0, written=False)] = 0
    check: Annotated[bool, Key(written=False)] = True

    def __post_init__(self) -> None:
        check(self)
        if self.population is not None and not self.spikes:
            raise InputError(
                "ask.population: expected ask.spikes to name the types of its units, received none"
            )
        rule = None if self.population is None else self.population.rule
        if not self.drives and rule is None and self.generator == GENERATORS[0]:
            return  # a family leaves the defaults open, so that it need not be loaded
        chosen = {"drives": self.drives, "generator": self.generator, "rule": rule}
        for name in AFFERENTS[self.afferents].refused(**chosen):
            where = "ask.population." if name == "rule" else "ask."
            raise InputError(
                f"{where}{name}: expected the default for afferents = {self.afferents!r}, which "
                f"have no such choice, received {chosen[name]!r}; leave it out, or set "
                "ask.afferents to 'thesis'"
            )

    def wants(self, output: str) -> bool:
        """Whether one of `OUTPUTS` is asked for, be it by default."""
        return getattr(self, output) is not False

    def settled(self, given: Collection[str]) -> Self:
        """Return it with a decision on each of `OUTPUTS` that is left open: whether it is given."""
        pressure, strain, fields = (
            each in given if getattr(self, each) is None else getattr(self, each)
            for each in OUTPUTS
        )
        return replace(self, pressure=pressure, strain=strain, fields=fields)
