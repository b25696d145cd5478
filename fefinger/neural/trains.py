"""Spike trains of afferent units, with exports to files and tables."""

from os import PathLike

from fefinger.neural import exports
from fefinger.neural.train_record import TrainRecord
from fefinger.support.checks import InputError


class SpikeTrains(TrainRecord):
    """Spike trains of afferent units, with exports to files and tables.

    What `Result.spikes`, `Result.fire` and `spikes` give. `times` has an array of ascending times
    in s for each unit; `names`, `types`, `positions` (mm), `depths` (mm) and `delays` (s) have one
    entry for each unit, silent ones too. Spikes are counted from `t_start` to `t_stop` s.
    """

    to_csv = exports.to_csv
    units_to_csv = exports.units_to_csv
    to_npz = exports.to_npz
    to_pandas = exports.to_pandas
    units_to_pandas = exports.units_to_pandas
    to_xarray = exports.to_xarray
    to_neo = exports.to_neo
    to_nwb = exports.to_nwb

    @classmethod
    def from_npz(cls, path: str | PathLike[str]) -> "SpikeTrains":
        """Read spike trains that `to_npz` wrote; InputError for another file."""
        fields = exports.read_npz(path)
        try:
            return cls(**fields)
        except InputError as error:
            raise InputError(f"{path}: {error}") from error
