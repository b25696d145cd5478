"""A family of afferents of a user's own: from the input of the units to their spikes."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from fefinger.neural.checked_signals import UnitInput
from fefinger.neural.recorded import combined
from fefinger.neural.trains import SpikeTrains
from fefinger.neural.variation import Variation
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import TYPES


class Units(NamedTuple):
    """Units to simulate: their types and names, and a random generator (seeded) of each."""

    types: tuple[str, ...]
    names: tuple[str, ...]
    random: tuple[np.random.Generator, ...]


class Family(ABC):
    """Base of a family of afferents: a `name`, `drives` and `simulate`.

    drives: component of the strain (of `vocabulary.DRIVES`) that drives each type. lengths: input
    in mm per strain of 1, by type; 1 by default, so that the input is the strain.
    """

    name: str
    drives: Mapping[str, str] = dict.fromkeys(TYPES, "compressive")
    lengths: Mapping[str, float] = dict.fromkeys(TYPES, 1.0)

    @abstractmethod
    def simulate(self, time: Array, x_in: Array, units: Units) -> Sequence[Array]:
        """Return the spike times in s of each unit, ascending and within `time`.

        time: (n_t,) s; x_in: (n_t, n_units), linear in between; of a unit with several end organs
        the largest of theirs at every time, or their mean.
        """


def fire(
    family: Family,
    time: Array,
    drive: Array,
    *,
    types: Sequence[str],
    unit: Any = None,
    rule: str = "max",
    delays: Any = 0.0,
    variation: Variation | None = None,
    names: Sequence[str] | None = None,
    positions: Any = None,
    depths: Any = None,
    since: float = -np.inf,
) -> SpikeTrains:
    """Simulate units of a family; arguments as in `recorded.simulate_recorded`.

    Raises
    ------
    InputError
        Spikes that are not finite, not ascending or outside of the times, or not of every unit.
    """
    given = UnitInput.of(
        time,
        drive,
        1.0,
        types,
        unit=unit,
        names=names,
        delays=delays,
        positions=positions,
        depths=depths,
        since=since,
    )
    x_in = combined(given.organs, given.columns, rule)
    variation = (variation or Variation(seed=0, noise=None)).for_units(given.types)
    numbers = range(len(given.types)) if variation.numbers is None else variation.numbers
    key = [variation.seed, variation.trial]
    random = tuple(np.random.default_rng([*key, int(number)]) for number in numbers)
    units = Units(given.types, given.names, random)
    times = _checked(family, family.simulate(given.time, x_in, units), given)
    return given.trains(
        times,
        x_in=x_in,
        notes=(f"Afferents: the family {family.name}, which is not of the package.",),
        family=family.name,
        current=x_in,
        seed=variation.seed,
        trial=variation.trial,
    )


def _checked(family: Family, found: Sequence[Array], units: UnitInput) -> list[Array]:
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
