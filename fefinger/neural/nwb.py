"""Spike trains as a file of Neurodata Without Borders (NWB), which its inspector accepts."""

import hashlib
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fefinger.neural.train_files import in_place, of_extra
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number


if TYPE_CHECKING:
    import pandas as pd


SIMULATED = {
    "subject_id": "simulated",
    "description": "a computed fingertip with model afferents; no person was recorded",
    "species": "Homo sapiens",
    "sex": "U",
    "age": "P18Y/",
}
"""Subject of computed spikes: an adult's finger."""

COLUMNS = {
    "unit_name": "name of the unit",
    "afferent_class": "SAI, SAII, FAI or FAII",
    "x_mm": "distal place of the end organ, nan if unknown",
    "y_mm": "radial place of the end organ, nan if unknown",
    "z_mm": "dorsal place of the end organ, nan if unknown",
    "depth_mm": "depth of the end organ under the skin, nan if unknown",
    "delay_s": "conduction delay from the end organ to the recording, part of the spike times",
}
"""Columns of the table of units, and their meaning."""


class Recorded(NamedTuple):
    """What is written: spike times in s by unit, units, span in s, and what drove them.

    table: one row per unit with COLUMNS first; time (n_t,) s; displacement (n_t, n_units) mm, and
    its meaning; source: version of the program.
    """

    times: Sequence[Array]
    table: "pd.DataFrame"
    span: tuple[float, float]
    time: Array
    displacement: Array
    meaning: str
    notes: Sequence[str]
    source: str


def write(
    path: str | PathLike[str],
    recorded: Recorded,
    *,
    description: str,
    started: datetime | None,
    subject: Mapping[str, object] | None,
    resolution: float | None,
    about: Mapping[str, object] | None,
) -> None:
    """Write what was recorded as `SpikeTrains.to_nwb` says."""
    pynwb = of_extra("pynwb", "nwb")
    if resolution is None:
        resolution = float(np.diff(recorded.time).min())
    resolution = number("resolution", resolution, above=0, unit="s")
    digest = hashlib.sha256(
        b"".join(times.tobytes() for times in (*recorded.times, recorded.displacement))
    )
    who = _made("subject", pynwb.file.Subject, dict(SIMULATED if subject is None else subject))
    file = _made(
        "about",
        pynwb.NWBFile,
        {
            "session_description": description,
            "experiment_description": description,
            "identifier": digest.hexdigest(),
            "session_start_time": started or datetime.now(UTC),
            "source_script": recorded.source,
            "source_script_file_name": "fefinger",
            "notes": "\n".join(recorded.notes),
            "subject": who,
            **(about or {}),
        },
    )
    file.units = pynwb.misc.Units(
        name="units", description="model afferents", resolution=resolution
    )
    for name, meaning in COLUMNS.items():
        file.add_unit_column(name, meaning)
    table = recorded.table.iloc[:, : len(COLUMNS)]
    for times, values in zip(recorded.times, table.itertuples(index=False), strict=True):
        file.add_unit(
            spike_times=times,
            obs_intervals=[list(recorded.span)],
            **dict(zip(COLUMNS, values, strict=True)),
        )
    series = pynwb.TimeSeries(
        name="skin_displacement",
        data=recorded.displacement,
        unit="meters",  # the name of NWB; readers find it beside a prefix, not "m"
        conversion=1e-3,
        **_clock(recorded.time),
        description=f"one column per unit: {recorded.meaning}",
    )
    file.add_stimulus(series)
    with in_place(path) as new, pynwb.NWBHDF5IO(str(new), "w") as io:
        io.write(file)


def _made(name: str, cls: Any, fields: Mapping[str, object]) -> Any:
    """Return an object of pynwb, or raise InputError for fields that it does not take."""
    try:
        return cls(**fields)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected fields of NWB's {cls.__name__}: {error}") from None


def _clock(time: Array) -> dict[str, object]:
    """Return the times (n,) of a series as start and rate, if they are even."""
    steps = np.diff(time)
    even = 1e-9  # relative difference of steps of time that are one step
    if np.ptp(steps) > even * steps.mean():
        return {"timestamps": time}
    return {"starting_time": float(time[0]), "rate": float((len(time) - 1) / (time[-1] - time[0]))}
