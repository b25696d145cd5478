"""Spike trains of afferent units: their record, and its exports to files and tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from datetime import datetime
from importlib.metadata import version
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from fefinger.neural.train_files import (
    CSV_COLUMNS,
    MEANINGS,
    PER_UNIT,
    SIGNALS,
    STORED,
    UNIT_COLUMNS,
    UNITS,
    equal,
    fields_of,
    in_place,
    of_extra,
    read_npz,
    whole,
    write_npz,
)
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError, names


if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


FEW = 12
"""Largest number of units that are listed and drawn one by one."""

UNMODELED = " (not modeled here)"
"""Beside spikes whose cause the mechanics leaves out."""


class Rerun(NamedTuple):
    """Another run of the same units: what it changes, and its spike counts (n_units,)."""

    change: str
    counts: Integers


@dataclass(frozen=True, kw_only=True, eq=False)
class SpikeTrains:
    """Spike trains of afferent units, with their input displacement and generator current.

    What `Result.spikes`, `Result.fire` and `spikes` return.

    types, names: one per unit, no name twice. times: one ascending array of spike times in s per
    unit, from t_start to t_stop, as recorded: a conduction delay after the spike left the end
    organ. delays: (n_units,) s, or one number; default 0. positions: (n_units, 3) mm of the end
    organs, or None. depths: (n_units,) mm of the end organs under the skin, or None. seed: of the
    random draws; None if nothing is random. trial: of the noise.

    time: (n_t,) s. x_in: (n_t, n_units) mm, input of the end organs, signed, compression positive,
    linear between its times. current: (n_t, n_units) µA/cm², generator current at these times. It
    is not linear in between, and the membrane was given it at more times: straight lines between
    few values do not fire the same spikes.

    peak_mV: (n_units,) highest potential above rest. block_seconds: (n_units,) time spent in
    depolarization block. stimulus_driven: (n_units,) crossings of the threshold that also occur
    with sodium activation frozen at rest, so that the current alone carries the potential over it.
    notes: sentences on limits and peculiarities of the trains. family: name of the model of the
    units. The current of units of "recorded" is scaled to a nominal threshold of 6.2 µA/cm², their
    potential to one of 40 mV; they have no block. reruns: what other runs of the units change, as
    step, samples, trial, gain and mesh; rerun_counts: (n_reruns, n_units) spikes in them, or None.

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
    reruns: tuple[str, ...] = ()
    rerun_counts: Integers | None = None

    def __post_init__(self) -> None:
        """Check that names are different, and that every field has all units."""
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
        if not isinstance(other, SpikeTrains):
            return NotImplemented
        return all(
            equal(getattr(self, each.name), getattr(other, each.name)) for each in fields(self)
        )

    def __hash__(self) -> int:
        """Return a hash of the units and the recorded span of time."""
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

    def beside(self, *reruns: Rerun) -> Self:
        """Return the trains with the counts of other runs of the units beside them."""
        if not reruns:
            return self
        counts = np.vstack([self._counts()[1:], *(each.counts for each in reruns)])
        changes = tuple(each.change for each in reruns)
        return replace(self, reruns=self.reruns + changes, rerun_counts=counts)

    def bounds(self) -> Integers:
        """Return the least and the largest spike count of each unit, (2, n_units), of all runs.

        What step, samples, trials, gains and mesh leave open, as far as other runs have changed
        them (`reruns`).
        """
        counts = self._counts()
        return np.stack([counts.min(axis=0), counts.max(axis=0)])

    def _counts(self) -> Integers:
        """Spike counts (1 + n_reruns, n_units) of this run and of the others."""
        others = [] if self.rerun_counts is None else [self.rerun_counts]
        return np.vstack([self.count(), *others])

    def at_end_organs(self, unit: int | str) -> Array:
        """Return the times in s at which the spikes of a unit left its end organs."""
        i = self.index(unit)
        return self.times[i] - self.delays[i]

    def summary(self, unmodeled: Sequence[str] = ()) -> str:
        """List the numbers of spikes: by unit for up to FEW units, else by type.

        With the least and the largest number in other runs, where they differ (`bounds`).

        unmodeled: types of which it says, beside their numbers, that they are not modeled.
        """
        counts, apart = self.count(), dict.fromkeys(unmodeled, UNMODELED)
        if len(self) <= FEW:
            rows = zip(self.names, self.types, counts, *self.bounds(), strict=True)
            return ", ".join(f"{n} {_within(*c)}{apart.get(kind, '')}" for n, kind, *c in rows)
        totals = []
        for kind, fired in self.totals().items():
            of_kind = counts[np.array(self.types) == kind]
            firing = f"{np.count_nonzero(of_kind)} of {len(of_kind)} units"
            totals.append(f"{kind} {_within(*fired)} from {firing}{apart.get(kind, '')}")
        return ", ".join(totals)

    def totals(self) -> dict[str, tuple[int, int, int]]:
        """Return the number of spikes of each type, and its least and largest in other runs."""
        counts, types = self._counts(), np.array(self.types)
        by_type = {kind: counts[:, types == kind].sum(axis=1) for kind in dict.fromkeys(self.types)}
        return {kind: (int(n[0]), int(n.min()), int(n.max())) for kind, n in by_type.items()}

    def rate(self, unit: int | str, t: ArrayLike) -> Array:
        """Return the instantaneous rate of a unit in Hz at times `t` in s, of any shape.

        One over the interval between two spikes, all through the interval (thesis 4.3.5); zero
        before the first spike and from the last one on.
        """
        times = self.times[self.index(unit)]
        steps = np.concatenate([[0.0], 1.0 / np.diff(times), [0.0]]) if len(times) else np.zeros(1)
        return steps[np.searchsorted(times, np.asarray(t, float), side="right")]

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write one row per spike in CSV_COLUMNS, by unit and then time; unknown places are empty.

        Silent units have no row: `units_to_csv` writes all.
        """
        with in_place(path) as new:
            self.to_pandas().to_csv(new, columns=list(CSV_COLUMNS), index=False)

    def units_to_csv(self, path: str | PathLike[str]) -> None:
        """Write one row per unit in UNIT_COLUMNS, silent ones too; unknown places are empty."""
        with in_place(path) as new:
            self.units_to_pandas().to_csv(new, index=False)

    def to_npz(self, path: str | PathLike[str]) -> None:
        """Write all fields to a compressed NPZ file, which `from_npz` reads back bit by bit.

        `spikes` holds the times of all units (unit i: from offsets[i] to offsets[i + 1]),
        `units_of_arrays` the unit of each array, `meanings` descriptions of SIGNALS.
        """
        given = {name: getattr(self, name) for name in (*STORED, "t_start", "t_stop", "family")}
        write_npz(path, self.times, given)

    @classmethod
    def from_npz(cls, path: str | PathLike[str]) -> Self:
        """Read spike trains that `to_npz` wrote; InputError for another file."""
        data = read_npz(path)
        try:
            fields = fields_of(data)
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise InputError(
                f"{path}: expected every array of spike trains, cannot use them: {error}; "
                "save again"
            ) from error
        try:
            return cls(**fields)
        except InputError as error:
            raise InputError(f"{path}: {error}") from error

    def to_pandas(self) -> "pd.DataFrame":
        """Convert to a table with one row per spike.

        Columns unit, type, x_mm, y_mm, z_mm, depth_mm, time_s and delay_s, the conduction delay
        that time_s includes. Silent units have no row: means over units need `units_to_pandas`.
        """
        units = self.units_to_pandas()[[*CSV_COLUMNS[:-1], "depth_mm", "delay_s"]]
        table = units.loc[np.repeat(np.arange(len(self)), self.count())].reset_index(drop=True)
        table.insert(len(table.columns) - 1, "time_s", np.concatenate(self.times))
        return table

    def units_to_pandas(self) -> "pd.DataFrame":
        """Convert to a table with one row per unit, silent ones too, in UNIT_COLUMNS.

        `count` spikes lie from t_start_s to t_stop_s, so that count / (t_stop_s - t_start_s) is the
        mean rate of the unit in Hz. Unknown places and depths are nan.
        """
        import pandas as pd

        places = np.full((len(self), 3), np.nan) if self.positions is None else self.positions
        table = {
            "unit": np.array(self.names, object),
            "type": np.array(self.types, object),
            **{f"{axis}_mm": places[:, i] for i, axis in enumerate("xyz")},
            "depth_mm": np.full(len(self), np.nan) if self.depths is None else self.depths,
            "delay_s": self.delays,
            "count": self.count(),
            "count_least": self.bounds()[0],
            "count_most": self.bounds()[1],
            "t_start_s": self.t_start,
            "t_stop_s": self.t_stop,
        }
        return pd.DataFrame(table, columns=list(UNIT_COLUMNS))

    def to_xarray(self) -> "xr.Dataset":
        """Convert to a Dataset: signals over `time` and `unit`, spikes over `spike`.

        `spike_unit` is the index of the unit of each spike. Every variable has its units, and the
        signals have a description in `long_name`.
        """
        import xarray as xr

        def variable(name: str, dims: tuple[str, ...], values: object) -> "xr.Variable":
            return xr.Variable(dims, values, {"units": UNITS[name]})

        data = {name: variable(name, ("time", "unit"), getattr(self, name)) for name in SIGNALS}
        for name, meaning in MEANINGS.items():
            data[name].attrs["long_name"] = meaning
        data |= {name: variable(name, ("unit",), getattr(self, name)) for name in PER_UNIT}
        data["delays"] = variable("delays", ("unit",), self.delays)
        data["delays"].attrs["long_name"] = "conduction delay, part of the times of the spikes"
        data["spike_time"] = variable("times", ("spike",), np.concatenate(self.times))
        data["spike_unit"] = xr.Variable(("spike",), np.repeat(range(len(self)), self.count()))
        if self.positions is not None:
            data["positions"] = variable("positions", ("unit", "axis"), self.positions)
        if self.depths is not None:
            data["depths"] = variable("depths", ("unit",), self.depths)
        coordinates = {
            "unit": list(self.names),
            "type": ("unit", list(self.types)),
            "time": variable("time", ("time",), self.time),
        }
        if self.positions is not None:
            coordinates["axis"] = ["x", "y", "z"]
        return xr.Dataset(data, coordinates, _provenance(self))

    def to_neo(self) -> Any:
        """Convert to a neo.Block with one Segment: a SpikeTrain per unit, and the signals.

        Each SpikeTrain is named after its unit and annotated with afferent_class, delay_s,
        position_mm and depth_mm; displacement and current are IrregularlySampledSignals. Needs the
        extra `neo`.
        """
        neo, pq = of_extra("neo", "neo"), of_extra("quantities", "neo")
        segment = neo.Segment(name="trial")
        span = {"t_start": self.t_start * pq.s, "t_stop": self.t_stop * pq.s}
        for i, times in enumerate(self.times):
            annotations: dict[str, Any] = {"afferent_class": self.types[i]}
            annotations["delay_s"] = float(self.delays[i])
            if self.positions is not None:
                annotations["position_mm"] = self.positions[i].tolist()
            if self.depths is not None:
                annotations["depth_mm"] = float(self.depths[i])
            segment.spiketrains.append(
                neo.SpikeTrain(times * pq.s, name=self.names[i], **span, **annotations)
            )
        density = pq.CompoundUnit("uA/cm**2")
        for name, unit in (("x_in", pq.mm), ("current", density)):
            labels = {"name": name, "description": MEANINGS[name]}
            segment.irregularlysampledsignals.append(
                neo.IrregularlySampledSignal(self.time * pq.s, getattr(self, name), unit, **labels)
            )
        block = neo.Block(name="fefinger", **_provenance(self))
        block.segments.append(segment)
        return block

    def to_nwb(
        self,
        path: str | PathLike[str],
        *,
        description: str = "simulated spike trains of tactile afferents",
        started: datetime | None = None,
        subject: Mapping[str, object] | None = None,
        resolution: float | None = None,
        about: Mapping[str, object] | None = None,
    ) -> None:
        """Write an NWB file: units, their class and place, and the displacement that drove them.

        Lengths are in mm in the table and in m in the series, as the format requires. `started` is
        the time of the session with its zone, by default now. `subject` has fields of pynwb's
        Subject, as subject_id, species, sex and age; by default it is a simulated finger.
        `resolution` is that of spike times in s, by default the step of the signals, which is
        coarser. `about` has other fields of an NWBFile, as experimenter, institution and keywords.
        Needs the extra `nwb`.

        Raises
        ------
        InputError
            Fields that NWB does not have, or a resolution that is not above 0.
        """
        from fefinger.neural import train_files

        recorded = train_files.Recorded(
            times=self.times,
            table=self.units_to_pandas(),
            span=(self.t_start, self.t_stop),
            time=self.time,
            displacement=self.x_in,
            meaning=MEANINGS["x_in"],
            notes=[*self.notes, f"seed: {self.seed}", f"trial: {self.trial}"],
            source=str(_provenance(self)["source"]),
        )
        train_files.write_nwb(
            *(path, recorded),
            description=description,
            started=started,
            subject=subject,
            resolution=resolution,
            about=about,
        )


def _within(count: int, least: int, most: int) -> str:
    """Return a number of spikes, and in brackets the least and the largest one, if they differ."""
    return f"{count} ({least} to {most})" if least < most else str(count)


def _provenance(trains: SpikeTrains) -> dict[str, object]:
    """Version of the program, seed, trial and notes."""
    source: dict[str, object] = {"source": f"fefinger {version('fefinger')}"}
    source["trial"] = whole(trains.trial)
    if trains.seed is not None:
        source["seed"] = whole(trains.seed)
    return source | {"notes": "\n".join(trains.notes)}
