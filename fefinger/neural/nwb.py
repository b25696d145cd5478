"""Spike trains as a file of Neurodata Without Borders (NWB), which its inspector accepts."""

import hashlib
from collections.abc import Mapping
from datetime import UTC, datetime
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.neural.train_files import in_place, of_extra
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number


if TYPE_CHECKING:
    from fefinger.neural.trains import SpikeTrains


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

EVEN = 1e-9
"""Relative difference of steps of time that are one step."""


def write(
    trains: "SpikeTrains",
    path: str | PathLike[str],
    provenance: Mapping[str, object],
    *,
    description: str,
    started: datetime | None,
    subject: Mapping[str, object] | None,
    resolution: float | None,
    about: Mapping[str, object] | None,
    meaning: str,
) -> None:
    """Write trains as `SpikeTrains.to_nwb` says.

    `provenance` has the version of the program; `meaning` is that of the displacement.
    """
    pynwb = of_extra("pynwb", "nwb")
    if resolution is None:
        resolution = float(np.diff(trains.time).min())
    resolution = number("resolution", resolution, above=0, unit="s")
    digest = hashlib.sha256(b"".join(times.tobytes() for times in (*trains.times, trains.x_in)))
    who = _made("subject", pynwb.file.Subject, dict(SIMULATED if subject is None else subject))
    file = _made(
        "about",
        pynwb.NWBFile,
        {
            "session_description": description,
            "experiment_description": description,
            "identifier": digest.hexdigest(),
            "session_start_time": started or datetime.now(UTC),
            "source_script": provenance["source"],
            "source_script_file_name": "fefinger",
            "notes": "\n".join([*trains.notes, f"seed: {trains.seed}", f"trial: {trains.trial}"]),
            "subject": who,
            **(about or {}),
        },
    )
    file.units = pynwb.misc.Units(
        name="units", description="model afferents", resolution=resolution
    )
    for name, meaning in COLUMNS.items():
        file.add_unit_column(name, meaning)
    table = trains.units_to_pandas().iloc[:, : len(COLUMNS)]
    for times, values in zip(trains.times, table.itertuples(index=False), strict=True):
        file.add_unit(
            spike_times=times,
            obs_intervals=[[trains.t_start, trains.t_stop]],
            **dict(zip(COLUMNS, values, strict=True)),
        )
    series = pynwb.TimeSeries(
        name="skin_displacement",
        data=trains.x_in,
        unit="meters",  # the name of NWB; readers find it beside a prefix, not "m"
        conversion=1e-3,
        **_clock(trains.time),
        description=f"one column per unit: {meaning}",
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
    if np.ptp(steps) > EVEN * steps.mean():
        return {"timestamps": time}
    return {"starting_time": float(time[0]), "rate": float((len(time) - 1) / (time[-1] - time[0]))}
