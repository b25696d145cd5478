"""Record of the spike trains of afferent units, with the signals that drove them."""

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError, choice, names
from fefinger.support.vocabulary import FAMILIES


FEW = 12
"""Largest number of units that are listed and drawn one by one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrainRecord:
    """Spike trains of afferent units, with their input displacement and generator current.

    types, names: one per unit, no name twice. times: one ascending array of spike times in s per
    unit, between t_start and t_stop; they are those of the recording, a conduction delay after the
    spike left the end organ. delays: (n_units,) s of it, or one number; default 0. positions:
    (n_units, 3) mm of the end organs, or None. depths: (n_units,) mm of the end organs under the
    skin, or None. seed: of the random draws; None if nothing is random. trial: of the noise.

    time: (n_t,) s, at which x_in (n_t, n_units) mm, signed, compression positive, is the input of
    the end organ and current (n_t, n_units) µA/cm² the generator current. x_in is linear in
    between. The current is not: it is the output of the filter at these times only, and the
    membrane was given it at more times. Where x_in has few samples, straight lines between these
    values of the current do not fire the same spikes.

    peak_mV: (n_units,) highest potential above rest. block_seconds: (n_units,) time spent in
    depolarization block. stimulus_driven: (n_units,) crossings of the threshold that also occur
    with sodium activation frozen at rest, so that the current alone carries the potential over it.
    notes: sentences on limits and peculiarities of the trains. family: of FAMILIES. For the units
    of "recorded" the current counts in a nominal threshold of 6.2 µA/cm², the potential in one of
    40 mV, and there is no block.

    Raises
    ------
    InputError
        Names that are not different strings, or fields with another number of units.
    """

    types: tuple[str, ...]
    names: tuple[str, ...]
    times: tuple[Array, ...]
    t_start: float
    t_stop: float
    time: Array
    x_in: Array
    current: Array
    peak_mV: Array
    block_seconds: Array
    stimulus_driven: Integers
    delays: Array = field(default_factory=lambda: np.zeros(()))
    positions: Array | None = None
    depths: Array | None = None
    seed: int | None = None
    trial: int = 0
    notes: tuple[str, ...] = ()
    family: str = "thesis"

    def __post_init__(self) -> None:
        """Check the family, that names are different, and that every field has all units."""
        choice("family", self.family, FAMILIES)
        n = len(names("names", self.names))
        if np.ndim(self.delays) == 0:
            object.__setattr__(self, "delays", np.full(n, float(self.delays)))
        lists = ("types", "times", "peak_mV", "block_seconds", "stimulus_driven", "delays")
        counts = {name: len(getattr(self, name)) for name in lists}
        counts |= {name: np.shape(getattr(self, name))[-1] for name in ("x_in", "current")}
        for name, count in counts.items():
            if count != n:
                raise InputError(f"{name}: expected one for each of {n} names, received {count}")

    def __repr__(self) -> str:
        """Show the numbers of spikes, not the arrays."""
        return f"<SpikeTrains, {self.t_start:g} to {self.t_stop:g} s: {self.summary()}>"

    def __eq__(self, other: object) -> bool:
        """Whether every field is equal, arrays element by element; nan equals nan."""
        if not isinstance(other, TrainRecord):
            return NotImplemented
        return all(
            _equal(getattr(self, each.name), getattr(other, each.name)) for each in fields(self)
        )

    def __hash__(self) -> int:
        """Return a hash of the units and the times at which their spikes begin and end to count."""
        return hash((self.types, self.names, self.t_start, self.t_stop))

    def __len__(self) -> int:
        """Return the number of units."""
        return len(self.names)

    def index(self, unit: int | str) -> int:
        """Index of a unit given by index or name; KeyError lists the names if it is unknown."""
        if isinstance(unit, str):
            if unit not in self.names:
                raise KeyError(f"no unit {unit!r} among {', '.join(self.names)}")
            return self.names.index(unit)
        return range(len(self))[unit]

    def count(self) -> Integers:
        """Return the number of spikes of each unit, (n_units,)."""
        return np.array([len(times) for times in self.times], np.int64)

    def at_end_organs(self, unit: int | str) -> Array:
        """Return the times in s at which the spikes of a unit left its end organs."""
        i = self.index(unit)
        return self.times[i] - self.delays[i]

    def summary(self) -> str:
        """List the numbers of spikes: by unit for up to FEW units, else by type."""
        counts = self.count()
        if len(self) <= FEW:
            return ", ".join(f"{n} {c}" for n, c in zip(self.names, counts.tolist(), strict=True))
        totals = []
        for kind in dict.fromkeys(self.types):
            of_kind = counts[np.array(self.types) == kind]
            firing = int(np.count_nonzero(of_kind))
            totals.append(f"{kind} {int(of_kind.sum())} from {firing} of {len(of_kind)} units")
        return ", ".join(totals)

    def rate(self, unit: int | str, t: ArrayLike) -> Array:
        """Return the instantaneous rate of a unit in Hz at times `t` in s, of any shape.

        One over the interval between two spikes, all through the interval (thesis 4.3.5); zero
        before the first spike and from the last one on.
        """
        times = self.times[self.index(unit)]
        steps = np.concatenate([[0.0], 1.0 / np.diff(times), [0.0]]) if len(times) else np.zeros(1)
        return steps[np.searchsorted(times, np.asarray(t, float), side="right")]


def _equal(one: Any, other: Any) -> bool:
    """Whether two values of a field are equal; tuples and arrays element by element."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_equal, one, other))
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        both = one is not None and other is not None
        return both and np.array_equal(one, other, equal_nan=True)
    return bool(one == other)
