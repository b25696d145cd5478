"""The record of spike trains of afferent units, with the signals that made them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.support.checks import InputError, names


FEW = 12
"""Units up to which each is told and drawn by itself."""

COLUMNS = ("unit", "type", "time_s")
"""Column names of `SpikeTrains.to_rows`."""


@dataclass(frozen=True, kw_only=True)
class TrainRecord:
    """What the afferent units fired, and the signals on the way to it.

    types, names: one per unit, no name twice. times: one ascending array of spike times in s per
    unit, between t_start and t_stop. positions: (n_units, 3) mm of the end organs, or None. depths:
    (n_units,) mm of the end organs under the skin, or None. seed: of what is random in them; None:
    nothing is.

    time: (n_t,) s, at which x_in (n_t, n_units) mm, signed, compression positive, is the input of
    the end organ and current (n_t, n_units) uA/cm² the generator current. x_in is linear in
    between. The current is not: it is what the filter makes of x_in at these times alone, and the
    membrane was given more of it in between. Where x_in is few corners, straight lines between
    these values do not fire the same spikes.

    peak_mV: (n_units,) highest potential above rest. block_seconds: (n_units,) time spent in
    depolarization block. stimulus_driven: (n_units,) crossings of the threshold that also occur
    with sodium activation frozen at rest, so that the current alone carries the potential over it.
    notes: what a reader of the trains has to know, in sentences.

    Raises
    ------
    InputError
        Names that are no strings or not different, or fields that are not of as many units.
    """

    types: tuple[str, ...]
    names: tuple[str, ...]
    times: tuple[NDArray[np.float64], ...]
    t_start: float
    t_stop: float
    time: NDArray[np.float64]
    x_in: NDArray[np.float64]
    current: NDArray[np.float64]
    peak_mV: NDArray[np.float64]
    block_seconds: NDArray[np.float64]
    stimulus_driven: NDArray[np.int64]
    positions: NDArray[np.float64] | None = None
    depths: NDArray[np.float64] | None = None
    seed: int | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check that a name is that of one unit, and that every field has all units."""
        n = len(names("names", self.names))
        lists = ("types", "times", "peak_mV", "block_seconds", "stimulus_driven")
        found = {field: len(getattr(self, field)) for field in lists}
        found |= {field: np.shape(getattr(self, field))[-1] for field in ("x_in", "current")}
        for field, count in found.items():
            if count != n:
                msg = f"{field}: expected one for each of {n} names, received {count}"
                raise InputError(msg)

    def __len__(self) -> int:
        """Return the number of units."""
        return len(self.names)

    def index(self, unit: int | str) -> int:
        """Return the index of a unit given by index or name; KeyError with the names if unknown."""
        if isinstance(unit, str):
            if unit not in self.names:
                msg = f"no unit {unit!r} among {', '.join(self.names)}"
                raise KeyError(msg)
            return self.names.index(unit)
        return range(len(self))[unit]

    def count(self) -> NDArray[np.int64]:
        """Return the number of spikes of each unit, (n_units,)."""
        return np.array([len(times) for times in self.times], np.int64)

    def summary(self) -> str:
        """Return the numbers of spikes in words: by unit where they are few, else by type."""
        counts = self.count()
        if len(self) <= FEW:
            return ", ".join(f"{n} {c}" for n, c in zip(self.names, counts.tolist(), strict=True))
        said = []
        for kind in dict.fromkeys(self.types):
            of_kind = counts[np.array(self.types) == kind]
            firing = int(np.count_nonzero(of_kind))
            said.append(f"{kind} {int(of_kind.sum())} from {firing} of {len(of_kind)} units")
        return ", ".join(said)

    def rate(self, unit: int | str, t: ArrayLike) -> NDArray[np.float64]:
        """Return the instantaneous rate of a unit in Hz at times `t` in s, of any shape.

        One over the interval between two spikes, all through the interval (thesis 4.3.5); zero
        before the first spike and from the last one on.
        """
        times = self.times[self.index(unit)]
        steps = np.concatenate([[0.0], 1.0 / np.diff(times), [0.0]]) if len(times) else np.zeros(1)
        return steps[np.searchsorted(times, np.asarray(t, float), side="right")]

    def to_rows(self) -> list[tuple[str, str, float]]:
        """Return one row (unit, type, time in s) per spike, by unit and then time."""
        return [
            (name, kind, float(t))
            for name, kind, times in zip(self.names, self.types, self.times, strict=True)
            for t in times
        ]
