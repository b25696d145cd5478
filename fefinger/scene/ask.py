"""Requested outputs and accuracy of a scene: the table [ask]."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, ClassVar, Self

from fefinger.scene.key import Key, check
from fefinger.scene.population import Layout
from fefinger.support.checks import InputError
from fefinger.support.registry import AFFERENTS
from fefinger.support.vocabulary import (
    DRIVES,
    FAMILIES,
    GENERATORS,
    TYPE_SYNONYMS,
    TYPES,
)


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
