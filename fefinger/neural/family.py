"""Families of afferents: how the input of a unit becomes its spikes, by a name in a scene.

`RECORDED` and `THESIS` are the two of the package; one of a user's own is a class like theirs.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.registry import own
from fefinger.support.vocabulary import GENERATORS, RECORDED_RULES, RULES, TYPES


if TYPE_CHECKING:
    from fefinger.neural.checked_signals import UnitInput
    from fefinger.neural.drives import Reference
    from fefinger.neural.stepped import SteppedUnits, UnitStepper
    from fefinger.neural.trains import SpikeTrains
    from fefinger.neural.variation import Variation


class Units(NamedTuple):
    """Units to simulate: types, names, how they vary, and a seeded random generator of each."""

    types: tuple[str, ...]
    names: tuple[str, ...]
    random: tuple[np.random.Generator, ...]
    variation: "Variation"


class Family(ABC):
    """Base of a family of afferents: a `name`, `drives`, `simulate` and perhaps `stepper`.

    drives: component of the strain (of `vocabulary.DRIVES`) that drives each type. lengths: input
    in mm per strain of 1, by type; 1 by default, so that the input is the strain.
    """

    name: str
    drives: Mapping[str, str] = dict.fromkeys(TYPES, "compressive")
    lengths: Mapping[str, float] = dict.fromkeys(TYPES, 1.0)
    corners: Mapping[str, float] = {}
    """Highest frequencies in Hz that a type follows, by which the samples of a series are checked;
    without any, they are not."""

    choices: ClassVar[frozenset[str]] = frozenset({"drives"})
    """Choices that it leaves open: "drives", "generator" and "tolerance"."""

    rules: ClassVar[tuple[str, ...]] = RECORDED_RULES
    """How the inputs of the end organs of a unit may be combined, the default first."""

    noisy: ClassVar[bool] = True
    """Whether trials differ where a population does not say so."""

    by_input: ClassVar[bool] = True
    """Whether the spikes of a unit follow from one input, of all of its end organs combined."""

    membranes: ClassVar[bool] = False
    """Whether its spikes have a block and a count with frozen sodium, which a report then shows."""

    @abstractmethod
    def simulate(self, time: Array, x_in: Array, units: Units) -> Sequence[Array]:
        """Return the spike times in s of each unit, ascending and within `time`.

        time: (n_t,) s; x_in: (n_t, n_units), linear in between; of a unit with several end organs
        the largest of theirs at every time, or their mean.
        """

    def stepper(self, units: Units) -> "UnitStepper":
        """Make the stepper of units, for loops in real time.

        It has `reset()`, and `step(x_in, dt)`: x_in (n_units,) at the end of a step of `dt` s, in
        which it is linear; returns the spikes as (index of the unit, s since the step began).
        InputError where the family has none.
        """
        raise InputError(
            f"family: expected one with a method stepper for a loop, received {self.name!r}, which "
            "has none; write it, or simulate the strain of the whole loop afterwards"
        )

    def notes(self) -> tuple[str, ...]:
        """Say of the units what a reader of the result has to know."""
        return (f"Afferents: the family {self.name}, which is not of the package.",)

    def refused(self, **chosen: object) -> tuple[str, ...]:
        """Return the names of choices, None where they are not made, that it does not leave open.

        `rule` may be one of `rules`, and `generator` the default.
        """
        closed = [name for name, value in chosen.items() if name not in self.choices and value]
        rule, generator = chosen.get("rule"), chosen.get("generator")
        allowed = {"rule": rule in self.rules, "generator": generator == GENERATORS[0]}
        return tuple(name for name in closed if not allowed.get(name, False))

    def x_in(
        self,
        strain: Array,
        normals: Array,
        types: Sequence[str],
        reference: "Reference",
        drives: Mapping[str, str],
    ) -> Array:
        """Return the input (n_t, n_organs) in mm of end organs from their strain.

        strain (n_t, n_organs, 3, 3); normals (n_organs, 3) of the skin; `reference`: a small flat
        press of the same finger; drives: other ones than the family has, by type.
        """
        from fefinger.neural.drives import driven_displacements

        with own(f"family {self.name!r}", type(self).__module__):
            chosen = {**self.drives, **drives}
            return driven_displacements(strain, normals, types, chosen, self.lengths)

    def fire(self, time: Array, drive: Array, **options: Any) -> "SpikeTrains":
        """Simulate units; arguments as in `recorded.simulate_recorded`.

        Raises
        ------
        InputError
            Spikes that are not finite, not ascending or outside of the times, or not of every unit.
        """
        from fefinger.neural.recorded import combined

        given, rule, variation = _input(time, drive, **options)
        x_in = combined(given.organs, given.columns, rule or self.rules[0])
        units = _units(given.types, given.names, variation)
        with own(f"family {self.name!r}", type(self).__module__):
            times = _checked(self, self.simulate(given.time, x_in, units), given)
        return given.trains(
            times,
            x_in=x_in,
            notes=(),
            family=self.name,
            current=x_in,
            seed=units.variation.seed,
            trial=units.variation.trial,
        )

    def stepped(
        self,
        types: Sequence[str],
        normals: Array,
        *,
        unit: Array | None,
        reference: "Callable[[], Reference]",
        drives: Mapping[str, str] | None = None,
        variation: "Variation | None" = None,
    ) -> "SteppedUnits":
        """Return units that a loop advances step by step with the strain at their end organs.

        types (n_organs,); unit (n_organs,): index of the unit of each end organ, the largest of
        whose inputs is the unit's; one each where it is None.
        """
        from fefinger.neural.stepped import OwnAfferents

        owner = np.arange(len(types)) if unit is None else np.asarray(unit)
        first = np.unique(owner, return_index=True)[1]
        kinds = tuple(types[i] for i in first)
        names = tuple(f"{kind}-{i + 1}" for i, kind in enumerate(kinds))
        stepper = self.stepper(_units(kinds, names, variation))
        chosen = {**self.drives, **(drives or {})}
        across = np.asarray(normals, float)
        return OwnAfferents(self.name, stepper, types, across, first, chosen, self.lengths)


def _input(
    time: Array,
    drive: Array,
    *,
    types: Sequence[str],
    lengths: Any = 1.0,
    rule: str | None = None,
    variation: "Variation | None" = None,
    check: bool = True,
    exact: bool = False,
    **options: Any,
) -> "tuple[UnitInput, str | None, Variation | None]":
    """Check the input of units; a family of a user's own has no step to halve and check."""
    from fefinger.neural.checked_signals import UnitInput

    return UnitInput.of(time, drive, lengths, types, **options), rule, variation


def _units(types: tuple[str, ...], names: tuple[str, ...], given: "Variation | None") -> Units:
    """Return units with their seeded random generators."""
    from fefinger.neural.variation import Variation

    variation = (given or Variation(seed=0, noise=None)).for_units(types)
    numbers = range(len(types)) if variation.numbers is None else variation.numbers
    key = [variation.seed, variation.trial]
    random = tuple(np.random.default_rng([*key, int(number)]) for number in numbers)
    return Units(types, names, random, variation)


def _checked(family: Family, found: Sequence[Array], units: "UnitInput") -> list[Array]:
    """Return spike times as arrays; InputError where they are none, or of no unit."""
    who = f"family {family.name!r}"
    names, time = units.names, units.time
    times = [np.asarray(each, float) for each in found]
    if len(times) != len(names):
        raise InputError(f"{who}: expected spikes of {len(names)} units, received {len(times)}")
    for name, each in zip(names, times, strict=True):
        inside = each.ndim == 1 and np.isfinite(each).all()
        inside = inside and ((each >= time[0]) & (each <= time[-1])).all()
        if not (inside and (np.diff(each) > 0).all()):
            raise InputError(
                f"{who}: expected ascending spike times of {name} from {time[0]:g} to "
                f"{time[-1]:g} s, received {np.array2string(each, threshold=6)}"
            )
    return times


class OfPackage(Family):
    """A family of the package: its units are simulated by `fire`, with their own checks."""

    def simulate(self, time: Array, x_in: Array, units: Units) -> Sequence[Array]:
        """Return the spike times of each unit in s."""
        trains = self.fire(time, x_in, types=units.types, variation=units.variation, check=False)
        return trains.times


class Recorded(OfPackage):
    """Units that were fitted to recorded responses (`neural/recorded.py`)."""

    name = "recorded"
    choices = frozenset()

    @property
    def drives(self) -> Mapping[str, str]:  # type: ignore[override]  # read at first use
        """Drives of the fit."""
        from fefinger.neural.recorded import fitted

        return {kind: unit.drive for kind, unit in fitted().items()}

    @property
    def lengths(self) -> Mapping[str, float]:  # type: ignore[override]  # read at first use
        """Lengths of the fit: mm of travel of a pin 1 mm wide."""
        from fefinger.neural.recorded import fitted

        return {kind: unit.length for kind, unit in fitted().items()}

    @property
    def corners(self) -> Mapping[str, float]:  # type: ignore[override]  # read at first use
        """Corners of the filters in Hz."""
        from fefinger.neural.recorded import fitted

        return {kind: unit.corner for kind, unit in fitted().items()}

    def notes(self) -> tuple[str, ...]:
        """Say what strain the input of the units is."""
        return (
            "Afferents: the family recorded, fitted to units of monkeys under probes and spheres. "
            "The input of a unit is its strain, expressed in mm of travel of a pin 1 mm wide that "
            "causes it.",
        )

    def fire(self, time: Array, drive: Array, **options: Any) -> "SpikeTrains":
        """Simulate units, as `recorded.simulate_recorded`."""
        from fefinger.neural.recorded import simulate_recorded

        return simulate_recorded(time, drive, **options)

    def stepped(
        self,
        types: Sequence[str],
        normals: Array,
        *,
        unit: Array | None,
        reference: "Callable[[], Reference]",
        **options: Any,
    ) -> "SteppedUnits":
        """Return the compiled units; `options` as for `streaming.RecordedAfferents`."""
        from fefinger.neural.streaming import RecordedAfferents

        if unit is not None:
            types = tuple(types[i] for i in np.unique(unit, return_index=True)[1])
        return RecordedAfferents(types, normals, unit=unit, **options)


class Thesis(OfPackage):
    """The chain of Pawluk (1997), with its squid membrane (`neural/afferent_units.py`)."""

    name = "thesis"
    lengths: Mapping[str, float] = {}  # from a reference press
    choices = frozenset({"drives", "generator", "tolerance"})
    rules = RULES
    noisy = False
    by_input = False  # the currents of the end organs are combined
    membranes = True

    @property
    def corners(self) -> Mapping[str, float]:  # type: ignore[override]  # read at first use
        """Fastest poles of the filters in Hz."""
        from fefinger.neural.endorgans import END_ORGANS

        return {kind: max(organ.poles) for kind, organ in END_ORGANS.items()}

    def notes(self) -> tuple[str, ...]:
        """Return none: the notes of the trains say all."""
        return ()

    def x_in(
        self,
        strain: Array,
        normals: Array,
        types: Sequence[str],
        reference: "Reference",
        drives: Mapping[str, str],
    ) -> Array:
        """Return the skin displacement (n_t, n_organs) in mm that a flat press would have."""
        from fefinger.neural.drives import equivalent_displacements

        return equivalent_displacements(strain, normals, types, reference, drives=drives)

    def fire(self, time: Array, drive: Array, **options: Any) -> "SpikeTrains":
        """Simulate units, as `afferent_units.simulate_units`."""
        from fefinger.neural.afferent_units import simulate_units

        return simulate_units(time, drive, **options)

    def stepped(
        self,
        types: Sequence[str],
        normals: Array,
        *,
        unit: Array | None,
        reference: "Callable[[], Reference]",
        **options: Any,
    ) -> "SteppedUnits":
        """Return a compiled unit of each end organ; `options` as for `streaming.Afferents`."""
        from fefinger.neural.streaming import Afferents

        return Afferents.of(types, normals, reference(), **options)


RECORDED, THESIS = Recorded(), Thesis()
