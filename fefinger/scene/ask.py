"""Requested outputs and accuracy of a scene: the table [ask]."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from fefinger.scene.population import Layout, by_type
from fefinger.support.checks import (
    FrozenDict,
    InputError,
    boolean,
    choice,
    choices,
    integer,
    number,
    set_number,
)
from fefinger.support.vocabulary import (
    DRIVES,
    FAMILIES,
    GENERATORS,
    RECORDED_RULES,
    TYPE_SYNONYMS,
    TYPES,
)


SOLVERS = ("multifrontal", "single", "iterative")
"""Names of the linear solvers of the finite elements, see `fem.linalg.system`."""


@dataclass(frozen=True, kw_only=True)
class Ask:
    """Requested outputs, accuracy and options of the afferents.

    Parameters
    ----------
    force, pressure, strain, fields
        Whether the result holds the force, the pressure on the pad, the strain at the end organs
        and the fields on the mesh.
    spikes
        Afferent types out of SAI, SAII, FAI, FAII; one unit of each, under first touch, unless
        there is a population.
    population
        Where units of these types lie, and how each is built: a Scatter, Grid, Line or Places.
    trial
        Number of the trial, 0 or more: another one is other noise and jitter of the same units at
        the same places. `Result.fire` gives further trials of a result.
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
        Family of the afferents: "thesis", the chain of the source with its squid membrane, or
        "recorded", fitted to responses of single units. `drives` and `generator` are choices of
        "thesis" alone.
    solver
        Linear solver of the finite elements; by default the fastest that fits in free memory.
    """

    force: bool = True
    pressure: bool = True
    strain: bool = True
    fields: bool = True
    spikes: tuple[str, ...] = ()
    rel_error: float = 0.05
    seconds: float | None = None
    mechanics: str | None = None
    depths: Mapping[str, float] = field(default_factory=dict, hash=False)
    drives: Mapping[str, str] = field(default_factory=dict, hash=False)
    generator: str = "saturating"
    afferents: str = FAMILIES[0]
    population: Layout | None = None
    trial: int = field(default=0, metadata={"written": False})
    solver: str | None = None

    def __post_init__(self) -> None:
        for name in ("force", "pressure", "strain", "fields"):
            boolean(f"ask.{name}", getattr(self, name))
        set_number(self, "ask.rel_error", above=0, at_most=1)
        checked: dict[str, Any] = {
            "spikes": choices("ask.spikes", self.spikes, TYPES, TYPE_SYNONYMS),
            "depths": {
                name: number(f"ask.depths.{name}", value, above=0, unit="mm")
                for name, value in by_type("ask.depths", self.depths).items()
            },
            "drives": {
                name: choice(f"ask.drives.{name}", value, DRIVES)
                for name, value in by_type("ask.drives", self.drives).items()
            },
        }
        integer("ask.trial", self.trial)
        if self.seconds is not None:
            set_number(self, "ask.seconds", above=0, unit="s")
        if self.mechanics is not None and not isinstance(self.mechanics, str):
            raise InputError(f"ask.mechanics: expected a name, received {self.mechanics!r}")
        choice("ask.generator", self.generator, GENERATORS)
        choice("ask.afferents", self.afferents, FAMILIES)
        if self.solver is not None:
            choice("ask.solver", self.solver, SOLVERS)
        population: Any = self.population
        if population is not None and not isinstance(population, Layout):
            raise InputError(f"ask.population: expected a Layout, received {population!r}")
        if population is not None and not checked["spikes"]:
            raise InputError(
                "ask.population: expected ask.spikes to name the types of its units, received none"
            )
        if self.afferents == "recorded":
            _check_recorded(checked["drives"], self.generator, population)
        for name, value in checked.items():
            frozen = FrozenDict(value) if isinstance(value, dict) else value
            object.__setattr__(self, name, frozen)


def _check_recorded(drives: Mapping[str, Any], generator: str, population: Layout | None) -> None:
    """Refuse choices that the family `recorded` does not have."""
    rule = None if population is None else population.rule
    refused = {
        "ask.drives": (drives, bool(drives)),
        "ask.generator": (generator, generator != GENERATORS[0]),
        "ask.population.rule": (rule, rule not in (None, *RECORDED_RULES)),
    }
    for name, (value, wrong) in refused.items():
        if wrong:
            raise InputError(
                f"{name}: expected the default for afferents = 'recorded', whose parameters were "
                f"fitted with it, received {value!r}; leave it out, or set ask.afferents to "
                "'thesis'"
            )
